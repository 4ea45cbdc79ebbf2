"""The table of actions, from which menus, buttons, keys and the page of keys are made.

F12 stops the rotors: a single key at the end of a row, easy to find without looking, and unused in
text fields, number fields, tables and plots. No other key stops them in any way: the button never
has the keyboard focus, and no menu contains the action.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from PyQt6.QtGui import QAction
from PyQt6.QtWidgets import QMenu, QMenuBar

from workbench.control.installed_laws import installed_laws, installed_programs
from workbench.gui.screen_table import SCREEN_TABLE

RECENT_FILES_MENU = "Recent &files"
ACTION_ABOVE_RECENT = "open_log"
"""Name of the action above the recent files."""

FILE_MENU, FLIGHT_MENU, VIEW_MENU, HELP_MENU = "&File", "F&light", "&View", "&Help"
MENU_TITLES = (FILE_MENU, FLIGHT_MENU, VIEW_MENU, HELP_MENU)


def fill_menus(bar: QMenuBar, actions: Mapping[str, QAction]) -> dict[str, QMenu]:
    """Fill the menu bar, and return all menus by their text."""
    made = {}
    for text in MENU_TITLES:
        menu = QMenu(text, bar)
        bar.addMenu(menu)
        made[text] = menu
        for row in menu_rows(text):
            if not row.in_menu:
                continue
            if row.after_line:
                menu.addSeparator()
            if row.submenu and row.submenu not in made:
                made[row.submenu] = QMenu(row.submenu, menu)
                menu.addMenu(made[row.submenu])
            made.get(row.submenu, menu).addAction(actions[row.name])
            if row.name == ACTION_ABOVE_RECENT:
                made[RECENT_FILES_MENU] = QMenu(RECENT_FILES_MENU, made[FILE_MENU])
                menu.addMenu(made[RECENT_FILES_MENU])
    return made


@dataclass(frozen=True)
class ActionRow:
    """An action with its words, key and place.

    Attributes:
        name: unique name.
        menu: its menu in the menu bar, "" for one of a screen.
        text: its text in the menu, with the mnemonic.
        help: what it does, as a sentence.
        shortcut: its key as Qt writes it, unless the user has chosen another; "" without one.
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


THEME_NAMES = ("system", "light", "dark")
THEME_MENU = "T&heme"
REAL_TIME_FACTORS = (0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0)
"""Selectable real-time factors."""
SPEED_MENU = "Spee&d"
CONTROLLER_MENU = "Con&troller"
CAMERA_MENU = "3-D &camera"

