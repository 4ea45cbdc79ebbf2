"""The continuous side has the drag of the sampled one, and carries derivatives."""

import numpy as np
import pytest

from workbench.systems.air.continuous_drag import ContinuousDrag_
from workbench.systems.air.drag import drag_wrench, rotor_rows

AREA, DENSITY = 0.2, 1.1


@pytest.fixture
def drag(vehicle):
    return ContinuousDrag_[float](vehicle=vehicle, drag_area=AREA, air_density=DENSITY)


def fixed(drag, state, speeds, wind=None):
    """Return a Context with inputs."""
    context = drag.CreateDefaultContext()
    drag.GetInputPort("state").FixValue(context, state)
    drag.GetInputPort("speeds").FixValue(context, speeds)
    if wind is not None:
        drag.GetInputPort("wind").FixValue(context, wind)
    return context


def drawn(seed):
    rng = np.random.default_rng(seed)
    return rng.normal(size=13) * 2.0, rng.uniform(0, 1000, 4), rng.normal(size=3) * 5.0


def test_its_wrench_is_the_pure_one(drag, vehicle):
    for seed in range(20):
        state, speeds, wind = drawn(seed)
        found = drag.get_output_port().Eval(fixed(drag, state, speeds, wind))
        rows = rotor_rows(vehicle.rotors)
        pressure = 0.5 * AREA * DENSITY
        wanted = drag_wrench(state, speeds, wind, pressure, vehicle.p_BoBcm_B, rows)
        assert found == pytest.approx(wanted, rel=1e-12)


def test_without_a_wind_the_air_is_still(drag):
    state, speeds, _ = drawn(1)
    calm = drag.get_output_port().Eval(fixed(drag, state, speeds, np.zeros(3)))
    assert drag.get_output_port().Eval(fixed(drag, state, speeds)).tolist() == calm.tolist()


def test_area_and_density_are_live(drag):
    context = fixed(drag, *drawn(2))
    before = drag.get_output_port().Eval(context).copy()
    context.get_mutable_numeric_parameter(0).SetFromVector([2 * AREA, DENSITY])
    wider = drag.get_output_port().Eval(context).copy()
    context.get_mutable_numeric_parameter(0).SetFromVector([AREA, 2 * DENSITY])
    denser = drag.get_output_port().Eval(context)
    assert np.abs(wider - before).max() > 0.1
    assert denser == pytest.approx(wider)


def test_it_converts(drag):
    twin = drag.ToAutoDiffXd()
    context, mirror = fixed(drag, *drawn(3)), twin.CreateDefaultContext()
    mirror.SetTimeStateAndParametersFrom(context)
    twin.FixInputPortsFrom(drag, context, mirror)
    carried = twin.get_output_port().Eval(mirror)
    wanted = drag.get_output_port().Eval(context)
    assert [value.value() for value in carried] == pytest.approx(wanted, rel=1e-12)
