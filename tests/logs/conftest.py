"""A short flight, flown once, and logs of it."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from workbench.gains.gain_choice import flight_gains
from workbench.link.backplane import Sampled
from workbench.link.topics import Topic
from workbench.logs.flight_log import FlightLog
from workbench.scenario.scenario import Action, Push, Scenario
from workbench.scenario.sensors_config import SensorsConfig
from workbench.session.session import Session
from workbench.systems.bridge import Bridge

SETTINGS = {"kp_velocity_z": 3.7}


@dataclass(frozen=True)
class Flown:
    """A flight as the log gets it.

    Attributes:
        done: what a pilot did, at its time.
        values: all parameter values of the start.
    """

    scenario: Scenario
    settings: dict[str, float]
    values: dict[str, float]
    vehicle: str
    topics: tuple[Topic, ...]
    samples: list[Sampled]
    done: list[Action]


def fly(scenario: Scenario, done: list[Action], settings: dict[str, float]) -> Flown:
    """Fly a scenario, while a pilot acts between its control updates."""
    session = Session(scenario, settings, bridge=Bridge())
    values = flight_gains(session.vehicle, scenario.vehicle.gains, settings)
    for action in done:
        session.tick(action.at - session.time)
        session.do(action)
    session.tick(scenario.duration - session.time)
    return Flown(
        scenario,
        settings,
        values,
        session.vehicle.name,
        session.topics,
        session.drain(),
        done,
    )


def write_log(flown: Flown, path: Path, samples: list[Sampled] | None = None) -> Path:
    """Write the log of a flight."""
    log = FlightLog(path, flown.topics, flown.scenario, flown.settings, flown.values, flown.vehicle)
    waiting = list(flown.done)
    for sampled in flown.samples if samples is None else samples:
        while waiting and waiting[0].at * 1e9 <= sampled.published.t_ns:
            log.act(waiting[0].at, waiting[0], "operator")
            waiting.pop(0)
        log.write(sampled)
    log.close()
    return path


@pytest.fixture(scope="session")
def flown() -> Flown:
    period = 1 / 128
    scenario = Scenario(
        title="a turn",
        sensors=SensorsConfig(use=["imu", "gps", "magnetometer"]),
        duration=1.5,
        script=[Action(0.25, velocity=[0.5, 0.0, 0.1])],
    )
    done = [
        Action(at=37 * period, velocity=[1.0, 0.1, 1 / 3]),
        Action(at=38 * period, yaw_rate=0.3, set={"kp_velocity_x": 5.1}),
        Action(at=112 * period, push=Push([1.0, 0.0, 0.0], duration=0.1)),
        Action(at=125 * period, request="land"),
    ]
    return fly(scenario, done, SETTINGS)


@pytest.fixture(scope="session")
def log(flown, tmp_path_factory) -> Path:
    return write_log(flown, tmp_path_factory.mktemp("logs") / "flight.mcap")


@pytest.fixture
def log_of(tmp_path) -> Callable[..., Path]:
    """Fly a scenario, and write its log."""
    return lambda scenario, done=(): write_log(fly(scenario, [*done], {}), tmp_path / "of.mcap")


@pytest.fixture
def write(flown, tmp_path) -> Callable[..., Path]:
    """Write the flight's log, or that of some of its samples."""
    return lambda name="again.mcap", samples=None: write_log(flown, tmp_path / name, samples)
