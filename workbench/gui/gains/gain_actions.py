"""The table of what can be done with a set of gains, by buttons, menus and keys."""

from workbench.gui.actions import ActionRow

GAIN_SLOTS = ("A", "B", "C")
"""Slots for sets of gains, each compared by one key."""
GAIN_MENU_ACTIONS = (
    "load",
    "own",
    "save",
    "history",
    "report",
    "",
    "copy",
    "paste",
    "",
    "import",
    "export",
    "",
    "schedule",
    "",
    *(f"store_{slot}" for slot in GAIN_SLOTS),
)
"""Names of the actions in the menu of the gain file; "" is a separator."""

GAIN_ACTIONS: tuple[ActionRow, ...] = (
    ActionRow(
        "keep", "", "&Keep", "Keep the gains that fly, so that Revert restores them.", "Ctrl+K"
    ),
    ActionRow(
        "revert",
        "",
        "&Revert",
        "Fly the kept gains at once, in any case.",
        "Ctrl+Shift+K",
    ),
    ActionRow("undo", "", "↶", "Undo the last change.", "Ctrl+Z"),
    ActionRow("redo", "", "↷", "Redo the change that was undone.", "Ctrl+Shift+Z"),
    ActionRow("discard", "", "&Back", "Discard the proposed gains that do not fly (Esc).", ""),
    ActionRow(
        "confirm",
        "",
        "Fly",
        "Fly the proposed gains in spite of the warning.",
        "Ctrl+Return",
    ),
    *(
        ActionRow(
            f"compare_{slot}",
            "",
            slot,
            f"Fly the gains of slot {slot}; press again to go back. An empty slot stores those "
            "shown.",
            f"F{number}",
        )
        for number, slot in enumerate(GAIN_SLOTS, start=2)
    ),
    *(
        ActionRow(
            f"store_{slot}",
            "",
            f"Store in slot &{slot}",
            f"Store the gains that are shown in slot {slot}.",
            f"Shift+F{number}",
        )
        for number, slot in enumerate(GAIN_SLOTS, start=2)
    ),
    ActionRow(
        "load",
        "",
        "&Load...",
        "Choose gains from a gain file; none flies until you confirm.",
        "Ctrl+Shift+L",
    ),
    ActionRow(
        "own",
        "",
        "&Model's own...",
        "Choose gains from those of the model.",
        "Ctrl+Shift+M",
    ),
    ActionRow(
        "history",
        "",
        "Histor&y...",
        "Show the gains that were kept and saved, with notes, and propose earlier ones.",
        "Ctrl+H",
    ),
    ActionRow(
        "report",
        "",
        "&Report",
        "Write a page with the gains, notes and pictures of this session.",
        "Ctrl+Shift+P",
    ),
    ActionRow("save", "", "&Save...", "Write the gains that fly to a gain file.", "Ctrl+S"),
    ActionRow(
        "copy",
        "",
        "&Copy YAML",
        "Copy the gains that fly as the text of a gain file.",
        "Ctrl+Shift+C",
    ),
    ActionRow(
        "import",
        "",
        "&Import from autopilot...",
        "Choose gains from an autopilot's parameter file; none flies until you confirm.",
        "Ctrl+Shift+I",
    ),
    ActionRow(
        "export",
        "",
        "&Export to autopilot...",
        "Write the gains that fly to an autopilot's file; all else in it stays.",
        "Ctrl+Shift+E",
    ),
    ActionRow(
        "schedule",
        "",
        "Sc&hedule...",
        "Use a set of gains at each of some speeds, heights, payloads or voltages.",
        "Ctrl+Shift+H",
    ),
    ActionRow(
        "paste", "", "&Paste YAML...", "Choose gains from the text of a gain file.", "Ctrl+Shift+V"
    ),
)
