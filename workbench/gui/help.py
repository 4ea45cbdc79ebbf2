"""Help in the app: about each card of the screens, pages of the docs, all keys, and "about"."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from html import escape
from typing import Any

from PyQt6.QtCore import QEvent, QObject, Qt, QUrl
from PyQt6.QtGui import QDesktopServices, QImage, QTextCursor, QTextDocument, QWhatsThisClickedEvent
from PyQt6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QGridLayout,
    QLabel,
    QScrollArea,
    QTextBrowser,
    QWidget,
)

from workbench.common.resources import docs_dir
from workbench.gui.actions import MENUS, rows_of
from workbench.gui.gains.gain_bar import GAIN_ACTIONS
from workbench.gui.layout import NO_MARGINS, grid, hbox, label, vbox

SIZE = (860, 640)
"""Size of the window [px]."""
WIDEST = 800
"""Width limit of pictures [px]."""


def anchor(heading: str) -> str:
    """Return the anchor of a heading, as GitHub forms it."""
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


class DocsBrowser(QTextBrowser):
    """Shows a page at a heading; links to other pages open here, external ones in the browser."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName("A page of the docs")
        self.setOpenLinks(False)
        self.anchorClicked.connect(self._follow)
        self._page = ""

    def open(self, link: str) -> None:
        """Show a page, as `linear.md#the-judgement`; without a name, the present one."""
        name, _, heading = link.partition("#")
        if name and name != self._page:
            path = docs_dir() / name
            if path.suffix != ".md" or not path.is_file():
                self.setPlainText(f"{name} is not among the docs in {docs_dir()}.")
                return
            self._page = name
            self.setMarkdown(path.read_text(encoding="utf-8"))
        self.show_heading(heading)

    def show_heading(self, wanted: str) -> None:
        """Scroll to the heading with an anchor, or to the top."""
        document = self.document()
        assert document is not None
        block = document.begin()
        while block.isValid() and not (
            block.blockFormat().headingLevel() and anchor(block.text()) == wanted
        ):
            block = block.next()
        found = block if block.isValid() else document.begin()
        self.setTextCursor(QTextCursor(found))
        layout, bar = document.documentLayout(), self.verticalScrollBar()
        assert layout is not None and bar is not None
        bar.setValue(round(layout.blockBoundingRect(found).top()))

    def loadResource(self, kind: int, name: QUrl) -> Any:
        """Return a picture of the docs, no wider than the page."""
        if kind != QTextDocument.ResourceType.ImageResource.value:
            return super().loadResource(kind, name)
        picture = QImage(str(docs_dir() / name.toString()))
        smooth = Qt.TransformationMode.SmoothTransformation
        return picture.scaledToWidth(WIDEST, smooth) if picture.width() > WIDEST else picture

    def _follow(self, url: QUrl) -> None:
        if url.scheme() in ("http", "https"):
            QDesktopServices.openUrl(url)
        else:
            self.open(url.toString())


def show_docs(link: str, parent: QWidget | None = None) -> QDialog:
    """Open a window with a page of the docs, and return it.

    Args:
        link: page and heading, as `linear.md#the-judgement`.
        parent: the Qt parent.
    """
    dialog = QDialog(parent)
    dialog.setWindowTitle("Docs")
    browser = DocsBrowser(dialog)
    vbox(browser, of=dialog, margins=NO_MARGINS)
    dialog.resize(*SIZE)
    dialog.show()  # first, because positions follow from the width
    browser.open(link)
    return dialog


@dataclass(frozen=True)
class CardHelp:
    """Help about one card.

    Attributes:
        title: title of the card.
        means: what it shows, as a sentence.
        read: how to read or use it, as another sentence.
        page: page of the docs and heading: `linear.md#the-judgement`.
    """

    title: str
    means: str
    read: str
    page: str

    @property
    def text(self) -> str:
        """The complete help as rich text."""
        words = f"{escape(self.means)} {escape(self.read)}"
        return (
            f'<b>{escape(self.title)}</b><p>{words}</p><p><a href="{self.page}">More in the '
            f"docs: {self.page.split('#')[0]}</a></p>"
        )


