"""What docs/logs.md shows runs as it stands."""

import re
import shlex
from pathlib import Path

import pytest

from workbench.commands.cli import main
from workbench.gateways.ros_messages.conversion import conversion
from workbench.link.drone_topics import Outfit, drone_topics
from workbench.logs.contents import ACTIONS, STATE
from workbench.logs.record import read_log
from workbench.logs.replay import replay

PAGE = (Path(__file__).parents[2] / "docs" / "logs.md").read_text(encoding="utf-8")
SCAN = {"azimuths": [0.0, 0.1, 1], "elevations": [0.0, 0.0, 1]}


def commands() -> list[list[str]]:
    lines = "\n".join(re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL)).splitlines()
    return [shlex.split(line.split("#")[0])[1:] for line in lines if line.startswith("workbench ")]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder in which the page's first command has flown."""
    path = tmp_path_factory.mktemp("page")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(path)
        first, *_ = commands()
        assert first[0] == "fly"
        assert main(first) == 0
    return path


@pytest.mark.slow
def test_the_commands_run(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    for command in commands()[1:]:
        assert main(command) == 0, command
    said = capsys.readouterr().out
    assert "are the same to the bit" in said
    assert "velocity_data.v_z" in said
    assert Path("out/flight.png").is_file() and Path("v_z.png").is_file()
    assert Path("tables/velocity_data.csv").is_file()


def test_the_python_runs(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    for code in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL):
        exec(compile(code, "logs.md", "exec"), {"__name__": "__main__"})
    first, second, third = capsys.readouterr().out.splitlines()
    assert re.fullmatch(r"1\.\d\d m at most, \d+ states", first)
    assert second == "True"
    assert third.endswith(" m/s")
    assert replay(read_log(Path("mine.mcap"))).equal


def test_every_topic_stands_on_the_page():
    outfit = Outfit(4, 205, 34, 200, 10, 10, 1, SCAN, [("world", "base_link")])
    channels = [c for topic in drone_topics(outfit) for c in conversion(topic).channels]
    for channel in (*channels, STATE, ACTIONS):
        assert channel.topic.removeprefix("/dh_drone/") in PAGE, channel
        assert channel.type.replace("/msg/", "/").removeprefix("dh_drone_msgs/") in PAGE, channel
