"""The time bar of a log: its clock, and the buttons that play it."""

from functools import partial
from time import perf_counter

from PyQt6.QtCore import QSignalBlocker, Qt, QTimer, pyqtSignal
from PyQt6.QtWidgets import QFrame, QSlider

from workbench.common.flight import MAX_LOG_TIME_S, Flight
from workbench.common.plain_text import plain_name
from workbench.gui.help import set_card_help
from workbench.gui.labels import Label, set_tip
from workbench.gui.layout import buddy, button, choice, hbox, label, named, vbox
from workbench.gui.style import set_class
from workbench.gui.tuning.added_cards import added_cards
from workbench.gui.units import LOG_TIME_UNIT

REPLAY_SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0)
REPLAY_STEP_S = 0.1
"""Time of a single step [s]."""
PLAYBACK_PERIOD_MS = 16
"""Period between pictures while it plays [ms]."""
DAY_S = 86400.0
SLIDER_STEPS_PER_S = 100
"""Number of the slider's steps per second."""


class LogClock:
    """A time within a log that plays, is paused, or is moved.

    Args:
        begin: time of the log's first sample [s].
        end: time of its last sample [s].

    Attributes:
        begin: time of the log's first sample [s].
        end: time of its last sample [s].
        time: shown time [s].
        speed: seconds of the log per second.
        plays: whether it plays.
        loops: whether it restarts at the end.
    """

    def __init__(self, begin: float, end: float) -> None:
        self.begin, self.end = begin, max(begin, end)
        self.time = self.end
        self.speed = 1.0
        self.plays = False
        self.loops = False

    def play(self) -> None:
        """Play; from the start if it is at the end."""
        if self.time >= self.end:
            self.time = self.begin
        self.plays = True

    def pause(self) -> None:
        """Pause."""
        self.plays = False

    def go_to(self, time: float) -> None:
        """Go to a time [s]."""
        self.time = min(max(time, self.begin), self.end)

    def step(self, steps: int) -> None:
        """Pause, and move by some steps."""
        self.pause()
        self.go_to(self.time + REPLAY_STEP_S * steps)

    def advance(self, passed: float) -> None:
        """Advance by a wall time [s]."""
        if not self.plays:
            return
        self.time += self.speed * passed
        if self.time >= self.end:
            duration = self.end - self.begin
            if self.loops and duration > 0.0:
                self.time = self.begin + (self.time - self.begin) % duration
            else:
                self.time = self.end
                self.plays = False


def shown_clock_start(clock_start: float) -> float:
    """Return a log's clock at its time 0 as shown [s]: since boot, or since midnight UTC.

    Args:
        clock_start: that clock; since 1970 if it is larger than any time since boot [s].
    """
    return clock_start % DAY_S if clock_start > MAX_LOG_TIME_S else clock_start


