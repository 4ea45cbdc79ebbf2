"""What docs/live.md shows runs as it stands, and names what there is."""

import re
from pathlib import Path

import pytest

from workbench.live.flight import LiveFlight

PAGE = (Path(__file__).parents[2] / "docs" / "live.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_program_flies(capsys):
    (program,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    exec(compile(program, "docs/live.md", "exec"), {})
    begun, stepped, *forked = capsys.readouterr().out.splitlines()
    assert begun.startswith("dh_drone flies, with ")
    late, speed = map(float, re.findall(r"[\d.]+", stepped))
    assert late >= 0.2 and speed > 0.0
    same, soft, lqi = forked
    assert same.startswith("as it is: ") and soft.startswith("soft: ")
    assert lqi.startswith("lqi: ")
    assert len({line.split(": ")[1] for line in forked}) == 3


def test_the_orders_are_those_there_are():
    rows = re.search(r"\| what \| orders \|\n.*?\n\n", PAGE, re.DOTALL)
    named = set(re.findall(r"`(\w+)(?:\([^`]*\))?`", rows[0])) - {"wait"}
    there = {name for name, each in vars(LiveFlight).items() if callable(each) and name[0] != "_"}
    assert named == there - {"wait", "close", "latest", "streamed"}
