"""Lines at the lower edge of the window: notices with remedies, and the guide for beginners."""

import math
import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from PyQt6.QtCore import QSettings, Qt, QTimer
from PyQt6.QtGui import QAction
from PyQt6.QtWidgets import (
    QFrame,
    QPushButton,
    QSizePolicy,
    QWidget,
)

from workbench.control.mode import FlightMode
from workbench.gui.file_dialogs import clipboard
from workbench.gui.flight_model import FlightModel
from workbench.gui.icons import icon, picture
from workbench.gui.labels import Label
from workbench.gui.layout import button, hbox, label, named, tool_button, vbox
from workbench.gui.notices import Notice, Notices, Severity
from workbench.gui.style import set_class
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView

if TYPE_CHECKING:
    from workbench.gui.gains.gain_editor import GainEditor


STAYS = {Severity.INFORMATION: 8.0, Severity.WARNING: 20.0, Severity.FAILURE: math.inf}
"""How long a notice stays if the user does not dismiss it [s]."""
MOST = 20
"""Limit of waiting notices; beyond it the oldest are dropped, failures last."""

TICK = 1000
"""Period between checks for expired notices [ms]."""
REMEDIES = (
    ("reset", "reset"),
    ("open a scenario", "open_scenario"),
    ("hide the 3-d view", "view_3d"),
)
"""Words of a remedy, and the action that carries it out."""
COLOURS = {
    Severity.INFORMATION: "accent",
    Severity.WARNING: "warning",
    Severity.FAILURE: "bad",
}
ICON = 22


class Banner(QFrame):
    """One notice at a time, at the lower edge, where it moves nothing under the pointer.

    The most severe one is shown, of equals the newest. A repeated sentence is only counted.

    Args:
        workspace: source of the notices.
        actions: actions that a remedy may name.
    """

    def __init__(self, workspace: Workspace, actions: Mapping[str, QAction]) -> None:
        super().__init__()
        self.setObjectName("banner")
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)
        self._look = workspace.look
        self._actions = actions
        self._told: list[tuple[Notice, int, float]] = []  # how often, and until when [s]
        self._shape = Label()
        self._word = label(kind="heading")
        self._what = label(wraps=True)
        self._what.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._remedy = label(kind="muted", wraps=True)
        self._more = label(kind="muted")
        self._offers: list[QPushButton] = []
        self._copy = button("&Copy details", self._copy_details)
        close = tool_button("", self.dismiss, "quiet compact", "Dismiss (Ctrl+Shift+D)")
        self._close = named(close, "Dismiss the notice, Ctrl+Shift+D")
        self._lay_out()
        self._timer = QTimer(self)
        self._timer.setInterval(TICK)
        self._timer.timeout.connect(self._expire)
        workspace.notices.told.connect(self.add)
        workspace.flight.begun.connect(self._forget_failures)
        workspace.flight.taken_over.connect(self._forget_warnings)
        workspace.look.changed.connect(self._show)
        self.hide()

    @property
    def _first(self) -> tuple[Notice, int, float] | None:
        ranks = list(Severity)
        return max(self._told, key=lambda each: ranks.index(each[0].severity), default=None)

    @property
    def shown(self) -> Notice | None:
        """The shown notice."""
        return self._first[0] if self._first else None

    @property
    def offers(self) -> tuple[QPushButton, ...]:
        """Buttons for the actions in the remedy."""
        return tuple(self._offers)

    def add(self, notice: Notice) -> None:
        """Add a notice."""
        equal = [
            each
            for each in self._told
            if (each[0].what, each[0].severity) == (notice.what, notice.severity)
        ]
        times = 1 + sum(times for _, times, _ in equal)
        until = time.monotonic() + STAYS[notice.severity]
        self._told = [(notice, times, until), *(each for each in self._told if each not in equal)]
        if len(self._told) > MOST:
            passing = [each for each in self._told if each[2] < math.inf]
            self._told.remove((passing or self._told)[-1])
        self._timer.start()
        self._show()

    def dismiss(self) -> None:
        """Dismiss the shown notice."""
        self._keep(lambda each: each is not self._first)

    def _keep(self, wanted: Callable[[tuple[Notice, int, float]], bool]) -> None:
        """Drop the other notices."""
        kept = [each for each in self._told if wanted(each)]
        if len(kept) != len(self._told):
            self._told = kept
            self._show()

    def _forget_failures(self, _: LiveView) -> None:
        """Drop failures that ended with the last flight; the end of a pause drops none."""
        self._keep(lambda each: each[0].severity is not Severity.FAILURE)

    def _forget_warnings(self, view: LiveView) -> None:
        """Drop warnings about a controller's file once its text flies; the event list has them."""
        self._keep(lambda each: each[0].severity is not Severity.WARNING)
        if view.controller is not None:
            self.add(
                Notice(
                    Severity.INFORMATION, f"The controller {view.controller.name} has taken over."
                )
            )

    def _expire(self) -> None:
        now = time.monotonic()
        self._keep(lambda each: each[2] > now)

    def _show(self) -> None:
        first = self._first
        self.setVisible(first is not None)
        if first is None:
            self._timer.stop()
            return
        notice, count, _ = first
        word = notice.severity.value
        colour = self._look.colour(COLOURS[notice.severity])
        set_class(self, word)
        self._shape.setPixmap(picture(word, colour, ICON, self.devicePixelRatioF()))
        self._word.setText(word.capitalize())
        times = f"  (×{count})" if count > 1 else ""
        self._what.setText(notice.what[:1].upper() + notice.what[1:] + times)
        self._remedy.setText(notice.remedy)
        self._remedy.setVisible(bool(notice.remedy))
        waiting = len(self._told) - 1
        self._more.setText(f"{waiting} more" if waiting else "")
        self._more.setVisible(waiting > 0)
        self._copy.setVisible(bool(notice.details))
        self._close.setIcon(icon("close", self._look.colour("ink")))
        self._offer(notice.remedy)
        self.setAccessibleName(f"{word}: {notice.what}{times} {notice.remedy}")

    def _offer(self, remedy: str) -> None:
        """Make a button for each action that the remedy names."""
        words = remedy.lower()
        names = [name for said, name in REMEDIES if said in words and name in self._actions]
        if names == [each.objectName() for each in self._offers]:
            return
        for each in self._offers:
            self._buttons.removeWidget(each)
            each.deleteLater()
        self._offers = []
        for at, name in enumerate(names):
            action = self._actions[name]
            offer = button(action.iconText(), action.trigger, help=action.toolTip())
            offer.setObjectName(name)
            self._buttons.insertWidget(at, offer)
            self._offers.append(offer)

    def _copy_details(self) -> None:
        if self.shown is not None:
            clipboard().setText(self.shown.details)

    def _lay_out(self) -> None:
        words = vbox(self._what, self._remedy, spacing=1)
        self._buttons = hbox(self._copy, self._more, self._close, spacing=6)
        for each in (self._shape, self._word):
            each.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Preferred)
        parts = (self._shape, self._word, (words, 1), self._buttons)
        hbox(*parts, of=self, margins=(12, 7, 10, 7), spacing=10)


