"""A law that states its period, runs a part of it in every fifth update, and knows the rotors."""

from dataclasses import replace

import numpy as np
import pytest

from workbench import Scenario, Session
from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.design.rollout.agreement import agreement, random_trials
from workbench.gains.gain_choice import flight_gains
from workbench.scenario.scenario import Rates, ScenarioStart

LAW = '''"""Velocity at 102.4 Hz around attitude at 512 Hz; the law makes its own thrusts."""

from workbench.controllers import GRAVITY, Loop, State, attitude_error, attitude_matrix, gain
from workbench.controllers import into_body, moment, position_error, probe3, tilted
from workbench.controllers import velocity_setpoint

PERIOD = 1 / 512
DIVIDERS = (5,)
PARAMETERS = [
    gain("p_position", "1/s", (0.0, 5.0), 0.8, "velocity per error of position"),
    gain("p_velocity", "1/s", (0.1, 20.0), 2.5, "acceleration per error of velocity"),
    gain("p_tilt", "1/s^2", (0.0, 900.0), 120.0, "angular acceleration per error of tilt"),
    gain("d_tilt", "1/s", (0.0, 100.0), 18.0, "the same per rate"),
    gain("p_yaw", "1/s", (0.0, 30.0), 4.0, "the same per error of rate"),
]
MEMORY = [State(f"f_{k}", "m/s^2", 9.81 * (k == "z")) for k in "xyz"]
MEMORY += [State("clock", "s"), State("runs", "1")]
POINTS = {f"velocity_{k}_error": "m/s" for k in "xyz"} | {f"turn_{k}": "rad/s^2" for k in "xyz"}
LOOPS = [
    Loop("velocity_x", "velocity_x_error", axis="x", gains=("p_velocity",)),
    Loop("pitch", "turn_y", axis="x", gains=("p_tilt", "d_tilt")),
]
DESIGNED = ("lift",)


def design(vehicle, g, dt):
    return [sum(rotor.force * rotor.max_thrust for rotor in vehicle.rotors)]


def update(measured, setpoint, g, vehicle, memory, dt, loops):
    x, y, z = position_error(measured, setpoint)
    back = g.p_position * x, g.p_position * y, g.p_position * z
    s_x, s_y, s_z, yaw_rate = velocity_setpoint(back, measured, setpoint, g)
    v, since = measured.v_WBcm, measured.elapsed[0]
    e = probe3((s_x - v[0], s_y - v[1], s_z - v[2]), 0, loops)
    f_W = (memory.f_x, memory.f_y, memory.f_z)
    runs = memory.runs
    if since > 0.0:
        f_W = tilted(g.p_velocity * e[0], g.p_velocity * e[1], g.p_velocity * e[2] + GRAVITY, g)
        runs = runs + 1.0
    R = attitude_matrix(measured.q_WT)
    f, w = into_body(R, f_W), into_body(R, measured.w_WB)
    s_w = R[6] * yaw_rate, R[7] * yaw_rate, R[8] * yaw_rate
    e_x, e_y, e_z = attitude_error(f, w, s_w)
    turn = g.p_tilt * e_x - g.d_tilt * w[0], g.p_tilt * e_y - g.d_tilt * w[1], g.p_yaw * e_z
    m_x, m_y, m_z = moment(probe3(turn, 3, loops), w, vehicle.inertia)
    force = vehicle.mass * f[2]
    force = force if force < g.lift else g.lift
    return (force, m_x, m_y, m_z), (*f_W, memory.clock + since, runs)
'''


@pytest.fixture
def law(tmp_path):
    path = tmp_path / "halves.py"
    path.write_text(LAW)
    return str(path)


def memory_of(session: Session) -> dict[str, float]:
    names = [state.name for state in session.controller.memory]
    bench = session._bench
    context = bench.computer.GetMyContextFromRoot(session._live.root)
    return dict(zip(names, context.get_discrete_state(2).value(), strict=True))


def test_a_law_flies_at_its_period_and_its_slow_part_in_every_fifth_update(law):
    session = Session(Scenario(controller=law, start=ScenarioStart(position=[0, 0, 5])))
    assert session.scenario.rates.control_period == 1 / 512
    session.command([1.0, 0.0, 0.0])
    session.tick(2.0)
    memory = memory_of(session)
    # updates at 0, 1/512, .. 1024/512: a part of them has not been made when time stops
    assert memory["runs"] == pytest.approx(1024 / 5, abs=1.0)
    assert memory["clock"] == pytest.approx(5 / 512 * memory["runs"], rel=1e-12)
    assert session.snapshot().v_WB[0] == pytest.approx(1.0, abs=0.1)  # nothing makes up for drag


def test_it_stops_in_the_middle_and_goes_on_to_the_bit(law):
    whole, parts = (Session(Scenario(controller=law)) for _ in range(2))
    for session in (whole, parts):
        session.command([0.5, -0.5, 0.2])
    whole.tick(1.0)
    for _ in range(1024):
        parts.tick(1 / 1024)
    assert np.array_equal(whole.state(), parts.state())
    other = Session(Scenario(controller=law))
    other.begin_from(parts.checkpoint())
    for session in (whole, other):
        session.tick(0.5)
    assert np.array_equal(whole.state(), other.state())


def test_a_scenario_that_states_another_period_keeps_it(law):
    scenario = Scenario(controller=law, rates=Rates(control_period=1 / 256))
    assert Session(scenario).scenario.rates.control_period == 1 / 256
    assert Session(Scenario()).scenario.rates.control_period == 1 / 128
    with pytest.raises(WorkbenchError, match=r"not a multiple of the physics step 0\.005 s"):
        Session(Scenario(controller=law, rates=Rates(physics_step=0.005, control_period=1 / 128)))


def test_it_takes_over_in_flight_with_its_period(law):
    session = Session(Scenario())
    session.tick(1.0)
    session.fly_controller(law)
    session.tick(1.0)
    assert memory_of(session)["runs"] == pytest.approx(512 / 5, abs=1.0)


@pytest.mark.slow
def test_compiled_flights_and_the_diagram_agree(law):
    scenario = Scenario(controller=law)
    session = Session(scenario)
    own = flight_gains(session.vehicle, controller=session.controller)
    trials = random_trials(session.vehicle, own, 4, 1)
    calm = [replace(trial, gains={}) for trial in trials]
    assert np.median(agreement(scenario, calm, duration=2.0).velocity) < 1e-3  # two integrators


def test_a_design_knows_the_rotors(law):
    session = Session(Scenario(controller=law))
    most = sum(rotor.max_thrust for rotor in session.vehicle.rotors)
    context = session._bench.computer.GetMyContextFromRoot(session._live.root)
    gains = context.get_numeric_parameter(0).CopyToVector()
    assert gains[-1] == pytest.approx(most, rel=1e-6)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ("PERIOD = 0.003", r"PERIOD is 0\.003: give it a multiple of 1/4096 s"),
        ("PERIOD = 'fast'", r"PERIOD is 'fast'"),
        ("PERIOD = 1.0", r"PERIOD is 1\.0"),
        ("DIVIDERS = (0,)", r"DIVIDERS has 0: give it numbers from 1 to 1000"),
    ],
)
def test_wrong_ones_are_sentences(tmp_path, wrong, said):
    path = tmp_path / "wrong.py"
    name = wrong.split(" = ", maxsplit=1)[0]
    lines = [wrong if line.startswith(f"{name} =") else line for line in LAW.splitlines()]
    path.write_text("\n".join(lines))
    with pytest.raises(WorkbenchError, match=said):
        load_controller(path)
