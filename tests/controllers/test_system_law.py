"""Drake systems as controllers, against the same law written as an update."""

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.design.judge.multiloop import multiloop_margin
from workbench.design.linear.study import LinearStudy
from workbench.design.sweep.sweep import sweep
from workbench.scenario.scenario import Action, Rates, Scenario
from workbench.session.session import Session

HEAD = """
from workbench.controllers import GRAVITY, State, gain

PARAMETERS = [
    gain("k_velocity", "1/s", (0.1, 20.0), 2.0, "acceleration per velocity error"),
    gain("k_integral", "1/s^2", (0.0, 5.0), 0.4, "the same, of its integral"),
    gain("k_tilt", "1/s^2", (1.0, 500.0), 120.0, "angular acceleration per tilt"),
    gain("k_rate", "1/s", (1.0, 100.0), 18.0, "angular acceleration per rate"),
]
"""
UPDATE = (
    HEAD
    + """
from workbench.controllers import position_error, probe, velocity_setpoint

MEMORY = [State(f"x_{k}", "1") for k in (1, 2, 3)]
POINTS = {"force": "N", "moment_x": "N*m", "moment_y": "N*m", "moment_z": "N*m"}


def update(measured, setpoint, g, vehicle, memory, dt, loops):
    v_x, v_y, v_z, yaw_rate = velocity_setpoint((0.0, 0.0, 0.0), measured, setpoint, g)
    p, v, q, w = position_error(measured, setpoint), measured.v_WBcm, measured.q_WT, measured.w_WB
    e_x, e_y, e_z = v_x + p[0] - v[0], v_y + p[1] - v[1], v_z + p[2] - v[2]
    f_x = g.k_velocity * e_x + memory.x_1
    f_y = g.k_velocity * e_y + memory.x_2
    f_z = g.k_velocity * e_z + memory.x_3
    tilt_x = -f_y / GRAVITY - 2.0 * q[1]
    tilt_y = f_x / GRAVITY - 2.0 * q[2]
    xx, yy, zz = vehicle.inertia[0], vehicle.inertia[3], vehicle.inertia[5]
    wrench = (
        probe(vehicle.mass * (f_z + GRAVITY), 0, loops),
        probe(xx * (g.k_tilt * tilt_x - g.k_rate * w[0]), 1, loops),
        probe(yy * (g.k_tilt * tilt_y - g.k_rate * w[1]), 2, loops),
        probe(zz * 4.0 * (yaw_rate - w[2]), 3, loops),
    )
    k = dt * g.k_integral
    return wrench, (memory.x_1 + k * e_x, memory.x_2 + k * e_y, memory.x_3 + k * e_z)
"""
)
MATRICES = (
    HEAD
    + """
import numpy as np

PORTS = ("position_error", "velocity_setpoint", "velocity", "attitude", "angular_velocity",
         "yaw_rate_setpoint")
SIZES = (3, 3, 3, 4, 3, 1)


def matrices(vehicle, g, dt):
    e = np.hstack([np.eye(3), np.eye(3), -np.eye(3), np.zeros((3, 8))])
    q, w, r = np.zeros((3, 17)), np.zeros((3, 17)), np.zeros(17)
    q[:, 10:13], w[:, 13:16], r[16] = np.eye(3), np.eye(3), 1.0
    xx, yy, zz = vehicle.inertia[0], vehicle.inertia[3], vehicle.inertia[5]
    f = g.k_velocity * e
    D = np.vstack([
        vehicle.mass * f[2],
        xx * (g.k_tilt * (-f[1] / GRAVITY - 2.0 * q[0]) - g.k_rate * w[0]),
        yy * (g.k_tilt * (f[0] / GRAVITY - 2.0 * q[1]) - g.k_rate * w[1]),
        zz * 4.0 * (r - w[2]),
    ])
    C = np.zeros((4, 3))
    C[0, 2], C[1, 1], C[2, 0] = vehicle.mass, -xx * g.k_tilt / GRAVITY, yy * g.k_tilt / GRAVITY
    return np.eye(3), dt * g.k_integral * e, C, D, np.array([vehicle.mass * GRAVITY, 0, 0, 0])
"""
)
DIAGRAM = (
    MATRICES
    + """
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import AffineSystem, Multiplexer


def system(vehicle, g, dt):
    A, B, C, D, y0 = matrices(vehicle, g, dt)
    builder = DiagramBuilder()
    stack = builder.AddSystem(Multiplexer(SIZES))
    law = builder.AddSystem(AffineSystem(A, B, np.zeros(3), C, D, y0, dt))
    builder.Connect(stack.get_output_port(), law.get_input_port())
    for k, name in enumerate(PORTS):
        builder.ExportInput(stack.get_input_port(k), name)
    builder.ExportOutput(law.get_output_port(), "wrench")
    return builder.Build()
"""
)
LEAF = (
    MATRICES
    + """
from pydrake.systems.framework import LeafSystem


class Law(LeafSystem):
    def __init__(self, vehicle, g, dt):
        super().__init__()
        self.matrices = matrices(vehicle, g, dt)
        self.ports = [self.DeclareVectorInputPort(*each) for each in zip(PORTS, SIZES)]
        self.DeclareVectorOutputPort("wrench", 4, self.wrench)
        self.DeclareDiscreteState(3)
        self.DeclarePeriodicDiscreteUpdateEvent(dt, 0.0, self.step)

    def inputs(self, context):
        return np.concatenate([port.Eval(context) for port in self.ports])

    def wrench(self, context, output):
        A, B, C, D, y0 = self.matrices
        x = context.get_discrete_state_vector().value()
        output.SetFromVector(C @ x + D @ self.inputs(context) + y0)

    def step(self, context, state):
        A, B, C, D, y0 = self.matrices
        x = context.get_discrete_state_vector().value()
        state.get_mutable_vector().SetFromVector(A @ x + B @ self.inputs(context))


def system(vehicle, g, dt):
    return Law(vehicle, g, dt)
"""
)

