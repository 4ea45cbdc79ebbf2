"""The button that measures the chosen loop on the flight, and what was measured of each loop."""

from collections.abc import Mapping

from PyQt6.QtCore import QObject, pyqtSignal
from PyQt6.QtWidgets import QPushButton

from workbench.analysis.questions import PlanMeasurement, Question
from workbench.analysis.replies import MeasurementPlanned
from workbench.control.mode import FlightMode
from workbench.design.judge.measured_loop import measured_loop
from workbench.gui.tuning.drawn_loop import DrawnLoop, drawn_measurement
from workbench.gui.tuning.excitation_card import BUSY, GROUNDED
from workbench.gui.tuning.margins_card import loop_label
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView
from workbench.session.injected import Injected

HELP = (
    "Add a multisine to this loop of the flight, and draw what it measures beside the model: with "
    "the gains that fly, in some {seconds:.0f} s of flight"
)
USUAL = 100.0
"""How long a measurement takes [s]: eight periods of 0.5 rad/s."""
Gains = Mapping[str, float]
Key = tuple[str, str, tuple[tuple[str, float], ...]]


class LoopMeasuring(QObject):
    """Asks for an injection, flies it, and keeps what it measures, with the gains that flew.

    Args:
        workspace: whose flight is measured, and whose analyst plans it.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        button: begins and ends a measurement.
        said: how it goes, "" where none is flown.
    """

    changed = pyqtSignal()
    """Something was measured, or it goes on."""

    def __init__(self, workspace: Workspace, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._flight, self._analysis = workspace.flight, workspace.analysis
        self._notices = workspace.notices
        self.button = QPushButton("Measure")
        self.button.setToolTip(HELP.format(seconds=USUAL))
        self.button.clicked.connect(self._press)
        self.said = ""
        self._analysis.measurement_planned.connect(self._fly)
        self._analysis.refused.connect(self._hear_refusal)
        self._wanted: tuple[str, str, Gains] = ("", "", {})
        self.begin()

    def begin(self) -> None:
        """Forget another flight."""
        self._measured: dict[Key, DrawnLoop] = {}
        self._asked: PlanMeasurement | None = None
        self._flown: Key | None = None
        self._seen: Injected | None = None
        self._share: float | None = None
        self._say("")

    def choose(self, loop: str, cut: str, gains: Gains) -> None:
        """Measure this loop next, with the gains that fly."""
        self._wanted = loop, cut, gains
        self._show_button()

    def known(self, loop: str, cut: str, gains: Gains) -> DrawnLoop | None:
        """Return what was measured of a loop with these gains, None where nothing was."""
        return self._measured.get(_key(loop, cut, gains))

    def keep(self, loop: str, cut: str, gains: Gains, drawn: DrawnLoop) -> None:
        """Keep what was measured."""
        self._measured[_key(loop, cut, gains)] = drawn
        self.changed.emit()

    def show_view(self, view: LiveView) -> None:
        """Show how a measurement goes, and what it has measured by now."""
        before, self._share = self._share, view.measuring
        measured = view.measured
        if measured is not None and measured is not self._seen and self._flown is not None:
            self._seen = measured
            found = measured_loop(measured)
            self._measured[self._flown] = drawn_measurement(
                found.frequency, found.response, found.coherence, found.deviation
            )
            self.changed.emit()
        if self._share is not None and self._flown is not None:
            # what is told in whole percents changes a hundred times, not sixty a second
            name = loop_label(self._flown[0])
            self._say(f"Measuring {name}: {100.0 * self._share:.0f} %")
        elif before is not None:
            self._say("")
        self._show_button()

    @property
    def _busy(self) -> bool:
        return self._share is not None or self._asked is not None

    def _press(self) -> None:
        if self._share is not None:
            self._flight.order(lambda live: live.stop_exciting())
            return
        loop, cut, gains = self._wanted
        self._asked = PlanMeasurement(gains, loop, cut)
        self._say("Finding what the loop bears …")
        self._analysis.ask(self._asked)

    def _fly(self, planned: MeasurementPlanned) -> None:
        if planned.asked != self._asked:
            return
        self._asked = None
        self._flown = _key(planned.asked.loop, planned.asked.cut, planned.asked.gains)
        self._seen = self._flight.view.measured  # of the measurement before
        self._say("")
        self._flight.order(
            lambda live: live.measure(planned.injection, hold=planned.hold),
            refused=lambda said: self._refuse(said),
        )

    def _hear_refusal(self, question: Question, said: str) -> None:
        if isinstance(question, PlanMeasurement) and question == self._asked:
            self._asked = None
            self._say("")

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
        flies = mode not in (*GROUNDED, *BUSY)
        stops = self._share is not None
        text = "Stop" if stops else "Measure"
        if self.button.text() != text:
            self.button.setText(text)
        self.button.setEnabled(stops or (flies and bool(self._wanted[0]) and not self._busy))


def _key(loop: str, cut: str, gains: Gains) -> Key:
    return loop, cut, tuple(sorted(gains.items()))
