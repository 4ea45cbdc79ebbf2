"""Oracles: the pure step in plain Python, called with the same numbers, and Drake's own plant."""

import dataclasses

import numba
import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource
from scipy.spatial.transform import Rotation

from workbench.common.jitable import tell_numba
from workbench.common.machine_code import kinds_of
from workbench.dynamics.air.normals import COUNT, draw_normals
from workbench.dynamics.air.settings import AirSettings, calm_air
from workbench.dynamics.air.update import push_at, wind_at
from workbench.dynamics.rigid_body import rigid_body
from workbench.dynamics.vehicle_step import FULL, rotor_rows, step_vehicle
from workbench.estimation.gyro import UNFILTERED
from workbench.plant.multibody import add_plant
from workbench.scenario.parameters import parameter_table
from workbench.systems import vehicle_dynamics as module
from workbench.systems.vehicle_dynamics import (
    ACCEL,
    BODY,
    GYRO,
    LAST,
    MEMORY,
    SPEEDS,
    TOUCHED,
    WIND,
    VehicleDynamics,
)

STEP = 1 / 1024
SEED = 77.0
SHARES = [1.0, 0.5, 0.0, 0.9]
GIVEN = [1.0, 0.5, 1.0, 0.9]
"""What one that has stopped gives while it runs down is all of it."""
HIGH = [1.0, *[0.0] * 5, 200.0, *[0.0] * 6]
WINDY = AirSettings(wind_x=5.0, turbulence=15.0, drag_area=0.1)
IN_AIR = 15
"""Place in the memory of how many steps nothing is touched for sure."""


@pytest.fixture(scope="module")
def spinning(description):
    """The shipped drone with rotors that have inertia."""
    rotors = tuple(dataclasses.replace(rotor, inertia=6.5e-5) for rotor in description.rotors)
    return dataclasses.replace(description, rotors=rotors)


@pytest.fixture
def dynamics(spinning, vehicle):
    return VehicleDynamics(description=spinning, settings=calm_air(vehicle), step=STEP)


def places(*names) -> list[int]:
    return [AirSettings._fields.index(name) for name in names]


def drawn(rng):
    """Return state, memory, commands and settings."""
    state = rng.normal(size=13) * 2.0
    state[:4] /= np.linalg.norm(state[:4])
    state[6] = rng.uniform(50.0, 100.0)
    eddies = np.append(rng.normal(size=5), rng.integers(0, 2))
    gyro = rng.normal(size=SPEEDS - GYRO)
    memory = [*rng.normal(size=9), *eddies, 100.0, *gyro, *rng.uniform(0, 1000, 4), *[1.0] * 4]
    settings = rng.normal(size=len(AirSettings._fields)) * 3.0
    positive = places("turbulence", "gust_duration", "drag_area", "air_density")
    settings[positive] = rng.uniform(0.6, 2.0, 4)
    settings[places("gust_start")] = rng.uniform(-0.5, 0.0)
    within = places("push_start", "push_duration")
    settings[within] = rng.uniform(0.0001, 0.0003, 2)  # a push within the step
    return state, np.array(memory), rng.uniform(0, 1000, 4), settings


tell_numba()


@numba.njit
def _normals(seed, number):
    drawn = np.empty(COUNT)
    draw_normals(seed, number, drawn)
    return drawn


def pure(spinning, vehicle, state, memory, commands, settings, number=0):
    """Return state and memory after a step."""
    eddies, speeds = np.zeros(6), np.zeros(4)
    time = number * STEP
    noise = _normals(SEED, number)
    wind = wind_at(time, state, noise, settings, STEP, memory[9:15], eddies)
    after, acceleration = step_vehicle(
        state,
        memory[LAST:WIND],
        memory[SPEEDS : SPEEDS + 4],
        commands,
        SHARES,
        wind,
        push_at(time, state, settings, STEP),
        0.5 * np.prod(settings[places("drag_area", "air_density")]),
        FULL,
        rigid_body(vehicle.mass, vehicle.inertia, vehicle.p_BoBcm_B).packed(),
        rotor_rows(spinning.rotors, STEP),
        STEP,
        np.zeros(4),
        np.zeros(4),
        speeds,
    )
    w_B = Rotation.from_quat(state[[1, 2, 3, 0]]).inv().apply(state[7:10])
    gyro = [*np.column_stack([np.zeros(3), w_B, np.zeros(3), w_B]).ravel(), *w_B]
    flown = [*after, *acceleration, *wind, *eddies, memory[IN_AIR] - 1.0]
    return np.array([*flown, *gyro, *memory[ACCEL:SPEEDS], *speeds, *GIVEN])


