"""The commands of docs/autopilots.md run, on the drones that they name."""

import re
import shlex
import shutil
from pathlib import Path

import pytest

from workbench.commands.cli import main

TESTS = Path(__file__).parents[1]
SITL = (TESTS.parent / "docs/betaflight-sitl.md").read_text(encoding="utf-8")
PAGE = (TESTS.parent / "docs/autopilots.md").read_text(encoding="utf-8")
NEW = re.search(r"^workbench new racer .*$", SITL, re.MULTILINE)[0]
PUBLISHED = TESTS.parent / "../shared/models/gym_pybullet_drones"


@pytest.mark.slow
def test_the_commands_of_the_page_run(tmp_path, monkeypatch, case):
    if PUBLISHED.exists():
        for each in PUBLISHED.glob("cf2*"):
            shutil.copy(each, tmp_path)
    monkeypatch.chdir(tmp_path)
    assert main(shlex.split(NEW)[1:]) == 0
    commands = "".join(re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL)).splitlines()
    assert len(commands) > 5
    for command in commands:
        words = shlex.split(command)
        if "cf2x.urdf" not in words or PUBLISHED.exists():
            with case(command):
                assert main(words[1:]) == 0