TIMED = """
from pydrake.systems.framework import LeafSystem

from workbench.controllers import GRAVITY


class Law(LeafSystem):
    def __init__(self, vehicle, g, dt):
        super().__init__()
        self.mass = vehicle.mass
        self.DeclareVectorOutputPort("wrench", 4, self.wrench)
        self.DeclareDiscreteState(1)
        self.DeclarePeriodicDiscreteUpdateEvent(dt / 7, 0.0, self.count)

    def wrench(self, context, output):
        climbs = 1.0 if context.get_time() > 0.49 else 0.0
        output.SetFromVector([self.mass * (GRAVITY + climbs), 0.0, 0.0, 0.0])

    def count(self, context, state):
        vector = state.get_mutable_vector()
        vector.SetAtIndex(0, vector.GetAtIndex(0) + 1.0)


def system(vehicle, g, dt):
    return Law(vehicle, g, dt)
"""
"""Climbs with 1 m/s² from 0.5 s on, and counts seven updates a period."""


def written(folder, name, text):
    path = folder / f"{name}.py"
    path.write_text(text, encoding="utf-8")
    return str(path)


def flown(controller):
    """Return states of a flight that is steered, checked on the way."""
    script = [Action(0.5, velocity=[1.0, -0.5, 0.3], yaw_rate=0.2)]
    session = Session(Scenario(controller=controller, script=script))
    session.tick(3.0)
    return session.recording()


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """The same law as an update."""
    return written(tmp_path_factory.mktemp("laws"), "plain", UPDATE)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "derivatives", "near"), [(DIAGRAM, "AutoDiff", 1e-11), (LEAF, "differences", 1e-6)]
)
def test_a_system_is_the_law_that_its_equations_are(tmp_path, plain, text, derivatives, near):
    name = written(tmp_path, "blocks", text)
    law = load_controller(name)
    assert (law.derivatives, law.compiles) == (derivatives, False)
    assert [loop.name for loop in law.loops] == ["force", "moment_x", "moment_y", "moment_z"]
    ours, theirs = flown(name), flown(plain)
    np.testing.assert_allclose(ours.v_WB, theirs.v_WB, atol=1e-9)
    np.testing.assert_allclose(ours.q_WB, theirs.q_WB, atol=1e-9)
    assert np.abs(ours.v_WB).max() > 0.9
    studies = [LinearStudy(Scenario(controller=each)) for each in (name, plain)]
    models = [study.sampled() for study in studies]
    for matrix in ("A", "input_matrix", "output_matrix", "feedthrough"):
        found, expected = (getattr(model, matrix) for model in models)
        np.testing.assert_allclose(found, expected, atol=near * max(1.0, np.abs(expected).max()))
    margins = [multiloop_margin(study.plant_input()).disk_margin for study in studies]
    assert margins[0] == pytest.approx(margins[1], rel=1e-3)


