"""Lines of fixed height at the lower edge of the window: a notice, and the guide for beginners."""

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from PyQt6.QtCore import QSettings, Qt, QTimer
from PyQt6.QtGui import QAction, QMouseEvent, QResizeEvent
from PyQt6.QtWidgets import QFrame, QSizePolicy, QWidget

from workbench.control.mode import FlightMode
from workbench.gui.command_action import show_tip
from workbench.gui.flight_model import FlightModel
from workbench.gui.icons import icon, picture
from workbench.gui.labels import FixedLinesLabel, Label, set_tip
from workbench.gui.layout import button, hbox, label, named, tool_button
from workbench.gui.notice_list import NoticeList
from workbench.gui.notice_panel import NOTICE_COLOURS, NoticePanel
from workbench.gui.notices import Notice, Severity
from workbench.gui.remedy_buttons import RemedyButtons
from workbench.gui.style import set_class
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView

if TYPE_CHECKING:
    from workbench.gui.gains.gain_editor import GainEditor


NOTICE_POLL_MS = 1000
"""Period between checks for notices that are no longer new [ms]."""
NOTICE_LINES = 2
"""Height of the banner's sentence in lines, whatever it says: so the banner moves nothing."""
NO_NOTICE_TEXT = "No new notices"
NOTICE_ICON_PX = 22
LIST_BUTTON_PADDING_PX = 24
"""Padding around the text of the button [px]."""


class Banner(QFrame):
    """One notice, at a fixed place at the lower edge, and the way to the list of all.

    The gravest new one is shown, or else the gravest that stays: a failure, or an alarm that has
    its cause. Its buttons have fixed places.

    Args:
        workspace: source of the notices.
        actions: actions that a remedy may name.

    Attributes:
        remedies: buttons for the shown notice.
        list_button: opens the list, and says how many notices it has.
        panel: the list, None before it was opened.
    """

    def __init__(self, workspace: Workspace, actions: Mapping[str, QAction]) -> None:
        super().__init__()
        self.setObjectName("banner")
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)
        self._look, self._keys = workspace.look, workspace.keys
        self._actions = actions
        self._list = NoticeList(lambda: time.monotonic())
        self.panel: NoticePanel | None = None
        self._shape = Label()
        self._shape.setFixedWidth(NOTICE_ICON_PX)
        self._said = FixedLinesLabel(NOTICE_LINES)
        self._said.setCursor(Qt.CursorShape.PointingHandCursor)
        self.remedies = RemedyButtons(actions)
        self.list_button = button("", self.toggle_list)
        show_tip(self.list_button, actions["notices"])
        widest = self.list_button.fontMetrics().horizontalAdvance("Notices: 88 ▴")
        self.list_button.setFixedWidth(widest + LIST_BUTTON_PADDING_PX)
        close = tool_button("", self.dismiss, "quiet compact")
        self._close = named(close, "Dismiss the notice")
        show_tip(self._close, actions["dismiss"])
        parts = (self._shape, (self._said, 1), self.remedies, self.list_button, self._close)
        hbox(*parts, of=self, margins=(12, 4, 10, 4), spacing=10)
        self._timer = QTimer(self)
        self._timer.setInterval(NOTICE_POLL_MS)
        self._timer.timeout.connect(self._show)
        workspace.notices.told.connect(self.add)
        workspace.notices.ended.connect(self._end_alarm)
        workspace.flight.begun.connect(self._end_of_flight)
        workspace.flight.taken_over.connect(self._end_warnings)
        workspace.look.changed.connect(self._show)
        self._show()

    @property
    def shown(self) -> Notice | None:
        """The shown notice."""
        return next(iter(self._list.present), None)

    def add(self, notice: Notice) -> None:
        """Add a notice."""
        in_text = self._keys.in_text
        notice = replace(notice, what=in_text(notice.what), remedy=in_text(notice.remedy))
        self._list.add(notice)
        self._timer.start()
        self._show()

    def dismiss(self) -> None:
        """Dismiss the shown notice; the list still has it."""
        shown = self.shown
        self._end(lambda notice: notice == shown)

    def toggle_list(self) -> None:
        """Show or hide the list of all notices."""
        if self.panel is None:
            self.panel = NoticePanel(
                self._list, self._show, self._actions, self._look, self.window() or self
            )
        if self.panel.isVisible():
            self.panel.hide()
        else:
            self.panel.show_above(self)

    def mouseReleaseEvent(self, event: QMouseEvent | None) -> None:
        """Show or hide the list; Qt's name."""
        if event is not None and event.button() == Qt.MouseButton.LeftButton:
            self.toggle_list()

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Keep the list above the banner; Qt's name."""
        super().resizeEvent(event)
        if self.panel is not None and self.panel.isVisible():
            self.panel.place_above(self)

    def _end(self, over: Callable[[Notice], bool]) -> None:
        self._list.end(over)
        self._show()

    def _end_alarm(self, what: str) -> None:
        self._end(lambda notice: notice.of_flight and notice.what == what)

    def _end_of_flight(self, _: LiveView) -> None:
        """End failures and alarms of the last flight; the end of a pause ends none."""
        self._end(lambda notice: notice.severity is Severity.FAILURE or notice.of_flight)

    def _end_warnings(self, view: LiveView) -> None:
        """End warnings about a controller's file once its text flies."""
        self._end(lambda notice: notice.severity is Severity.WARNING)
        if view.controller is not None:
            said = f"The controller {view.controller.name} has taken over."
            self.add(Notice(Severity.INFORMATION, said))

    def _show(self) -> None:
        first, count = self.shown, len(self._list.ordered)
        self.list_button.setText(f"Notices: {count} ▴")
        self._close.setEnabled(first is not None)
        self._close.setIcon(icon("close", self._look.colour("ink")))
        if not self._list.has_new:
            self._timer.stop()
        if self.panel is not None and self.panel.isVisible():
            self.panel.show_notices()
        if first is None:
            self._shape.clear()
            said, word = NO_NOTICE_TEXT, ""
        else:
            word = first.severity.value
            colour = self._look.colour(NOTICE_COLOURS[first.severity])
            self._shape.setPixmap(picture(word, colour, NOTICE_ICON_PX, self.devicePixelRatioF()))
            said = f"{word.capitalize()}: {first.sentence} {first.remedy}".rstrip()
        set_class(self, word)
        set_class(self._said, "" if first is not None else "muted")
        self._said.setText(said)
        set_tip(self._said, said)
        self.setAccessibleName(said)
        self.remedies.show_remedy(first.advice if first is not None else "")


