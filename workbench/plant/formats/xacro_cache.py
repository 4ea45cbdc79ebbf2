"""What xacro files expanded to, kept for as long as no file that was read has changed.

Expanding takes a process and a third of a second, and every command begins with it.
"""

import hashlib
import json
import os
import tempfile
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path

from workbench.common.cache import cache_folder
from workbench.common.errors import WorkbenchError

MOST_KEPT = 200
"""Expansions; the oldest go first."""


def kept_expansion(request: dict[str, object]) -> str | None:
    """Return the text that a request of `expand_xacro` led to before, if it still would."""
    try:
        entry = json.loads(_place(request).read_text(encoding="utf-8"))
        if all(_digest(Path(path)) == digest for path, digest in entry["read"].items()):
            return str(entry["text"])
    except (OSError, ValueError, KeyError, TypeError, AttributeError, WorkbenchError):
        return None  # never kept, or by somebody else: expand it
    return None


def keep_expansion(request: dict[str, object], text: str, read: Sequence[str]) -> None:
    """Keep an expansion with what was read for it; where nothing can be written, do nothing."""
    try:
        entry = {"read": {path: _digest(Path(path)) for path in read}, "text": text}
        place = _place(request)
        handle, partial = tempfile.mkstemp(dir=place.parent, prefix=".partial")
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            json.dump(entry, file)
        Path(partial).replace(place)
        kept = sorted(place.parent.glob("*.json"), key=lambda path: path.stat().st_mtime)
        for old in kept[:-MOST_KEPT]:
            old.unlink(missing_ok=True)
    except (OSError, WorkbenchError):
        return  # it works without


def _place(request: dict[str, object]) -> Path:
    """Return the file for a request."""
    asked = json.dumps([request, metadata.version("xacro"), str(Path.cwd())], sort_keys=True)
    return cache_folder("xacro") / f"{hashlib.sha256(asked.encode()).hexdigest()[:24]}.json"


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
