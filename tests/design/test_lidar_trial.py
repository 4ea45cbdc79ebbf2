"""Each criterion of the lidar trial finds its fault, in flights whose every number is known."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from workbench.design.lidar_accuracy import RangeErrors, judge_scans
from workbench.design.lidar_flight import Scan, TrialFlight, ray_directions
from workbench.design.lidar_trial import report_trial, scan_timing
from workbench.design.obstacle_detection import find_detections, slowest_detection
from workbench.design.obstacles import RayObstacle, first_hits
from workbench.design.ray_solid import box, half_space, sphere
from workbench.plant.sensors import Lidar, Noise, ScanAxis

PERIOD, CONTROL = 102 / 1024, 1 / 128
SAMPLE = 6 / 1024
SPEED, TURN = 4.0, 0.3
SIGMA = 0.01
CRATE, BALL, HIDDEN, CART, GROUND = range(5)

LIDAR = Lidar(
    name="lidar",
    type="gpu_lidar",
    frame="lidar_link",
    link="lidar_link",
    rate=10.0,
    p_BS=(0.0, 0.0, 0.2),
    R_BS=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    horizontal=ScanAxis(360, -math.pi, math.pi - math.radians(1.0)),
    vertical=ScanAxis(8, -0.3, 0.1),
    min_range=0.1,
    max_range=12.0,
    noise=Noise(stddev=SIGMA),
)


def standing(name, solid, *place):
    X_WO = RigidTransform(list(place))
    return RayObstacle(name, ((solid, RigidTransform()),), lambda time: X_WO)


OBSTACLES = (
    standing("crate", box((0.5, 0.5, 0.5)), 5.0, 2.0, 0.5),
    standing("ball", sphere(1.0), 20.0, 0.0, 1.0),  # comes into range on the way
    standing("hidden", box((0.2, 0.2, 0.2)), 5.0, 60.0, 0.2),  # too far away for ever
    RayObstacle(
        "cart",
        ((box((0.5, 0.5, 0.5)), RigidTransform([0.0, 0.0, 0.5])),),
        lambda time: RigidTransform([8.0, -6.0 + 0.5 * time, 0.0]),
        moves=True,
    ),
    standing("ground", half_space(), 0.0, 0.0, 0.0),
)


def quaternions(yaw):
    zero = np.zeros_like(yaw)
    return np.stack([np.cos(0.5 * yaw), zero, zero, np.sin(0.5 * yaw)], axis=1)


def make_flight(sigma: float = SIGMA, duration: float = 3.0) -> TrialFlight:
    """Along x at a constant speed, turning, with a scan every period that is right."""
    time = np.arange(0.0, duration + 1e-9, SAMPLE)
    p_WB = np.stack([SPEED * time, 0.0 * time, 1.0 + 0.0 * time], axis=1)
    vehicle = SimpleNamespace(name="drone", span=0.5)
    record = SimpleNamespace(time=time, p_WB=p_WB, q_WB=quaternions(TURN * time), vehicle=vehicle)
    record.v_WB = np.gradient(p_WB, time, axis=0)
    record.w_WB = np.tile([0.0, 0.0, TURN], (len(time), 1))
    flight = TrialFlight(
        recording=record,
        lidar=dataclasses.replace(LIDAR, noise=Noise(stddev=sigma)),
        asked_rate=10.0,
        period=PERIOD,
        latency=0.0,
        control_period=CONTROL,
        obstacles=OBSTACLES,
        scans=(),
        computing_time=math.nan,
    )
    rng = np.random.default_rng(1)
    stamps = np.arange(0.0, duration - CONTROL, PERIOD)
    return dataclasses.replace(flight, scans=tuple(take(flight, t, rng) for t in stamps.tolist()))


def hovering(flight: TrialFlight) -> TrialFlight:
    """Return a flight that stays where it begins."""
    still = SimpleNamespace(**vars(flight.recording))
    still.p_WB = np.tile([0.0, 0.0, 1.0], (len(still.time), 1))
    still.q_WB = quaternions(0.0 * still.time)
    still.v_WB = still.w_WB = np.zeros((len(still.time), 3))
    return dataclasses.replace(flight, recording=still)


def true_pose(time: float) -> RigidTransform:
    """The mounting is 0.2 m above the base link."""
    return RigidTransform(RollPitchYaw(0.0, 0.0, TURN * time), [SPEED * time, 0.0, 1.2])


def take(flight: TrialFlight, stamp: float, rng: np.random.Generator) -> Scan:
    X_WS = true_pose(stamp)
    length, _ = first_hits(OBSTACLES, stamp, X_WS, flight.directions, flight.lidar.max_range)
    ranges = length + flight.lidar.noise.stddev * rng.standard_normal(len(length))
    ranges = np.where(length <= flight.lidar.max_range, ranges, np.inf)
    delivered = CONTROL * (math.floor(stamp / CONTROL) + 1)
    return Scan(stamp, delivered, ranges.reshape(8, 360), X_WS)


def changed(flight: TrialFlight, change) -> TrialFlight:
    """Return a flight with every scan changed; those that become None are lost."""
    scans = [change(scan) for scan in flight.scans]
    return dataclasses.replace(flight, scans=tuple(scan for scan in scans if scan))


@pytest.fixture(scope="module")
def noisy():
    return make_flight()


@pytest.fixture(scope="module")
def quiet():
    return make_flight(sigma=0.0)


@pytest.fixture(scope="module")
def report(noisy, quiet):
    return report_trial(noisy, quiet)


def missed(report) -> set[str]:
    return {demand.quantity for demand in report.demands if not demand.met}


def test_a_lidar_that_is_right_meets_everything(report):
    assert missed(report) == set()
    assert report.exact.total.maximum < 1e-12
    assert report.accuracy.displacement < 1e-12
    assert report.accuracy.total.rmse == pytest.approx(SIGMA, rel=0.02)
    assert report.accuracy.total.percentile_95 == pytest.approx(1.96 * SIGMA, rel=0.03)
    assert report.accuracy.at_edges == 0


def test_rays_point_where_azimuth_and_elevation_say():
    lidar = dataclasses.replace(
        LIDAR, horizontal=ScanAxis(2, 0.0, math.pi / 2), vertical=ScanAxis(2, -math.pi / 6, 0.0)
    )
    level, down = math.cos(math.pi / 6), -0.5
    assert ray_directions(lidar) == pytest.approx(
        np.array([[level, 0, down], [0, level, down], [1, 0, 0], [0, 1, 0]], dtype=float)
    )


def test_the_pose_is_exact_at_samples_and_between(noisy):
    for time in (0.0, 17 * SAMPLE, 17.5 * SAMPLE, 3.0 - SAMPLE):
        X_WS = noisy.X_WS(time)
        assert X_WS.IsNearlyEqualTo(true_pose(time), 1e-6)


def test_a_quaternion_and_its_negative_are_one_pose(noisy):
    record = SimpleNamespace(**vars(noisy.recording))
    record.q_WB = record.q_WB * np.where(np.arange(len(record.time)) % 2, 1.0, -1.0)[:, None]
    flight = dataclasses.replace(noisy, recording=record)
    assert flight.X_WS(17.5 * SAMPLE).IsNearlyEqualTo(true_pose(17.5 * SAMPLE), 1e-6)


def test_figures_of_errors_are_those_by_hand():
    found = RangeErrors.of(np.array([0.01, -0.01, 0.03, 0.01]))
    assert found == RangeErrors(4, pytest.approx(0.01), pytest.approx(math.sqrt(3e-4)), *[
        pytest.approx(size) for size in (0.027, 0.03)
    ])  # fmt: skip
    assert RangeErrors.of(np.zeros(0)).returns == 0
    assert math.isnan(RangeErrors.of(np.zeros(0)).bias)


def test_each_obstacle_has_its_own_errors(noisy):
    def off(scan):
        _, obstacle = first_hits(OBSTACLES, scan.stamp, scan.X_WS, noisy.directions, 12.0)
        wrong = np.where(obstacle == BALL, 0.02, 0.0).reshape(8, 360)
        return dataclasses.replace(scan, ranges=scan.ranges + wrong)

    by_obstacle = judge_scans(changed(noisy, off)).by_obstacle
    assert by_obstacle[BALL].bias == pytest.approx(0.02, abs=0.003)
    assert by_obstacle[CRATE].bias == pytest.approx(0.0, abs=0.002)
    assert by_obstacle[HIDDEN].returns == 0


def longer_by(length):
    return lambda scan: dataclasses.replace(scan, ranges=scan.ranges + length)


def moved_by(*offset):
    return lambda scan: dataclasses.replace(
        scan, X_WS=RigidTransform(scan.X_WS.rotation(), scan.X_WS.translation() + offset)
    )


def with_one(ray, value):
    """Give one ray of each scan a value."""

    def change(scan):
        ranges = scan.ranges.copy()
        ranges[ray] = value
        return dataclasses.replace(scan, ranges=ranges)

    return change


DOWN = (0, 180)
"""A ray of the lowest layer, ahead: it always meets the ground at 1.2 m / sin(0.3)."""
AHEAD_UP = (7, 0)
"""A ray of the highest layer, backwards: it never meets anything."""


def test_a_wrong_range_a_lost_return_a_false_one_or_a_wrong_pose_is_found(case, noisy, quiet):
    for change, quantities in [
        (longer_by(0.003), {"bias", "error_without_noise"}),
        (longer_by(-0.003), {"bias", "error_without_noise"}),
        (longer_by(0.0005), set()),
        (with_one(DOWN, math.inf), {"missed_returns"}),
        (with_one(DOWN, -math.inf), {"missed_returns"}),
        (with_one(DOWN, math.nan), {"missed_returns"}),
        (with_one(AHEAD_UP, 5.0), {"false_returns"}),
        (moved_by(0.0, 0.0, 0.002), {"displacement_by_pose"}),
    ]:
        with case(change, quantities):
            assert (
                missed(report_trial(changed(noisy, change), changed(quiet, change))) == quantities
            )


def test_a_turned_pose_is_found_by_what_it_does_far_away(quiet):
    def turned(scan):
        return dataclasses.replace(
            scan, X_WS=scan.X_WS @ RigidTransform(RollPitchYaw(0.0, 0.0, 1e-3), [0.0] * 3)
        )

    assert judge_scans(changed(quiet, turned)).displacement == pytest.approx(12.0 * 1e-3, rel=1e-6)


def test_ranges_from_another_place_or_time_are_errors(quiet):
    late = changed(quiet, lambda scan: dataclasses.replace(scan, stamp=scan.stamp + SAMPLE))
    found = judge_scans(late)
    assert found.total.maximum > 0.5 * SPEED * SAMPLE
    assert found.displacement == pytest.approx(SPEED * SAMPLE + 12.0 * TURN * SAMPLE, rel=1e-3)


def test_more_noise_than_declared_is_found(quiet):
    rng = np.random.default_rng(2)

    def louder(scan):
        noise = 0.015 * rng.standard_normal(scan.ranges.shape)
        return dataclasses.replace(scan, ranges=scan.ranges + noise)

    assert missed(report_trial(changed(make_flight(0.0), louder), quiet)) >= {"rmse"}
    found = dataclasses.replace(changed(quiet, louder), lidar=LIDAR)
    assert missed(report_trial(found, quiet)) == {"rmse"}


def test_what_lies_within_a_millimetre_of_an_edge_is_not_judged(quiet):
    """A ray that passes 0.5 mm beside the crate may return from it, one 2 mm beside may not."""
    X_WS = RigidTransform([0.0, 0.0, 0.6])
    lidar = dataclasses.replace(
        quiet.lidar, p_BS=(0.0, 0.0, -0.4), horizontal=ScanAxis(1, 0, 0), vertical=ScanAxis(1, 0, 0)
    )
    for beside, at_edges, false in ((0.0005, 1, 0), (0.002, 0, 1)):
        crate = standing("crate", box((0.5, 0.5, 0.5)), 5.0, 0.5 + beside, 0.5)
        scan = Scan(0.0, 0.0, np.array([[4.5]]), X_WS)
        found = judge_scans(
            dataclasses.replace(quiet, lidar=lidar, obstacles=(crate,), scans=(scan,))
        )
        assert (found.at_edges, found.false) == (at_edges, false)


def test_an_error_is_not_taken_for_an_edge(quiet):
    """A ray tilted by a millimetre at the ground far away is some millimetres longer."""
    for length in (0.002, 0.003, 0.005):
        found = judge_scans(changed(quiet, longer_by(length)))
        assert found.at_edges < 5  # of 46,000, where the crate stands on the ground
        assert found.total.bias == pytest.approx(length)


def test_detection_is_timed_from_coming_into_view(report):
    found = {each.obstacle: each for each in report.detections}
    ball = found["ball"]
    # A ray hits it first within range; its nearest point, 11 m to 12 m away, needs no ray on it.
    assert 11.8 < ball.entered_distance < 12.0
    gone = SPEED * (ball.returned - ball.entered)
    assert ball.returned_distance == pytest.approx(ball.entered_distance - gone, abs=1e-2)
    assert 0.0 < ball.delay <= slowest_detection(report.flight)
    assert not ball.from_start
    assert found["ground"].from_start and found["ground"].entered == 0.0
    assert found["crate"].returned == CONTROL
    assert math.isnan(found["hidden"].entered) and math.isnan(found["hidden"].delay)


def without_ball(until, instead=np.inf):
    def change(scan):
        _, obstacle = first_hits(OBSTACLES, scan.stamp, scan.X_WS, ray_directions(LIDAR), 12.0)
        blind = (obstacle == BALL).reshape(8, 360) & (scan.stamp < until)
        return dataclasses.replace(scan, ranges=np.where(blind, instead, scan.ranges))

    return change


def test_an_obstacle_that_is_overlooked_is_found_late_or_never(noisy, quiet):
    prompt = {each.obstacle: each for each in find_detections(noisy, judge_scans(noisy))}["ball"]
    for until, delay in ((prompt.entered + 0.5, 0.55), (math.inf, math.inf)):
        late = report_trial(changed(noisy, without_ball(until)), quiet)
        ball = {each.obstacle: each for each in late.detections}["ball"]
        assert ball.entered == prompt.entered
        assert ball.delay == pytest.approx(delay, abs=0.06)
        assert {"slowest", "missed_returns"} <= missed(late)


def test_a_return_from_elsewhere_is_none_from_the_obstacle(noisy):
    wrong = changed(noisy, without_ball(math.inf, instead=3.0))
    ball = {each.obstacle: each for each in find_detections(wrong, judge_scans(wrong))}["ball"]
    assert ball.delay == math.inf


def test_a_glimpse_between_two_scans_is_no_coming_into_view(noisy):
    """A ball shows for 50 ms, and half a second later for good."""
    seen = ((0.52, 0.57), (1.0, 9.0))
    ball = RayObstacle(
        "ball",
        ((sphere(1.0), RigidTransform()),),
        lambda time: RigidTransform(
            [5.0 if any(begin <= time < end for begin, end in seen) else 99.0, 0.0, 1.2]
        ),
        moves=True,
    )
    flight = dataclasses.replace(hovering(noisy), obstacles=(ball,), scans=())
    (found,) = find_detections(flight, judge_scans(flight))
    assert found.entered == pytest.approx(1.0, abs=SAMPLE)


def test_what_is_hidden_comes_into_view_when_nothing_is_before_it(noisy):
    """A wall 1 m ahead of the ball slides away to the left at 2 m/s."""
    wall = RayObstacle(
        "wall",
        ((box((0.1, 3.0, 5.0)), RigidTransform()),),
        lambda time: RigidTransform([8.0, 2.0 * time, 1.0]),
        moves=True,
    )
    ball = standing("ball", sphere(1.0), 10.0, 0.0, 1.2)
    flight = dataclasses.replace(hovering(noisy), obstacles=(wall, ball), scans=())
    (_, found) = find_detections(flight, judge_scans(flight))
    # Seen from the lidar, its right edge is 1 m aside of the middle at 10 m: 0.8 m aside at 8 m.
    assert found.entered == pytest.approx((3.0 - 0.8) / 2.0, abs=0.1)
    assert found.delay == math.inf


def delayed(scan):
    return dataclasses.replace(scan, delivered=scan.delivered + 0.1)


def test_scans_that_come_late_are_found(noisy, quiet):
    late = report_trial(changed(noisy, delayed), quiet)
    assert missed(late) == {"slowest", "maximum_age", "late_scans"}
    assert late.response.late == late.response.delivered
    assert late.response.share_on_time == 0.0
    assert late.response.lost == 0


def test_ages_are_from_stamp_to_delivery(noisy):
    ages = [scan.delivered - scan.stamp for scan in noisy.scans]
    found = scan_timing(noisy)
    assert found.maximum_age == max(ages) <= CONTROL
    assert found.median_age == pytest.approx(np.median(ages))
    assert found.rate == pytest.approx(1024 / 102)
    assert (found.expected, found.late, found.lost) == (len(noisy.scans), 0, 0)


@pytest.mark.parametrize(
    ("lost", "count"),
    [
        (lambda number: number == 10, 1),
        (lambda number: number in (3, 10, 11), 3),
        (lambda number: number < 4, 3),  # the first may be taken anywhere in its period
        (lambda number: number >= 25, 6),
        (lambda number: True, 31),
    ],
)
def test_scans_that_are_left_out_are_counted(noisy, lost, count):
    assert len(noisy.scans) == 31
    left = tuple(scan for number, scan in enumerate(noisy.scans) if not lost(number))
    found = scan_timing(dataclasses.replace(noisy, scans=left))
    assert (found.delivered, found.lost) == (len(left), count)


def test_the_flight_must_not_reach_into_an_obstacle(report, noisy, quiet):
    nearest = report.clearance
    assert nearest.obstacle == "crate"
    assert nearest.distance == pytest.approx(1.5, abs=0.01)
    assert nearest.time == pytest.approx(5.0 / SPEED, abs=0.2)
    post = standing("post", box((0.1, 0.1, 2.0)), 6.0, 0.3, 1.0)
    through = [
        dataclasses.replace(each, obstacles=(*OBSTACLES[:4], post, OBSTACLES[4]))
        for each in (noisy, quiet)
    ]
    assert "reach_into_obstacles" in missed(report_trial(*through))
