"""Figures show what was flown: curves, means, units, and legends beside the data."""

import math

import numpy as np
import pytest
from PIL import Image

from workbench.design.plots import stacked, styled, write_png
from workbench.design.plots_flight import plot_flight
from workbench.design.plots_step import plot_reproduced, plot_step
from workbench.design.reproduce import PAPER_FIGURES, compare_with_paper
from workbench.design.step_response import STEP_EDGE_S, fly_step
from workbench.scenario.scenario import Action, Scenario
from workbench.session.session import Session


@pytest.fixture(scope="module", params=PAPER_FIGURES, ids=lambda figure: figure.axis)
def row(request):
    figure = request.param
    return compare_with_paper(figure, fly_step(figure.axis, figure.command, duration=2.5))


@pytest.fixture(scope="module")
def recording():
    scenario = Scenario(
        duration=1.5,
        script=[Action(at=0.25, velocity=[1.0, 0.5, 0.0]), Action(at=1.0, go_to=[1.0, 0.0, 1.5])],
    )
    session = Session(scenario)
    session.run()
    return session.recording()


def lines(axes):
    return {line.get_label(): line for line in axes.get_lines()}


def panels(figure):
    return {axes.get_title(loc="left"): axes for axes in figure.axes}


def assert_readable(figure, tmp_path):
    """Every panel has title and units, no text lies on another's, and legends beside the data."""
    figure.savefig(tmp_path / "figure.png")
    texts = []
    for axes in figure.axes:
        title, ylabel = axes.get_title(loc="left"), axes.get_ylabel()
        assert title
        assert "mode" in title or "[" in ylabel, f"'{title}' has no unit"
        texts += [text for text in (axes.yaxis.label, *axes.texts) if text.get_text()]
        legend = axes.get_legend()
        if legend:
            data = axes.get_window_extent()
            assert not legend.get_window_extent().overlaps(data), f"legend in '{title}'"
            texts += legend.get_texts()
    assert any("[s]" in axes.get_xlabel() for axes in figure.axes)
    width, height = figure.canvas.get_width_height()
    boxes = [(text.get_text(), text.get_window_extent()) for text in texts]
    for index, (text, box) in enumerate(boxes):
        assert box.x0 >= 0 and box.y0 >= 0, f"'{text}' is cut off"
        assert box.x1 <= width and box.y1 <= height, f"'{text}' is cut off"
        for other, its_box in boxes[index + 1 :]:
            assert not box.overlaps(its_box), f"'{text}' lies on '{other}'"


@pytest.mark.slow
def test_reproduced_figures_have_the_papers_three_panels(row, tmp_path):
    figure = plot_reproduced(row)
    assert_readable(figure, tmp_path)
    first, force, acceleration = panels(figure)
    assert "command and response" in first
    assert ("torque" if row.paper.axis == "yaw" else "rotor") in force
    assert "acceleration" in acceleration


def test_reproduced_figures_show_both_means_over_the_window(row):
    _, force, acceleration = plot_reproduced(row).axes
    for axes, mean, paper in (
        (force, row.mean_force, row.paper.mean_force),
        (acceleration, row.mean_acceleration, row.paper.mean_acceleration),
    ):
        found = lines(axes)
        ours = next(line for name, line in found.items() if name.startswith("mean"))
        theirs = next(line for name, line in found.items() if name.startswith("paper's mean"))
        assert list(ours.get_xdata()) == [0.0, row.t90]
        assert list(ours.get_ydata()) == [mean, mean]
        assert f"{paper:g}" in theirs.get_label()
        assert theirs.get_linestyle() == "--"
        low, high = axes.get_ylim()
        if len(theirs.get_ydata()):
            assert low < paper < high
        else:
            assert "off this scale" in theirs.get_label()
            assert row.paper.axis == "yaw"


def test_reproduced_figures_show_the_recorded_response(row):
    response = lines(plot_reproduced(row).axes[0])["response"]
    time, values = response.get_xdata(), response.get_ydata()
    assert np.interp(0.0, time, values) == pytest.approx(0.0, abs=1e-3)
    assert np.interp(row.t90, time, values) == pytest.approx(0.9 * row.paper.command, rel=1e-3)


