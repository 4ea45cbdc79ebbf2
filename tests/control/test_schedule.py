"""Scheduled gains: against np.interp, against laws without a schedule, and in every engine."""

import dataclasses
import pickle
from collections import namedtuple
from pathlib import Path

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.control.law_constants import known_body, law_constants
from workbench.control.schedule import SCHEDULE_QUANTITIES, parse_schedule
from workbench.design.judge.loop_judgement import judge_loops
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy
from workbench.design.linear.trim import filtered_of
from workbench.design.rollout.agreement import AgreementTrial, agreement
from workbench.design.rollout.candidates import start_state
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.step_response import fly_step
from workbench.design.tune.case import Robustness
from workbench.design.tune.tuner import tune
from workbench.design.tune.wish import wishes_for
from workbench.gains.gain_choice import flight_gains
from workbench.logs.flight_log import LoggedFlight
from workbench.logs.record import read_log
from workbench.logs.replay import replay
from workbench.scenario.scenario import Action, Scenario, ScenarioStart, VehicleConfig
from workbench.session.session import Session

ORACLES = Path(__file__).resolve().parents[1] / "oracles"
EFFECTS = VehicleConfig(
    str(ORACLES / "uneven_quad.urdf"), rotors=str(ORACLES / "effects.rotors.yaml")
)
"""A vehicle with a battery that sags."""
PERIOD = 1 / 128


def uneven(law, own, spread):
    """Return gains whose sets differ by factors, and nothing else."""
    found = dict(own)
    for row in law.parameters:
        number = law.schedule.number_of(row.name)
        if number:
            found[row.name] = min(row.maximum, found[row.name] * spread[number])
    return {row.name: found[row.name] for row in law.parameters}


def test_labels_are_read_and_anything_else_is_a_sentence(case):
    law = load_controller("pd@speed=0,2.5,8")
    assert law.name == "pd@speed=0,2.5,8" and law.shipped and law.unscheduled == "pd"
    assert pickle.loads(pickle.dumps(law)) is law
    assert law.gain_of("kp_velocity_z_at_2_5") == "kp_velocity_z"
    assert "at speed 2.5 m/s" in next(r.help for r in law.parameters if r.name.endswith("_at_2_5"))
    assert [row.name for row in law.parameters if row.group == "Limits"] == [
        row.name for row in load_controller("pd").parameters if row.group == "Limits"
    ]
    for label, said in (
        ("sped=0,4", "near is speed|known are"),
        ("speed=4", "2 to 8 ascending values"),
        ("speed=4,0", "ascending"),
        ("speed=-1,4", "0 or more"),
        ("speed=0,1e-9", "six digits"),
        ("speed=0,nan", "ascending"),
        ("speed=", "ascending"),
        ("speed=0,1,2,3,4,5,6,7,8", "2 to 8"),
        ("speed=0,4@height=1,2", "over one quantity"),
        ("speed", "write it as pd@speed=0,4,8"),
        ("Speed=0,4", "write it as pd@speed=0,4,8"),
    ):
        with case(label), pytest.raises(WorkbenchError, match=said):
            load_controller(f"pd@{label}")
    with pytest.raises(WorkbenchError, match="unknown controller"):
        load_controller("pdd@speed=0,4")