GUIDE_DONE_KEY = "guide/done"
"""Settings key: whether the guide was completed or skipped."""
AIRBORNE_MODES = (
    FlightMode.HOVERING,
    FlightMode.ASCENDING,
    FlightMode.DESCENDING,
    FlightMode.CRUISING,
)


GUIDE_STAGES = (
    ("Take off", "Press F6. F12 stops the rotors at any time."),
    (
        "Fly a step",
        "Press Start in the card Excitation (Ctrl+E). The chart shows the step as predicted and as "
        "flown, with its numbers.",
    ),
    (
        "Move a gain",
        "Drag the slider of a gain of the loop whose setpoint stepped. Margins and the predicted "
        "step follow; a gain that would make a loop unstable does not fly.",
    ),
    (
        "Keep it",
        "Press Keep (Ctrl+K). Revert (Ctrl+Shift+K) restores the gains that were kept last.",
    ),
)
"""Stages of the guide: a title of a few words, and instructions in a sentence."""
GUIDE_END_TEXT = "F1 lists all keys, and First minutes in the menu Help starts this again."
"""What the line shows after the last stage, until the user closes it."""


class BeginnerGuide(QFrame):
    """Shows the next step in a line above the banner, and advances when the user has done it.

    It goes only when the user closes it, so that nothing moves under the pointer.

    Args:
        flight: the observed flight.
        store: remembers that the guide is done.
        show_tuning: shows the tuning screen, and returns its gains.
        parent: the Qt parent.
        in_text: puts the user's keys into a text.
    """

    def __init__(
        self,
        flight: FlightModel,
        store: QSettings,
        show_tuning: Callable[[], "GainEditor | None"],
        parent: QWidget | None = None,
        in_text: Callable[[str], str] = str,
    ) -> None:
        super().__init__(parent)
        self._in_text = in_text
        self.setObjectName("guide")
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)
        self._store, self._show_tuning = store, show_tuning
        self._stage = len(GUIDE_STAGES)
        self._excited = False
        self._gains: GainEditor | None = None
        self._what, self._how = label(kind="heading"), FixedLinesLabel(NOTICE_LINES)
        help = "Close these hints, and do not show them again"
        self.skip = button("Close hints", self.end, help=help)
        hbox(self._what, (self._how, 1), self.skip, of=self)
        flight.viewed.connect(self._follow)
        self.hide()

    @property
    def wanted(self) -> bool:
        """Whether the user has neither completed nor skipped the guide."""
        return str(self._store.value(GUIDE_DONE_KEY, False)).lower() != "true"

    def begin(self) -> None:
        """Show the first stage."""
        self._gains = self._show_tuning()
        if self._gains is not None:
            self._enter(0)

    def end(self) -> None:
        """Close the guide for good."""
        self._stage = len(GUIDE_STAGES)
        self._store.setValue(GUIDE_DONE_KEY, True)
        self.hide()

    def _enter(self, stage: int) -> None:
        self._stage, self._excited = stage, False
        last = len(GUIDE_STAGES)
        if stage == last:
            self._store.setValue(GUIDE_DONE_KEY, True)
            what, how = "Done", GUIDE_END_TEXT
        else:
            title, how = map(self._in_text, GUIDE_STAGES[stage])
            what = f"{stage + 1} of {last}: {title}"
        self._what.setText(what)
        self._how.setText(how)
        self.setAccessibleName(f"{self._what.text()}. {how}")
        self.show()

    def _follow(self, view: LiveView) -> None:
        if self._stage < len(GUIDE_STAGES) and self._is_done(view):
            self._enter(self._stage + 1)

    def _is_done(self, view: LiveView) -> bool:
        """Return whether the present stage is done."""
        assert self._gains is not None
        match self._stage:
            case 0:
                return view.snapshot is not None and view.snapshot.mode in AIRBORNE_MODES
            case 1:
                if view.exciting is not None and view.exciting.rounds_flown:
                    return True  # it may repeat for as long as it likes
                over = self._excited and view.exciting is None and not view.excitation_ended
                self._excited = view.exciting is not None
                return over
            case 2:
                return self._has_tried(self._gains, view)
            case _:
                return not self._has_tried(self._gains, view)

    def _has_tried(self, gains: "GainEditor", view: LiveView) -> bool:
        """Return whether a gain is being tried that the scenario's script has not set."""
        script = view.scenario.script if view.scenario is not None else ()
        scripted = {each for action in script for each in action.set.items()}
        return any((name, gains.flown[name]) not in scripted for name in gains.tried)
