"""Derivatives that the flight core carries, against central differences of the plain one."""

from pathlib import Path

import numpy as np
import pytest
from pydrake.autodiffutils import InitializeAutoDiff
from pydrake.systems.framework import Context
from pydrake.systems.primitives import Linearize

from workbench.control.controller_file import load_controller
from workbench.control.guidance import Guidance, Reference
from workbench.diagram.core import make_flight_core
from workbench.plant.description import read_description
from workbench.setup import make_setup

GAINS = [row.name for row in load_controller().parameters]
STEP = 1e-6
HOLD = Guidance(1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.3, -0.2, 10.0)
STILL = Reference(0, 0, 0, 0, 0, 0, 0, 0)
SEEDS = range(8)


class Core:
    """A continuous flight core; its derivatives as a function of state, reference and gains."""

    def __init__(self, description):
        setup = make_setup(description=description)
        self.vehicle = setup.vehicle
        self.diagram = make_flight_core(setup)
        self.gains = np.array(self.vector(self.diagram.CreateDefaultContext()).CopyToVector())
        self.twin = self.diagram.ToAutoDiffXd()

    def vector(self, root: Context, diagram=None):
        controller = (diagram or self.diagram).GetSubsystemByName("controller")
        return controller.GetMyMutableContextFromRoot(root).get_mutable_numeric_parameter(0)

    def root(self, state, reference, guidance=HOLD, gains=None, twin=False) -> Context:
        diagram = self.twin if twin else self.diagram
        root = diagram.CreateDefaultContext()
        root.SetContinuousState(state)
        diagram.GetInputPort("reference").FixValue(root, np.array(reference))
        diagram.GetInputPort("guidance").FixValue(root, np.array(guidance))
        self.vector(root, diagram).SetFromVector(self.gains if gains is None else gains)
        return root

    def derivatives(self, state, reference, guidance=HOLD, gains=None) -> np.ndarray:
        root = self.root(state, reference, guidance, gains)
        return self.diagram.EvalTimeDerivatives(root).CopyToVector()

    def carried(self, state, reference, gains) -> np.ndarray:
        """Return the derivatives as AutoDiffXd, of whatever the arguments carry."""
        root = self.root(state, reference, HOLD, gains, twin=True)
        return self.twin.EvalTimeDerivatives(root).CopyToVector()


@pytest.fixture(scope="module")
def core(description):
    return Core(description)


@pytest.fixture(scope="module")
def effects():
    here = Path(__file__).parent
    return Core(read_description(here / "uneven_quad.urdf", rotors=here / "effects.rotors.yaml"))


def differences(function, at: np.ndarray) -> np.ndarray:
    """Return the Jacobian by central differences."""
    columns = []
    for index in range(len(at)):
        step = np.zeros(len(at))
        step[index] = STEP * max(1.0, abs(at[index]))
        columns.append((function(at + step) - function(at - step)) / (2.0 * step[index]))
    return np.array(columns).T


def in_flight(core, seed) -> tuple[np.ndarray, np.ndarray]:
    """Return a state and a reference away from the law's limits, where it has derivatives."""
    rng = np.random.default_rng(seed)
    state = core.diagram.CreateDefaultContext().get_continuous_state_vector().CopyToVector()
    q = np.array([1.0, *rng.uniform(-0.15, 0.15, 3)])
    state[0:4] = q / np.linalg.norm(q)
    state[4:7] = [*rng.uniform(-0.3, 0.3, 2), 10.0 + rng.uniform(-0.3, 0.3)]
    state[7:10] = rng.uniform(-0.3, 0.3, 3)
    state[10:13] = rng.uniform(-0.5, 0.5, 3)
    names = ("rotors", "acceleration_estimate", "controller")
    sizes = [core.diagram.GetSubsystemByName(name).num_continuous_states() for name in names]
    assert sizes == [4, 3, 1] and len(state) == 21
    state[13:17] = core.vehicle.hover_speeds * rng.uniform(0.97, 1.03, 4)
    state[17:20] = state[10:13] + rng.uniform(-0.02, 0.02, 3)
    state[20] = rng.uniform(-0.01, 0.01)
    velocity = state[10:13] + rng.uniform(-0.3, 0.3, 3)
    reference = np.array([*velocity, 0.2, *rng.uniform(-1, 1, 2), 10.0, 0.0])
    return state, reference


def agree(found: np.ndarray, wanted: np.ndarray) -> None:
    """Compare Jacobians: to a part in 10^5 of the largest entry in the row."""
    scale = np.maximum(1.0, np.abs(wanted).max(axis=1, keepdims=True))
    assert found / scale == pytest.approx(wanted / scale, abs=1e-5)


def jacobian(values, size: int) -> np.ndarray:
    return np.array([x.derivatives() if x.derivatives().size else np.zeros(size) for x in values])


@pytest.mark.parametrize("seed", SEEDS)
def test_derivatives_by_state(core, seed):
    state, reference = in_flight(core, seed)
    carried = core.carried(InitializeAutoDiff(state), reference, core.gains)
    wanted = differences(lambda x: core.derivatives(x, reference), state)
    assert np.abs(wanted).max() > 10.0
    agree(jacobian(carried, 21), wanted)