@pytest.mark.parametrize("name", ["pd", "lqi"])
def test_gains_lie_on_lines_between_their_sets(name, vehicle):
    """Every number of `g`, designed ones too, is that of numpy's interpolation."""
    law, plain = load_controller(f"{name}@height=1,3,10"), load_controller(name)
    body = known_body(law_constants(vehicle))
    own = flight_gains(vehicle, controller=law)
    sets = uneven(law, own, (1.0, 1.3, 0.7))
    numbers = law.gains({**own, **sets}, body, PERIOD)
    names = [*(row.name for row in law.parameters), *law.designed]
    by_name = dict(zip(names, numbers, strict=True))
    heard = []

    def listen(measured, setpoint, g, vehicle, memory, dt, loops):
        heard.append(g._asdict())

    schedule = parse_schedule("height=1,3,10")
    gains = namedtuple("Gains", listed(plain))
    scheduled = [each for each in listed(plain) if each not in names]
    update = schedule.update(listen, gains, scheduled, f"{name}_test")
    measured = namedtuple("M", "p_WB")
    for height in (-1.0, 0.0, 1.0, 1.7, 3.0, 4.2, 9.9, 10.0, 50.0):
        g = namedtuple("All", names)(*numbers)
        update(measured((0.0, 0.0, height)), None, g, None, None, PERIOD, None)
        for gain, value in heard.pop().items():
            values = (
                [by_name[each] for each in schedule.names(gain)]
                if gain in scheduled
                else [by_name[gain]] * 3
            )
            assert value == pytest.approx(np.interp(height, [1, 3, 10], values), rel=1e-12)
            if gain in scheduled:
                assert schedule.between(values, height) == value


def listed(law):
    return [*(row.name for row in law.parameters), *law.designed]


@pytest.mark.slow
@pytest.mark.parametrize("quantity", [each.name for each in SCHEDULE_QUANTITIES])
def test_equal_sets_fly_as_the_law_without_a_schedule_to_the_bit(quantity):
    flown = []
    for name in ("pid", f"pid@{quantity}=0,0.9,2"):
        session = Session(Scenario(controller=name, vehicle=EFFECTS))
        session.set("known_payload_mass", 0.1)
        session.set("payload_mass", 0.1)
        session.command([2.0, 1.0, 0.5], 0.2)
        session.tick(1.5)
        flown.append(session.recording().p_WB.tobytes() + session.state().tobytes())
    assert flown[0] == flown[1]


SCHEDULED = (
    ("pd@speed=0,2", VehicleConfig()),
    ("pd@height=9,11", VehicleConfig()),
    ("pd@payload=0,0.3", VehicleConfig()),
    ("pd@voltage=0.9,1", EFFECTS),
)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "vehicle"), SCHEDULED, ids=[name for name, _ in SCHEDULED])
def test_compiled_flights_agree_with_the_diagram(name, vehicle):
    """The sets of gains move them by more than 1 mm/s."""
    duration = 2.0
    scenario = Scenario(vehicle=vehicle, controller=name)
    law = load_controller(name)
    session = Session(scenario)
    own = session.parameters()
    gains = uneven(law, own, (1.0, 0.6))
    trials = [
        AgreementTrial(
            {**gains, "known_payload_mass": 0.1 * k, "payload_mass": 0.1 * k},
            ScenarioStart(position=[0.0, 0.0, 10.0]),
            (1.5 * k, 0.5, 0.2 * k, 0.1),
        )
        for k in range(4)
    ]
    found = agreement(scenario, trials, duration=duration)
    assert not found.lost.any()
    assert found.velocity.max() < 5e-4 and found.angular_velocity.max() < 3e-3  # two integrators
    same = [
        AgreementTrial({**each.gains, **equal(law, own)}, each.start, each.command)
        for each in trials
    ]
    moved = agreement_difference(scenario, trials, same, duration)
    assert moved > 1e-3, "the sets that differ make no difference"


def equal(law, own):
    return {row.name: own[row.name] for row in law.parameters}


def agreement_difference(scenario, trials, others, duration) -> float:
    """Return by how much two series of compiled flights differ [m/s]."""
    session = Session(scenario)
    engine = RolloutEngine(session.vehicle, controller=session.controller)
    flown = [
        engine.fly_from(
            [each.gains for each in some],
            np.array([start_state(session.vehicle, each.start) for each in some]),
            np.array([each.command for each in some]),
            duration=duration,
        ).states
        for some in (trials, others)
    ]
    return float(np.abs(flown[0][:, :, 10:] - flown[1][:, :, 10:]).max())


