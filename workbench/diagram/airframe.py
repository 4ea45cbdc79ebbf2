"""The vehicle and its world as systems of a diagram."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from pydrake.geometry import GeometryId, SceneGraph
from pydrake.multibody.plant import ExternallyAppliedSpatialForceMultiplexer, MultibodyPlant
from pydrake.multibody.tree import RigidBody, RotationalInertia, SpatialInertia
from pydrake.systems.framework import Context, DiagramBuilder, InputPort, OutputPort
from pydrake.systems.primitives import MatrixGain

from workbench.dynamics.rigid_body import into_world, rotation
from workbench.estimation.gyro import GyroSettings
from workbench.plant.description import Description
from workbench.plant.loading import make_vehicle
from workbench.plant.multibody import add_plant
from workbench.plant.payload import Payload, laden, payload_of
from workbench.plant.reach import Reach, reach
from workbench.plant.rotors import Rotor
from workbench.plant.sensors import Imu
from workbench.plant.vehicle import BatteryPack, Vehicle
from workbench.plant.worlds.world import EMPTY, World
from workbench.scenario.parameters import parameter_table
from workbench.scenario.scenario import Rates
from workbench.systems.battery import PERIOD, Battery, ChargeGauge
from workbench.systems.body_forces import BodyForces, BodyForces_
from workbench.systems.flight_imu import FlightImu
from workbench.systems.noise import CountedNoise, add_counted_noise
from workbench.systems.push import Push, PushSettings
from workbench.systems.rotors import Rotors, Rotors_
from workbench.systems.wind import Wind, WindSettings

FASTEST_CHANGE = 1000.0
"""Upper bound of the acceleration of a vehicle [m/s²]; it bounds how soon contact is possible."""


@dataclass(frozen=True)
class Airframe:
    """The vehicle in its world.

    Attributes:
        plant: owns the state of all bodies.
        scene_graph: scene graph with all shapes.
        body: of the base link in the plant.
        places: of its state (13) in that of the plant.
        state: port of its state (13): q_WB, p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        acceleration: port of its angular acceleration [rad/s²] and the acceleration of its origin
            [m/s²] in W (6).
        joints: port of the positions and velocities of all joints, None without any.
        vehicle: as it flies, without its payload.
        rotors: their lag and forces.
        body_forces: drag, and the push.
        push: what pushes it.
        wind: the velocity of the air.
        imu: samples of the flight computer.
        shapes: of the vehicle that can touch.
        around: the sphere around everything that can touch, whether or not more is drawn.
        ground: whether there is ground.
        obstacles: whether there is anything to touch but the ground.
    """

    plant: MultibodyPlant
    scene_graph: SceneGraph
    body: RigidBody
    places: np.ndarray
    state: OutputPort
    acceleration: OutputPort
    joints: OutputPort | None
    vehicle: Vehicle
    rotors: Rotors
    body_forces: BodyForces
    push: Push
    wind: Wind
    imu: FlightImu
    shapes: frozenset[GeometryId]
    around: Reach
    ground: bool
    obstacles: bool

    @property
    def commands(self) -> InputPort:
        """Commanded rotor speeds (n) [rad/s]."""
        return self.rotors.GetInputPort("commands")

    @property
    def sensed(self) -> OutputPort:
        """The state with the angular velocity of the gyro (13)."""
        return self.imu.GetOutputPort("sensed")

    def signals(self, commands: OutputPort) -> dict[str, OutputPort]:
        """Return the signals that every flight records, with the rotor commands."""
        joints = {"joints": self.joints} if self.joints else {}
        return joints | {
            "state": self.state,
            "acceleration": self.acceleration,
            "thrusts": self.rotors.GetOutputPort("thrusts"),
            "speeds": self.rotors.GetOutputPort("speeds"),
            "wind": self.wind.get_output_port(),
            "commands": commands,
        }

    def set_payload(self, root: Context, payload: Payload) -> None:
        """Let the vehicle carry a payload from now on.

        The state is that of the body's origin, and is continuous: a payload that is picked up has
        the velocity of the body at its place, and adds its own momentum.
        """
        whole = self.body.default_spatial_inertia()
        if payload.payload_mass > 0.0:
            box = payload.inertial
            moments = RotationalInertia(*box.moments)
            own = SpatialInertia.MakeFromCentralInertia(box.mass, box.X_LI.translation(), moments)
            whole = SpatialInertia(whole.get_mass(), whole.get_com(), whole.get_unit_inertia())
            whole += own
        context = self.plant.GetMyMutableContextFromRoot(root)
        self.body.SetSpatialInertiaInBodyFrame(context, whole)
        forces = self.body_forces.GetMyMutableContextFromRoot(root)
        center = laden(self.vehicle, payload).p_BoBcm_B
        forces.get_mutable_numeric_parameter(1).SetFromVector(list(center))

    def place(self, root: Context, state: np.ndarray, speeds: np.ndarray) -> None:
        """Begin at a state of the body (13), with the rotors at speeds (n) [rad/s]."""
        context = self.plant.GetMyMutableContextFromRoot(root)
        whole = self.plant.GetPositionsAndVelocities(context).copy()
        whole[self.places] = state
        self.plant.SetPositionsAndVelocities(context, whole)
        self.rotors.GetMyMutableContextFromRoot(root).SetContinuousState(speeds)
        self.imu.begin(self.imu.GetMyMutableContextFromRoot(root), state)

    def may_touch(self, root: Context, period: float) -> bool:
        """Return whether the vehicle may touch something within a time [s]."""
        state = self.body_state(root)
        p_WC = state[4:7] + into_world(rotation(state[0:4]), self.around.p_BC)
        way = np.linalg.norm(state[10:13]) * period + 0.5 * FASTEST_CHANGE * period**2
        if not self.obstacles:
            return bool(self.ground and p_WC[2] - self.around.radius < way)
        query = self.scene_graph.get_query_output_port().Eval(
            self.scene_graph.GetMyContextFromRoot(root)
        )
        return any(
            each.distance < self.around.radius + way and each.id_G not in self.shapes
            for each in query.ComputeSignedDistanceToPoint(p_WC, self.around.radius + way)
        )

    def body_state(self, root: Context) -> np.ndarray:
        """Return a copy of the state of the body (13)."""
        context = self.plant.GetMyContextFromRoot(root)
        whole: np.ndarray = self.plant.GetPositionsAndVelocities(context)
        return whole[self.places]


@dataclass(frozen=True)
class Gauge:
    """The estimator of the charge, and the source of its noise."""

    system: ChargeGauge
    noise: CountedNoise


def add_airframe(
    builder: DiagramBuilder,
    description: Description,
    values: Mapping[str, float],
    *,
    rates: Rates,
    world: World = EMPTY,
    imu: Imu | None = None,
) -> Airframe:
    """Add a vehicle and its world.

    Args:
        builder: the diagram being built.
        description: of the vehicle, with or without drawn shapes.
        values: of parameters by name; those of air and gyro are used.
        rates: of physics and control.
        world: the surroundings.
        imu: of the estimator; None without one.
    """
    plant, scene_graph = add_plant(builder, description, time_step=0.0, world=world)
    plant.set_name("plant")
    body = plant.GetBodyByName(description.base_link)
    vehicle = make_vehicle(description)
    turning = description.rotors
    if not world.ground:
        turning = tuple(replace(rotor, ground_effect_coefficient=0.0) for rotor in turning)
    rotors, body_forces = add_forces(builder, body, turning, vehicle, values)
    push = builder.AddNamedSystem(
        "push",
        Push(
            settings=PushSettings(*(values[name] for name in PushSettings._fields)),
            period=rates.control_period,
        ),
    )
    wind = builder.AddNamedSystem(
        "wind",
        Wind(
            settings=WindSettings(*(values[name] for name in WindSettings._fields)),
            period=rates.control_period,
        ),
    )
    gyro = {row.name: values[row.name] for row in parameter_table().of("gyro")}
    flight_imu = builder.AddNamedSystem(
        "flight_imu",
        FlightImu(
            settings=GyroSettings(**gyro),
            step=rates.physics_step,
            readout=rates.control_steps,
            imu=imu,
        ),
    )
    places = body_places(plant, body)
    state = _chosen(builder, "body_state", plant.get_state_output_port(), places)
    accelerations = plant.get_generalized_acceleration_output_port()
    moving = places[7:] - plant.num_positions()
    acceleration = _chosen(builder, "body_acceleration", accelerations, moving)
    others = np.setdiff1d(np.arange(plant.num_multibody_states()), places)
    joints = None
    if len(others):
        joints = _chosen(builder, "joints", plant.get_state_output_port(), others)
    connect_forces(builder, plant, state, rotors, body_forces)
    for system in (wind, flight_imu):
        builder.Connect(state, system.GetInputPort("state"))
    for system in (rotors, body_forces):
        builder.Connect(wind.get_output_port(), system.GetInputPort("wind"))
    builder.Connect(push.get_output_port(), body_forces.GetInputPort("push"))
    if imu:
        builder.Connect(acceleration, flight_imu.GetInputPort("acceleration"))
    return Airframe(
        plant=plant,
        scene_graph=scene_graph,
        body=body,
        places=places,
        state=state,
        acceleration=acceleration,
        joints=joints,
        vehicle=vehicle,
        rotors=rotors,
        body_forces=body_forces,
        push=push,
        wind=wind,
        imu=flight_imu,
        shapes=frozenset(
            shape
            for index in plant.GetBodyIndices(body.model_instance())
            for shape in plant.GetCollisionGeometriesForBody(plant.get_body(index))
        ),
        around=reach(description.undrawn().model, description.base_link, description.rotors),
        ground=world.ground,
        obstacles=bool(world.names),
    )


def add_forces(
    builder: DiagramBuilder,
    body: RigidBody,
    turning: Sequence[Rotor],
    vehicle: Vehicle,
    values: Mapping[str, float],
) -> tuple[Rotors, BodyForces]:
    """Add what acts on a body; `connect_forces` connects it.

    Args:
        builder: the diagram being built.
        body: of the base link in the plant.
        turning: its rotors.
        vehicle: as it flies, without its payload.
        values: of parameters by name; those of air and payload are used.
    """
    rotors = builder.AddNamedSystem("rotors", Rotors_[float](rotors=turning, body=body.index()))
    body_forces = builder.AddNamedSystem(
        "body_forces",
        BodyForces_[float](
            body=body.index(),
            drag_area=values["drag_area"],
            air_density=values["air_density"],
            p_BoBcm_B=laden(vehicle, payload_of(values)).p_BoBcm_B,
        ),
    )
    return rotors, body_forces


def connect_forces(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    state: OutputPort,
    rotors: Rotors,
    body_forces: BodyForces,
) -> None:
    """Let rotors and drag see the state of a body (13), and act on it."""
    forces = builder.AddNamedSystem("forces", ExternallyAppliedSpatialForceMultiplexer(2))
    for number, system in enumerate((rotors, body_forces)):
        builder.Connect(state, system.GetInputPort("state"))
        builder.Connect(system.GetOutputPort("spatial_forces"), forces.get_input_port(number))
    builder.Connect(forces.get_output_port(), plant.get_applied_spatial_force_input_port())


def body_places(plant: MultibodyPlant, body: RigidBody) -> np.ndarray:
    """Return the places of a free body's state (13) in that of the plant."""
    positions = body.floating_positions_start() + np.arange(7)
    velocities = body.floating_velocities_start_in_v() + np.arange(6)
    return np.concatenate([positions, plant.num_positions() + velocities])


