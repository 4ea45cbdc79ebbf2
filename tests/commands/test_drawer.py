"""Oracle: the same picture, drawn here."""

import os
import signal

import pytest
from matplotlib import image

from workbench.commands.drawer import Drawer
from workbench.common.errors import WorkbenchError
from workbench.design.plots import write_png
from workbench.design.plots_step import plot_step
from workbench.design.step_response import fly_step


@pytest.fixture(scope="module")
def step():
    return fly_step("x", 1.0, duration=0.5)


def test_a_picture_is_that_of_this_process(step, tmp_path):
    with Drawer("workbench.design.plots_step", "plot_step") as drawer:
        drawer.png(step, tmp_path / "there.png")
    write_png(plot_step(step), tmp_path / "here.png")
    there, here = (image.imread(tmp_path / f"{name}.png") for name in ("there", "here"))
    assert (there == here).all()


def test_a_process_that_is_ended_is_a_sentence(step, tmp_path):
    with Drawer("workbench.design.plots_step", "plot_step") as drawer:
        drawer.png(step, tmp_path / "first.png")
        os.kill(drawer._process.pid, signal.SIGKILL)
        with pytest.raises(WorkbenchError, match="the picture's process was killed: .* --no-plots"):
            drawer.png(step, tmp_path / "second.png")
    assert not (tmp_path / "second.png").exists()


def test_what_drawing_raises_arrives(tmp_path):
    with (
        Drawer("workbench.design.plots_step", "plot_step") as drawer,
        pytest.raises(AttributeError),
    ):
        drawer.png("no step", tmp_path / "none.png")