DONE = "guide/done"
"""Settings key: whether the guide was completed or skipped."""
HOVERS = (
    FlightMode.HOVERING,
    FlightMode.ASCENDING,
    FlightMode.DESCENDING,
    FlightMode.CRUISING,
)


STAGES = (
    ("Take off", "Press F6. F12 stops the rotors at any time."),
    (
        "Fly a step",
        "Press Start in the card Excitation (Ctrl+E). The chart shows the step as predicted and as "
        "flown, with its numbers.",
    ),
    (
        "Move a gain",
        "Drag the slider of Velocity x Kp. Margins and the predicted step follow; a gain that "
        "would make a loop unstable does not fly.",
    ),
    (
        "Keep it",
        "Press Keep (Ctrl+K). Revert (Ctrl+Shift+K) restores the gains that were kept last.",
    ),
)
"""Stages of the guide: a title of a few words, and instructions in a sentence."""
END = "This is the end. F1 lists all keys, and First minutes in the menu Help starts again."


class Guide(QFrame):
    """Shows the next step in a line above the banner, and advances when the user has done it.

    Args:
        flight: the observed flight.
        notices: takes the final notice.
        store: remembers that the guide is done.
        show_tuning: shows the tuning screen, and returns its gains.
        parent: the Qt parent.
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
        self._what, self._how = label(kind="heading"), label(wraps=True)
        help = "Close these hints, and do not show them again"
        self.skip = button("Ski&p", self.end, help=help)
        hbox(self._what, (self._how, 1), self.skip, of=self)
        flight.viewed.connect(self._follow)
        self.hide()

    @property
    def wanted(self) -> bool:
        """Whether the user has neither completed nor skipped the guide."""
        return str(self._store.value(DONE, False)).lower() != "true"

    def begin(self) -> None:
        """Show the first stage."""
        self._gains = self._show_tuning()
        if self._gains is not None:
            self._enter(0)

    def end(self) -> None:
        """Close the guide for good."""
        self._stage = len(STAGES)
        self._store.setValue(DONE, True)
        self.hide()

    def _enter(self, stage: int) -> None:
        self._stage, self._excited = stage, False
        if stage == len(STAGES):
            self.end()
            self._notices.inform(END)
            return
        what, how = STAGES[stage]
        self._what.setText(f"{stage + 1} of {len(STAGES)}: {what}")
        self._how.setText(how)
        self.setAccessibleName(f"{self._what.text()}. {how}")
        self.show()

    def _follow(self, view: LiveView) -> None:
        if self._stage < len(STAGES) and self._is_done(view):
            self._enter(self._stage + 1)

    def _is_done(self, view: LiveView) -> bool:
        """Return whether the present stage is done."""
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