HOME, SERVER, STICKS = "app.md#home", "app.md#server", "app.md#joystick"
CHARTS, TUNING, SETTINGS = "app.md#visualization", "app.md#tuning", "app.md#settings"
CARDS = (
    CardHelp(
        "Clock",
        "Wall time, simulated time, and how the flight keeps up with the wall clock.",
        "If it falls behind, a sentence says so.",
        HOME,
    ),
    CardHelp(
        "Flight condition",
        "The flight mode and its reason, rotors on or off, and the wind.",
        "Read it first if a command seems to have no effect.",
        HOME,
    ),
    CardHelp(
        "Motion",
        "Displacement since the start, velocity and acceleration in the world's frame W.",
        "The axes point east, north and up; total is the length of the vector.",
        HOME,
    ),
    CardHelp(
        "Battery",
        "The charge left, how long it lasts, and the reserve at which the drone lands by itself.",
        "The mark on the bar is the reserve; Settings say how large it is.",
        "estimation.md#the-battery",
    ),
    CardHelp(
        "Rotors",
        "Thrust and speed of each rotor as a bar, with its limit.",
        "A bar at its end means that the law commands more than the rotor can give.",
        HOME,
    ),
    CardHelp(
        "Attitude",
        "Roll, pitch and heading of the drone, as an artificial horizon and a compass.",
        "Roll is positive with the right side down, pitch with the nose down.",
        HOME,
    ),
    CardHelp(
        "IMU, magnetometer",
        "The latest readings of gyro, accelerometer and magnetometer.",
        "In hover the turn rates are near 0 and the specific force is 9.81 m/s² along z.",
        "sensors.md#failures",
    ),
    CardHelp(
        "Barometer, range finder",
        "Height by air pressure, and by the distance to the ground or obstacle below.",
        "They differ over obstacles, and the barometer drifts.",
        "sensors.md#failures",
    ),
    CardHelp(
        "Lidar, obstacles",
        "What the lidar measures: the nearest obstacles around the drone, seen from above.",
        "Brake if the distance in the direction of flight is short.",
        "sensors.md#the-nearest-obstacle",
    ),
    CardHelp(
        "GPS, path",
        "The fix of the GPS, and the flown path from above with a scale.",
        "North is up; the path of the estimate differs from the true one by the GPS's error.",
        HOME,
    ),
    CardHelp(
        "Server",
        "Whether this flight can be watched and flown over the network.",
        "Start begins the server, Stop ends it; the drone flies on.",
        "link.md#serve",
    ),
    CardHelp(
        "Where and who",
        "The address and the port on which the server listens, and who may connect.",
        "On another address than this machine's a token file is needed.",
        "link.md#serve",
    ),
    CardHelp(
        "Connect",
        "Commands and code that connect a client to this server.",
        "Copy a line into a terminal or a script on the other machine.",
        "link.md#watch-from-python",
    ),
    CardHelp(
        "Clients",
        "Who is connected, what each one reads, and who has control.",
        "Take over gives you control, Give back lets clients request it again.",
        "link.md#who-has-control",
    ),
    CardHelp(
        "Refusals",
        "What the server refused, with the reason.",
        "Each sentence says what to do about it.",
        "link.md#who-has-control",
    ),
    CardHelp(
        "Who flies",
        "Who flies the drone, and whether the sticks count now.",
        "If you have to press a button before they count, it is here.",
        STICKS,
    ),
    CardHelp(
        "Sticks",
        "Two sticks: the left one climbs and turns, the right one moves over the ground.",
        "The dot is where the stick is, forward is where the nose points, and releasing the stick "
        "holds the position.",
        STICKS,
    ),
    CardHelp(
        "Command and answer",
        "What the sticks command, and what the drone does, along four axes.",
        "The limits of the flight are marked on the bars.",
        STICKS,
    ),
    CardHelp(
        "Feel of the sticks",
        "How the travel of a stick becomes a command: full speed, dead band, sensitivity and expo.",
        "The curve shows the command over the travel; more expo makes small movements gentler.",
        STICKS,
    ),
    CardHelp(
        "Charts",
        "Signals of the flight or of an opened log over time, over frequency or over each other.",
        "Drag signals from the list onto a chart; the wheel zooms, a double click shows all.",
        CHARTS,
    ),
    CardHelp(
        "Lidar",
        "The cloud of the lidar's points, in colour.",
        "Choose above the picture in which frame it is drawn; the drone is in the middle.",
        CHARTS,
    ),
    CardHelp(
        "Camera",
        "The two pictures of the depth camera, and the scale of the depth.",
        "Settings say whether the flight has one.",
        CHARTS,
    ),
    CardHelp(
        "Frames",
        "All frames of the flight with their poses: world, drone, links and sensors.",
        "Choose one to read its position and angles.",
        "sensors.md#frames",
    ),
    CardHelp(
        "Events",
        "What happened in the flight: events, alarms and changed parameters, the newest last.",
        "Each has its simulated time.",
        CHARTS,
    ),
    CardHelp(
        "Log",
        "The opened log, and the time of it that all charts and the 3-D view show.",
        "Drag the slider or press Play; Back to live closes the log.",
        "logs.md#contents",
    ),
    CardHelp(
        "Gains",
        "The gains of the law that flies, grouped by loop, each with its own name and unit.",
        "Green on a slider is where the loop stays stable with the other gains as they are.",
        TUNING,
    ),
    CardHelp(
        "Excitation",
        "Excitation of the flight: a step, a load, a push, a gust, wind or a fault.",
        "Choose one and its amplitude, and press the button; Response shows the result.",
        TUNING,
    ),
    CardHelp(
        "Response",
        "The last steps that were flown, the predicted one dashed, and their numbers.",
        "A number over one of your limits is marked; ghosts are earlier steps.",
        TUNING,
    ),
    CardHelp(
        "Margins",
        "How far every loop is from instability, in gain, phase, delay and disk margin.",
        "A red number is under your limit; a click on a row draws that loop under Frequency.",
        "linear.md#the-judgement",
    ),
    CardHelp(
        "Margins with these",
        "The margins of every loop with the gains of the file, before they are taken.",
        "A red number is under your limit: leave out what causes it, or take nothing.",
        "linear.md#the-judgement",
    ),
    CardHelp(
        "Frequency",
        "One loop over frequency, with the gains that fly, those proposed and those kept.",
        "The curves show their margins where they cross 0 dB and −180°; sliders below move the "
        "loop's gains.",
        "app.md#tuning",
    ),
    CardHelp(
        "Poles",
        "Poles of the sampled closed loop in continuous terms, filled with the proposed gains.",
        "Left is faster and near the axis is less damped; drag one and the gains follow.",
        "app.md#tuning",
    ),
    CardHelp(
        "Map",
        "A metric over two gains around those proposed, from predicted flights.",
        "A click on a place proposes its gains.",
        TUNING,
    ),
    CardHelp(
        "Sensitivity",
        "Which gain changes the chosen metric most, for the same relative change.",
        "Start with the longest bar.",
        TUNING,
    ),
    CardHelp(
        "Compare",
        "Designs over each other: kept, flown, proposed, A, B, C and other laws.",
        "The best number of a row is bold and green, one over your limits is underlined.",
        TUNING,
    ),
    CardHelp(
        "What if",
        "The opened log as it was flown, and as it would have been with the proposed gains.",
        "Move a gain and compare the curves; the band shows the uncertainty of the vehicle.",
        "prediction.md#in-the-app",
    ),
    CardHelp(
        "Fork the flight",
        "Two flights from this moment on, side by side, with the numbers of each step.",
        "Keep the one you prefer; the live flight does not change until you do.",
        "live.md#forks",
    ),
    CardHelp(
        "Auto-tune",
        "Gains that meet your wishes, searched with predicted flights and verified in full "
        "flights.",
        "Write wishes as level.rise_time <= 0.4, then accept or refuse what is found.",
        "tuning.md#wishes",
    ),
    CardHelp(
        "Pin as regression",
        "Writes what was just flown as a spec with a baseline.",
        "From then on `workbench regress` fails if a number leaves its limits.",
        "regression.md#pins",
    ),
    CardHelp(
        "Settings: Appearance",
        "Whether the window is light, dark, or follows the desktop.",
        "It takes effect at once and is saved.",
        SETTINGS,
    ),
    CardHelp(
        "Settings: Units shown",
        "Units of angles and speeds on the screens.",
        "Files, logs and commands stay in SI units and radians.",
        SETTINGS,
    ),
    CardHelp(
        "Settings: Sticks",
        "How the travel of a stick becomes a command: full speed, dead band, sensitivity and expo.",
        "They are the same as on the Joystick screen, which draws their curve.",
        SETTINGS,
    ),
    CardHelp(
        "Settings: Charts",
        "How much of the past a chart shows.",
        "It takes effect at once and is saved.",
        SETTINGS,
    ),
    CardHelp(
        "Settings: Tuning",
        "Whether a moved slider flies at once, or only after Enter.",
        "It takes effect at once and is saved.",
        SETTINGS,
    ),
    CardHelp(
        "Settings: Files",
        "Where the Record button writes its logs.",
        "Left empty, they go to the folder in which the app was started.",
        SETTINGS,
    ),
    CardHelp(
        "Settings: Flight",
        "Whether flights are drawn in 3-D.",
        "It takes effect with the next flight.",
        SETTINGS,
    ),
    CardHelp(
        "Settings: Limits",
        "The largest speeds, tilt, height and yaw rate that the law flies.",
        "They take effect at once, and are saved for each vehicle.",
        SETTINGS,
    ),
    CardHelp(
        "Settings: The flight",
        "What a flight is built from: world, sensors, noise and rates.",
        "Press the button to start another flight with these settings.",
        SETTINGS,
    ),
)
_BY_TITLE = {row.title: row for row in CARDS}


