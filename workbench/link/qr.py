"""An address as a QR code, for a terminal, and as a picture for the app."""

import io

import segno

QUIET_ZONE_MODULES = 4
"""Width of the light margin around a code in modules, from its standard."""
_DARK_ON_WHITE = "\x1b[38;5;16;48;5;231m"
_RESET_COLOURS = "\x1b[0m"
_HALF_BLOCKS = {(False, False): " ", (True, False): "▀", (False, True): "▄", (True, True): "█"}


def terminal_code(text: str) -> str:
    """Return a QR code as lines for a terminal, with two rows of modules per line.

    It sets its own colours, black on white, as not every phone reads a light code on a dark
    background.

    Args:
        text: an address.
    """
    rows = [
        [bool(module) for module in row]
        for row in _made(text).matrix_iter(border=QUIET_ZONE_MODULES)
    ]
    if len(rows) % 2:
        rows.append([False] * len(rows[0]))
    lines = (
        "".join(_HALF_BLOCKS[pair] for pair in zip(upper, lower, strict=True))
        for upper, lower in zip(rows[::2], rows[1::2], strict=True)
    )
    return "".join(f"{_DARK_ON_WHITE}{line}{_RESET_COLOURS}\n" for line in lines)


def png_code(text: str, scale: int = 8) -> bytes:
    """Return a QR code as PNG, black on white.

    Args:
        text: an address.
        scale: of a module [px].
    """
    out = io.BytesIO()
    _made(text).save(
        out, kind="png", scale=scale, border=QUIET_ZONE_MODULES, dark="black", light="white"
    )
    return out.getvalue()


def _made(text: str) -> segno.QRCode:
    """Return the code; it is readable with a seventh of it hidden."""
    return segno.make_qr(text, error="m")
