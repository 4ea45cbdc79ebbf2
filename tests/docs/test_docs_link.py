"""What docs/link.md shows is run as it stands, but for the address, beside a real flight."""

import re
from pathlib import Path

import pytest

from workbench.commands.cli import main
from workbench.common.resources import find_scenario
from workbench.link.server.config import ServerConfig
from workbench.live.flight import LiveFlight
from workbench.scenario.scenario import load_scenario

PAGE = (Path(__file__).parents[2] / "docs" / "link.md").read_text(encoding="utf-8")
ADDRESS = "127.0.0.1:7733"


def shown(language):
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


CLIENTS = [code for code in shown("python") if ADDRESS in code]
"""The other one is a ground station, whose calls `tests/gateways/test_mavlink.py` makes."""


@pytest.fixture(scope="module")
def address():
    """Return where a real flight is served."""
    with LiveFlight(load_scenario(find_scenario("network"))) as flight:
        flight.wait()
        yield flight.serve(ServerConfig(port=0)).result(60.0)


def test_all_but_one_program_are_clients():
    assert len(CLIENTS) == len(shown("python")) - 1 > 0


@pytest.mark.slow
@pytest.mark.parametrize("number", range(len(CLIENTS)))
def test_the_python_of_the_page_runs(address, capsys, number):
    code = CLIENTS[number]
    exec(compile(code.replace(ADDRESS, address), "link.md", "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out.strip()


@pytest.mark.slow
def test_the_monitor_shows_the_flight_once(address, capsys):
    assert main(["monitor", address, "--once"]) == 0
    text = capsys.readouterr().out
    for label in ("mode", "position", "attitude", "rotors", "imu", "control", "link"):
        assert re.search(rf"^{label} ", text, re.MULTILINE), label
