"""The flight that the app shows: started, replaced and ended, and polled sixty times a second."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

from PyQt6.QtCore import QObject, Qt, QTimer, pyqtSignal

from workbench.common.errors import WorkbenchError
from workbench.gui.errands import BackgroundTasks, FutureCallbacks, RefusalCallback, ResultCallback
from workbench.gui.notices import Notices
from workbench.link.backplane import Published
from workbench.live.choice import Choice
from workbench.live.flight import LiveFlight
from workbench.live.messages import Phase
from workbench.live.orders import LiveOrder
from workbench.live.view import LiveView
from workbench.scenario.scenario import Scenario


@dataclass(frozen=True)
class _Attempt:
    """What to fly, and how; `live` is the flight once its process starts."""

    what: Choice | Scenario
    settings: Mapping[str, float]
    draw: bool
    live: LiveFlight | None = None


FLIGHT_POLL_MS = 16
"""Period between polls of the flight [ms]."""
NO_FLIGHT_REASON = "nothing flies: open a scenario first"


class FlightModel(QObject):
    """One live flight at a time, for all screens; no method blocks.

    Args:
        notices: takes refusals and ends.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        draws: whether flights are drawn in 3-D.
        asks_first: called with a function that would replace the flight; may call it at once,
            later, or never.
    """

    begun = pyqtSignal(object)
    """A flight has begun, or restarted after a reset: its first `LiveView`."""
    taken_over = pyqtSignal(object)
    """Another controller, or another text of its file, now flies: a `LiveView`."""
    viewed = pyqtSignal(object)
    """The newest `LiveView`, when it has changed; at most sixty times a second."""
    streamed = pyqtSignal(object)
    """A list of `Published`: everything that was sampled since the last signal."""
    phase_changed = pyqtSignal(object)
    """A `Phase`."""
    opening = pyqtSignal(str)
    """Progress of starting another flight while the present one continues; "" when it is over."""
    arguments_wanted = pyqtSignal(object, object)
    """A `Choice` or `Scenario` that lacks values for arguments of its xacro file, and those
    `XacroArgument`s."""

    def __init__(self, notices: Notices, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._notices = notices
        self.draws = True
        self.asks_first: Callable[[Callable[[], None]], None] = lambda go_on: go_on()
        self._live: LiveFlight | None = None
        self._present = self._good = _Attempt(Choice(), {}, draw=False)
        self._next: _Attempt | None = None
        self._next_said = ""
        self._again: Callable[[], None] = self._say_nothing_flies
        self._view = LiveView()
        self._answers = FutureCallbacks(lambda said: notices.warn(said), self)
        self._errands = BackgroundTasks()
        self._missed = 0
        self._timer = QTimer(self)
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.setInterval(FLIGHT_POLL_MS)
        self._timer.timeout.connect(self._look)

    @property
    def view(self) -> LiveView:
        """The newest view; before the first flight, that of a starting one."""
        return self._view

    @property
    def what(self) -> Choice | Scenario:
        """What flies, or is starting; a failed attempt does not count."""
        return (self._next or self._present).what

    @property
    def live(self) -> LiveFlight | None:
        """The flight itself, None without one."""
        return self._live

    @property
    def is_flying(self) -> bool:
        """Whether a flight has begun and its process runs."""
        return self._live is not None and self._view.snapshot is not None and not self._view.is_over

    def fly(
        self, choice: Choice | Scenario, settings: Mapping[str, float] | None = None, *, draw: bool
    ) -> None:
        """Start another flight, and end the present one as soon as the other one flies.

        If it cannot be read or built, the present flight continues, and a notice says why.
        """
        self._ask(_Attempt(choice, dict(settings or {}), draw))

    def again(self) -> None:
        """Restart the last flight in a new process."""
        self._again()

    def end(self) -> None:
        """End the flight, if there is one, and a starting one, in the background."""
        self._timer.stop()
        self._drop_next()
        live, self._live = self._live, None
        if live is not None:
            self._errands.do(live.close)

    def close(self) -> None:
        """End the flight and wait until its process is gone; must be the last call."""
        self.end()
        self._answers.close()
        self._errands.close()

    def _ask(self, wanted: _Attempt) -> None:
        """Start a flight once nothing of the present one would be lost."""
        self.asks_first(lambda: self._try(wanted))

    def _try(self, wanted: _Attempt) -> None:
        """Start a flight: in place of the present one if that is not visible."""
        self._drop_next()
        keeps = self._live is not None and self._view.snapshot is not None
        if not keeps:
            self.end()
            self._again = partial(self._ask, wanted)
        try:
            attempt = self._start(wanted)
        except WorkbenchError as error:
            self._tell_not_begun(str(error), "Close other programs, then open it again.")
            return
        if keeps:
            self._next, self._next_said = attempt, ""
            self._look_at_next()
        else:
            self._begin(attempt)

    def _start(self, wanted: _Attempt) -> _Attempt:
        draw = wanted.draw and self.draws
        return replace(
            wanted,
            live=LiveFlight(wanted.what, wanted.settings, draw=draw, stream=True, watch=True),
        )

    def _begin(self, attempt: _Attempt) -> None:
        """Show a flight from now on."""
        assert attempt.live is not None
        self._live, self._present = attempt.live, attempt
        self._again = partial(self._ask, attempt)
        self._missed = 0
        self._show(self._live.latest())
        self._timer.start()

    def _look_at_next(self) -> None:
        """Let the next flight replace the present one once it flies."""
        attempt = self._next
        if attempt is None or attempt.live is None:
            return
        view = attempt.live.latest()
        if view.phase is Phase.ENDED:
            self._drop_next()
            self._tell_cannot_fly(attempt, view)
        elif view.snapshot is not None:
            before, self._next = self._live, None
            self.opening.emit("")
            if before is not None:
                self._errands.do(before.close)
            self._begin(attempt)
        elif view.said != self._next_said:
            self._next_said = view.said
            self.opening.emit(view.said)

    def _drop_next(self) -> None:
        """Drop the starting flight."""
        attempt, self._next = self._next, None
        if attempt is not None and attempt.live is not None:
            self.opening.emit("")
            self._errands.do(attempt.live.close)

    def _tell_cannot_fly(self, attempt: _Attempt, view: LiveView) -> None:
        """Report why a flight is impossible; if only values are missing, ask for them."""
        if view.needed:
            self.arguments_wanted.emit(attempt.what, view.needed)
        else:
            self._tell_not_begun(view.said, "Correct it, or open another.")

    def _tell_not_begun(self, said: str, remedy: str) -> None:
        """Report why another flight did not start, and whether the present one continues."""
        if self._live is None:
            self._show(LiveView().ended(said))
            self._notices.fail(said, remedy)
        elif self._view.phase in (Phase.FLYING, Phase.PAUSED):
            self._notices.warn(said, f"The present flight continues. {remedy}")
        else:
            self._notices.fail(said, f"{remedy} Reset flies the previous flight again.")

    def do(
        self,
        order: LiveOrder,
        done: ResultCallback | None = None,
        refused: RefusalCallback | None = None,
    ) -> None:
        """Give the flight an order.

        Args:
            order: what the flight is to do.
            done: called with the answer, in this thread, once `view` shows the effect.
            refused: called with the reason of a refusal; by default a notice shows it, unless
                another flight has started meanwhile.
        """
        live = self._live
        if live is not None:
            tell = refused or partial(self._tell_refusal, live)
            self._answers.expect(live.do(order), done, tell)
        else:
            (refused or self._notices.warn)(NO_FLIGHT_REASON)

    def _tell_refusal(self, live: LiveFlight, said: str) -> None:
        if live is self._live:
            self._notices.warn(said)

    def _say_nothing_flies(self) -> None:
        self._notices.warn(NO_FLIGHT_REASON)

    def _look(self) -> None:
        """Emit the signals for news; a slot may end the flight, or start another."""
        self._look_at_next()
        live = self._live
        if live is None:
            return
        published = live.streamed()
        view = live.latest()
        restarted = has_restarted(self._view, view)
        if restarted:  # older samples belong to the last flight
            self._show(view)
            published = since_last_restart(published, view)
        if published:
            self.streamed.emit(published)
        if view is not self._view:
            self._show(view)
        if self._live is live:
            self._tell_missed(live.missed)

    def _tell_missed(self, missed: int) -> None:
        """Report that curves have a gap, which they do not show."""
        if missed > self._missed:
            self._missed = missed
            self._notices.warn(
                "The window was busy for so long that the charts have a gap.",
                "The flight and its log have none.",
            )

    def _show(self, view: LiveView) -> None:
        before, self._view = self._view, view
        if has_restarted(before, view):
            self._good = self._present
            self.begun.emit(view)
        elif controller_changed(before, view) and view.controller and view.scenario:
            law, other = view.controller, before.controller
            if other is None or law.reference != other.reference:
                # gains of the same law also fit sets of them
                keep = other is not None and law.unscheduled == other.unscheduled
                what = with_controller(self._present.what, view.scenario.controller, keep=keep)
                self._present = self._good = replace(self._present, what=what)
            self.taken_over.emit(view)
        if view.phase is not before.phase:
            self.phase_changed.emit(view.phase)
            if view.phase is Phase.ENDED and self._live is not None:
                self._end_of(view)
            elif view.phase is Phase.BROKEN:
                self._notices.fail(view.said, "Reset the flight (Ctrl+R) to fly again.")
        self._tell_trouble(before, view)
        self.viewed.emit(view)

    def _tell_trouble(self, before: LiveView, view: LiveView) -> None:
        """Report why an autopilot, or an excitation, has ended by itself."""
        lived = before.autopilot is None or not before.autopilot.ended
        if lived and view.autopilot is not None and view.autopilot.ended:
            self._notices.fail(view.autopilot.ended, "Reset the flight (Ctrl+R) to start it again.")
        ended = view.excitation_ended
        if ended and not before.excitation_ended:
            remedy = "Fly it with a smaller amplitude, with other gains, or elsewhere."
            self._notices.alarm(f"The excitation has ended: {ended}", remedy)
        elif before.excitation_ended and not ended:
            self._notices.end_alarm(f"The excitation has ended: {before.excitation_ended}")
        for what in before.lasting:
            if what not in view.lasting:
                self._notices.end_alarm(what)

    def _end_of(self, view: LiveView) -> None:
        """Report a flight that has ended by itself, or could not start."""
        attempt = self._present
        self._present = self._good
        if view.needed:
            self.arguments_wanted.emit(attempt.what, view.needed)
        else:
            self._notices.fail(view.said, "Open a scenario, or reset, to fly again.")


def with_controller(what: Choice | Scenario, name: str, *, keep: bool = False) -> Choice | Scenario:
    """Return what to fly with a controller, by name of a shipped one or path of a file.

    Args:
        what: the last flight's scenario or choice.
        name: name of the controller.
        keep: whether the gain file also fits the new controller; else it is left out.
    """
    if what.controller == name:
        return what
    if isinstance(what, Choice):
        return replace(what, controller=name, gains=what.gains if keep else "")
    gains = what.vehicle.gains if keep else ""
    return replace(what, controller=name, vehicle=replace(what.vehicle, gains=gains))


def has_restarted(before: LiveView, view: LiveView) -> bool:
    """Return whether a flight has begun, or restarted, between two views."""
    if view.snapshot is None:
        return False
    if before.snapshot is None or before.vehicle is not view.vehicle:
        return True
    return view.flight != before.flight


def controller_changed(before: LiveView, view: LiveView) -> bool:
    """Return whether another controller took over between two views of a flight.

    Before its first snapshot a flight has a controller, but it does not fly yet.
    """
    return before.snapshot is not None and view.controller is not before.controller


def since_last_restart(published: list[Published], view: LiveView) -> list[Published]:
    """Return the data published since the last restart of time.

    Args:
        published: data in order of arrival: the end of one flight and the start of the next.
        view: view of the new flight.
    """
    starts = [index for index, (a, b) in enumerate(pairwise(published), 1) if b.t_ns < a.t_ns]
    latest = view.snapshot.time if view.snapshot else 0.0
    return [
        each for each in published[max(starts, default=0) :] if each.t_ns * 1e-9 <= latest + 1.0
    ]
