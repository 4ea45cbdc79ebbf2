"""Flights against an integrator of the tests' own, `reference_flight`, and against MuJoCo.

The reference knows the vehicle from what `workbench inspect --json` prints, and gets the rotor
commands that were flown; so these also show that the two are enough to fly the same elsewhere.
"""

import copy
import dataclasses
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from reference_flight import (
    ReferenceVehicle,
    air_loads,
    angles_between,
    fly,
    quaternion_rate,
    rotation,
    speed_rates,
)

from workbench.commands.cli import main
from workbench.plant.variation import Variation
from workbench.scenario.scenario import Rates, Scenario, ScenarioStart, VehicleConfig
from workbench.session.open_loop import fly_open_loop
from workbench.session.session import Session

UNEVEN = str(Path(__file__).parent / "uneven_quad.urdf")
VEHICLES = pytest.mark.parametrize("model", ["dh_drone", UNEVEN], ids=["dh_drone", "uneven_quad"])
PERIOD = 1 / 128
STEP = Rates().physics_step
DURATION = 5.0
HIGH = [0.0, 0.0, 300.0]
"""So that nothing touches the ground [m]."""
PLACE = 1e-3
"""By which a flight may differ from the reference [m]."""
ANGLE = math.radians(0.05)
"""The same of its attitude [rad]."""


@pytest.fixture
def printed(capsys):
    """Return a vehicle as the reference reads it from what is printed."""

    def read(model: str, *options: str) -> ReferenceVehicle:
        capsys.readouterr()
        assert main(["inspect", model, *options, "--json"]) == 0
        return ReferenceVehicle.from_json(capsys.readouterr().out)

    return read


@pytest.fixture
def flown(tmp_path):
    """Fly rotor commands through the workbench's open loop and return the recording."""

    def fly_commands(vehicle, start, time, speeds, duration=DURATION, **rates):
        table = tmp_path / "commands.csv"
        thrusts = vehicle.thrusts(speeds)
        np.savetxt(table, np.column_stack([time, thrusts]), delimiter=",", fmt="%.17g")
        return fly_open_loop(Scenario(duration=duration, rates=Rates(**rates), **start), table)

    return fly_commands


def started(model: str, w_WB=(0.0, 0.0, 0.0), **start) -> dict:
    """Return vehicle and start of a scenario."""
    return {
        "vehicle": VehicleConfig(model=model),
        "start": ScenarioStart(position=HIGH, angular_velocity=list(w_WB), **start),
    }


def started_as(model: str, recording) -> dict:
    """Return a start in the first state of a flight: one that hovers begins as its rotors lean."""
    w, x, y, z = recording.q_WB[0].tolist()
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = math.asin(2 * (w * y - z * x))
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    velocity = recording.v_WB[0].tolist()
    return started(
        model, recording.w_WB[0].tolist(), velocity=velocity, roll_pitch_yaw=[roll, pitch, yaw]
    )