def test_linear_models_are_those_of_the_set_that_flies():
    """Beyond the last set gains do not change with the speed, and at rest it has no derivative."""
    own = LinearStudy(Scenario()).gains
    study = LinearStudy(Scenario(controller="pd@speed=0,3"))
    sets = uneven(study.controller, study.gains, (1.0, 0.8))
    for speed, factor in ((0.0, 1.0), (4.0, 0.8)):
        plain = {name: own[name] * (factor if f"{name}_at_3" in sets else 1.0) for name in own}
        point = OperatingPoint(velocity=(speed, 0.0, 0.0))
        found, wanted = study.sampled(point, sets), LinearStudy(Scenario()).sampled(point, plain)
        assert pytest.approx(wanted.A, abs=1e-9) == found.A


def test_linear_models_know_how_gains_change_with_the_quantity():
    """Between two sets: the law's derivative by the speed, beside differences of its updates."""
    study = LinearStudy(Scenario(controller="pd@speed=0,4"))
    sets = {**study.gains, **uneven(study.controller, study.gains, (1.0, 0.5))}
    point = OperatingPoint(velocity=(2.0, 0.0, 0.0))
    trim = study.trim(point, sets)
    derivatives = study._derivatives
    derivatives.set_gains(sets)
    arguments = [trim.state, filtered_of(trim, study._rate), trim.commands]
    reference, guidance = np.zeros(8), np.zeros(22)
    reference[0] = 2.5
    guidance[:3] = 1.0
    found = derivatives._update(*arguments, reference, guidance, np.empty(0))
    for axis in range(3):
        either = []
        for sign in (1.0, -1.0):
            state = trim.state.copy()
            state[10 + axis] += sign * 1e-6
            moved = derivatives._update(state, *arguments[1:], reference, guidance, np.empty(0))
            either.append(moved.commands)
        slope = (either[0] - either[1]) / 2e-6
        assert found.commands_by[:, 9 + axis] == pytest.approx(slope, rel=1e-5, abs=1e-5)


def test_another_schedule_takes_over_without_a_bump():
    """With the gains that fly then: of one set, or between two of them."""
    flown = {}
    for takes_over in ("", "pd@speed=0,4", "pd@height=1,2"):
        session = Session(Scenario())
        session.command([3.0, 0.0, 0.5])
        session.tick(0.75)
        if takes_over:
            session.fly_controller(takes_over)
        session.tick(0.75)
        flown[takes_over] = session.state().tobytes()
    assert len(set(flown.values())) == 1

    session = Session(Scenario(controller="pd@speed=0,4"))
    session.set("kp_velocity_x_at_4", 2.0)
    session.command([2.0, 0.0, 0.0])
    session.tick(2.0)
    sets = [session.get(f"kp_velocity_x_at_{value}") for value in (0, 4)]
    speed = float(np.linalg.norm(session.state()[10:13]))
    session.fly_controller("pd")
    assert session.get("kp_velocity_x") == pytest.approx(np.interp(speed, [0.0, 4.0], sets))


def test_a_set_that_does_not_fly_changes_no_bit():
    flown = []
    for value in (None, 1.0):
        session = Session(Scenario(controller="pd@speed=0,2,4"))
        session.command([1.5, 0.0, 0.0])
        session.tick(0.5)
        if value:
            session.set("kp_velocity_x_at_4", value)
        session.tick(0.5)
        flown.append(session.state().tobytes())
    assert flown[0] == flown[1]


def test_a_log_with_a_schedule_is_flown_again_to_the_bit(tmp_path):
    own = tmp_path / "mine.py"
    own.write_text((ORACLES.parent / "controllers/cascade.py").read_text(), encoding="utf-8")
    for name, gain in (("pd@speed=0,2", "kp_velocity_x"), (f"{own}@speed=0,2", "k_speed")):
        path = tmp_path / "flight.mcap"
        script = [Action(velocity=[2.0, 0.0, 0.0])]
        scenario = Scenario(controller=name, duration=1.0, script=script)
        LoggedFlight(path, scenario, {f"{gain}_at_2": 3.0}).run(lambda share: None)
        record = read_log(path)
        trust = "" if name.startswith("pd") else str(path)
        assert replay(record, controller=trust).equal
    assert replay(record, controller=str(own)).equal


