"""Pictures of a judgement: every panel has title and units, and shows the numbers judged."""

import math

import numpy as np
import pytest

from workbench.control.controller_file import find_loop, load_controller
from workbench.design.judge.gang_of_four import gang_of_four
from workbench.design.judge.margins import loop_margins
from workbench.design.judge.operating_map import OperatingMap, find_direction
from workbench.design.judge.plots import plot_loop, plot_loops, plot_rates
from workbench.design.judge.plots_map import plot_map, plot_sensitivity
from workbench.design.judge.sampled_stability import RateSample, SlowestRate
from workbench.design.judge.sensitivity import Sensitivity
from workbench.design.judge.step_pair import StepPair
from workbench.design.linear_step import linear_step
from workbench.design.step_metrics import step_metrics

LOOPS = load_controller().loops


def titled(figure):
    return {axes.get_title(loc="left"): axes for axes in figure.axes if axes.get_title(loc="left")}


def assert_drawn(figure, tmp_path):
    """The picture can be saved, has units on both axes, and no text beyond its edge."""
    figure.savefig(tmp_path / "figure.png")
    width, height = figure.canvas.get_width_height()
    for axes in titled(figure).values():
        shared = axes.get_shared_y_axes().get_siblings(axes)  # and itself
        assert any("[" in each.get_ylabel() for each in shared)
        for text in (axes.yaxis.label, axes.xaxis.label, axes.title):
            box = text.get_window_extent()
            assert box.x0 >= 0 and box.y0 >= 0
            assert box.x1 <= width + 1 and box.y1 <= height + 1


@pytest.fixture(scope="module")
def pair(steering):
    time = steering.period * np.arange(640)
    response = 2.0 * linear_step(steering, "reference_v_x", "v_x", 640)
    metrics = step_metrics(time, response, 2.0)
    return StepPair("x", 2.0, time, response, 0.99 * response, metrics, metrics)


def test_a_loops_picture_has_all_and_its_margins(steering, pair, tmp_path):
    figure = plot_loop(steering, find_loop("pitch"), (pair,))
    assert_drawn(figure, tmp_path)
    panels = titled(figure)
    words = ("magnitude", "phase", "Nyquist", "KS", "GS", "root locus", "poles", "step of 2 m/s")
    assert all(any(word in title for title in panels) for word in words)
    margins = loop_margins(steering, "pitch_acceleration")
    title = figure.get_suptitle()
    assert f"{math.degrees(margins.phase_margin):.1f} deg" in title
    assert f"{1e3 * margins.delay_margin:.1f} ms" in title
    nyquist = panels["Nyquist"]
    marks = [line.get_xdata()[0] for line in nyquist.get_lines() if len(line.get_xdata()) == 1]
    assert -1.0 in marks
    assert any(x == pytest.approx(-1.0 / margins.gain_margin) for x in marks)
    load = panels["GS: load sensitivity"]
    top = gang_of_four(steering, find_loop("pitch")).load_sensitivity
    assert np.max(load.get_lines()[0].get_ydata()) == np.abs(top).max()
    assert load.get_ylabel() == "size [1/(rad/s^2)]"
    labels = [line.get_label() for line in panels["step of 2 m/s"].get_lines()]
    assert labels == ["command", "flown", "linear"]


def test_the_disk_touches_the_curve(steering, tmp_path):
    axes = titled(plot_loop(steering, find_loop("roll")))["Nyquist"]
    disk = axes.patches[0].get_xy()
    centre, radius = disk[:, 0].min() / 2 + disk[:, 0].max() / 2, np.ptp(disk[:, 0]) / 2
    curve = next(line for line in axes.get_lines() if line.get_label() == "L")
    away = np.hypot(np.array(curve.get_xdata()) - centre, curve.get_ydata())
    assert away.min() == pytest.approx(radius, rel=2e-3)