def test_a_checkpoint_has_the_state_of_the_system(tmp_path):
    scenario = Scenario(controller=written(tmp_path, "blocks", LEAF))
    session = Session(scenario)
    session.command(velocity=(1.0, 0.0, 0.0))
    session.tick(1.0)
    other = Session(scenario)
    other.begin_from(session.checkpoint())
    for each in (session, other):
        each.tick(1.0)
    assert session.state().tobytes() == other.state().tobytes()


@pytest.mark.parametrize(
    ("period", "updates"),
    [
        ("dt / 7", 7),
        ("dt * 0.99999999", 1),
        pytest.param("dt * 1.00000001", 1, marks=pytest.mark.slow),
        pytest.param("dt * 0.49999999", 2, marks=pytest.mark.slow),
    ],
)
def test_a_system_sees_the_time_of_the_flight(tmp_path, period, updates):
    """By hand: 1 m/s² for half a second, later by about the lag of the rotors, 13 ms.

    Multiples of 1 ms are not exact in binary, nor equal to those of 7 ms. A period that is rounded
    to some digits has its updates in each control period, however long the flight is.
    """
    text = TIMED.replace("dt / 7", period)
    rates = Rates(physics_step=0.001, control_period=0.007, mode_period=0.07, record_period=0.007)
    session = Session(Scenario(controller=written(tmp_path, "timed", text), rates=rates))
    session.tick(0.49)
    assert abs(session.state()[12]) < 1e-6
    session.tick(0.511)
    assert session.state()[12] == pytest.approx(0.5, abs=0.02)
    computer = session.checkpoint().systems[session._bench.computer.GetSystemPathname()]
    assert computer.state[-1] == (updates * 143.0,)


@pytest.mark.slow
def test_a_sweep_of_it_flies_on_the_diagram(tmp_path):
    scenario = Scenario(controller=written(tmp_path, "blocks", LEAF))
    table = sweep(["k_velocity=1..3:2"], axis="x", scenario=scenario, duration=2.0)
    assert len(table) == 2
    use = table.values[:, [metric.name for metric in table.metrics].index("peak_rotor_use")]
    assert use[1] > use[0] > 0.6


def test_what_a_system_has_not_is_refused_with_what_to_do(tmp_path, case):
    for before, after, said in (
        ('"position_error"', '"place"', "has an input port place .3.: rename it to one of"),
        ('"wrench", 4', '"thrust", 4', "has no output port wrench"),
        ("(dt, 0.0, self.step)", "(3 * dt, 0.0, self.step)", "let all have one period of 0.0078"),
        ("self.DeclareDiscreteState(3)", "self.Declare(3)", "system fails: AttributeError"),
        ("return Law(vehicle, g, dt)", "return 3", "system returns 3: let it return a LeafSystem"),
        (
            "def system(vehicle, g, dt)",
            "def system(vehicle)",
            r"write def system\(vehicle, g, dt\)",
        ),
        ("class Law", "MEMORY = []\n\n\nclass Law", "so leave MEMORY out"),
    ):
        text = LEAF.replace(before, after)
        assert text != LEAF
        with case(said), pytest.raises(WorkbenchError, match=said):
            load_controller(written(tmp_path, "wrong", text))
    study = LinearStudy(Scenario(controller=written(tmp_path, "blocks", LEAF)))
    with pytest.raises(WorkbenchError, match="no model without sampling here"):
        study.continuous()
