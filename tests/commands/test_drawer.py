"""Oracle: the same picture, drawn here."""

import os
import signal

import pytest
from matplotlib import image

from workbench.commands import drawer as drawer_module
from workbench.commands.drawer import Drawer
from workbench.common.errors import WorkbenchError
from workbench.design.plots import write_png
from workbench.design.plots_step import plot_step
from workbench.design.step_response import fly_step

MODULE = "workbench.design.plots_step"


@pytest.fixture(scope="module")
def step():
    return fly_step("x", 1.0, duration=0.5)


@pytest.fixture(scope="module")
def drawer():
    """A process for all tests but that which ends it: each takes most of a second to load."""
    with Drawer(MODULE) as made:
        yield made


def drawn(drawer, what, to):
    drawer.begin(to, MODULE, "plot_step", what)
    drawer.finish()


def test_a_picture_is_that_of_this_process(drawer, step, tmp_path):
    drawn(drawer, step, tmp_path / "there.png")
    write_png(plot_step(step), tmp_path / "here.png")
    there, here = (image.imread(tmp_path / f"{name}.png") for name in ("there", "here"))
    assert (there == here).all()


def test_a_process_that_is_ended_is_a_sentence(step, tmp_path):
    with Drawer(MODULE) as drawer:
        drawn(drawer, step, tmp_path / "first.png")
        os.kill(drawer._process.pid, signal.SIGKILL)
        with pytest.raises(WorkbenchError, match="the picture's process was killed: .* --no-plots"):
            drawn(drawer, step, tmp_path / "second.png")
    assert not (tmp_path / "second.png").exists()


def test_a_picture_that_takes_long_is_said_to_be_drawn(drawer, step, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(drawer_module, "FIGURE_MESSAGE_PERIOD_S", 0.0)
    drawn(drawer, step, tmp_path / "slow.png")
    said = capsys.readouterr().err
    assert f"workbench: drawing {tmp_path / 'slow.png'};" in said


def test_what_drawing_raises_arrives(drawer, tmp_path):
    with pytest.raises(AttributeError):
        drawn(drawer, "no step", tmp_path / "none.png")


def test_pictures_are_drawn_one_after_the_other_and_a_fault_is_told_at_its_turn(
    drawer, step, tmp_path
):
    for name, what in (("first", step), ("none", "no step"), ("last", step)):
        drawer.begin(tmp_path / f"{name}.png", MODULE, "plot_step", what)
    with pytest.raises(AttributeError):
        drawer.finish()
    drawer.finish()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["first.png", "last.png"]