def explain(card: QWidget, title: str) -> None:
    """Give a card its help, shown by *What is this?* (Shift+F1); a KeyError is a programming error.

    Args:
        card: the card; the help appears anywhere on it.
        title: title of a row of the table.
    """
    card.setWhatsThis(_BY_TITLE[title].text)
    card.installEventFilter(_Links(card))


class _Links(QObject):
    """Opens the docs when a link in a card's help is clicked."""

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Handle the click; other events pass."""
        if isinstance(event, QWhatsThisClickedEvent) and isinstance(watched, QWidget):
            show_docs(event.href(), watched.window())
            return True
        return False


LONGEST_KEY = "Ctrl+Shift+W  "
WORDS = 268
"""Width of an action's description: two columns fit into the smallest window [px]."""
MARGIN = 40
"""Margin between page and window [px]."""
TUNING_KEYS = (
    ("Ctrl+E", "Start or stop the excitation."),
    ("Ctrl+F", "Search the parameters."),
    ("Arrows", "Move the slider; with Shift in large steps, with Ctrl in small ones."),
    ("Enter", "Fly the proposed gains, if gains fly on Enter."),
    ("Ctrl+Return", "Fly the proposed gains in spite of a warning."),
    ("Esc", "Discard proposed gains that do not fly."),
)
ABOUT = (
    "<b>Drake drone workbench</b><br>Design a multirotor and its controller on Drake: fly it, "
    "watch it, and tune it while it flies.<br><br>Free software under the GNU General Public "
    "License, version 3 or later, without any warranty."
)