def stepped(dynamics, context, state, memory, commands, settings) -> np.ndarray:
    dynamics.GetInputPort("commands").FixValue(context, commands)
    values = context.get_mutable_numeric_parameter(0).get_mutable_value()
    values[: module.SHARES + 4] = [*settings, SEED, *UNFILTERED, 0.0, 0.0, *SHARES]
    context.SetDiscreteState(BODY, state)
    context.SetDiscreteState(MEMORY, memory)
    after = dynamics.EvalUniquePeriodicDiscreteUpdate(context)
    return np.concatenate([after.value(BODY), after.value(MEMORY)])


@pytest.mark.parametrize("number", [0, 1, 128 * 3600])
def test_in_the_air_its_update_is_the_pure_one_compiled(dynamics, spinning, vehicle, number):
    """And each has noise of its own."""
    context = dynamics.CreateDefaultContext()
    context.SetTime(number * STEP)
    rng = np.random.default_rng(3)
    for _ in range(50):
        given = drawn(rng)
        found = stepped(dynamics, context, *given)
        wanted = pure(spinning, vehicle, *given, number)
        assert found == pytest.approx(wanted, rel=1e-8, abs=1e-9)
        other = pure(spinning, vehicle, *given, number + 1)
        assert found != pytest.approx(other, rel=1e-8, abs=1e-9)


def test_settings_are_live_and_in_the_order_of_the_parameter_table(dynamics, spinning, vehicle):
    """Every one of them changes something."""
    assert [row.name for row in parameter_table().of("air")] == list(AirSettings._fields)
    context = dynamics.CreateDefaultContext()
    *given, settings = drawn(np.random.default_rng(4))
    before = stepped(dynamics, context, *given, settings)
    for index in range(len(settings)):
        changed = settings.copy()
        changed[index] += 0.05 if index not in places("push_duration") else 0.0002
        found = stepped(dynamics, context, *given, changed)
        assert np.abs(found - before).max() > 1e-10, AirSettings._fields[index]
        wanted = pure(spinning, vehicle, *given, changed)
        assert found == pytest.approx(wanted, rel=1e-8, abs=1e-9)


def test_defaults_are_those_of_the_table(vehicle):
    defaults = {row.name: row.default for row in parameter_table().of("air")}
    assert AirSettings(**defaults) == calm_air(vehicle)._replace(drag_area=0.015)


def test_all_rotors_are_whole_to_begin_with(dynamics):
    values = dynamics.CreateDefaultContext().get_numeric_parameter(0).value()
    assert values[module.SHARES : module.SHARES + 4].tolist() == [1.0] * 4


def test_inputs_are_only_read(dynamics):
    """Compiled code is handed Drake's own arrays."""
    context = dynamics.CreateDefaultContext()
    state, memory, commands, settings = drawn(np.random.default_rng(5))
    stepped(dynamics, context, state, memory, commands, settings)
    dynamics.GetOutputPort("acceleration").Eval(context)
    assert dynamics.GetInputPort("commands").Eval(context).tolist() == commands.tolist()
    values = context.get_numeric_parameter(0).value().tolist()
    assert values[: module.SHARES + 4] == [*settings, SEED, *UNFILTERED, 0.0, 0.0, *SHARES]
    assert context.get_discrete_state(BODY).value().tolist() == state.tolist()
    assert context.get_discrete_state(MEMORY).value().tolist() == memory.tolist()


def test_outputs_follow_from_its_state(dynamics, vehicle):
    context = dynamics.CreateDefaultContext()
    state, memory, _, _ = drawn(np.random.default_rng(6))
    context.SetDiscreteState(BODY, state)
    context.SetDiscreteState(MEMORY, memory)
    memory[SPEEDS + 4 :] = GIVEN
    context.SetDiscreteState(MEMORY, memory)
    speeds = memory[SPEEDS : SPEEDS + 4]
    assert dynamics.GetOutputPort("state").Eval(context).tolist() == state.tolist()
    assert dynamics.GetOutputPort("speeds").Eval(context).tolist() == speeds.tolist()
    assert dynamics.GetOutputPort("wind").Eval(context).tolist() == memory[6:9].tolist()
    constants = np.array([rotor.motor_constant for rotor in vehicle.rotors])
    thrusts = constants * speeds**2 * GIVEN
    assert dynamics.GetOutputPort("thrusts").Eval(context) == pytest.approx(thrusts)
    assert dynamics.GetOutputPort("acceleration").Eval(context).tolist() == memory[:6].tolist()


def test_the_acceleration_is_the_change_of_velocity_in_the_step_before(dynamics):
    context = dynamics.CreateDefaultContext()
    given = drawn(np.random.default_rng(7))
    found = stepped(dynamics, context, *given)
    assert STEP * found[13:19] == pytest.approx(found[7:13] - given[0][7:13], abs=1e-12)


