"""The table of all keys that can be changed, by group."""

from workbench.gui.actions import MENU_TITLES, ActionRow, menu_rows
from workbench.gui.gains.gain_actions import GAIN_ACTIONS

EXCITE_KEY = ActionRow("excite", "", "Excite", "Start or stop the excitation.", "Ctrl+E")
FIND_GAIN_KEY = ActionRow("find_gain", "", "Search", "Search the parameters.", "Ctrl+F")
TIME_KEYS = (
    ActionRow("play", "", "Play", "Play or pause the log that is shown, else the flight.", "Space"),
)
CHART_KEYS = (
    ActionRow("cursor_a", "", "Cursor A", "Set cursor A at the crosshair of a chart.", "A"),
    ActionRow("cursor_b", "", "Cursor B", "Set cursor B at the crosshair of a chart.", "B"),
    ActionRow("statistics", "", "Statistics", "Show or hide the statistics of a chart.", "S"),
    ActionRow("zero", "", "Zero", "Always show zero in a chart.", "Z"),
)
"""Keys of the chart under the pointer, or else of the first one."""
STICK_KEYS = (
    ActionRow("stick_climb", "", "Climb", "Climb while it is held.", "W"),
    ActionRow("stick_sink", "", "Sink", "Sink while it is held.", "S"),
    ActionRow("stick_turn_left", "", "Turn left", "Turn left while it is held.", "A"),
    ActionRow("stick_turn_right", "", "Turn right", "Turn right while it is held.", "D"),
    ActionRow("stick_forward", "", "Forward", "Fly forward while it is held.", "Up"),
    ActionRow("stick_back", "", "Back", "Fly back while it is held.", "Down"),
    ActionRow("stick_left", "", "Left", "Fly to the left while it is held.", "Left"),
    ActionRow("stick_right", "", "Right", "Fly to the right while it is held.", "Right"),
)
SERVO_KEYS = (
    ActionRow("servo_raise", "", "Servo up", "Move the setpoint of the chosen servo up.", "R"),
    ActionRow("servo_lower", "", "Servo down", "Move the setpoint of the chosen servo down.", "F"),
    ActionRow("servo_next", "", "Next servo", "Choose the next servo.", "T"),
)
"""Keys of the servos beside the sticks."""

KEY_GROUPS: tuple[tuple[str, tuple[ActionRow, ...]], ...] = (
    *((title.replace("&", ""), tuple(menu_rows(title))) for title in MENU_TITLES),
    ("Gains", GAIN_ACTIONS),
    ("Tuning", (EXCITE_KEY, FIND_GAIN_KEY)),
    ("Time", TIME_KEYS),
    ("Charts", CHART_KEYS),
    ("Sticks", STICK_KEYS),
    ("Servos", SERVO_KEYS),
)
"""All rows, below the heading of their group."""
KEY_ROWS = tuple(row for _, rows in KEY_GROUPS for row in rows)