def _chosen(builder: DiagramBuilder, name: str, port: OutputPort, places: np.ndarray) -> OutputPort:
    """Return the values of a port at some places."""
    if len(places) == port.size():
        return port
    gain = builder.AddNamedSystem(name, MatrixGain(np.eye(port.size())[places]))
    builder.Connect(port, gain.get_input_port())
    return gain.get_output_port()


def add_battery(
    builder: DiagramBuilder,
    airframe: Airframe,
    vehicle: Vehicle,
    battery_duration: float,
    sag_compensation: float,
    gauge: Gauge | None = None,
) -> Battery:
    """Add the battery of an airframe; if the description has one, its sag weakens the rotors.

    Args:
        builder: the diagram being built.
        airframe: supplied by the battery.
        vehicle: as the law knows it; its hover power defines the duration.
        battery_duration: of a hover on the full battery [s].
        sag_compensation: share of its sag that is compensated.
        gauge: estimates its charge, which the compensation then uses; None for the true charge.
    """
    battery = builder.AddNamedSystem(
        "battery",
        Battery(vehicle=vehicle, duration=battery_duration, compensation=sag_compensation),
    )
    rotors = airframe.rotors
    builder.Connect(rotors.GetOutputPort("static_thrusts"), battery.GetInputPort("thrusts"))
    if vehicle.battery:
        builder.Connect(battery.GetOutputPort("supply"), rotors.GetInputPort("supply"))
    if gauge:
        system = gauge.system
        builder.Connect(battery.GetOutputPort("terminals"), system.GetInputPort("terminals"))
        builder.Connect(system.GetOutputPort("open_circuit"), battery.GetInputPort("open_circuit"))
    return battery


def add_gauge(builder: DiagramBuilder, pack: BatteryPack, voltage_noise: float) -> Gauge:
    """Add an estimator of a battery's charge; `add_battery` connects the two.

    Args:
        builder: the diagram being built.
        pack: the known properties of the battery.
        voltage_noise: standard deviation of the measured voltage [V].
    """
    gauge = builder.AddNamedSystem("gauge", ChargeGauge(pack=pack, voltage_noise=voltage_noise))
    return Gauge(gauge, add_counted_noise(builder, gauge.noise_input, PERIOD))
