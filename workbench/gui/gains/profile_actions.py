"""The table of what can be done with gains from anywhere on the screen that tunes them."""

from dataclasses import dataclass

from workbench.gui.gains.gain_slots import SLOTS


@dataclass(frozen=True)
class ProfileAction:
    """Something that a key does.

    Attributes:
        name: unique.
        text: on its button or in its menu, with its mnemonic.
        shortcut: as Qt writes it.
        help: what it does, a sentence.
    """

    name: str
    text: str
    shortcut: str
    help: str

    @property
    def tip(self) -> str:
        """What a pointer over its button tells."""
        return f"{self.help} ({self.shortcut})"


PROFILE_ACTIONS: tuple[ProfileAction, ...] = (
    ProfileAction(
        "keep", "&Keep", "Ctrl+K", "Let the gains that fly be those that Revert brings back."
    ),
    ProfileAction(
        "revert", "Re&vert", "Ctrl+Shift+K", "Fly the kept gains at once, whatever is the matter."
    ),
    ProfileAction("undo", "↶", "Ctrl+Z", "Take the last change back."),
    ProfileAction("redo", "↷", "Ctrl+Shift+Z", "Make the change again that was taken back."),
    *(
        ProfileAction(
            f"compare_{slot}",
            slot,
            f"F{number}",
            f"Fly the gains of slot {slot}; again, go back. An empty slot takes those shown.",
        )
        for number, slot in enumerate(SLOTS, start=2)
    ),
    *(
        ProfileAction(
            f"store_{slot}",
            f"Store in slot &{slot}",
            f"Shift+F{number}",
            f"Store the gains that are shown in slot {slot}.",
        )
        for number, slot in enumerate(SLOTS, start=2)
    ),
    ProfileAction(
        "load", "&Load...", "Ctrl+Shift+L", "Choose lines of a gain file; none flies before."
    ),
    ProfileAction(
        "own", "&Model's own...", "Ctrl+Shift+M", "Choose lines of the gains the model came with."
    ),
    ProfileAction("save", "&Save...", "Ctrl+S", "Write what flies to a gain file."),
    ProfileAction(
        "copy", "&Copy YAML", "Ctrl+Shift+C", "Copy what flies as the text of a gain file."
    ),
    ProfileAction("paste", "&Paste YAML...", "Ctrl+Shift+V", "Choose lines of a gain file's text."),
)
