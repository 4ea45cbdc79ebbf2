"""The path of a pinned regression, apart from the card that asks for it."""

import re
from pathlib import Path

SUFFIX = ".spec.yaml"
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 ._-]*")


def spec_path(folder: str, name: str) -> Path:
    """Return where a spec of a name is written."""
    stem = name.strip().removesuffix(SUFFIX).replace(" ", "-")
    return Path(folder or ".").expanduser() / f"{stem}{SUFFIX}"


def name_fault(name: str) -> str:
    """Return what is wrong with a name, as a sentence; "" where nothing is."""
    if not name.strip():
        return "Give it a name."
    if not _NAME.fullmatch(name.strip()):
        return "Use letters, digits, spaces, dots, dashes and underscores."
    return ""


def regress_command(path: Path) -> str:
    """Return the command that flies a pinned regression, for a shell."""
    text = str(path)
    return f"workbench regress {_quoted(text)}"


def _quoted(text: str) -> str:
    if re.fullmatch(r"[\w./+-]+", text):
        return text
    return "'" + text.replace("'", "'\\''") + "'"
