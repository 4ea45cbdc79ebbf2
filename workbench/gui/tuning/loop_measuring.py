"""The measurement of a loop in flight, and the gains that flew."""

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.analysis.queries import PlanMeasurement
from workbench.control.loop import loop_label
from workbench.control.mode import FlightMode
from workbench.design.judge.measured_loop import measured_loop
from workbench.gui.analysis import QueryStream
from workbench.gui.layout import button
from workbench.gui.tuning.drawn_loop import DrawnLoop, drawn_measurement
from workbench.gui.tuning.excitation_card import GROUNDED_MODES, TRANSITION_MODES
from workbench.gui.tuning.loop_curves import CurveGains
from workbench.gui.units import SHARE_UNIT
from workbench.gui.workspace import Workspace
from workbench.live.orders import FlightOrder, MeasureLoop
from workbench.live.view import LiveView
from workbench.scenario.scenario import Injection
from workbench.session.injected import InjectedSignal

MEASURE_HELP = (
    "Add a multisine to this loop of the flight, and draw what it measures beside the model: with "
    "the gains that fly, in some {seconds:.0f} s of flight"
)
USUAL_MEASUREMENT_S = 100.0
"""Usual duration of a measurement [s]: eight periods of 0.5 rad/s."""
MeasurementKey = tuple[str, str, tuple[tuple[str, float], ...]]


class LoopMeasuring(QObject):
    """Asks for an injection, flies it, and keeps the measurement with the gains that flew.

    Args:
        workspace: its flight is measured, and its analyst plans the injection.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        button: starts and ends a measurement.
        said: progress, "" without a measurement.
    """

    changed = pyqtSignal()
    """A measurement was made, or has progressed."""

    def __init__(self, workspace: Workspace, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._flight, self._notices = workspace.flight, workspace.notices
        self._plans = QueryStream(workspace.analysis, self, seen=True)
        self.button = button(
            "Measure",
            self._press,
            kind="compact",
            help=MEASURE_HELP.format(seconds=USUAL_MEASUREMENT_S),
        )
        self.said = ""
        self._plans.answered.connect(self._fly)
        self._plans.refused.connect(lambda _: self._say(""))  # a notice says why
        self._wanted: tuple[str, str, CurveGains] = ("", "", {})
        self.begin()

    def begin(self) -> None:
        """Clear the last flight's measurements."""
        self._measured: dict[MeasurementKey, DrawnLoop] = {}
        self._plans.forget()
        self._flown: tuple[str, str, CurveGains] | None = None
        self._seen: InjectedSignal | None = None
        self._share: float | None = None
        self._say("")

    def choose(self, loop: str, cut: str, gains: CurveGains) -> None:
        """Select the loop to measure next, with the gains that fly."""
        self._wanted = loop, cut, gains
        self._show_button()

    def known(self, loop: str, cut: str, gains: CurveGains) -> DrawnLoop | None:
        """Return the measurement of a loop with these gains, None without one."""
        return self._measured.get(_measurement_key(loop, cut, gains))

    def keep(self, loop: str, cut: str, gains: CurveGains, drawn: DrawnLoop) -> None:
        """Keep a measurement."""
        self._measured[_measurement_key(loop, cut, gains)] = drawn
        self.changed.emit()

    def show_view(self, view: LiveView) -> None:
        """Show the progress of a measurement, and its result so far."""
        before, self._share = self._share, view.measuring
        measured = view.measured
        if measured is not None and measured is not self._seen and self._flown is not None:
            self._seen = measured
            found = measured_loop(measured)
            drawn = drawn_measurement(
                found.frequency, found.response, found.coherence, found.deviation
            )
            self.keep(*self._flown, drawn)
        if self._share is not None and self._flown is not None:
            # reported in whole percent, it changes a hundred times, not sixty times a second
            name = loop_label(self._flown[0])
            self._say(f"Measuring {name}: {SHARE_UNIT.text(self._share)}")
        elif before is not None:
            self._say("")
        self._show_button()

    @property
    def _busy(self) -> bool:
        return self._share is not None or self._plans.is_waiting

    def _press(self) -> None:
        if self._share is not None:
            self._flight.do(FlightOrder.STOP_EXCITING)
            return
        loop, cut, gains = self._wanted
        self._say("Finding a size that the loop can take …")
        self._plans.ask(PlanMeasurement(gains, loop, cut))
        self._show_button()

    def _fly(self, question: PlanMeasurement, planned: tuple[Injection, bool]) -> None:
        self._flown = question.loop, question.cut, question.gains
        self._seen = self._flight.view.measured  # of the last measurement
        self._say("")
        injection, hold = planned
        self._flight.do(MeasureLoop(injection, hold), refused=self._refuse)

    def _refuse(self, said: str) -> None:
        self._notices.warn(said)
        self._say("")

    def _say(self, said: str) -> None:
        if said != self.said:
            self.said = said
            self.changed.emit()
        self._show_button()

    def _show_button(self) -> None:
        view = self._flight.view
        mode = view.snapshot.mode if view.snapshot is not None else FlightMode.OFF
        flies = self._flight.is_flying and mode not in (*GROUNDED_MODES, *TRANSITION_MODES)
        stops = self._share is not None
        self.button.setText("Stop" if stops else "Measure")
        self.button.setEnabled(stops or (flies and bool(self._wanted[0]) and not self._busy))


def _measurement_key(loop: str, cut: str, gains: CurveGains) -> MeasurementKey:
    return loop, cut, tuple(sorted(gains.items()))
