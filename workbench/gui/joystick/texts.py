"""Lines of help on the joystick screen."""

from workbench.gui.joystick.game_pad import PadButton

MODE_HELP = "Forward is where the nose points."
KEYS_HELP = "Keys: W A S D and the arrows, held down; not while a field or a slider has the focus."
NO_PAD = "Game pad: none is plugged in; it is found as soon as it is."


def say_pad(missing: str, name: str) -> str:
    """Return a line on the game pad.

    Args:
        missing: why there can be none, "" else.
        name: of the pad, "" without one.
    """
    if missing:
        return missing
    if not name:
        return NO_PAD
    buttons = ", ".join(f"{each.place}: {each.words}" for each in PadButton)
    return f"Game pad: {name}. {buttons}."
