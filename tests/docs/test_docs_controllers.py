"""The controller that its page shows flies, is judged and guarded by the commands that it shows."""

import re
import shlex
from pathlib import Path

import pytest

import workbench.controllers
from workbench.commands.cli import main
from workbench.control.controller import ARGUMENTS, COMMON, SHIPPED, load_controller
from workbench.control.flight_law import Body
from workbench.control.guidance import Measured
from workbench.scenario.scenario import Scenario
from workbench.session.session import Session

PAGE = (Path(__file__).parents[2] / "docs" / "controllers.md").read_text(encoding="utf-8")
SMALLEST, LAW, NOTCH, CLIMB = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
COMMANDS = re.search(r"```sh\n(.*?)```", PAGE, re.DOTALL)[1]
MOST_LINES = 60


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with the page's controller."""
    made = tmp_path_factory.mktemp("own")
    (made / "mine.py").write_text(LAW, encoding="utf-8")
    return made


def test_the_page_has_a_whole_controller_in_few_lines(folder):
    law = load_controller(folder / "mine.py")
    assert len(LAW.splitlines()) <= MOST_LINES
    assert law.name == "mine" and len(law.memory) == 8 and len(law.loops) == 6


@pytest.mark.slow
def test_the_commands_of_the_page_run(folder, monkeypatch, case):
    monkeypatch.chdir(folder)
    for command in COMMANDS.splitlines():
        words = shlex.split(command)
        if words[0] == "workbench":
            with case(command):
                assert main(words[1:]) == 0


def test_the_smallest_controller_of_the_page_flies(tmp_path):
    """A lag of first order at p_velocity 3/s has 99.75 % of a step after 2 s."""
    path = tmp_path / "smallest.py"
    path.write_text(SMALLEST, encoding="utf-8")
    session = Session(Scenario(controller=str(path)))
    session.run_law(interpreted=True)
    session.command(velocity=(1.0, 0.0, 0.2), yaw_rate=0.3)
    session.tick(2.0)
    now = session.snapshot()
    assert now.v_WB == pytest.approx([1.0, 0.0, 0.2], abs=0.05)
    assert now.w_WB[2] == pytest.approx(0.3, abs=0.05)


def test_the_other_examples_of_the_page_are_controllers(tmp_path):
    """The compensator's lines stand in a law of their own; the system flies."""
    path = tmp_path / "climb.py"
    path.write_text(CLIMB, encoding="utf-8")
    session = Session(Scenario(controller=str(path)))
    session.command(velocity=(0.0, 0.0, 0.5))
    session.tick(2.0)
    assert session.snapshot().v_WB[2] == pytest.approx(0.5, abs=0.02)
    update = f"def update({', '.join(ARGUMENTS)}):\n    x, states = notch(0.0, g, memory)\n"
    path = tmp_path / "notched.py"
    path.write_text(f"{NOTCH}\n\n{update}    return (x, x, x, x), states\n", encoding="utf-8")
    assert len(load_controller(path).memory) == 2


def test_the_page_names_all_that_there_is():
    names = [name for name in vars(workbench.controllers) if re.match(r"[A-Za-z]", name)]
    names = [
        n for n in names if n not in (*SHIPPED, "betaflight_sitl", "pd_rule", "Scalar", "Vector")
    ]
    names += [*Measured._fields, *Body._fields, *ARGUMENTS, *(row.name for row in COMMON)]
    missing = [name for name in names if not re.search(rf"[`.\[]{name}\b", PAGE)]
    assert not missing
    assert [name for name in re.findall(r"^### (\w+)$", PAGE, re.MULTILINE) if name in SHIPPED] == [
        *SHIPPED
    ]
