"""Logs of real flights: other programs' formats, identification, prediction and what-if.

`__init__.pyi` lists the public names. Each is loaded on first use, as those of `workbench`.
"""

from importlib import import_module
from pathlib import Path
from typing import Any

_ROWS = [line.split() for line in Path(f"{__file__}i").read_text(encoding="utf-8").splitlines()]
_MODULES = {row[3]: row[1] for row in _ROWS if row[:1] == ["from"]}

__all__ = sorted(_MODULES)


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return getattr(import_module(_MODULES[name]), name)
