"""Step responses out of ordinary flying, against closed forms and flown steps; and poor data."""

from pathlib import Path

import numpy as np
import pytest
import scipy.signal

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.common.series import make_series
from workbench.logs.flight_log import LoggedFlight
from workbench.logs.flight_reader import read_flight
from workbench.logs.logged_loop import find_logged_loop
from workbench.logs.step_response import StepEstimate, identify_step_response
from workbench.scenario.scenario import Action, Scenario

FREQUENCY, DAMPING = 12.0, 0.6
"""Of a loop of second order [rad/s]."""
LOOP = scipy.signal.StateSpace(
    [[0.0, 1.0], [-(FREQUENCY**2), -2.0 * DAMPING * FREQUENCY]],
    [[0.0], [FREQUENCY**2]],
    [[1.0, 0.0]],
    [[0.0]],
)
SETPOINT, RESPONSE = "rate_setpoint.w_x", "imu.angular_velocity.x"
TIMES = np.arange(0.0, 1.0, 0.1)
SETTLED = 0.36
"""From there on the response settles [s]."""


def true_step(time: np.ndarray) -> np.ndarray:
    """Return the loop's closed form."""
    fast = FREQUENCY * np.sqrt(1.0 - DAMPING**2)
    late = np.maximum(time, 0.0)
    sine = DAMPING / np.sqrt(1.0 - DAMPING**2) * np.sin(fast * late)
    return np.where(
        time < 0.0, 0.0, 1.0 - np.exp(-DAMPING * FREQUENCY * late) * (np.cos(fast * late) + sine)
    )


def noise(seed: int, count: int, low: float, high: float, rate: float) -> np.ndarray:
    sections = scipy.signal.butter(2, [low, high], "band", fs=rate, output="sos")
    made = scipy.signal.sosfilt(sections, np.random.default_rng(seed).standard_normal(count))
    return made / made.std()


def record(time: np.ndarray, setpoint: np.ndarray, response: np.ndarray) -> Flight:
    signals = {
        name: make_series(name, "rad/s", time, values, end=float(time[-1]))
        for name, values in ((SETPOINT, setpoint), (RESPONSE, response))
    }
    return Flight("made", Path("made"), "made", signals, end=float(time[-1]))