@pytest.mark.parametrize("name", [pytest.param("position_z", marks=pytest.mark.slow), "yaw_rate"])
def test_loops_that_were_not_flown_show_the_linear_step(steering, holding, tmp_path, name):
    loop = find_loop(name)
    figure = plot_loop(holding if loop.hold else steering, loop, cut="error")
    assert_drawn(figure, tmp_path)
    step = next(axes for title, axes in titled(figure).items() if "linear" in title)
    assert step.get_lines()[1].get_ydata()[-1] == pytest.approx(
        step.get_lines()[0].get_ydata()[0], rel=0.02
    )


def test_the_overview_has_a_panel_a_loop(steering, holding, tmp_path):
    figure = plot_loops(steering, holding)
    assert_drawn(figure, tmp_path)
    assert [title.split("\n")[0] for title in titled(figure)] == [loop.name for loop in LOOPS]
    assert len(titled(plot_loops(steering))) == 6


def test_an_unstable_loop_is_drawn_too(study, tmp_path):
    model = study.sampled(gains={"kp_pitch": 2000.0})
    assert_drawn(plot_loops(model), tmp_path)
    figure = plot_loop(model, find_loop("pitch"))
    assert_drawn(figure, tmp_path)
    assert "unstable" in figure.get_suptitle()


@pytest.mark.parametrize("shape", [(5, 4), (1, 4)])
def test_a_map_is_drawn_with_its_holes(tmp_path, shape):
    values = np.add.outer(np.arange(shape[0]), np.arange(shape[1])) * 0.1
    values[0, 0] = np.nan
    first, second = find_direction("speed"), find_direction("payload")
    place = np.arange(shape[1]), np.arange(shape[0])
    names = (("roll",) * shape[1],) * shape[0]
    found = OperatingMap("it", first, second, *place, values, values, values, names)
    figure = plot_map(found)
    assert_drawn(figure, tmp_path)
    titles = ["smallest phase margin", "smallest disk margin", "least damping ratio"]
    assert list(titled(figure)) == titles


def test_sensitivities_are_a_table_of_what_matters(tmp_path):
    nan = {"kp_roll": math.nan, "kp_pitch": math.nan}
    rows = (
        Sensitivity("rise_time", 0.3, {}, {"kp_roll": 1e-9, "kp_pitch": -0.97}),
        Sensitivity("overshoot", 0.0, {}, nan),
    )
    figure = plot_sensitivity(rows, "a step")
    figure.savefig(tmp_path / "figure.png")
    assert [text.get_text() for text in figure.axes[0].texts] == ["-0.97"]


def test_rates_are_drawn_over_the_period(tmp_path):
    samples = (RateSample(0.001, 0.99, True, 1.0, -4.0), RateSample(0.05, 1.2, False, 0.0, 3.0))
    figure = plot_rates(SlowestRate(0.001, 0.001, samples), "it")
    assert_drawn(figure, tmp_path)
    assert figure.axes[0].get_lines()[0].get_xdata() == pytest.approx([1.0, 50.0])
    assert figure.axes[0].get_lines()[0].get_ydata() == pytest.approx([-4.0, 3.0])


@pytest.mark.parametrize(
    ("name", "cut"),
    [
        ("velocity_z", "actuator"),
        *(
            pytest.param(name, cut, marks=pytest.mark.slow)
            for name in ("pitch", "yaw_rate", "velocity_z")
            for cut in ("actuator", "error")
            if (name, cut) != ("velocity_z", "actuator")
        ),
    ],
)
def test_words_on_the_bode_plots_stay_within_and_off_the_curve(steering, tmp_path, name, cut):
    figure = plot_loop(steering, find_loop(name), cut=cut)
    figure.savefig(tmp_path / "figure.png")
    panels = titled(figure)
    magnitude = panels["Bode: magnitude"]
    frame = magnitude.get_window_extent()
    boxes = [text.get_window_extent() for text in magnitude.texts]
    assert all(frame.x0 <= box.x0 and box.x1 <= frame.x1 for box in boxes)
    assert not boxes[0].overlaps(boxes[1])
    phase = next(axes for title, axes in panels.items() if "phase" in title)
    (words,) = [text.get_window_extent() for text in phase.texts]
    curve = phase.transData.transform(phase.get_lines()[0].get_xydata())
    assert not any(words.contains(*point) for point in curve)
