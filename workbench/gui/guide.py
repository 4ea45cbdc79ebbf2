"""The first minutes: a line that says what to do next, until it was done."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from PyQt6.QtCore import QSettings
from PyQt6.QtWidgets import QFrame, QLabel, QPushButton, QSizePolicy, QWidget

from workbench.control.mode import FlightMode
from workbench.gui.flight_model import FlightModel
from workbench.gui.layout import hbox
from workbench.gui.notices import Notices
from workbench.gui.style import dressed
from workbench.live.view import LiveView

if TYPE_CHECKING:
    from workbench.gui.gains.gain_editor import GainEditor

DONE = "guide/done"
"""Of settings: whether the guide was gone through or skipped."""
HOVERS = (
    FlightMode.HOVERING,
    FlightMode.ASCENDING,
    FlightMode.DESCENDING,
    FlightMode.CRUISING,
)


@dataclass(frozen=True)
class Stage:
    """Something to do.

    Attributes:
        what: in a few words.
        how: a sentence.
    """

    what: str
    how: str


STAGES = (
    Stage("Take off", "Press F6. F12 stops the rotors at any time."),
    Stage(
        "Fly a step",
        "Press Start in the card Excitation (Ctrl+E). The chart shows the step as predicted and as "
        "flown, with its numbers.",
    ),
    Stage(
        "Move a gain",
        "Drag the slider of Velocity x Kp. Margins and the predicted step follow; what would make "
        "a loop unstable does not fly.",
    ),
    Stage("Keep it", "Press Keep (Ctrl+K). Revert (Ctrl+Shift+K) goes back to what was kept last."),
)
END = "That was it. F1 lists all keys, and First minutes in the menu Help begins again."


class Guide(QFrame):
    """Says what to do next, in a line above the banner, and goes on once it was done.

    Args:
        flight: that is watched.
        notices: where the end is told.
        store: remembers that it was gone through.
        show_tuning: shows the tuning screen, and returns its gains.
        parent: in which it stands.
    """

    def __init__(
        self,
        flight: FlightModel,
        notices: Notices,
        store: QSettings,
        show_tuning: Callable[[], "GainEditor | None"],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setObjectName("guide")
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)
        self._notices, self._store, self._show_tuning = notices, store, show_tuning
        self._stage = len(STAGES)
        self._excited = False
        self._gains: GainEditor | None = None
        self._what, self._how = dressed(QLabel(), "heading"), QLabel()
        self._how.setWordWrap(True)
        self.skip = QPushButton("Ski&p")
        self.skip.setToolTip("Close these hints, and do not show them again")
        self.skip.clicked.connect(self.end)
        hbox(self._what, (self._how, 1), self.skip, of=self)
        flight.viewed.connect(self._follow)
        self.hide()

    @property
    def wanted(self) -> bool:
        """Whether nobody has gone through it, or skipped it."""
        return str(self._store.value(DONE, False)).lower() != "true"

    def begin(self) -> None:
        """Begin with the first stage."""
        self._gains = self._show_tuning()
        if self._gains is not None:
            self._enter(0)

    def end(self) -> None:
        """Go away, for good."""
        self._stage = len(STAGES)
        self._store.setValue(DONE, True)
        self.hide()

    def _enter(self, stage: int) -> None:
        self._stage, self._excited = stage, False
        if stage == len(STAGES):
            self.end()
            self._notices.inform(END)
            return
        self._what.setText(f"{stage + 1} of {len(STAGES)}: {STAGES[stage].what}")
        self._how.setText(STAGES[stage].how)
        self.setAccessibleName(f"{self._what.text()}. {STAGES[stage].how}")
        self.show()

    def _follow(self, view: LiveView) -> None:
        if self._stage < len(STAGES) and self._is_done(view):
            self._enter(self._stage + 1)

    def _is_done(self, view: LiveView) -> bool:
        """Return whether the present stage was done."""
        assert self._gains is not None
        match self._stage:
            case 0:
                return view.snapshot is not None and view.snapshot.mode in HOVERS
            case 1:
                over = self._excited and view.exciting is None and not view.excitation_ended
                self._excited = view.exciting is not None
                return over
            case 2:
                return bool(self._gains.tried)
            case _:
                return not self._gains.tried
