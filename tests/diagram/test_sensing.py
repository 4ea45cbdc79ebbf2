"""Oracles: the same flight flown otherwise; and what was ordered of the sensors."""

import dataclasses
import logging
import math

import numpy as np
import pytest
from pydrake.geometry import Meshcat

from workbench.common.errors import WorkbenchError
from workbench.diagram.workbench import make_workbench
from workbench.plant.sensors import CORE_SENSORS
from workbench.scenario.scenario import (
    Action,
    FigureEight,
    Gust,
    Push,
    Rates,
    Scenario,
    ScenarioStart,
    SensorsConfig,
)
from workbench.session.recording import Recording
from workbench.session.session import Session
from workbench.setup import make_setup

KINDS = tuple(each.kind for each in CORE_SENSORS)
"""The shipped drone has one of each."""
STEP, PERIOD = Rates().physics_step, Rates().control_period
SLOW = {"depth_camera": 5.0}
"""So that these tests do not wait for pictures."""
ALL = SensorsConfig(use=["all"], rates=SLOW)
OTHERS = ["imu", "gps", "lidar", "range_finder", "barometer", "magnetometer"]
EVERYTHING_NOISY = {"gps_fault": 2.0, "depth_camera_fault": 2.0}
"""The description has no noise of its own for these two."""
DECIMAL = Rates(physics_step=0.001, control_period=0.004, mode_period=0.02, record_period=0.01)


def lively(**changes) -> Scenario:
    """A second and a half of a figure of eight, in wind, with a gust and a push."""
    script = [
        Action(at=0.0, set={"wind_x": 4.0, "wind_y": -3.0, "turbulence": 12.0}),
        Action(at=0.3, push=Push(force=[6.0, 4.0, -2.0], point=[0.1, 0.05, 0.0], duration=0.2)),
        Action(at=0.7, gust=Gust(velocity=[0.0, 5.0, 1.0], duration=0.5)),
    ]
    scenario = Scenario(
        duration=1.5,
        world="room",
        script=script,
        figure_eight=FigureEight(length=3.0, width=2.0, period=5.0, laps=1),
    )
    return dataclasses.replace(scenario, **changes)


def flown(scenario: Scenario, settings=None, meshcat=None) -> Session:
    session = Session(scenario, settings, meshcat)
    session.tick(scenario.duration)
    return session


def assert_equal_to_the_bit(one: Recording, other: Recording) -> None:
    for field in dataclasses.fields(Recording):
        if field.name != "vehicle":
            a, b = getattr(one, field.name), getattr(other, field.name)
            assert a.tobytes() == b.tobytes(), field.name


def assert_equal_but_for_integration(one: Recording, other: Recording, share: float) -> None:
    """Steps of the integrator end where a sensor samples; errors are shares of a signal's peak."""
    for field in dataclasses.fields(Recording):
        if field.name != "vehicle":
            a, b = getattr(one, field.name), getattr(other, field.name)
            np.testing.assert_allclose(
                a, b, rtol=0.0, atol=share * np.abs(b).max(initial=0.0), err_msg=field.name
            )
    assert one.mode.tobytes() == other.mode.tobytes()


@pytest.fixture(scope="module")
def meshcat():
    logging.getLogger("drake").setLevel(logging.WARNING)
    return Meshcat()


@pytest.fixture(scope="module")
def without_sensors() -> Session:
    return flown(lively())


@pytest.fixture(scope="module")
def with_all() -> Session:
    return flown(lively(sensors=ALL), EVERYTHING_NOISY)


@pytest.fixture
def readings(dump):
    """Return what every sensor of a session delivered last, to be compared to the bit."""
    return lambda session: {kind: dump(session.reading(kind)) for kind in KINDS}


def test_a_lively_flight_is_lively(without_sensors):
    """So that the equalities here are not those of nothing."""
    flight = without_sensors.recording()
    assert flight.tilt.max() > 0.1
    assert np.ptp(flight.p_WB[:, 0]) > 0.3
    assert np.ptp(flight.wind_W, axis=0).min() > 0.2
    assert flight.clearance.min() < 5.0


