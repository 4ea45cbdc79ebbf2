"""Programs of the pages that need a served flight or a cluster run beside one of this machine."""

import re
import shlex
from pathlib import Path

import pytest

from workbench.commands.cli import main
from workbench.common.resources import find_scenario
from workbench.link.server.config import ServerConfig
from workbench.live.flight import LiveFlight
from workbench.scenario.scenario_file import load_scenario

DOCS = Path(__file__).parents[2] / "docs"
SERVER, SCHEDULER = "127.0.0.1:7733", "tcp://192.168.1.10:8786"


def shown(page: str, language: str) -> list[str]:
    text = (DOCS / page).read_text(encoding="utf-8")
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


CLIENTS = [code for page in ("index.md", "link.md") for code in shown(page, "python")]
CLIENTS = [code for code in CLIENTS if SERVER in code]


@pytest.fixture
def address():
    """Return where a flight is served, one for each program: some leave the drone in the air."""
    with LiveFlight(load_scenario(find_scenario("network"))) as flight:
        flight.wait()
        yield flight.serve(ServerConfig(port=0)).result(60.0)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(len(CLIENTS)))
def test_a_client_of_the_pages_runs(address, capsys, number):
    code = CLIENTS[number]
    exec(compile(code.replace(SERVER, address), "page", "exec"), {"__name__": "__main__"})
    assert bool(capsys.readouterr().out.strip()) == ("print(" in code)


@pytest.mark.slow
def test_the_commands_for_a_cluster_fly_on_one(capsys, tmp_path, monkeypatch):
    from tests.clusters import local_cluster

    monkeypatch.chdir(tmp_path)
    lines = "".join(shown("clusters.md", "sh")).splitlines()
    there = [line for line in lines if line.startswith("workbench ") and SCHEDULER in line]
    assert len(there) == 3
    with local_cluster(2) as cluster:
        for line in there:
            words = shlex.split(line.replace(SCHEDULER, cluster.scheduler_address))[1:]
            short = ["--duration", "0.2"] if words[0] == "sweep" else ["margins"]
            assert main([*words, *short]) == 0, line
            assert "flying on 2 workers" in capsys.readouterr().err
