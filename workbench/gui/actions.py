"""The table of actions, from which menus, buttons, shortcuts and the page of keys are made.

F12 stops the rotors: a single key at the end of a row, easy to find without looking, and unused in
text fields, number fields, tables and plots. No other key stops them in any way: the button never
has the keyboard focus, and no menu contains the action.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from PyQt6.QtCore import Qt
from PyQt6.QtGui import QAction, QKeySequence
from PyQt6.QtWidgets import QMenu, QMenuBar, QWidget

from workbench.control.controller import PROGRAMS, SHIPPED
from workbench.gui.labels import set_tip
from workbench.gui.screen_table import SCREENS

RECENT = "Recent &files"
REPEATED = ("step", "undo", "redo")
"""Actions that a held key repeats."""
AFTER = "open_log"
"""Name of the action above the recent files."""

FILE, FLIGHT, VIEW, HELP = "&File", "F&light", "&View", "&Help"
MENUS = (FILE, FLIGHT, VIEW, HELP)


def fill_menus(bar: QMenuBar, actions: Mapping[str, QAction]) -> dict[str, QMenu]:
    """Fill the menu bar, and return all menus by their text."""
    made = {}
    for text in MENUS:
        menu = QMenu(text, bar)
        bar.addMenu(menu)
        made[text] = menu
        for row in rows_of(text):
            if not row.in_menu:
                continue
            if row.after_line:
                menu.addSeparator()
            if row.submenu and row.submenu not in made:
                made[row.submenu] = QMenu(row.submenu, menu)
                menu.addMenu(made[row.submenu])
            made.get(row.submenu, menu).addAction(actions[row.name])
            if row.name == AFTER:
                made[RECENT] = QMenu(RECENT, made[FILE])
                menu.addMenu(made[RECENT])
    return made


@dataclass(frozen=True)
class ActionRow:
    """An action with its words, key and place.

    Attributes:
        name: unique name.
        menu: its menu in the menu bar, "" for one of a screen.
        text: its text in the menu, with the mnemonic.
        help: what it does, as a sentence.
        shortcut: key sequence as Qt writes it, "" without one.
        icon: name of the icon, see `icons`, "" without one.
        checkable: whether it can be switched on and off.
        after_line: whether a separator precedes it.
        submenu: its submenu, "" for none.
        button: text on its button, if different.
        in_menu: whether the menu contains it.
    """

    name: str
    menu: str
    text: str
    help: str
    shortcut: str = ""
    icon: str = ""
    checkable: bool = False
    after_line: bool = False
    submenu: str = ""
    button: str = ""
    in_menu: bool = True

    @property
    def label(self) -> str:
        """The text without its mnemonic."""
        return self.text.replace("&", "").removesuffix("...")


THEMES = ("system", "light", "dark")
THEME_MENU = "T&heme"
SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0)
"""Selectable real-time factors."""
SPEED_MENU = "Spee&d"
CONTROLLER_MENU = "Con&troller"
CAMERA_MENU = "3-D &camera"

ACTIONS: tuple[ActionRow, ...] = (
    ActionRow("open_scenario", FILE, "&Open scenario...", "Fly another scenario.", "Ctrl+O"),
    ActionRow(
        "open_model",
        FILE,
        "Open &model...",
        "Fly another drone in the present scenario: xacro, URDF or SDF.",
        "Ctrl+Shift+O",
    ),
    ActionRow("open_world", FILE, "Open &world...", "Fly in another world.", "Ctrl+Shift+W"),
    *(
        ActionRow(
            f"controller_{name}",
            FILE,
            name,
            f"Let the control law {name} take over in flight, with its own gains.",
            submenu=CONTROLLER_MENU,
        )
        for name in SHIPPED
    ),
    *(
        ActionRow(
            f"controller_{name}",
            FILE,
            name,
            f"Start another flight with {name}, a separate program that runs the law.",
            submenu=CONTROLLER_MENU,
        )
        for name in PROGRAMS
    ),
    ActionRow(
        "open_controller",
        FILE,
        "&Your own...",
        "Let a control law of your own take over in flight: a Python file, whose code runs.",
        submenu=CONTROLLER_MENU,
    ),
    ActionRow("open_log", FILE, "Open &log...", "Show a recorded flight.", "Ctrl+L"),
    ActionRow(
        "record",
        FILE,
        "&Record",
        "Start or stop writing a log (MCAP).",
        "Ctrl+Shift+R",
        "record",
        checkable=True,
        after_line=True,
    ),
    ActionRow(
        "screenshot",
        FILE,
        "S&creenshot",
        "Write a picture of the window.",
        "Ctrl+Shift+S",
        "screenshot",
    ),
    ActionRow("quit", FILE, "&Quit", "End the flight and close.", "Ctrl+Q", after_line=True),
    ActionRow("arm", FLIGHT, "&Arm", "Let the rotors idle.", "F5", "arm"),
    ActionRow("take_off", FLIGHT, "&Take off", "Climb to 1.5 m and hover.", "F6", "take_off"),
    ActionRow(
        "hold", FLIGHT, "&Hold", "Brake and hold the position; ends any manoeuvre.", "F7", "hold"
    ),
    ActionRow("land", FLIGHT, "&Land", "Come down and switch the rotors off.", "F8", "land"),
    ActionRow(
        "stop",
        FLIGHT,
        "STOP",
        "Switch the rotors off at once; in the air it falls. Works wherever the keyboard is.",
        "F12",
        "stop",
        in_menu=False,
    ),
    ActionRow(
        "pause",
        FLIGHT,
        "&Pause",
        "Pause or resume simulated time.",
        "F9",
        "pause",
        checkable=True,
        after_line=True,
    ),
    ActionRow(
        "step", FLIGHT, "Si&ngle step", "While paused, fly one control period.", "F10", "step"
    ),
    ActionRow(
        "reset",
        FLIGHT,
        "&Reset",
        "Start the flight again, with its first gains.",
        "Ctrl+R",
        "reset",
    ),
    *(
        ActionRow(
            f"speed_{factor:g}",
            FLIGHT,
            f"{factor:g} times real time",
            f"Fly {factor:g} simulated seconds in a second.",
            submenu=SPEED_MENU,
        )
        for factor in SPEEDS
    ),
    *(
        ActionRow(
            f"show_{screen.name}",
            VIEW,
            f"&{number} {screen.title}",
            f"Show the {screen.title} screen.",
            f"Ctrl+{number}",
            screen.icon,
            checkable=True,
            button=screen.title,
        )
        for number, screen in enumerate(SCREENS, start=1)
    ),
    ActionRow(
        "view_3d",
        VIEW,
        "3-D view &beside",
        "Show the flight in 3-D beside any screen, or hide it.",
        "Ctrl+0",
        "view3d",
        checkable=True,
        after_line=True,
    ),
    ActionRow(
        "browse_3d",
        VIEW,
        "3-D view in the br&owser",
        "Open the 3-D view in the browser.",
        "Ctrl+Shift+0",
    ),
    *(
        ActionRow(f"look_{way}", VIEW, text, help, shortcut, submenu=CAMERA_MENU, button=button)
        for way, text, button, help, shortcut in (
            (
                "follow",
                "&Follow",
                "Follow",
                "Show the drone from behind, as it turns.",
                "Ctrl+7",
            ),
            ("top", "&Top", "Top", "Show the drone from above, north up.", "Ctrl+8"),
            ("side", "&Side", "Side", "Show the drone from the south, height up.", "Ctrl+Shift+8"),
            (
                "free",
                "Fr&ee",
                "Free",
                "Keep the camera still while the drone moves.",
                "Ctrl+Shift+7",
            ),
            ("reset", "&Reset view", "Reset", "Show the drone as at the start.", "Ctrl+Shift+9"),
        )
    ),
    ActionRow(
        "trail_3d",
        VIEW,
        "Trai&l",
        "Show the last 30 s of the path in the 3-D view, or hide them.",
        "Ctrl+9",
        checkable=True,
        submenu=CAMERA_MENU,
    ),
    ActionRow(
        "arrows_3d",
        VIEW,
        "Thrust and &wind",
        "Show arrows of each rotor's thrust and of the wind in the 3-D view, or hide them.",
        checkable=True,
        submenu=CAMERA_MENU,
    ),
    ActionRow(
        "lidar_3d",
        VIEW,
        "Lidar &points",
        "Show the lidar's points in the 3-D view, or hide them.",
        checkable=True,
        submenu=CAMERA_MENU,
    ),
    ActionRow("dismiss", VIEW, "&Dismiss notice", "Dismiss the banner's notice.", "Ctrl+Shift+D"),
    ActionRow("full_screen", VIEW, "&Full screen", "Fill the screen.", "F11", checkable=True),
    *(
        ActionRow(
            f"theme_{theme}",
            VIEW,
            f"&{theme.capitalize()}",
            "Colours of the desktop." if theme == "system" else f"{theme} colours.",
            checkable=True,
            submenu=THEME_MENU,
        )
        for theme in THEMES
    ),
    ActionRow("guide", HELP, "&First minutes", "Take off, fly a step, move a gain and keep it."),
    ActionRow(
        "explain",
        HELP,
        "&What is this?",
        "Click on a card to read what it means, with a link into the docs.",
        "Shift+F1",
    ),
    ActionRow("keys", HELP, "&Keys", "All shortcuts on one page.", "F1"),
    ActionRow("about", HELP, "&About", "About the app, and its licence."),
)


def make_actions(
    parent: QWidget,
    handlers: Mapping[str, Callable[[], object]],
    rows: Iterable[ActionRow] = ACTIONS,
    context: Qt.ShortcutContext = Qt.ShortcutContext.ApplicationShortcut,
) -> dict[str, QAction]:
    """Return an action for each row of a table, by name.

    Args:
        parent: widget that gets the actions.
        handlers: what each action calls, by name.
        rows: the table.
        context: where the shortcuts work.
    """
    made = {}
    for row in rows:
        action = QAction(row.text, parent)
        action.setObjectName(row.name)
        action.setIconText(row.button or row.label)
        action.setCheckable(row.checkable)
        set_tip(action, tip(row))
        action.setStatusTip(row.help)
        if row.shortcut:
            action.setShortcut(QKeySequence(row.shortcut))
            action.setShortcutContext(context)
            action.setAutoRepeat(row.name in REPEATED)
        handler = handlers[row.name]
        action.triggered.connect(lambda _checked, handler=handler: handler())
        parent.addAction(action)
        made[row.name] = action
    return made


def tip(row: ActionRow) -> str:
    """Return the tooltip of a button."""
    return f"{row.help} ({row.shortcut})" if row.shortcut else row.help


def find_row(name: str) -> ActionRow:
    """Return the row with a name; a KeyError is a programming error."""
    return {row.name: row for row in ACTIONS}[name]


def rows_of(menu: str) -> Iterable[ActionRow]:
    """Return the rows of a menu, in order."""
    return [row for row in ACTIONS if row.menu == menu]
