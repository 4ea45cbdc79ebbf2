"""The live diagram over the least diagram that flies: `python benchmarks/live_diagram.py`.

The least one is Drake's continuous plant of one body on four feet, one LeafSystem of four rotors
and one of a sampled PD law, both in Python as one writes them with numpy, with `runge_kutta5` at
one step a control period of 1/128 s. The live diagram flies in turns with it, by processor time, so
that other load affects both alike.
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.common.value import Value
from pydrake.geometry import HalfSpace, Sphere
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    CoulombFriction,
    ExternallyAppliedSpatialForce,
    MultibodyPlantConfig,
)
from pydrake.multibody.tree import BodyIndex, SpatialInertia, UnitInertia
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import Context, ContinuousState, DiagramBuilder, LeafSystem
from spread import Spread, ratios, spread, text

from workbench.scenario.scenario import Rates, Scenario, ScenarioStart, SensorsConfig
from workbench.session.session import Session

PERIOD = 1 / 128
MASS, LAG, HOVER, TORQUE, DRAG = 1.2, 0.03, 600.0, 0.016, 0.2
INERTIA = np.array([0.012, 0.012, 0.02])
X, Y = np.array([0.17, -0.17, -0.17, 0.17]), np.array([0.17, 0.17, -0.17, -0.17])
TURNS = np.array([1.0, -1.0, 1.0, -1.0])
THRUST = MASS * 9.81 / 4.0 / HOVER**2
ROUNDS, SLICE = 12, 1.0
"""Of each, and what one flies in a turn [s]."""


class LeastRotors(LeafSystem):
    """Four rotors with a first-order lag."""

    def __init__(self, body: BodyIndex) -> None:
        super().__init__()
        self._body = body
        self._command = self.DeclareVectorInputPort("command", 4)
        self._state = self.DeclareVectorInputPort("state", 13)
        self.DeclareContinuousState(4)
        self.DeclareAbstractOutputPort(
            "forces",
            lambda: Value[list[ExternallyAppliedSpatialForce]]([ExternallyAppliedSpatialForce()]),
            self._calc_forces,
        )

    def DoCalcTimeDerivatives(self, context: Context, derivatives: ContinuousState) -> None:
        speeds = context.get_continuous_state_vector().CopyToVector()
        slopes = (self._command.Eval(context) - speeds) / LAG
        derivatives.get_mutable_vector().SetFromVector(slopes)

    def _calc_forces(self, context: Context, output: Value) -> None:
        thrusts = THRUST * context.get_continuous_state_vector().CopyToVector() ** 2
        state = self._state.Eval(context)
        R_WB = RotationMatrix(Quaternion(state[:4] / np.linalg.norm(state[:4]))).matrix()
        moment = np.array([Y @ thrusts, -X @ thrusts, -TORQUE * TURNS @ thrusts])
        force = ExternallyAppliedSpatialForce()
        force.body_index = self._body
        force.F_Bq_W = SpatialForce(R_WB @ moment, thrusts.sum() * R_WB[:, 2] - DRAG * state[10:13])
        output.set_value([force])


class LeastLaw(LeafSystem):
    """Height and level attitude by PD, held over a control period."""

    def __init__(self) -> None:
        super().__init__()
        self._state = self.DeclareVectorInputPort("state", 13)
        self.DeclareStateOutputPort("command", self.DeclareDiscreteState([HOVER] * 4))
        self.DeclarePeriodicDiscreteUpdateEvent(PERIOD, 0.0, self._update)

    def _update(self, context: Context, discrete_state) -> None:
        state = self._state.Eval(context).tolist()
        w, x, y, z, _, _, height, w_x, w_y, w_z, _, _, climb = state
        roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
        pitch = math.asin(2.0 * (w * y - z * x))
        yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        force = MASS * (9.81 + 4.0 * (2.0 - height) - 4.0 * climb)
        errors, rates = np.array([-roll, -pitch, -yaw]), np.array([w_x, w_y, w_z])
        moment = INERTIA * (np.array([60.0, 60.0, 9.0]) * errors - [14.0, 14.0, 6.0] * rates)
        thrusts = force / 4.0 + moment[0] / (4.0 * Y) - moment[1] / (4.0 * X)
        thrusts = thrusts - TURNS * moment[2] / (4.0 * TORQUE)
        discrete_state.set_value(np.sqrt(np.maximum(0.0, thrusts) / THRUST))


def least() -> Callable[[], None]:
    """Return what flies the least diagram for `SLICE`."""
    builder = DiagramBuilder()
    config = MultibodyPlantConfig(time_step=0.0, contact_model="point")
    plant, _ = AddMultibodyPlant(config, builder)
    inertia = SpatialInertia(MASS, np.zeros(3), UnitInertia(*INERTIA / MASS))
    body = plant.AddRigidBody("base", inertia)
    friction = CoulombFriction(0.6, 0.6)
    for x, y in zip(X, Y, strict=True):
        pose = RigidTransform([x, y, -0.1])
        plant.RegisterCollisionGeometry(body, pose, Sphere(0.02), f"{x} {y}", friction)
    plant.RegisterCollisionGeometry(
        plant.world_body(), RigidTransform(), HalfSpace(), "ground", friction
    )
    plant.Finalize()
    rotors = builder.AddSystem(LeastRotors(body.index()))
    law = builder.AddSystem(LeastLaw())
    state = plant.get_state_output_port()
    builder.Connect(state, rotors.GetInputPort("state"))
    builder.Connect(state, law.GetInputPort("state"))
    builder.Connect(law.GetOutputPort("command"), rotors.GetInputPort("command"))
    builder.Connect(rotors.get_output_port(), plant.get_applied_spatial_force_input_port())
    simulator = Simulator(builder.Build())
    context = simulator.get_mutable_context()
    pose = RigidTransform([0.0, 0.0, 2.0])
    plant.SetFreeBodyPose(plant.GetMyMutableContextFromRoot(context), body, pose)
    rotors.GetMyMutableContextFromRoot(context).SetContinuousState([HOVER] * 4)
    ResetIntegratorFromFlags(simulator, "runge_kutta5", PERIOD).set_fixed_step_mode(True)
    simulator.Initialize()
    return lambda: simulator.AdvanceTo(context.get_time() + SLICE) and None


@dataclass(frozen=True)
class Live:
    """A live flight, and the least share of the least diagram's speed that it must have."""

    name: str
    scenario: Scenario
    settings: dict[str, float]
    mark: float