@pytest.mark.parametrize("seed", SEEDS[:3])
def test_derivatives_by_state_with_all_effects(effects, seed):
    """A metre above the ground, with a thrust curve, inflow, and a battery that sags."""
    state, reference = in_flight(effects, seed)
    state[6] -= 8.0
    carried = effects.carried(InitializeAutoDiff(state), reference, effects.gains)
    wanted = differences(lambda x: effects.derivatives(x, reference), state)
    assert np.abs(wanted[10:13, 6]).max() > 0.1
    agree(jacobian(carried, 21), wanted)


@pytest.mark.parametrize("seed", SEEDS)
def test_derivatives_by_reference(core, seed):
    state, reference = in_flight(core, seed)
    carried = core.carried(state, InitializeAutoDiff(reference).ravel(), core.gains)
    wanted = differences(lambda u: core.derivatives(state, u), reference)
    assert np.abs(wanted[:, :4]).max() > 1.0
    agree(jacobian(carried, 8), wanted)


@pytest.mark.parametrize("seed", SEEDS)
def test_derivatives_by_wind(core, seed):
    """All of it through drag: force over mass, about 0.1 1/s, and moments at the hubs."""
    state, reference = in_flight(core, seed)
    wind = np.random.default_rng(seed).uniform(-5.0, 5.0, 3)

    def at(wind):
        root = core.root(state, reference)
        core.diagram.GetInputPort("wind").FixValue(root, wind)
        return core.diagram.EvalTimeDerivatives(root).CopyToVector()

    root = core.root(state, reference, twin=True)
    core.twin.GetInputPort("wind").FixValue(root, InitializeAutoDiff(wind).ravel())
    carried = core.twin.EvalTimeDerivatives(root).CopyToVector()
    wanted = differences(at, wind)
    assert np.abs(wanted[10:13]).max() > 0.05
    agree(jacobian(carried, 3), wanted)


@pytest.mark.parametrize("seed", SEEDS)
def test_derivatives_by_gains(core, seed):
    state, reference = in_flight(core, seed)
    carried = core.carried(state, reference, InitializeAutoDiff(core.gains))
    wanted = differences(lambda g: core.derivatives(state, reference, gains=g), core.gains)
    used = [GAINS[i] for i in np.flatnonzero(np.abs(wanted).max(axis=0) > 1e-3)]
    assert {"kp_velocity_x", "kd_velocity_z", "kp_roll", "kd_pitch", "kp_yaw_rate"} <= set(used)
    agree(jacobian(carried, len(core.gains)), wanted)


def test_linearize_of_hover_is_the_jacobian(core):
    state = in_flight(core, 0)[0]
    state[:] = 0.0
    state[0], state[4:7] = 1.0, [0.3, -0.2, 10.0]
    state[13:17] = core.vehicle.hover_speeds
    root = core.root(state, STILL)
    linear = Linearize(
        core.diagram,
        root,
        core.diagram.GetInputPort("reference").get_index(),
        core.diagram.GetOutputPort("state").get_index(),
    )
    agree(linear.A(), differences(lambda x: core.derivatives(x, STILL), state))
    # while it holds, a reference of nothing has no derivative: steering lets go of the point
    free = HOLD._replace(hold_xy=0.0, hold_z=0.0)
    root = core.root(state, STILL, free)
    linear = Linearize(
        core.diagram,
        root,
        core.diagram.GetInputPort("reference").get_index(),
        core.diagram.GetOutputPort("state").get_index(),
    )
    wanted = differences(lambda u: core.derivatives(state, u, free), np.array(STILL, dtype=float))
    agree(linear.B()[:, :4], wanted[:, :4])
    assert linear.C() == pytest.approx(np.eye(21)[:13])


def test_conversion_copies_everything(core, description):
    """Changed gains too: outputs and derivatives are equal at random places."""
    changed = {"kp_roll": 123.0, "max_tilt": 0.3}
    diagram = make_flight_core(make_setup(settings=changed, description=description))
    twin = diagram.ToAutoDiffXd()
    rng = np.random.default_rng(23)
    for _ in range(50):
        state = in_flight(core, 0)[0]
        state[0:4] = rng.normal(size=4)
        state[0:4] /= np.linalg.norm(state[0:4])
        state[7:13] = rng.uniform(-5, 5, 6)
        reference = np.array([*rng.uniform(-5, 5, 4), *rng.uniform(-2, 12, 3), 1.0])
        found = []
        for system in (diagram, twin):
            root = system.CreateDefaultContext()
            root.SetContinuousState(state)
            system.GetInputPort("reference").FixValue(root, reference)
            system.GetInputPort("guidance").FixValue(root, np.array(HOLD))
            outputs = [system.GetOutputPort(n).Eval(root) for n in ("state", "thrusts", "speeds")]
            outputs.append(system.EvalTimeDerivatives(root).CopyToVector())
            found.append(np.concatenate(outputs))
        assert [x.value() for x in found[1]] == pytest.approx(found[0], rel=1e-9, abs=1e-9)
