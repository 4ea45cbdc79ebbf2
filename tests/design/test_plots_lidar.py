"""The figure of a lidar trial shows what was measured, and every panel can be read."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest
from pydrake.math import RigidTransform

from workbench.design.lidar_flight import Scan, TrialFlight
from workbench.design.lidar_trial import report_trial
from workbench.design.obstacle_detection import slowest_detection
from workbench.design.obstacles import RayObstacle, first_hits
from workbench.design.plots_lidar import cloud_of, plot_trial
from workbench.design.ray_solid import box, half_space, sphere
from workbench.plant.sensors import Lidar, Noise, ScanAxis

LIDAR = Lidar(
    name="lidar",
    type="lidar",
    frame="lidar_link",
    link="lidar_link",
    rate=10.0,
    p_BS=(0.0, 0.0, 0.0),
    R_BS=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    horizontal=ScanAxis(180, -math.pi, math.pi),
    vertical=ScanAxis(8, -0.3, 0.3),
    min_range=0.1,
    max_range=20.0,
    noise=Noise(stddev=0.01),
)


def obstacle(name, solid, pose, moves=False):
    return RayObstacle(name, ((solid, RigidTransform()),), pose, moves)


OBSTACLES = (
    obstacle("crate", box((1.0, 1.0, 1.0)), lambda time: RigidTransform([8.0, 4.0, 1.0])),
    obstacle("cart", sphere(0.5), lambda time: RigidTransform([6.0, -4.0 + time, 1.0]), True),
    obstacle("ground", half_space(), lambda time: RigidTransform()),
)


def make_flight(sigma, speed=2.0, samples=513) -> TrialFlight:
    time = np.arange(samples) / 256
    place = np.stack([speed * time, 0.0 * time, 1.0 + 0.0 * time], axis=1)
    upright = np.tile([1.0, 0.0, 0.0, 0.0], (len(time), 1))
    vehicle = SimpleNamespace(name="drone", span=0.5)
    flight = TrialFlight(
        recording=SimpleNamespace(
            time=time,
            p_WB=place,
            q_WB=upright,
            v_WB=np.tile([speed, 0.0, 0.0], (len(time), 1)),
            w_WB=np.zeros((len(time), 3)),
            vehicle=vehicle,
        ),
        lidar=dataclasses.replace(LIDAR, noise=Noise(stddev=sigma)),
        asked_rate=16.0,
        period=1 / 16,
        latency=0.0,
        control_period=1 / 128,
        obstacles=OBSTACLES,
        scans=(),
        computing_time=math.nan,
    )
    rng, scans = np.random.default_rng(6), []
    for stamp in np.arange(0.0, time[-1], 1 / 16).tolist():
        X_WS = flight.X_WS(stamp)
        length, _ = first_hits(OBSTACLES, stamp, X_WS, flight.directions, 20.0)
        length = np.where(length <= 20.0, length + sigma * rng.standard_normal(len(length)), np.inf)
        scans.append(Scan(stamp, stamp + 1 / 128, length.reshape(8, 180), X_WS))
    return dataclasses.replace(flight, scans=tuple(scans))


@pytest.fixture(scope="module")
def report():
    return report_trial(make_flight(0.01), make_flight(0.0))


@pytest.fixture(scope="module")
def figure(report, tmp_path_factory):
    figure = plot_trial(report, "drone: a trial")
    figure.savefig(tmp_path_factory.mktemp("plot") / "trial.png")
    return figure


def panels(figure):
    return {axes.get_title(loc="left"): axes for axes in figure.axes}


def panel(figure, start):
    return next(axes for title, axes in panels(figure).items() if title.startswith(start))


@pytest.mark.slow
@pytest.mark.parametrize("along", [0.0, 2.0, 8.0, 40.0])
def test_the_legend_of_the_cloud_does_not_hide_its_title(tmp_path, along):
    """From a region as wide as it is high to one far wider."""
    flight = make_flight(0.0, speed=along, samples=300)
    figure = plot_trial(report_trial(flight, flight), "drone: a trial")
    figure.savefig(tmp_path / "trial.png")
    axes = panel(figure, "cloud of")
    title = next(t for t in (axes._left_title, axes.title) if t.get_text().startswith("cloud of"))
    legend = axes.get_legend().get_window_extent()
    assert not legend.overlaps(title.get_window_extent())
    assert legend.x1 <= figure.bbox.x1


def test_every_panel_has_a_title_and_units(figure):
    titles = list(panels(figure))
    assert [title.split()[0] for title in titles] == ["cloud", "the", "errors:", "errors", "speed"]
    flat = [axes for axes in figure.axes if axes.axison]
    assert len(flat) == len(titles) - 1  # all but the picture in space
    for axes in flat:
        assert "[" in axes.get_xlabel() + axes.get_ylabel()


def test_the_cloud_from_above_lies_on_the_obstacles(figure, report):
    axes = panel(figure, "cloud of")
    assert f"{len(report.flight.scans)} scans" in axes.get_title(loc="left")
    assert axes.get_aspect() == 1.0
    points = np.asarray(axes.collections[0].get_offsets())
    distances = [abs(np.abs(points - [8.0, 4.0]).max(axis=1) - 1.0)]
    assert (distances[0] < 0.05).sum() > 100  # on a side of the crate
    flown = next(line for line in axes.get_lines() if line.get_label() == "flown path")
    assert flown.get_xydata() == pytest.approx(report.flight.recording.p_WB[:, :2])
    names = {text.get_text() for text in axes.texts}
    assert names == {"crate", "cart (moves)"}
    outlines = [patch.get_xy() for patch in axes.patches]
    assert len(outlines) == 1 + 8  # the crate, and where the cart is when
    assert np.abs(outlines[0] - [8.0, 4.0]).max() == pytest.approx(1.0)


def test_the_picture_in_space_has_near_points_over_far_ones(figure, report):
    axes = panel(figure, "the same cloud in 3-D")
    assert {text.get_text() for text in axes.texts} == {"crate", "cart"}
    offsets, sizes = axes.collections[0].get_offsets(), axes.collections[0].get_sizes()
    assert len(offsets) == len(sizes) > 1000
    assert (np.diff(sizes) >= 0.0).all()  # nearer ones are larger, and drawn later


def test_the_errors_panels_show_measured_beside_declared(figure, report):
    histogram = panel(figure, "errors: measured less closed form")
    heights = [patch.get_height() * patch.get_width() for patch in histogram.patches]
    assert sum(heights) == pytest.approx(1.0)
    (bell,) = histogram.get_lines()
    assert bell.get_ydata().max() == pytest.approx(
        1.0 / (10.0 * math.sqrt(2.0 * math.pi)), rel=1e-3
    )
    (text,) = histogram.texts
    assert f"RMSE {1000.0 * report.accuracy.total.rmse:.2f} mm" in text.get_text()
    over = {line.get_label(): line for line in panel(figure, "errors over").get_lines()}
    assert over["± declared"].get_ydata()[0] == pytest.approx(10.0)
    assert over["mean of a metre"].get_ydata() == pytest.approx(0.0, abs=3.0)


def test_the_delays_stand_beside_their_limit(figure, report):
    axes = panel(figure, "speed of detection")
    widths = [patch.get_width() for patch in axes.patches]
    assert widths == pytest.approx([1000.0 * each.delay for each in report.detections])
    (limit,) = axes.get_lines()
    assert limit.get_xdata()[0] == 1000.0 * slowest_detection(report.flight)
    assert [text.get_text() for text in axes.get_yticklabels()] == ["crate", "cart", "ground"]


@pytest.mark.slow
def test_a_trial_without_noise_movement_or_scans_is_drawn_too(tmp_path):
    still = make_flight(0.0, speed=0.0, samples=40)
    blind = dataclasses.replace(still, scans=())
    alone = dataclasses.replace(blind, obstacles=())
    for flight in (still, blind, alone):
        figure = plot_trial(report_trial(flight, flight), "nothing")
        figure.savefig(tmp_path / "trial.png")
        titles = list(panels(figure))
        assert titles[0].startswith(f"cloud of {len(flight.scans)} scans")
        assert len(titles) == 5


def test_the_cloud_of_the_page_is_the_measured_one(report):
    cloud = cloud_of(report)
    points = cloud.xyzs().T
    assert len(points) == len(report.accuracy.p_WP)
    assert points == pytest.approx(report.accuracy.p_WP, abs=1e-5)
    crate = report.accuracy.obstacle == 0
    assert len(np.unique(cloud.rgbs().T[crate], axis=0)) == 1