def test_a_step_that_never_arrives_is_drawn_too(tmp_path):
    flight = fly_step("yaw", 0.2, duration=0.5, settings={"kp_yaw_rate": 0.0})
    row = compare_with_paper(PAPER_FIGURES[3], flight)
    assert math.isnan(row.t90)
    assert_readable(plot_reproduced(row), tmp_path)
    assert_readable(plot_step(flight), tmp_path)


def test_a_steps_figure_has_its_metrics_and_every_rotor(row, tmp_path):
    figure = plot_step(row.flight)
    assert_readable(figure, tmp_path)
    texts = "\n".join(text.get_text() for axes in figure.axes for text in axes.texts)
    assert f"{row.flight.metrics.rise_time:.3f} s" in texts
    assert f"{100 * row.flight.peak_rotor_use:.0f} %" in texts
    assert {"rotor 1", "rotor 2", "rotor 3", "rotor 4", "limit"} == set(lines(figure.axes[3]))
    assert lines(figure.axes[0])["command"].get_ydata()[-1] == row.paper.command
    assert figure.axes[0].get_xlim()[1] <= row.flight.recording.time[-1] - STEP_EDGE_S


@pytest.mark.slow
def test_a_steps_figure_is_about_its_edge_and_the_velocity_before_it():
    """In wind the command steps once the drone drifts steadily, and its band lies about the end."""
    flown = fly_step("x", 1.0, duration=2.5, settings={"wind_x": 6.0})
    (response, *_) = plot_step(flown).axes
    time, command = lines(response)["command"].get_data()
    assert 0.0 <= time[command > 0.5][0] <= 1 / 128  # taken by the update at the edge
    (band,) = (each for each in response.patches if "steady state" in each.get_label())
    middle = band.get_y() + 0.5 * band.get_height()
    assert middle == pytest.approx(flown.recording.v_WB[-1, 0], abs=1e-9)
    assert flown.before > 0.2


def test_a_flights_overview_shows_path_and_commands(recording, tmp_path):
    figure = plot_flight(recording, "a flight")
    assert_readable(figure, tmp_path)
    found = panels(figure)
    path = lines(found["path from above"])
    assert path["flown"].get_xydata() == pytest.approx(recording.p_WB[:, :2])
    assert path["asked for"].get_xydata() == pytest.approx(np.array([[1.0, 0.0]]))
    assert path["start"].get_xydata() == pytest.approx(recording.p_WB[:1, :2])
    assert path["end"].get_xydata() == pytest.approx(recording.p_WB[-1:, :2])
    assert found["path from above"].get_aspect() == 1.0
    velocity = lines(found["velocity and command"])
    assert velocity["along y"].get_ydata() == pytest.approx(recording.v_WB[:, 1])
    assert velocity["y command"].get_ydata() == pytest.approx(recording.reference[:, 1])
    modes = [text.get_text() for text in found["flight mode"].get_yticklabels()]
    assert modes == ["hovering", "cruising"]


def test_a_flight_of_one_sample_is_drawn(recording, tmp_path):
    assert_readable(plot_flight(recording.between(0.0, 0.0), "a moment"), tmp_path)


def test_the_readers_own_style_is_left_alone(recording):
    import matplotlib

    before = dict(matplotlib.rcParams)
    plot_flight(recording, "a flight")
    assert dict(matplotlib.rcParams) == before


@styled
def ramp():
    figure, (upper, _) = stacked("a ramp", 2)
    upper.plot([0.0, 1.0], [2.0, 3.0])
    return figure


def test_a_picture_has_the_pixels_that_savefig_would_write(tmp_path):
    figure = ramp()
    write_png(figure, tmp_path / "ours.png")
    figure.savefig(tmp_path / "theirs.png")
    ours, theirs = (np.asarray(Image.open(tmp_path / f"{name}.png")) for name in ("ours", "theirs"))
    np.testing.assert_array_equal(ours, theirs)