def test_systems_of_drake_cannot_be_scheduled(tmp_path):
    file = tmp_path / "held.py"
    file.write_text(
        """
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource


def system(vehicle, g, dt):
    builder = DiagramBuilder()
    source = builder.AddSystem(ConstantVectorSource([0.0] * 4))
    builder.ExportOutput(source.get_output_port(), "wrench")
    return builder.Build()
""",
        encoding="utf-8",
    )
    with pytest.raises(WorkbenchError, match="cannot be scheduled"):
        load_controller(f"{file}@speed=0,4")


@pytest.mark.slow
def test_a_step_from_a_steady_flight_is_the_same_compiled_and_on_the_diagram():
    assert_steps_agree(1.5)


def test_the_begin_of_such_a_step_is_the_same_compiled():
    assert_steps_agree(0.25)


def assert_steps_agree(duration) -> None:
    """Compare a step from 3 m/s with that of the diagram [s]."""
    velocity, law = (3.0, 0.0, 0.5), load_controller("pd@speed=0,2")
    sets = uneven(law, Session(Scenario(controller=law.name)).parameters(), (1.0, 0.6))
    flown = fly_step(
        "y",
        1.0,
        duration=duration,
        scenario=Scenario(controller=law.name),
        settings=sets,
        velocity=velocity,
    )
    engine = RolloutEngine(flown.recording.vehicle, controller=law)
    compiled = engine.fly([sets], "y", 1.0, duration=duration, velocity=velocity)
    response = compiled.response[0]
    assert flown.response == pytest.approx(response - response[0], abs=1e-4)
    assert flown.recording.between(1.0, 1.1).v_WB[0] == pytest.approx(velocity, abs=0.05)


@pytest.mark.slow
def test_tuning_at_a_speed_changes_the_set_that_flies_there():
    """And the set at rest, tuned for other wishes, stays as it was found."""
    scenario = Scenario(controller="pd@speed=0,6")
    wishes = wishes_for(
        "x.rise_time<=0.8", "pitch.phase_margin>=45deg", controller=scenario.controller
    )
    wishes = dataclasses.replace(wishes, robustness=Robustness(0.0, 0.0, 0.0))  # one vehicle
    found = tune(wishes, scenario, velocity=(6.0, 0.0, 0.0))
    assert found.met and found.proof and not found.proof.missed
    assert found.gains and all(name.endswith("_at_6") for name in found.gains)
    assert found.profile.controller == scenario.controller
    again = fly_step(
        "x", 1.0, scenario=scenario, settings={**found.profile.gains}, velocity=(6.0, 0.0, 0.0)
    )
    assert again.metrics.rise_time <= 0.8
    model = LinearStudy(scenario).sampled(
        OperatingPoint(velocity=(6.0, 0.0, 0.0)), found.profile.gains
    )
    (pitch,) = [each for each in judge_loops(model) if each.loop == "pitch"]
    assert pitch.actuator.phase_margin >= np.radians(45.0)


def test_each_quantity_is_read_of_its_own_part_of_a_flight(case):
    flight = {"height": 3.0, "velocity": (2.0, -1.0, 2.0), "payload": 0.25, "voltage": 0.8}
    expected = {"height": 3.0, "speed": 3.0, "payload": 0.25, "voltage": 0.8}
    for name, value in expected.items():
        with case(name):
            assert parse_schedule(f"{name}=0,1,4").value(**flight) == value


def test_the_nearest_set_is_the_one_with_the_largest_weight(case):
    schedule = parse_schedule("height=1,3,10")
    for value, number in ((-5.0, 0), (1.9, 0), (2.1, 1), (6.4, 1), (6.6, 2), (99.0, 2)):
        with case(value):
            assert schedule.nearest(value) == number
            weights = [schedule.between([float(k == n) for k in range(3)], value) for n in range(3)]
            assert weights[number] == max(weights)