class LogBar(QFrame):
    """Time bar of a log."""

    moved = pyqtSignal(float)
    """The time to show [s]."""
    whole_wanted = pyqtSignal(float, float)
    """The whole log should be visible, between two times [s]."""
    clock_started = pyqtSignal(float)
    """The time that is shown at time 0 of the log [s]."""
    live_wanted = pyqtSignal()
    """The log should be closed."""
    card_wanted = pyqtSignal(str)
    """The card of the Tuning screen with this title should be shown."""

    def __init__(self) -> None:
        super().__init__()
        self.clock = LogClock(0.0, 0.0)
        self._last = self._clock_start = 0.0
        self._timer = QTimer(self)
        self._timer.setInterval(PLAYBACK_PERIOD_MS)
        self._timer.timeout.connect(self._tick)
        set_class(self, "card")
        set_card_help(self, "Log")
        self.name = label(kind="heading")
        self.remark = label(kind="warning", wraps=True)
        self.back = button("&Back to live", self.live_wanted.emit)
        self.earlier = named(
            button("− 0.1 s", lambda: self._step(-1)), "A tenth of a second earlier"
        )
        self.later = named(button("+ 0.1 s", lambda: self._step(1)), "A tenth of a second later")
        self.absolute = button("Log's cloc&k", self._show_clock)
        self.absolute.setCheckable(True)
        self.whole = button(
            "&Whole log", lambda: self.whole_wanted.emit(self.clock.begin, self.clock.end)
        )
        self.card_buttons = {
            row.title: button(
                row.log_button, partial(self.card_wanted.emit, row.title), help=row.log_help
            )
            for row in added_cards()
            if row.log_button
        }
        self.play, self.loop = button("&Play"), button("L&oop")
        for each in (self.play, self.loop):
            each.setCheckable(True)
        speeds = (f"{speed:g} ×" for speed in REPLAY_SPEEDS)
        self.speed = choice("Seconds of the log in a second", speeds)
        self.speed.setCurrentIndex(REPLAY_SPEEDS.index(1.0))
        self.slider = named(QSlider(Qt.Orientation.Horizontal), "Time of the log in s")
        self.time = Label()
        self._lay_out()
        self._connect()

    def show_log(self, flight: Flight) -> None:
        """Show a new log, at its end."""
        self.clock = LogClock(flight.begin, flight.end)
        self.clock.speed = REPLAY_SPEEDS[self.speed.currentIndex()]
        self.clock.loops = self.loop.isChecked()
        self.name.setText(f"LOG  {plain_name(flight.source.name)}")
        set_tip(self.name, f"{flight.source}, vehicle {flight.vehicle}")
        self.remark.setText(flight.remark)
        self.remark.setVisible(bool(flight.remark))
        with QSignalBlocker(self.slider):  # setting a range without its value changes the value
            self.slider.setRange(
                round(flight.begin * SLIDER_STEPS_PER_S), round(flight.end * SLIDER_STEPS_PER_S)
            )
        self._clock_start = flight.clock_start
        self.absolute.setEnabled(flight.clock_start != 0.0)
        since = "midnight UTC" if flight.clock_start > MAX_LOG_TIME_S else "the start of its clock"
        self.absolute.setChecked(self.absolute.isChecked() and self.absolute.isEnabled())
        says = f"Show times since {since}, instead of since the log's first sample"
        set_tip(self.absolute, says if flight.clock_start else "The log's clock starts with it")
        self.clock_started.emit(self._shown_start)
        self.slider.setAccessibleDescription(f"{flight.begin:.2f} to {flight.end:.2f} s")
        self._show()

    def stop(self) -> None:
        """Stop playing."""
        self.clock.pause()
        self._timer.stop()
        self._show()

    @property
    def _shown_start(self) -> float:
        """The time that is shown at time 0 [s]."""
        return shown_clock_start(self._clock_start) if self.absolute.isChecked() else 0.0

    def _show_clock(self) -> None:
        """Show times by the log's own clock, or from its first sample on."""
        self.clock_started.emit(self._shown_start)
        self._show()

    def _toggle_play(self, plays: bool) -> None:
        if plays:
            self.clock.play()
            self._last = perf_counter()
            self._timer.start()
        else:
            self.stop()
        self._show()

    def _tick(self) -> None:
        now = perf_counter()
        self.clock.advance(now - self._last)
        self._last = now
        if not self.clock.plays:
            self._timer.stop()
        self._show()

    def _step(self, steps: int) -> None:
        self.clock.step(steps)
        self._timer.stop()
        self._show()

    def _scrub(self, place: int) -> None:
        self.clock.go_to(place / SLIDER_STEPS_PER_S)
        self._show()

    def _set_speed(self, index: int) -> None:
        self.clock.speed = REPLAY_SPEEDS[index]

    def _set_loop(self, loops: bool) -> None:
        self.clock.loops = loops

    def _show(self) -> None:
        """Show the clock, without a signal from the slider."""
        with QSignalBlocker(self.slider):
            self.slider.setValue(round(self.clock.time * SLIDER_STEPS_PER_S))
        self.play.setChecked(self.clock.plays)
        self.play.setText("&Pause" if self.clock.plays else "&Play")
        times = (self.clock.time, self.clock.begin, self.clock.end)
        now, begin, end = (LOG_TIME_UNIT.number(each + self._shown_start) for each in times)
        self.time.setText(f"{now} of {begin} to {end}{LOG_TIME_UNIT.suffix}")
        self.moved.emit(self.clock.time)

    def _lay_out(self) -> None:
        said = label("This is a log, not a live flight.", "muted")
        head = hbox(
            self.name, said, 1, *self.card_buttons.values(), self.absolute, self.whole, self.back
        )
        row = hbox(
            self.play,
            self.earlier,
            self.later,
            (self.slider, 1),
            self.time,
            buddy("Spee&d", self.speed, kind=""),
            self.speed,
            self.loop,
            spacing=8,
        )
        vbox(head, self.remark, row, of=self, margins=(10, 6, 10, 6), spacing=4)
        self.slider.setSingleStep(SLIDER_STEPS_PER_S // 10)
        self.slider.setPageStep(SLIDER_STEPS_PER_S)
        self.time.setMinimumWidth(
            self.fontMetrics().horizontalAdvance("0000.00 of 0000.00 to 0000.00 s")
        )

    def _connect(self) -> None:
        self.play.clicked.connect(self._toggle_play)
        self.slider.valueChanged.connect(self._scrub)
        self.speed.currentIndexChanged.connect(self._set_speed)
        self.loop.clicked.connect(self._set_loop)