def fly(
    seed: int = 0, duration: float = 60.0, rate: float = 200.0, disturbed: float = 0.2
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return time, a pilot's setpoint, and the response with a slow disturbance and noise."""
    count = int(duration * rate)
    time = np.arange(count) / rate
    setpoint = noise(seed, count, 0.05, 2.0, rate)
    response = scipy.signal.lsim(LOOP, setpoint, time)[1]
    response = response + disturbed * noise(seed + 100, count, 0.2, 3.0, rate)
    return (
        time,
        setpoint,
        response + 0.03 * np.random.default_rng(seed + 1000).standard_normal(count),
    )


@pytest.mark.parametrize(
    ("seed", "rate"), [(0, 200.0), pytest.param(2, 1000.0, marks=pytest.mark.slow)]
)
def test_a_measured_response_is_the_closed_form(seed, rate):
    found = identify_step_response(record(*fly(seed, rate=rate)), "roll_rate")
    off = np.abs(found.values - true_step(found.time))
    assert found.trusted, found.doubts
    assert off[found.time > SETTLED].max() < 0.05
    assert off.max() < 0.06
    assert found.rise == pytest.approx(0.153, abs=0.02)
    assert found.overshoot == pytest.approx(0.095, abs=0.04)
    inside = (found.low - 0.01 <= true_step(found.time)) & (
        true_step(found.time) <= found.high + 0.01
    )
    assert inside.mean() > 0.9


def test_gaps_cost_nothing_but_their_time():
    time, setpoint, response = fly()
    kept = np.abs((time % 10.0) - 5.0) > 0.7
    found = identify_step_response(record(time[kept], setpoint[kept], response[kept]), "roll_rate")
    assert found.trusted, found.doubts
    assert np.abs(found.values - true_step(found.time)).max() < 0.06
    assert len(record(time[kept], setpoint[kept], response[kept])[SETPOINT].gaps) == 6


def poor_data() -> dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Return logs that no step response can be trusted of, by what is wrong with them."""
    time, setpoint, response = fly()
    count = len(time)
    slow = slice(None, None, 20)
    wild = noise(7, count, 0.05, 2.0, 200.0)
    torn = np.arange(count) % 150 < 100
    following = np.interp(time - 0.02, time, scipy.signal.lsim(LOOP, wild, time)[1])
    return {
        "a setpoint that never moves": (time, np.full(count, 0.3), response),
        "hover: a setpoint of noise alone": (
            time,
            0.02 * np.random.default_rng(5).standard_normal(count),
            response,
        ),
        "a setpoint of another flight": (time, wild, response),
        "a response that stands still": (time, setpoint, np.full(count, 0.1)),
        "three seconds": (time[:600], setpoint[:600], response[:600]),
        "ten samples a second": (time[slow], setpoint[slow], response[slow]),
        "gaps everywhere": (time[torn], setpoint[torn], response[torn]),
        "turbulence that drowns it": fly(disturbed=3.0),
        "a clock that is 0.1 s off": (time[:-20], setpoint[:-20], response[20:]),
        "a setpoint that follows the response": (time, following, wild),
    }


def test_poor_data_are_said_to_be_poor(case):
    """Each of ten kinds: refused, or not trusted, with a reason."""
    for what, flown in poor_data().items():
        with case(what):
            try:
                found = identify_step_response(record(*flown), "roll_rate")
            except WorkbenchError as error:
                assert "there is no step response" in str(error)
            else:
                assert found.doubts, (found.coherence, found.final)
                drowned = "another flight" in what or "drowns" in what
                assert any("coherence" in doubt for doubt in found.doubts) or not drowned


def test_what_a_log_does_not_have_is_a_sentence(case):
    flight = record(*fly(duration=5.0))
    for loop, said in (
        ("roll", "has no attitude_setpoint.roll"),
        ("rol_rate", "did you mean 'roll_rate'"),
        (f"{SETPOINT}:imu.angular_velocity.z", "unknown signal"),
    ):
        with case(loop), pytest.raises(WorkbenchError, match=said):
            identify_step_response(flight, loop)


def flown(path: Path, seconds: float, actions: list[Action], turbulence: float) -> Flight:
    log = LoggedFlight(path, Scenario(duration=seconds, script=actions), {"turbulence": turbulence})
    log.run(lambda share: None)
    return read_flight(path)


def pilot(seed: int, seconds: float) -> list[Action]:
    """Return velocities that a pilot asks for, each for 0.4 to 2.5 s."""
    random, actions, at = np.random.default_rng(seed), [], 3.0
    while at < seconds:
        velocity = random.uniform(-0.7, 0.7, 3).tolist()
        actions.append(Action(at=round(128.0 * at) / 128.0, velocity=velocity))
        at += random.uniform(0.4, 2.5)
    return actions


@pytest.mark.slow
def test_a_flight_through_turbulence_gives_the_step_that_is_flown_in_calm_air(tmp_path, case):
    """Within 6 % in the settled part, in light and in moderate turbulence."""
    for axis in "xz":
        velocity = [0.5 * (axis == each) for each in "xyz"]
        steps = [Action(at=4.0, velocity=[0.0] * 3), Action(at=6.0, velocity=velocity)]
        calm = flown(tmp_path / f"{axis}.mcap", 12.0, steps, 0.0)[f"velocity_data.v_{axis}"]
        for seed, turbulence in enumerate((7.7, 15.4)):
            with case(axis, turbulence):
                path = tmp_path / f"{axis}{turbulence}.mcap"
                flight = flown(path, 60.0, pilot(seed, 60.0), turbulence)
                found: StepEstimate = identify_step_response(flight, f"v_{axis}")
                true = np.interp(6.0 + found.time, calm.time, calm.values) / 0.5
                off = np.abs(found.values - true)[found.time > 0.6 * found.time[-1]]
                assert found.trusted, found.doubts
                assert off.max() < 0.06


def test_a_measured_place_or_velocity_goes_before_an_estimate_of_it(case):
    """Whichever the log has first; the gyro goes before both of a rate."""
    for loop, setpoint, responses in (
        ("x", "setpoint.x", ("position_data.x", "estimate.x")),
        ("v_z", "setpoint.v_z", ("velocity_data.v_z", "estimate.v_z")),
        ("pitch_rate", "rate_setpoint.w_y", ("imu.angular_velocity.y", "estimate.w_y")),
    ):
        for names in (responses, responses[::-1], responses[1:]):
            signals = {name: make_series(name, "", TIMES, TIMES) for name in (setpoint, *names)}
            found = find_logged_loop(Flight("made", Path("made"), "made", signals, end=1.0), loop)
            with case(loop, names):
                assert found[:2] == (setpoint, min(names, key=responses.index))
