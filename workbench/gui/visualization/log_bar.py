"""The bar with which a log is played."""

from time import perf_counter

from PyQt6.QtCore import QSignalBlocker, Qt, QTimer, pyqtSignal
from PyQt6.QtWidgets import (
    QComboBox,
    QFrame,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QSlider,
    QVBoxLayout,
    QWidget,
)

from workbench.gui.charts.ticks import number_text
from workbench.gui.style import set_class
from workbench.gui.visualization.log_messages import LogContents

SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0)
STEP = 0.1
"""Time of a single step [s]."""

PERIOD = 16
"""Between two pictures while it plays [ms]."""
PARTS = 100
"""Of a second that the slider tells apart."""


class LogClock:
    """A time within a log that runs, stands, or is moved.

    Args:
        begin: time of the log's first sample [s].
        end: of its last one [s].

    Attributes:
        begin: see there.
        end: see there.
        time: that is shown [s].
        speed: seconds of the log in a second.
        plays: whether it runs.
        loops: whether it begins again at the end.
    """

    def __init__(self, begin: float, end: float) -> None:
        self.begin, self.end = begin, max(begin, end)
        self.time = self.end
        self.speed = 1.0
        self.plays = False
        self.loops = False

    def play(self) -> None:
        """Run; from the start if it stands at the end."""
        if self.time >= self.end:
            self.time = self.begin
        self.plays = True

    def pause(self) -> None:
        """Stand."""
        self.plays = False

    def go_to(self, time: float) -> None:
        """Show a time [s]."""
        self.time = min(max(time, self.begin), self.end)

    def step(self, steps: int) -> None:
        """Stand, and show a time some steps later."""
        self.pause()
        self.go_to(self.time + STEP * steps)

    def advance(self, passed: float) -> None:
        """Let a wall time pass [s]."""
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


class LogBar(QFrame):
    """Time bar of a log.

    Args:
        parent: the Qt parent; this object is deleted with it.
    """

    moved = pyqtSignal(float)
    """The time that is to be shown [s]."""
    whole_wanted = pyqtSignal(float, float)
    """All of the log is to be seen, from a time to another [s]."""
    live_wanted = pyqtSignal()
    """The log is no longer wanted."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.clock = LogClock(0.0, 0.0)
        self._last = 0.0
        self._timer = QTimer(self)
        self._timer.setInterval(PERIOD)
        self._timer.timeout.connect(self._tick)
        set_class(self, "card")
        self.name = QLabel()
        set_class(self.name, "heading")
        self.remark = QLabel()
        self.remark.setWordWrap(True)
        set_class(self.remark, "warning")
        self.back = QPushButton("Back to &live")
        self.play = QPushButton("&Play")
        self.play.setCheckable(True)
        self.earlier = QPushButton("− 0.1 s")
        self.later = QPushButton("+ 0.1 s")
        self.whole = QPushButton("&Whole log")
        self.loop = QPushButton("L&oop")
        self.loop.setCheckable(True)
        self.speed = QComboBox()
        self.speed.addItems([f"{speed:g} ×" for speed in SPEEDS])
        self.speed.setCurrentIndex(SPEEDS.index(1.0))
        self.slider = QSlider(Qt.Orientation.Horizontal)
        self.time = QLabel()
        self._lay_out()
        self._connect()

    def show_log(self, contents: LogContents) -> None:
        """Show a log that was read, at its end."""
        self.clock = LogClock(contents.begin, contents.end)
        self.clock.speed = SPEEDS[self.speed.currentIndex()]
        self.clock.loops = self.loop.isChecked()
        self.name.setText(f"LOG  {contents.path.name}")
        self.name.setToolTip(f"{contents.path}, vehicle {contents.vehicle}")
        self.remark.setText(contents.remark)
        self.remark.setVisible(bool(contents.remark))
        with QSignalBlocker(self.slider):  # a range that leaves its value out moves it
            self.slider.setRange(round(contents.begin * PARTS), round(contents.end * PARTS))
        self.slider.setAccessibleDescription(f"{contents.begin:.2f} to {contents.end:.2f} s")
        self._show()

    def stop(self) -> None:
        """Play no more."""
        self.clock.pause()
        self._timer.stop()
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
        self.clock.go_to(place / PARTS)
        self._show()

    def _set_speed(self, index: int) -> None:
        self.clock.speed = SPEEDS[index]

    def _set_loop(self, loops: bool) -> None:
        self.clock.loops = loops

    def _show(self) -> None:
        """Show the clock, without an echo from the slider."""
        self.slider.blockSignals(True)
        self.slider.setValue(round(self.clock.time * PARTS))
        self.slider.blockSignals(False)
        self.play.setChecked(self.clock.plays)
        self.play.setText("&Pause" if self.clock.plays else "&Play")
        now, end = number_text(self.clock.time, 2), number_text(self.clock.end, 2)
        begin = number_text(self.clock.begin, 2)
        self.time.setText(f"{now} of {begin} to {end} s")
        self.moved.emit(self.clock.time)

    def _lay_out(self) -> None:
        head = QHBoxLayout()
        head.addWidget(self.name)
        said = QLabel("This is a log, no live flight.")
        set_class(said, "muted")
        head.addWidget(said)
        head.addStretch(1)
        head.addWidget(self.whole)
        head.addWidget(self.back)
        label = QLabel("Sp&eed")
        label.setBuddy(self.speed)
        row = QHBoxLayout()
        row.setSpacing(8)
        steps = (self.play, self.earlier, self.later)
        for button in steps:
            row.addWidget(button)
        row.addWidget(self.slider, 1)
        for widget in (self.time, label, self.speed, self.loop):
            row.addWidget(widget)
        box = QVBoxLayout(self)
        box.setContentsMargins(10, 6, 10, 6)
        box.setSpacing(4)
        box.addLayout(head)
        box.addWidget(self.remark)
        box.addLayout(row)
        self.slider.setAccessibleName("Time of the log in s")
        self.slider.setSingleStep(PARTS // 10)
        self.slider.setPageStep(PARTS)
        self.speed.setAccessibleName("Seconds of the log in a second")
        self.earlier.setAccessibleName("A tenth of a second earlier")
        self.later.setAccessibleName("A tenth of a second later")
        self.time.setMinimumWidth(
            self.fontMetrics().horizontalAdvance("0000.00 of 0000.00 to 0000.00 s")
        )

    def _connect(self) -> None:
        self.play.clicked.connect(self._toggle_play)
        self.earlier.clicked.connect(lambda: self._step(-1))
        self.later.clicked.connect(lambda: self._step(1))
        self.slider.valueChanged.connect(self._scrub)
        self.speed.currentIndexChanged.connect(self._set_speed)
        self.loop.clicked.connect(self._set_loop)
        self.whole.clicked.connect(lambda: self.whole_wanted.emit(self.clock.begin, self.clock.end))
        self.back.clicked.connect(self.live_wanted)