def smooth_commands(vehicle, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return times and rotor speeds about those of hover: sines of 0.2 to 2 Hz in each thrust."""
    rng = np.random.default_rng(seed)
    rotors = len(vehicle.top)
    time = np.arange(round(DURATION / PERIOD)) * PERIOD
    frequency, phase = rng.uniform(0.2, 2.0, (4, rotors)), rng.uniform(0, 2 * np.pi, (4, rotors))
    waves = np.sin(2 * np.pi * frequency * time[:, None, None] + phase).sum(axis=1)
    return time, vehicle.hover_speeds * np.sqrt(1.0 + 0.06 * waves)


def first_state(recording) -> np.ndarray:
    return np.concatenate(
        [recording.q_WB[0], recording.p_WB[0], recording.w_WB[0], recording.v_WB[0]]
    )


def differences(recording, reference) -> tuple[float, float]:
    """Return how far place [m] and attitude [rad] are apart at most."""
    count = len(reference.time)
    assert recording.time[:count] == pytest.approx(reference.time)
    places = np.linalg.norm(recording.p_WB[:count] - reference.p_WB, axis=1)
    return places.max(), angles_between(recording.q_WB[:count], reference.q_WB).max()


def check_same(recording, reference):
    place, angle = differences(recording, reference)
    assert place < PLACE
    assert angle < ANGLE


@pytest.mark.slow
@VEHICLES
@pytest.mark.parametrize(("seed", "w_WB"), [(0, (0.0, 0.0, 0.0)), (2, (-6.0, 13.0, 4.0))], ids=str)
def test_a_tumbling_flight_is_the_references(printed, flown, model, w_WB, seed):
    vehicle = printed(model)
    time, commands = smooth_commands(vehicle, seed)
    recording = flown(vehicle, started(model, w_WB), time, commands)
    start = first_state(recording)
    reference = fly(
        vehicle, start, commands[0], time, commands, DURATION, sample=PERIOD, step=1 / 512
    )
    rates = np.linalg.norm(reference.w_WB, axis=1)
    assert 4.0 < rates.max() < 25.0
    assert np.abs(commands - reference.rotor_speeds[:-1]).max() > 3.0
    assert recording.rotor_speeds == pytest.approx(reference.rotor_speeds, abs=0.05)
    check_same(recording, reference)


@VEHICLES
@pytest.mark.parametrize(
    "period",
    [
        pytest.param(1 / 64, marks=pytest.mark.slow, id="1/64"),
        pytest.param(1 / 128, id="1/128"),
        pytest.param(1 / 512, marks=pytest.mark.slow, id="1/512"),
    ],
)
def test_a_controlled_flight_is_the_references_under_its_commands(printed, flown, model, period):
    """The plant knows no control period: a table of the commands gives the same flight, to 5e-5.

    By that much steps of `runge_kutta5` and the shorter ones of `runge_kutta3` differ.

    A command reaches the rotors a physics step after the law read the state, so that the table
    begins with the speeds of the rotors. Off the control periods a table is held at each physics
    step, so that the replay is integrated more finely: 3e-4 apart at 1/64 s.
    """
    vehicle = printed(model)
    begun = started(model, (9.0, -7.0, 4.0), velocity=[3.0, -2.0, 1.0])
    begun["vehicle"].variation = Variation(command_delay=STEP)
    session = Session(
        Scenario(duration=2.0, rates=Rates(control_period=period, record_period=period), **begun),
        {"drag_area": vehicle.drag_area},
    )
    session.run()
    recording = session.recording()
    time = np.append(0.0, recording.time[:-1] + STEP)
    commands = np.vstack([recording.rotor_speeds[:1], recording.commanded_speeds[1:]])
    speeds = recording.rotor_speeds[0]
    assert np.ptp(commands, axis=0).max() > 100.0

    start = first_state(recording)
    check_same(recording, fly(vehicle, start, speeds, time, commands, 2.0, sample=period))
    start = started_as(model, recording)
    one, other = (
        flown(vehicle, start, time, commands, 2.0, control_period=each, record_period=period)
        for each in (1 / 64, 1 / 512)
    )
    for name in ("p_WB", "q_WB", "v_WB", "w_WB"):
        found, again, wanted = (getattr(each, name) for each in (one, other, recording))
        assert np.abs(found - again[: len(found)]).max() < 5e-5, name
        assert np.abs(found - wanted[: len(found)]).max() < 5e-4, name


@pytest.mark.slow
@pytest.mark.parametrize("most", [20.0, 40.0])
def test_random_tumbling_flights_under_a_law_are_the_references(printed, most):
    """Eight flights of 5 s that begin at any attitude, the last one turning at `most` rad/s."""
    vehicle, rng = printed("dh_drone"), np.random.default_rng(round(most))
    fastest = 0.0
    for share in np.linspace(0.3, 1.0, 8):
        turn = rng.normal(size=3)
        turn *= share * most / np.linalg.norm(turn)
        begun = started(
            "dh_drone",
            turn.tolist(),
            velocity=rng.uniform(-4.0, 4.0, 3).tolist(),
            roll_pitch_yaw=rng.uniform(-math.pi, math.pi, 3).tolist(),
        )
        settings = {"drag_area": vehicle.drag_area}
        session = Session(Scenario(duration=DURATION, **begun), settings)
        session.command(rng.uniform(-2.0, 2.0, 3).tolist(), 0.0)
        session.run()
        recording = session.recording()
        reference = fly(
            vehicle,
            first_state(recording),
            recording.rotor_speeds[0],
            recording.time[:-1],
            recording.commanded_speeds[1:],
            DURATION,
            sample=PERIOD,
            step=1 / 1024,
        )
        fastest = max(fastest, np.linalg.norm(recording.w_WB, axis=1).max())
        check_same(recording, reference)
    assert 0.8 * most < fastest < 1.2 * most


@pytest.mark.slow
@VEHICLES
@pytest.mark.parametrize(
    ("axis", "duration", "limit"),
    [
        ((1.0, 0.2, 0.3), 5.0, 1e-6),
        ((0.3, 1.0, -0.2), 5.0, 1e-6),
        ((0.5, -0.4, 1.0), 5.0, 1e-6),
        ((0.5, -0.4, 1.0), 60.0, 1e-5),
    ],
    ids=str,
)
def test_free_of_torque_a_body_keeps_momentum_and_energy(
    printed, flown, model, axis, duration, limit
):
    """17.5 rad/s with the rotors at rest; drag of the body acts at the centre of mass."""
    vehicle = printed(model)
    w_WB = 17.5 * np.array(axis) / np.linalg.norm(axis)
    still = np.zeros((1, len(vehicle.top)))
    begun = started(model, w_WB.tolist())
    begun["start"].position[2] = 20e3  # it falls 18 km in a minute
    recording = flown(vehicle, begun, np.zeros(1), still, duration)
    momenta, energies = [], []
    for q, w_W in zip(recording.q_WB, recording.w_WB, strict=True):
        R_WB = rotation(q)
        h_B = vehicle.inertia @ (R_WB.T @ w_W)
        momenta.append(R_WB @ h_B)
        energies.append(0.5 * w_W @ R_WB @ h_B)
    turned = np.linalg.norm(np.diff(recording.w_WB, axis=0), axis=1).sum()
    assert turned > 1.0  # it does not just spin about a principal axis
    lost = np.linalg.norm(np.array(momenta) - momenta[0], axis=1).max()
    assert lost < limit * np.linalg.norm(momenta[0])
    assert energies == pytest.approx(np.full(len(energies), energies[0]), rel=limit)


def laden(vehicle: ReferenceVehicle, mass: float, place, size) -> ReferenceVehicle:
    """Return a vehicle with a box that is fixed to it, by the parallel-axis theorem."""
    place, (a, b, c) = np.array(place), np.square(size)
    whole = vehicle.mass + mass
    com = (vehicle.mass * vehicle.com + mass * place) / whole
    inertia = vehicle.inertia + mass / 12.0 * np.diag([b + c, a + c, a + b])
    # two bodies turn about their common centre as their reduced mass does at their distance
    arm = place - vehicle.com
    reduced = vehicle.mass * mass / whole
    inertia = inertia + reduced * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return replace(vehicle, mass=whole, com=com, inertia=inertia)


@pytest.mark.parametrize("model", ["dh_drone", pytest.param(UNEVEN, marks=pytest.mark.slow)])
def test_a_payload_is_picked_up_and_dropped_as_in_the_reference(printed, model):
    """Position, velocity and attitude of the body's origin go on; the law is told wrong things."""
    vehicle = printed(model)
    place, size = (0.12, -0.08, -0.15), (0.1, 0.06, 0.2)
    session = Session(
        Scenario(**started(model, (6.0, -5.0, 4.0), velocity=[3.0, -2.0, 1.0])),
        {"drag_area": vehicle.drag_area, "known_payload_mass": 0.2}
        | {f"payload_{axis}": p for axis, p in zip("xyz", place, strict=True)}
        | {f"payload_size_{axis}": s for axis, s in zip("xyz", size, strict=True)},
    )
    carried = [(0.5, 0.0), (0.75, 0.6), (0.75, 0.0)]
    for duration, mass in carried:
        session.set("payload_mass", mass)
        session.tick(duration)
    recording = session.recording()
    acts, commands = recording.time[:-1], recording.commanded_speeds[1:]
    state, speeds, began = first_state(recording), recording.rotor_speeds[0], 0.0
    for duration, mass in carried:
        now = np.searchsorted(acts, began, side="right") - 1
        held = np.append(0.0, acts[now + 1 :] - began)
        flown = laden(vehicle, mass, place, size)
        leg = fly(flown, state, speeds, held, commands[now:], duration, sample=PERIOD)
        count = round(duration / PERIOD) + 1
        first = round(began / PERIOD)
        places = recording.p_WB[first : first + count] - leg.p_WB
        assert np.linalg.norm(places, axis=1).max() < PLACE
        turned = angles_between(recording.q_WB[first : first + count], leg.q_WB)
        assert turned.max() < ANGLE
        state = np.concatenate([leg.q_WB[-1], leg.p_WB[-1], leg.w_WB[-1], leg.v_WB[-1]])
        speeds, began = leg.rotor_speeds[-1], began + duration


EFFECTS = {
    "linear": ("linear_motor_constant",),
    "inflow": ("inflow_coefficient",),
    "ground": ("ground_effect_coefficient", "propeller_radius"),
    "battery": (),
}
"""Keys of what rotors may have, by effect; that of the battery is its own."""


@pytest.mark.parametrize(
    "rows",
    [
        (tuple(EFFECTS),),
        pytest.param(tuple((effect,) for effect in EFFECTS), marks=pytest.mark.slow),
    ],
    ids=["together", "alone"],
)
def test_each_effect_is_the_references(printed, flown, tmp_path, rows, case):
    """With a coefficient off by an eighth it is another flight."""
    whole = yaml.safe_load((Path(__file__).parent / "effects.rotors.yaml").read_text())
    for wanted in rows:
        with case(wanted):
            file = copy.deepcopy(whole)
            for effect in EFFECTS.keys() - set(wanted):
                for key in EFFECTS[effect]:
                    del file["defaults"][key]
            if "battery" not in wanted:
                del file["battery"]
            sidecar = tmp_path / "rotors.yaml"
            sidecar.write_text(yaml.safe_dump(file))
            vehicle = printed(UNEVEN, "--rotors", str(sidecar))
            start = started(UNEVEN, (3.0, -2.0, 4.0), velocity=[1.0, -1.0, 5.0])
            start["vehicle"].rotors = str(sidecar)
            start["start"].position = [0.0, 0.0, 7.0]
            time, commands = smooth_commands(vehicle, 5)
            recording = flown(vehicle, start, time, commands, 2.0)
            assert recording.p_WB[:, 2].min() > 1.0
            given = (first_state(recording), commands[0], time, commands, 2.0)
            steps = {"sample": PERIOD, "step": 1 / 512}
            reference = fly(vehicle, *given, **steps)
            place, angle = differences(recording, reference)
            assert place < PLACE and angle < ANGLE
            for effect in wanted:
                other = fly(off(vehicle, effect), *given, **steps)
                assert differences(recording, other)[0] > 2e-3, effect


def off(vehicle, effect: str) -> ReferenceVehicle:
    """Return a vehicle whose coefficient of an effect is an eighth too large."""
    if effect == "battery":
        battery = vehicle.battery | {"resistance": 1.125 * vehicle.battery["resistance"]}
        return dataclasses.replace(vehicle, battery=battery)
    name = f"{effect}_coefficients"
    return dataclasses.replace(vehicle, **{name: 1.125 * getattr(vehicle, name)})


class MujocoBody:
    """The vehicle in MuJoCo: a floating body, and the rotors as bodies that turn on hinges.

    So spin-up torque and gyroscopic moment come from MuJoCo's multibody dynamics, not from a
    formula. Rotors take a little of the mass; each is a disk about its axis.
    """

    SHARE = 0.01
    """Of the mass that is in a rotor."""

    def __init__(self, mujoco, vehicle):
        self.mujoco = mujoco
        mass = self.SHARE * vehicle.mass
        base_mass = vehicle.mass - len(vehicle.top) * mass
        moment = vehicle.mass * vehicle.com - mass * vehicle.hubs.sum(axis=0)
        base_com = moment / base_mass
        base = vehicle.inertia - self.shifted(base_mass, base_com - vehicle.com)
        rotors = ""
        for hub, axis, J in zip(vehicle.hubs, vehicle.axes, vehicle.rotor_inertias, strict=True):
            disk = J * (0.6 * np.eye(3) + 0.4 * np.outer(axis, axis))
            base = base - disk - self.shifted(mass, hub - vehicle.com)
            rotors += (
                f'<body pos="{self.text(hub)}"><joint type="hinge" axis="{self.text(axis)}"/>'
                f'<inertial pos="0 0 0" mass="{mass!r}" fullinertia="{self.six(disk)}"/></body>'
            )
        model = mujoco.MjModel.from_xml_string(
            f'<mujoco><compiler boundinertia="0"/><option gravity="0 0 {-vehicle.gravity!r}"/>'
            f'<worldbody><body><freejoint/><inertial pos="{self.text(base_com)}" '
            f'mass="{base_mass!r}" fullinertia="{self.six(base)}"/>{rotors}</body></worldbody>'
            "</mujoco>"
        )
        self.model, self.data = model, mujoco.MjData(model)
        self.com = vehicle.com

    @staticmethod
    def text(values) -> str:
        return " ".join(repr(float(value)) for value in values)

    def six(self, M) -> str:
        return self.text([M[0, 0], M[1, 1], M[2, 2], M[0, 1], M[0, 2], M[1, 2]])

    @staticmethod
    def shifted(mass, arm):
        """Return what a point mass has about a point that far from it."""
        return mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))

    def rates(self, vehicle, x, commands, wind_W):
        """Return what `reference_flight.derivatives` does."""
        q, p, w, v_W, speeds, _ = np.split(x, [4, 7, 10, 13, -1])
        R_WB = rotation(q)
        rotor_rates = speed_rates(vehicle, speeds, commands)
        arm = R_WB @ self.com
        model, data = self.model, self.data
        data.qpos[0:7] = [*(p - arm), *q]
        data.qvel[0:3] = v_W - R_WB @ np.cross(w, self.com)
        data.qvel[3:6] = w
        data.qvel[6:] = vehicle.turns * speeds
        self.mujoco.mj_forward(model, data)
        force, moment = air_loads(vehicle, R_WB.T @ (v_W - wind_W), w, speeds, R_WB[2], p[2])
        applied = np.zeros(model.nv)
        self.mujoco.mj_applyFT(model, data, R_WB @ force, R_WB @ moment, p, 1, applied)
        M = np.zeros((model.nv, model.nv))
        self.mujoco.mj_fullM(model, data, M)
        left = applied[:6] - data.qfrc_bias[:6] - M[:6, 6:] @ (vehicle.turns * rotor_rates)
        a = np.linalg.solve(M[:6, :6], left)
        # of the base's origin, so that the centre's follows
        dw = a[3:6]
        turning = np.cross(dw, self.com) + np.cross(w, np.cross(w, self.com))
        dv = a[0:3] + R_WB @ turning
        return np.concatenate([quaternion_rate(q, w), v_W, dw, dv, rotor_rates, [0.0]])


@pytest.mark.slow
@VEHICLES
def test_mujoco_moves_the_body_and_its_rotors_alike(printed, flown, model):
    import mujoco  # takes a second

    vehicle = printed(model)
    time, commands = smooth_commands(vehicle, 1)
    recording = flown(vehicle, started(model, (9.0, -8.0, 10.0)), time, commands)
    start = first_state(recording)
    body = MujocoBody(mujoco, vehicle)
    given = (vehicle, start, commands[0], time, commands, DURATION)
    theirs = fly(*given, sample=PERIOD, step=1 / 512, rates=body.rates)
    check_same(recording, theirs)
    # two derivations of one motion: they differ by rounding alone
    ours = fly(*given, sample=PERIOD, step=1 / 512)
    place, angle = differences(theirs, ours)
    assert place < 1e-6
    assert angle < 1e-6
