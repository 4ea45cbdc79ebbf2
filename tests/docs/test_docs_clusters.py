"""What docs/clusters.md shows is run as it stands, on a cluster of this machine."""

import re
import shlex
from pathlib import Path

import pytest

from workbench.commands.cli import main

PAGE = (Path(__file__).parents[2] / "docs" / "clusters.md").read_text(encoding="utf-8")
ADDRESS = "tcp://192.168.1.10:8786"


def commands() -> list[str]:
    text = "\n".join(re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL))
    return [line for line in text.splitlines() if line.startswith("workbench ")]


@pytest.mark.slow
def test_the_monte_carlo_study_of_the_page_flies(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (study,) = (line for line in commands() if "seed=" in line)
    assert main([*shlex.split(study)[1:], "--duration", "0.2"]) == 0
    assert "no best is chosen" in capsys.readouterr().out
    table = (tmp_path / "out" / "sweep-x.csv").read_text().splitlines()
    assert "seed [1]" in table[0]
    assert len(table) == 1 + 8


@pytest.mark.slow
def test_the_commands_of_the_page_fly_on_a_cluster(capsys, tmp_path, monkeypatch):
    from distributed import LocalCluster

    monkeypatch.chdir(tmp_path)
    there = [line for line in commands() if ADDRESS in line]
    assert len(there) == 2
    with LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        processes=True,
        protocol="tcp://",
        host="127.0.0.1",
        dashboard_address="127.0.0.1:0",
    ) as cluster:
        for line in there:
            words = shlex.split(line.replace(ADDRESS, cluster.scheduler_address))[1:]
            short = ["--duration", "0.2"] if words[0] == "sweep" else ["margins"]
            assert main([*words, *short]) == 0, line
            assert "flying on 2 workers" in capsys.readouterr().err


@pytest.mark.slow
def test_the_python_of_the_page_runs(capsys):
    code = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)[1]
    exec(compile(code, "clusters.md", "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out.strip().startswith("[")
