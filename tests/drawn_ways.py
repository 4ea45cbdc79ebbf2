"""The ways through the code that docs/architecture.md draws."""

import re
import sys
from pathlib import Path

PAGE = (Path(__file__).parents[1] / "docs" / "architecture.md").read_text(encoding="utf-8")
WAYS = {
    re.findall(r"^(\w+/[\w/]+\.py)", drawn, re.MULTILINE)[0]: (int(functions), int(files), drawn)
    for functions, files, drawn in re.findall(
        r"through (\d+) functions in (\d+) files.*?```\n(.*?)```", PAGE, re.DOTALL
    )
}
"""Numbers of functions and files, and the drawing, by the file where a way begins."""
GAIN = "gui/gains/gain_input.py"


def drawn_functions(drawn: str) -> list[tuple[str, str]]:
    """Return file and name of each function of a drawing."""
    lines = re.findall(r"^([\w/]+\.py) +(\w[\w., ]*?)(?:  |$)", drawn, re.MULTILINE)
    return [(file, name) for file, names in lines for name in names.split(", ")]


def drawn_parts(begin: str) -> list[list[tuple[str, str]]]:
    """Return the functions that a way draws in each process, in their order."""
    return [drawn_functions(part) for part in re.split(r"^──.*$", WAYS[begin][2], flags=re.M)]


def present_way() -> list[tuple[str, str]]:
    """Return the functions of the package that call each other now, the outermost first."""
    found = []
    frame = sys._getframe(1)
    while frame is not None:
        path = frame.f_code.co_filename.partition("/workbench/")[2]
        if path:
            found.append((path, frame.f_code.co_qualname))
        frame = frame.f_back
    return found[::-1]
