"""Oracle: the pure update in plain Python, called with the same numbers."""

import numba
import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, PassThrough

from workbench.parameters import parameters_of
from workbench.systems import compiled
from workbench.systems.air import air as module
from workbench.systems.air.air import Air, add_air
from workbench.systems.air.drag import rotor_rows
from workbench.systems.air.normals import COUNT, draw_normals
from workbench.systems.air.settings import AirSettings, calm_air
from workbench.systems.air.update import air_update

PERIOD = 1 / 128
PORTS = ("state", "speeds")
SEED = 77.0
WINDY = AirSettings(wind_x=5.0, turbulence=15.0, drag_area=0.1)


@pytest.fixture
def air(vehicle):
    return Air(vehicle=vehicle, settings=calm_air(vehicle), period=PERIOD, speeds=11)


def drawn(rng):
    """Return inputs, settings and what the turbulence remembers."""
    state = rng.normal(size=13) * 2.0
    state[6] = rng.uniform(0.0, 100.0)
    settings = rng.normal(size=len(AirSettings._fields)) * 3.0
    settings[[3, 8, 17, 18]] = rng.uniform(0.6, 2.0, 4)
    settings[7] = rng.uniform(-0.5, 0.0)
    settings[[15, 16]] = rng.uniform(0.001, 0.003, 2)  # a push within the period
    eddies = np.append(rng.normal(size=5), rng.integers(0, 2))
    return (state, rng.uniform(0, 1000, 11)), settings, eddies


@numba.njit
def _normals(seed, number):
    drawn = np.empty(COUNT)
    draw_normals(seed, number, drawn)
    return drawn


def pure(vehicle, inputs, settings, eddies, number=0):
    wrench, wind, after = np.zeros(6), np.zeros(3), np.zeros(6)
    p_BoBcm_B, rotors = np.array(vehicle.p_BoBcm_B), rotor_rows(vehicle.rotors)
    time, noise = number * PERIOD, _normals(SEED, number)
    results = (wrench, wind, after)
    air_update(time, *inputs, noise, settings, p_BoBcm_B, rotors, PERIOD, eddies, *results)
    return np.concatenate([wrench, wind, after])


def next_values(air, context, inputs, settings, eddies):
    for name, signal in zip(PORTS, inputs, strict=True):
        air.GetInputPort(name).FixValue(context, signal)
    context.get_mutable_numeric_parameter(0).SetFromVector(settings)
    context.get_mutable_numeric_parameter(1).SetFromVector([SEED])
    context.SetDiscreteState(2, eddies)
    after = air.EvalUniquePeriodicDiscreteUpdate(context)
    return np.concatenate([after.get_vector(i).CopyToVector() for i in range(3)])


def test_its_update_is_the_pure_one_compiled(air, vehicle):
    context = air.CreateDefaultContext()
    rng = np.random.default_rng(3)
    for _ in range(200):
        inputs, settings, eddies = drawn(rng)
        found = next_values(air, context, inputs, settings, eddies)
        assert found == pytest.approx(pure(vehicle, inputs, settings, eddies), rel=1e-8, abs=1e-9)


def test_settings_are_live_and_in_the_order_of_the_parameter_table(air, vehicle):
    """Every one of them changes something."""
    assert [row.name for row in parameters_of("air")] == list(AirSettings._fields)
    context = air.CreateDefaultContext()
    inputs, settings, eddies = drawn(np.random.default_rng(4))
    before = next_values(air, context, inputs, settings, eddies)
    for index in range(len(settings)):
        changed = settings.copy()
        changed[index] += 0.05
        found = next_values(air, context, inputs, changed, eddies)
        assert np.abs(found - before).max() > 1e-9, AirSettings._fields[index]
        assert found == pytest.approx(pure(vehicle, inputs, changed, eddies), rel=1e-8, abs=1e-9)


def test_defaults_are_those_of_the_table(vehicle):
    defaults = {row.name: row.default for row in parameters_of("air")}
    assert AirSettings(**defaults) == calm_air(vehicle)._replace(drag_area=0.015)


def test_inputs_are_only_read(air):
    """Compiled code is handed Drake's own arrays."""
    context = air.CreateDefaultContext()
    inputs, settings, eddies = drawn(np.random.default_rng(5))
    next_values(air, context, inputs, settings, eddies)
    for name, signal in zip(PORTS, inputs, strict=True):
        assert air.GetInputPort(name).Eval(context).tolist() == list(signal)
    assert context.get_numeric_parameter(0).CopyToVector().tolist() == settings.tolist()
    assert context.get_discrete_state(2).value().tolist() == eddies.tolist()


def test_outputs_are_its_state(air):
    assert not air.HasAnyDirectFeedthrough()
    context = air.CreateDefaultContext()
    context.SetDiscreteState(0, np.arange(6.0))
    context.SetDiscreteState(1, np.arange(3.0))
    assert air.GetOutputPort("wrench").Eval(context).tolist() == [0, 1, 2, 3, 4, 5]
    assert air.GetOutputPort("wind").Eval(context).tolist() == [0, 1, 2]


def wind_of(vehicle, seed, settings=WINDY, duration=0.5) -> list[list[float]]:
    """Return the wind at a drone that stands in the air, period by period."""
    builder = DiagramBuilder()
    state = builder.AddSystem(ConstantVectorSource([1.0, *[0.0] * 5, 20.0, *[0.0] * 6]))
    speeds = builder.AddSystem(ConstantVectorSource([700.0] * 4))
    taker = builder.AddSystem(PassThrough(6))
    air = add_air(
        builder,
        state.get_output_port(),
        speeds.get_output_port(),
        taker.get_input_port(),
        vehicle,
        settings,
        PERIOD,
    )
    simulator = Simulator(builder.Build())
    root = simulator.get_mutable_context()
    context = air.GetMyMutableContextFromRoot(root)
    air.set_seed(context, seed)
    found = []
    for step in range(1, round(duration / PERIOD)):
        simulator.AdvanceTo((step + 0.5) * PERIOD)
        found.append(air.GetOutputPort("wind").Eval(context).tolist())
    return found


def test_equal_seeds_give_equal_winds(vehicle):
    assert wind_of(vehicle, 1) == wind_of(vehicle, 1)
    assert wind_of(vehicle, 1) != wind_of(vehicle, 2)


@pytest.mark.parametrize("number", [1, 2, 128 * 3600])
def test_every_update_has_noise_of_its_own(air, vehicle, number):
    context = air.CreateDefaultContext()
    context.SetTime(number * PERIOD)
    inputs, settings, eddies = drawn(np.random.default_rng(6))
    found = next_values(air, context, inputs, settings, eddies)
    wanted = pure(vehicle, inputs, settings, eddies, number)
    assert found == pytest.approx(wanted, rel=1e-8, abs=1e-9)
    assert found != pytest.approx(pure(vehicle, inputs, settings, eddies, number - 1), abs=1e-6)


def test_every_file_of_the_update_is_watched():
    """What the compiled function calls of ours, found by following its imports."""
    folder = compiled.Path(compiled.__file__).parent
    found, todo = set(), ["air/update.py"]
    while todo:
        name = todo.pop()
        if name in found:
            continue
        found.add(name)
        marker = "from workbench.systems."
        todo += [
            line.split(marker)[1].split()[0].replace(".", "/") + ".py"
            for line in (folder / name).read_text().splitlines()
            if line.startswith(marker)
        ]
    assert found == set(module.SOURCES)