SENSORS = ["imu", "gps", "barometer", "magnetometer", "lidar", "range_finder"]
LIVE = (
    Live("truth, wind and battery", Scenario(), {"wind_x": 3.0, "turbulence": 3.0}, 0.4),
    Live(
        "EKF, filters, all sensors but the camera",
        Scenario(estimator="ekf", sensors=SensorsConfig(use=SENSORS)),
        {"gyro_lowpass": 80.0, "setpoint_lowpass": 10.0, "derivative_lowpass": 30.0},
        0.12,
    ),
    Live("law at 1 kHz", Scenario(rates=Rates(control_period=1 / 1024)), {}, 0.05),
    Live("landed and idle", Scenario(start=ScenarioStart(mode="off")), {}, 0.1),
    Live(
        "landed, EKF and sensors",
        Scenario(
            start=ScenarioStart(mode="off"), estimator="ekf", sensors=SensorsConfig(use=SENSORS)
        ),
        {},
        0.0,
    ),
)


@dataclass(frozen=True)
class LiveRow:
    """A live flight.

    Attributes:
        name: what flies.
        real_time_factor: simulated time over processor time.
        to_least: its speed relative to the least diagram, turn by turn.
        mark: the least that the median must be.
    """

    name: str
    real_time_factor: Spread
    to_least: Spread
    mark: float


def measure() -> list[LiveRow]:
    """Return a row for each flight."""
    fly_least, rows = least(), []
    fly_least()
    for each in LIVE:
        session = Session(each.scenario, each.settings)
        session.tick(SLICE)
        paces: tuple[list[float], list[float]] = ([], [])
        for _ in range(ROUNDS):
            for pace, fly in zip(paces, (fly_least, partial(session.tick, SLICE)), strict=True):
                begun = time.process_time()
                fly()
                pace.append(SLICE / (time.process_time() - begun))
        rows.append(LiveRow(each.name, spread(paces[1]), ratios(paces[1], paces[0]), each.mark))
    return rows


def show(rows: list[LiveRow]) -> None:
    """Print a line for each flight."""
    print(f"{'':42} times real time   over the least diagram     mark")
    for row in rows:
        pace = row.real_time_factor.median
        print(f"{row.name:42} {pace:15.1f}   {text(row.to_least):24} {row.mark:6.2f}")


if __name__ == "__main__":
    show(measure())