ACTION_TABLE: tuple[ActionRow, ...] = (
    ActionRow("open_scenario", FILE_MENU, "&Open scenario...", "Fly another scenario.", "Ctrl+O"),
    ActionRow(
        "open_model",
        FILE_MENU,
        "Open &drone...",
        "Fly another drone in the present scenario: xacro, URDF or SDF.",
        "Ctrl+Shift+O",
    ),
    ActionRow("open_world", FILE_MENU, "Open &world...", "Fly in another world.", "Ctrl+Shift+W"),
    *(
        ActionRow(
            f"controller_{name}",
            FILE_MENU,
            name,
            f"Let the control law {name} take over in flight, with its own gains.",
            submenu=CONTROLLER_MENU,
        )
        for name in installed_laws()
    ),
    *(
        ActionRow(
            f"controller_{name}",
            FILE_MENU,
            name,
            f"Start another flight with {name}, a separate program that runs the law.",
            submenu=CONTROLLER_MENU,
        )
        for name in installed_programs()
    ),
    ActionRow(
        "open_controller",
        FILE_MENU,
        "&Your own...",
        "Let a control law of your own take over in flight: a Python file, whose code runs.",
        submenu=CONTROLLER_MENU,
    ),
    ActionRow("open_log", FILE_MENU, "Open &log...", "Show a recorded flight.", "Ctrl+L"),
    ActionRow(
        "record",
        FILE_MENU,
        "&Record",
        "Start or stop writing a log (MCAP).",
        "Ctrl+Shift+R",
        "record",
        checkable=True,
        after_line=True,
    ),
    ActionRow(
        "screenshot",
        FILE_MENU,
        "S&creenshot",
        "Write a picture of the window.",
        "Ctrl+Shift+S",
        "screenshot",
    ),
    ActionRow("quit", FILE_MENU, "&Quit", "End the flight and close.", "Ctrl+Q", after_line=True),
    ActionRow("arm", FLIGHT_MENU, "&Arm", "Let the rotors idle.", "F5", "arm"),
    ActionRow("take_off", FLIGHT_MENU, "&Take off", "Climb to 1.5 m and hover.", "F6", "take_off"),
    ActionRow(
        "hold",
        FLIGHT_MENU,
        "&Hold",
        "Brake and hold the position; ends any manoeuvre, and the scenario's script.",
        "F7",
        "hold",
    ),
    ActionRow("land", FLIGHT_MENU, "&Land", "Come down and switch the rotors off.", "F8", "land"),
    ActionRow(
        "open_hooks",
        FLIGHT_MENU,
        "&Open hooks",
        "Drop the loads on cables; again, take those that their cables reach.",
        "Ctrl+G",
        checkable=True,
    ),
    ActionRow(
        "stop",
        FLIGHT_MENU,
        "STOP",
        "Switch the rotors off at once; in the air it falls. Works wherever the keyboard is.",
        "F12",
        "stop",
        in_menu=False,
    ),
    ActionRow(
        "pause",
        FLIGHT_MENU,
        "&Pause",
        "Pause or resume simulated time.",
        "F9",
        "pause",
        checkable=True,
        after_line=True,
    ),
    ActionRow(
        "step", FLIGHT_MENU, "Si&ngle step", "While paused, fly one control period.", "F10", "step"
    ),
    ActionRow(
        "reset",
        FLIGHT_MENU,
        "&Reset",
        "Start the flight again, with its first gains.",
        "Ctrl+R",
        "reset",
    ),
    *(
        ActionRow(
            f"speed_{factor:g}",
            FLIGHT_MENU,
            f"{factor:g} times real time",
            f"Fly {factor:g} simulated seconds in a second.",
            submenu=SPEED_MENU,
        )
        for factor in REAL_TIME_FACTORS
    ),
    *(
        ActionRow(
            f"show_{screen.name}",
            VIEW_MENU,
            f"&{screen.shortcut[-1]} {screen.title}".replace("&N ", "&"),
            f"Show the {screen.title} screen.",
            screen.shortcut,
            screen.icon,
            checkable=True,
            button=screen.title,
        )
        for screen in SCREEN_TABLE
    ),
    ActionRow(
        "view_3d",
        VIEW_MENU,
        "3-D view &beside",
        "Show the flight in 3-D beside any screen, or hide it.",
        "Ctrl+0",
        "view3d",
        checkable=True,
        after_line=True,
    ),
    ActionRow(
        "browse_3d",
        VIEW_MENU,
        "3-D view in the br&owser",
        "Open the 3-D view in the browser.",
        "Ctrl+Shift+0",
    ),
    *(
        ActionRow(
            f"look_{way}", VIEW_MENU, text, help, shortcut, submenu=CAMERA_MENU, button=button
        )
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
        VIEW_MENU,
        "Trai&l",
        "Show the last 30 s of the path in the 3-D view, or hide them.",
        "Ctrl+9",
        checkable=True,
        submenu=CAMERA_MENU,
    ),
    ActionRow(
        "arrows_3d",
        VIEW_MENU,
        "Thrust and &wind",
        "Show arrows of each rotor's thrust and of the wind in the 3-D view, or hide them.",
        checkable=True,
        submenu=CAMERA_MENU,
    ),
    ActionRow(
        "lidar_3d",
        VIEW_MENU,
        "Lidar &points",
        "Show the lidar's points in the 3-D view, or hide them.",
        checkable=True,
        submenu=CAMERA_MENU,
    ),
    ActionRow(
        "notices", VIEW_MENU, "&Notices", "Show or hide the list of notices.", "Ctrl+Shift+N"
    ),
    ActionRow(
        "dismiss", VIEW_MENU, "&Dismiss notice", "Dismiss the banner's notice.", "Ctrl+Shift+D"
    ),
    ActionRow("full_screen", VIEW_MENU, "&Full screen", "Fill the screen.", "F11", checkable=True),
    *(
        ActionRow(
            f"theme_{theme}",
            VIEW_MENU,
            f"&{theme.capitalize()}",
            "Colours of the desktop." if theme == "system" else f"{theme} colours.",
            checkable=True,
            submenu=THEME_MENU,
        )
        for theme in THEME_NAMES
    ),
    ActionRow(
        "guide", HELP_MENU, "&First minutes", "Take off, fly a step, move a gain and keep it."
    ),
    ActionRow(
        "explain",
        HELP_MENU,
        "&What is this?",
        "Click on a card to read what it means, with a link into the docs.",
        "Shift+F1",
    ),
    ActionRow("keys", HELP_MENU, "&Keys", "All shortcuts on one page.", "F1"),
    ActionRow("about", HELP_MENU, "&About", "About the app, and its licence."),
)


def find_action(name: str) -> ActionRow:
    """Return the row with a name; a KeyError is a programming error."""
    return {row.name: row for row in ACTION_TABLE}[name]


def menu_rows(menu: str) -> Iterable[ActionRow]:
    """Return the rows of a menu, in order."""
    return [row for row in ACTION_TABLE if row.menu == menu]