def test_sensors_do_not_change_the_flight(without_sensors, with_all):
    assert_equal_but_for_integration(with_all.recording(), without_sensors.recording(), 2e-5)


@pytest.mark.parametrize("sensors", [SensorsConfig(), ALL], ids=["none", "all"])
def test_the_picture_does_not_either_nor_what_sensors_measure(
    without_sensors, with_all, readings, meshcat, sensors
):
    """The propellers turn in the picture; no sensor sees them."""
    drawn = flown(lively(sensors=sensors), EVERYTHING_NOISY if sensors.use else None, meshcat)
    bare = with_all if sensors.use else without_sensors
    assert_equal_to_the_bit(drawn.recording(), bare.recording())
    if sensors.use:
        assert readings(drawn) == readings(with_all)


def test_steps_that_are_not_exact_in_binary_change_nothing():
    """Then a sensor's time and that of a step may differ in the last bit."""
    sensors = SensorsConfig(use=OTHERS)
    one = flown(lively(rates=DECIMAL, sensors=sensors))
    other = flown(lively(rates=DECIMAL))
    assert_equal_but_for_integration(one.recording(), other.recording(), 2e-7)
    assert one.reading("imu").stamp == pytest.approx(1.495, abs=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_a_sensor_that_is_off_is_not_there(kind, with_all, system_names):
    """Its systems are not built, and the others are the same."""
    everything = system_names(with_all.diagram)
    use = [other for other in KINDS if other != kind]
    session = Session(lively(sensors=SensorsConfig(use=use)))
    own = {name for name in everything if name.startswith(f"{kind.removeprefix('depth_')}_sensor")}
    assert len(own) == (1 if kind == "lidar" else 2)  # the lidar draws its own numbers
    assert set(system_names(session.diagram)) == set(everything) - own
    with pytest.raises(WorkbenchError, match=f"'{kind}'.*known are"):
        session.reading(kind)


def test_all_off_leaves_no_system_and_no_event(without_sensors, with_all, system_names):
    bare = system_names(without_sensors.diagram)
    more = set(system_names(with_all.diagram)) - set(bare)
    assert bare == [name for name in system_names(with_all.diagram) if name not in more]
    assert len(more) == 13
    assert not any("sensor" in name for name in bare)


def test_another_seed_is_another_turbulence(without_sensors):
    other = flown(lively(sensors=SensorsConfig(seed=1)))
    winds = [session.recording().wind_W for session in (without_sensors, other)]
    assert np.abs(winds[0] - winds[1]).max() > 0.1


def test_in_still_air_another_seed_is_the_same_flight_with_other_noise_in_every_sensor(readings):
    one, other = (
        flown(
            lively(script=[], duration=0.5, sensors=dataclasses.replace(ALL, seed=seed)),
            EVERYTHING_NOISY,
        )
        for seed in (0, 7)
    )
    assert_equal_to_the_bit(one.recording(), other.recording())
    mine, theirs = readings(one), readings(other)
    assert [kind for kind in KINDS if mine[kind] == theirs[kind]] == []


def test_slices_of_any_size_measure_alike_and_so_does_a_reset(readings, with_all):
    """Looked at after each slice, which must not matter either; `with_all` was flown in one."""
    session = with_all
    wanted, recording = readings(session), session.recording()
    session.reset()
    assert session.reading("imu") is None
    cuts = np.sort(np.random.default_rng(100).uniform(0.0, 1.5, 99))
    for duration in np.diff([0.0, *cuts, 1.5]):
        session.tick(float(duration))
        session.snapshot()
        session.reading("lidar")
    assert readings(session) == wanted
    assert_equal_to_the_bit(session.recording(), recording)


def test_two_sessions_at_once_do_not_disturb_each_other(with_all, readings):
    """Nor is a flight with an equal seed another one, to the bit."""
    one = Session(lively(sensors=ALL), EVERYTHING_NOISY)
    other = Session(lively(script=[], sensors=dataclasses.replace(ALL, seed=3)))
    for _ in range(10):
        one.tick(0.15)
        other.tick(0.15)
    assert readings(one) == readings(with_all)
    assert_equal_to_the_bit(one.recording(), with_all.recording())


@pytest.mark.parametrize("rates", [Rates(), DECIMAL], ids=["binary", "decimal"])
def test_rates_are_independent_of_each_other_and_of_the_law(rates):
    """Each sample is stamped with a whole number of periods; none is missed, none comes twice."""
    asked = {"imu": 300.0, "gps": 7.0, "range_finder": 33.0, "barometer": 111.0}
    config = SensorsConfig(use=[*asked], rates=asked, keep=True)
    session = Session(Scenario(rates=rates, sensors=config))
    session.tick(0.5)
    kinds = {sensor.name: sensor.kind for sensor in session.vehicle.sensors}
    stamps = {kinds[each.sensor]: each.stamps for each in session.samples()}
    for kind, rate in asked.items():
        due = np.arange(math.ceil(0.5 * rate)) / rate
        assert stamps[kind] == pytest.approx(due, abs=1e-12), kind
    for status in session.snapshot().sensors:
        assert status.asked_rate == asked[status.kind]
        assert status.rate == pytest.approx(asked[status.kind], rel=1e-12)


def test_a_latency_delays_delivery_and_not_the_stamp():
    config = SensorsConfig(use=["imu", "gps"], rates={"gps": 16.0}, latency={"gps": 0.1})
    session = Session(Scenario(sensors=config))
    session.tick(0.1)
    assert session.reading("gps") is None
    assert math.isinf(next(s.age for s in session.snapshot().sensors if s.kind == "gps"))
    session.tick(PERIOD)
    assert session.reading("gps").stamp == 0.0
    session.tick(1.0)
    time = session.time
    assert session.reading("gps").stamp == math.floor((time - 0.1) * 16.0) / 16.0
    assert time - session.reading("imu").stamp < 6 * STEP


@pytest.fixture(scope="module")
def faulty() -> Session:
    """Drifts, so that no two samples are the same even where there is no noise."""
    start = ScenarioStart(velocity=[0.5, 0.3, 0.1])
    scenario = Scenario(world="room", start=start, sensors=dataclasses.replace(ALL, noise=False))
    return Session(scenario)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_faults_come_and_go_while_it_flies(faulty, kind, dump):
    """`dump` has the stamp first, and then what was measured."""

    def fly(fault: float):
        faulty.set(f"{kind}_fault", fault)
        faulty.tick(0.5)
        (status,) = (each for each in faulty.snapshot().sensors if each.kind == kind)
        assert status.fault == fault
        return faulty.reading(kind), status

    faulty.reset()
    working, status = fly(0.0)
    assert status.age < 0.25
    frozen, status = fly(1.0)
    assert frozen.stamp > working.stamp
    assert dump(frozen)[1:] == dump(working)[1:]
    assert status.rate == pytest.approx(status.asked_rate, rel=0.03)
    silent, status = fly(3.0)
    assert silent.stamp == frozen.stamp
    assert status.age == faulty.time - frozen.stamp > 0.5
    assert status.rate < 0.8 * status.asked_rate
    mended, status = fly(0.0)
    assert mended.stamp > silent.stamp
    assert dump(mended)[1:] != dump(working)[1:]
    assert status.age < 0.25


def test_a_fault_of_one_kind_leaves_the_others_alone(with_all, readings, dump):
    session = flown(lively(sensors=ALL), {**EVERYTHING_NOISY, "imu_fault": 3.0})
    assert session.reading("imu") is None
    wanted = readings(with_all)
    for kind in set(KINDS) - {"imu"}:
        assert dump(session.reading(kind)) == wanted[kind], kind


def deviations(session: Session, fault: float) -> np.ndarray:
    """Return deviations of specific force, pressure and ranges, sampled at rest."""
    session.reset()
    session.set("imu_fault", fault)
    session.set("barometer_fault", fault)
    session.set("lidar_fault", fault)
    forces, pressures = [], []
    for _ in range(300):
        session.tick(PERIOD)
        forces.append(session.reading("imu").specific_force)
        pressures.append(session.reading("barometer").pressure)
    scan = session.reading("lidar")
    return np.array([np.std(forces, axis=0).mean(), np.std(pressures), spread(scan)])


def spread(scan) -> float:
    """Return the deviation of a scan from the walls and the ground of the room, at its middle."""
    d = scan.pattern.directions_S.reshape(*scan.ranges.shape, 3)
    with np.errstate(divide="ignore"):
        walls = np.minimum(5.0 / np.abs(d[..., 0]), 4.0 / np.abs(d[..., 1]))
        ground = np.where(d[..., 2] < 0.0, -scan.p_WS[2] / d[..., 2], np.inf)
    seen = np.isfinite(scan.ranges)
    return float(np.std((scan.ranges - np.minimum(walls, ground))[seen]))


def test_a_noisy_sensor_has_ten_times_its_noise():
    config = SensorsConfig(use=["imu", "barometer", "lidar"], rates={"barometer": 204.8})
    session = Session(Scenario(world="room", sensors=config))
    usual, noisy = deviations(session, 0.0), deviations(session, 2.0)
    # as in the description; the IMU is sampled a little faster than it says, at equal density
    assert usual == pytest.approx([0.03 * math.sqrt(204.8 / 200.0), 2.0, 0.01], rel=0.12)
    assert noisy / usual == pytest.approx(10.0, rel=0.15)


def test_a_sensor_of_no_known_kind_is_no_sensor(with_all):
    with pytest.raises(WorkbenchError, match="unknown sensor of this flight 'radar': .*known are"):
        with_all.reading("radar")
    assert with_all.reading("camera").frame == "camera_link"  # by name
    assert with_all.reading("depth_camera").frame == "camera_link"  # by kind


def test_without_sensors_nothing_can_be_read(without_sensors):
    with pytest.raises(WorkbenchError, match="'imu' measures nothing: .* no sensors switched on"):
        without_sensors.reading("imu")


def test_names_that_look_like_those_of_helpers_do_not_clash(setup, system_names):
    """A description may call its sensors what it likes."""
    by_kind = {sensor.kind: sensor for sensor in setup.vehicle.sensors}
    new = {
        "imu": by_kind["imu"],
        "imu_noise": by_kind["gps"],
        "imu_sensor": by_kind["barometer"],
        "imu_sensor_noise": by_kind["range_finder"],
        "part::imu": by_kind["imu"],
        "part/imu": by_kind["imu"],
        "part::eye": by_kind["depth_camera"],
        "part/eye": by_kind["depth_camera"],
    }
    sensors = tuple(dataclasses.replace(sensor, name=name) for name, sensor in new.items())
    odd = dataclasses.replace(setup.vehicle, sensors=sensors)
    scenario = Scenario(sensors=SensorsConfig(use=["all"]))
    bench = make_workbench(make_setup(scenario, description=setup.description, vehicle=odd))
    assert [each.choice.sensor.name for each in bench.sensing.mounted] == list(new)
    assert (
        len([name for name in system_names(bench.diagram) if "imu" in name]) == 12 + 1
    )  # and `flight_imu`


def test_no_caster_is_made_where_nothing_casts(monkeypatch):
    def refuses(*arguments, **names):
        raise AssertionError("made a caster")

    monkeypatch.setattr("workbench.systems.casting.caster.Caster", refuses)
    Session(Scenario(sensors=SensorsConfig(use=["imu", "gps", "barometer"])))
    with pytest.raises(AssertionError):
        Session(Scenario(sensors=SensorsConfig(use=["range_finder"])))
