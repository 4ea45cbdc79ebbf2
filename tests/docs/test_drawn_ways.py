"""The map of the code, docs/architecture.md, and CONTRIBUTING.md, held to the code."""

import re
import sys
from pathlib import Path

import pytest

from workbench.commands.cli import main
from workbench.ipc import child_process

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
WAYS = {
    re.findall(r"^(\w+/[\w/]+\.py)", drawn, re.MULTILINE)[0]: (int(functions), int(files), drawn)
    for functions, files, drawn in re.findall(
        r"through (\d+) functions in (\d+) files.*?```\n(.*?)```", PAGE, re.DOTALL
    )
}
"""Numbers of functions and files, and the drawing, by the file where a way begins."""
STEP, DRAWER = "commands/cli.py", "commands/drawer.py"

XACRO = "workbench.plant.formats.xacro_child"
"""It reads a description in its own process, once until a file changes."""


def drawn_functions(drawn: str) -> list[tuple[str, str]]:
    """Return file and name of each function of a drawing."""
    lines = re.findall(r"^(\w+/[\w/]+\.py) +(\w[\w., ]*?)(?:  |$)", drawn, re.MULTILINE)
    return [(file, name) for file, names in lines for name in names.split(", ")]


def test_ways_are_drawn_by_functions_that_there_are(case):
    assert set(WAYS) == {STEP, "link/server/tcp.py", "gui/gains/gain_row.py"}
    for begin, (count, files, drawn) in WAYS.items():
        functions = drawn_functions(drawn)
        with case(begin):
            assert (len(functions), len({file for file, _ in functions})) == (count, files)
        for file, name in functions:
            source = (ROOT / "workbench" / file).read_text(encoding="utf-8")
            for part in name.split("."):
                assert re.search(rf"^ *(class|def) {part}\b", source, re.MULTILINE), (file, name)


def source_of(name: str) -> str:
    """Return the text of a file that a page names, by its path or the end of its path."""
    found = [path for path in (ROOT / "workbench").rglob(Path(name).name) if path.is_file()]
    found += [ROOT / name] if (ROOT / name).is_file() else []
    return "".join(each.read_text("utf-8") for each in found if str(each).endswith(f"/{name}"))


def test_what_the_map_names_is_there(case):
    files, names = [], []
    for page in (PAGE, (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")):
        files += re.findall(r"`([\w/]+\.(?:py|js))`", page)
        names += re.findall(r"`([A-Za-z_][\w.]*)` (?:\(|of |in )`([\w/]+\.py)`", page)
    assert len(files) > 60 and len(names) > 20
    for file in files:
        with case(file):
            assert source_of(file)
    for name, file in names:
        with case(name, file):
            source = source_of(file)
            assert all(
                re.search(rf"^ *(class |def )?{part}\b", source, re.M) for part in name.split(".")
            )


@pytest.mark.skipif(sys.version_info < (3, 12), reason="sys.monitoring came with Python 3.12")
def test_a_step_goes_the_drawn_way_in_two_processes(tmp_path, monkeypatch):
    """It calls the drawn functions in that order, apart from machine code and the other process."""
    monkeypatch.chdir(tmp_path)
    start, started = child_process.start_module, []
    monkeypatch.setattr(
        child_process, "start_module", lambda *a, **o: started.append(a) or start(*a, **o)
    )
    called: list[tuple[str, str]] = []  # each function once, as it is called first

    def note(code, offset):
        path = code.co_filename.partition("/workbench/")[2]
        if path:
            called.append((path, code.co_qualname.removesuffix(".__init__")))
        return sys.monitoring.DISABLE

    tool, starts = sys.monitoring.PROFILER_ID, sys.monitoring.events.PY_START
    sys.monitoring.use_tool_id(tool, "way")
    sys.monitoring.register_callback(tool, starts, note)
    sys.monitoring.set_events(tool, starts)
    try:
        assert main(["step", "--axis", "x", "--amplitude", "1"]) == 0
    finally:
        sys.monitoring.free_tool_id(tool)
    elsewhere = ("flight_loop", "plot_step", "write_png")
    drawn = drawn_functions(WAYS[STEP][2])
    assert WAYS[STEP][1] <= 15
    here = [each for each in drawn if each[1] not in elsewhere and each != (DRAWER, "main")]
    rest = iter(called)
    for each in here:
        assert each in rest, each
    assert {module for module, *_ in started} - {XACRO} == {"workbench.commands.drawer"}
    assert (tmp_path / "out" / "step-x.png").is_file()
