"""A Drake-based workbench for designing a multirotor and its controller.

`__init__.pyi` lists the public names. Each is loaded on first use, so that `import workbench`
stays free of Drake, Qt and matplotlib.
"""

from importlib import import_module
from typing import Any

# Without pathlib: in Python 3.12 it imports `math`, and `python -m workbench` gets here while the
# current folder, which may have a math.py, is still searched first.
with open(f"{__file__}i", encoding="utf-8") as _file:  # noqa: PTH123
    # `from MODULE import NAME as NAME`: taken apart as text, since `ast` takes 5 ms to load
    _ROWS = [line.split() for line in _file if line.startswith("from ")]
_MODULES = {row[3]: row[1] for row in _ROWS}

__all__ = sorted(_MODULES)


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'workbench' has no attribute '{name}'")
    return getattr(import_module(_MODULES[name]), name)
