"""A Drake-based workbench for designing a multirotor and its controller.

`__init__.pyi` lists the public names. Each is loaded on first use, so that `import workbench`
stays free of Drake, Qt and matplotlib.
"""

from importlib import import_module
from pathlib import Path
from typing import Any

_LINES = Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8").splitlines()
# `from MODULE import NAME as NAME`: taken apart as text, since `ast` takes 5 ms to load
_MODULES = {line.split()[3]: line.split()[1] for line in _LINES if line.startswith("from ")}

__all__ = sorted(_MODULES)


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'workbench' has no attribute '{name}'")
    return getattr(import_module(_MODULES[name]), name)