def wind_of(spinning, seed, duration=0.5) -> list[list[float]]:
    """Return the wind at a drone that hovers, step by step."""
    builder = DiagramBuilder()
    commands = builder.AddSystem(ConstantVectorSource([660.0] * 4))
    dynamics = VehicleDynamics(description=spinning, settings=WINDY, step=STEP)
    builder.AddSystem(dynamics)
    builder.Connect(commands.get_output_port(), dynamics.GetInputPort("commands"))
    simulator = Simulator(builder.Build())
    context = dynamics.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    dynamics.place(context, np.array(HIGH), np.full(4, 660.0))
    dynamics.set_seed(context, seed)
    found = []
    for step in range(1, round(duration / STEP)):
        simulator.AdvanceTo((step + 0.5) * STEP)
        found.append(dynamics.GetOutputPort("wind").Eval(context).tolist())
    return found


def test_equal_seeds_give_equal_winds(spinning):
    assert wind_of(spinning, 1) == wind_of(spinning, 1)
    assert wind_of(spinning, 1) != wind_of(spinning, 2)


def test_where_it_touches_it_steps_as_drakes_plant_does(description, vehicle):
    """Dropped on a corner from a few centimetres, rotors at rest: up to rest on the ground.

    In the air above, steps are of second order and so not the plant's; they meet it at the same
    height at which it would arrive to within a step.
    """
    bare = dataclasses.replace(
        description,
        rotors=tuple(
            dataclasses.replace(r, rotor_drag_coefficient=0.0) for r in description.rotors
        ),
    )
    airless = calm_air(vehicle)._replace(drag_area=0.0)
    dynamics = VehicleDynamics(description=bare, settings=airless, step=STEP)
    context = dynamics.CreateDefaultContext()
    dynamics.GetInputPort("commands").FixValue(context, np.zeros(4))
    builder = DiagramBuilder()
    plant, _ = add_plant(builder, description.undrawn(), time_step=STEP)
    diagram = builder.Build()
    root = diagram.CreateDefaultContext()
    in_plant = plant.GetMyMutableContextFromRoot(root)
    q = np.array([1.0, 0.15, 0.1, 0.0])
    state = np.array([*q / np.linalg.norm(q), 0, 0, vehicle.ground_clearance + 0.01, *[0.0] * 6])
    dynamics.place(context, state, np.zeros(4))
    touched = 0
    for _ in range(2048):
        before = context.get_discrete_state(BODY).value().copy()
        after = dynamics.EvalUniquePeriodicDiscreteUpdate(context)
        found, memory = after.value(BODY).copy(), after.value(MEMORY).copy()
        if memory[IN_AIR] == TOUCHED:
            plant.SetPositionsAndVelocities(in_plant, before)
            wanted = plant.EvalUniquePeriodicDiscreteUpdate(in_plant).value().copy()
            wanted[:4] /= np.linalg.norm(wanted[:4])
            same = found == pytest.approx(wanted, abs=1e-10)
            touched += same
        context.SetDiscreteState(BODY, found)
        context.SetDiscreteState(MEMORY, memory)
    assert touched > 500
    assert np.abs(found[7:13]).max() < 1e-2
    assert found[6] == pytest.approx(vehicle.ground_clearance, abs=2e-3)


def test_at_rest_on_the_ground_it_is_not_accelerated(description, vehicle):
    dynamics = VehicleDynamics(description=description, settings=calm_air(vehicle), step=STEP)
    context = dynamics.CreateDefaultContext()
    dynamics.GetInputPort("commands").FixValue(context, np.zeros(4))
    state = np.array([1.0, *[0.0] * 5, vehicle.ground_clearance, *[0.0] * 6])
    dynamics.place(context, state, np.zeros(4))
    for _ in range(1024):
        after = dynamics.EvalUniquePeriodicDiscreteUpdate(context)
        context.SetDiscreteState(BODY, after.value(BODY).copy())
        context.SetDiscreteState(MEMORY, after.value(MEMORY).copy())
    found = dynamics.GetOutputPort("acceleration").Eval(context)
    assert np.abs(found).max() < 1e-3


def test_on_the_ground_flies_the_machine_code_of_the_air(dynamics, vehicle, monkeypatch):
    """A flight that touches something for the first time would wait for other machine code."""
    used = set()
    advance = module.compiled_advance

    def noting(*args):
        used.add(kinds_of(args))
        return advance(*args)

    noting.run = noting
    monkeypatch.setattr(module, "compiled_advance", noting)
    context = dynamics.CreateDefaultContext()
    dynamics.GetInputPort("commands").FixValue(context, np.zeros(4))
    for height in (HIGH[6], vehicle.ground_clearance):
        dynamics.place(context, np.array([*HIGH[:6], height, *HIGH[7:]]), np.zeros(4))
        memory = dynamics.EvalUniquePeriodicDiscreteUpdate(context).value(MEMORY)
    assert memory[IN_AIR] == TOUCHED
    assert len(used) == 1