def keys_page(parent: QWidget | None = None) -> QDialog:
    """Return a dialog with all shortcuts, from the table of actions.

    Args:
        parent: the Qt parent.
    """
    dialog = QDialog(parent)
    dialog.setWindowTitle("Keys")
    page = QWidget()
    columns = hbox(of=page, spacing=24)
    for tables in (
        [(menu.replace("&", ""), _keys_of(menu)) for menu in MENUS],
        [("Tuning", _tuning_keys())],
    ):
        column = vbox()
        for heading, keys in tables:
            if keys:
                column.addLayout(_table(heading, keys))
                column.addSpacing(12)
        column.addStretch(1)
        columns.addLayout(column)
    scrolling = QScrollArea()
    scrolling.setWidgetResizable(True)
    scrolling.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    scrolling.setWidget(page)
    bar = scrolling.verticalScrollBar()
    assert bar is not None
    scrolling.setMinimumWidth(page.sizeHint().width() + bar.sizeHint().width())
    layout = vbox(scrolling, _close_button(dialog), of=dialog, margins=(22, 18, 22, 14))
    above = parent.window() if parent is not None else None
    room = above.height() - MARGIN if above is not None else page.sizeHint().height()
    rest = layout.minimumSize().height() - scrolling.minimumSizeHint().height()
    dialog.resize(0, min(room, page.sizeHint().height() + rest + MARGIN // 2))
    return dialog


def about_page(parent: QWidget | None = None) -> QDialog:
    """Return a dialog about the app and its licence.

    Args:
        parent: the Qt parent.
    """
    dialog = QDialog(parent)
    dialog.setWindowTitle("About")
    words = label(ABOUT, wraps=True)
    words.setTextFormat(Qt.TextFormat.RichText)
    words.setMinimumWidth(380)
    vbox(words, _close_button(dialog), of=dialog, margins=(22, 18, 22, 14))
    return dialog


def _table(heading: str, keys: Iterable[tuple[str, str]]) -> QGridLayout:
    """Return keys and their actions in two columns."""
    made = grid(spacing=(16, 3), stretches=(0, 1))
    made.addWidget(label(heading, "heading"), 0, 0, 1, 2)
    for at, (shortcut, help) in enumerate(keys, start=1):
        made.addWidget(_key(shortcut), at, 0, Qt.AlignmentFlag.AlignTop)
        words = label(help, wraps=True)
        words.setFixedWidth(WORDS)
        words.setMinimumHeight(words.heightForWidth(WORDS))
        made.addWidget(words, at, 1)
    made.setColumnMinimumWidth(0, QLabel(LONGEST_KEY).sizeHint().width())
    return made


def _keys_of(menu: str) -> list[tuple[str, str]]:
    return [(row.shortcut, row.help) for row in rows_of(menu) if row.shortcut]


def _tuning_keys() -> list[tuple[str, str]]:
    return [(row.shortcut, row.help) for row in GAIN_ACTIONS] + list(TUNING_KEYS)


def _key(shortcut: str) -> QLabel:
    key = QLabel(f"<b>{escape(shortcut)}</b>")
    key.setTextFormat(Qt.TextFormat.RichText)
    return key


def _close_button(dialog: QDialog) -> QDialogButtonBox:
    box = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
    box.rejected.connect(dialog.close)
    return box
