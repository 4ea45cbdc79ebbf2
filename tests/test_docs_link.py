"""What docs/link.md shows is run as it stands, but for the address, beside a real flight."""

import re
import shlex
from pathlib import Path

import pytest

from workbench.cli import _parser, main
from workbench.link.server.config import ServerConfig
from workbench.live.flight import LiveFlight
from workbench.resources import find_scenario
from workbench.scenario import load_scenario

PAGE = (Path(__file__).parent.parent / "docs" / "link.md").read_text(encoding="utf-8")
ADDRESS = "127.0.0.1:7733"


def shown(language):
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


def commands():
    lines = [line.partition("#")[0].strip() for block in shown("sh") for line in block.splitlines()]
    return [line.partition("|")[0] for line in lines if line.startswith("workbench ")]


@pytest.fixture(scope="module")
def address():
    """Return where a real flight is served."""
    with LiveFlight(load_scenario(find_scenario("network"))) as flight:
        flight.wait()
        yield flight.serve(ServerConfig(port=0)).result(60.0)


@pytest.mark.parametrize("number", range(len(shown("python"))))
def test_the_python_of_the_page_runs(address, capsys, number):
    code = shown("python")[number]
    assert ADDRESS in code
    exec(compile(code.replace(ADDRESS, address), "link.md", "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out.strip()


def test_the_monitor_shows_the_flight_once(address, capsys):
    assert main(["monitor", address, "--once"]) == 0
    text = capsys.readouterr().out
    for label in ("mode", "position", "attitude", "rotors", "imu", "control", "link"):
        assert re.search(rf"^{label} ", text, re.MULTILINE), label


@pytest.mark.parametrize("line", commands())
def test_the_commands_of_the_page_are_understood(line):
    words = shlex.split(line)[1:]
    assert _parser().parse_args(words).command == words[0]
