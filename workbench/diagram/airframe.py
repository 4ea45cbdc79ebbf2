"""The vehicle and its world as systems of a diagram."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from pydrake.geometry import GeometryId, SceneGraph
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody, RotationalInertia, SpatialInertia
from pydrake.systems.framework import Context, DiagramBuilder, InputPort, OutputPort

from workbench.diagram.ball_frames import BallFrames
from workbench.diagram.forces import (
    JOINT_FORCES_SYSTEM,
    add_body_motion,
    add_cables,
    add_contact_forces,
    add_forces,
    add_joint_forces,
    body_places,
    chosen_values,
    connect_forces,
)
from workbench.diagram.free_loads import (
    FreeLoad,
    free_loads,
    refuse_out_of_reach,
)
from workbench.diagram.joint_modes import JointMode, joint_modes
from workbench.dynamics.air.settings import AirSettings
from workbench.dynamics.rigid_body import into_world, rotation
from workbench.estimation.gyro import GyroSettings
from workbench.plant.description import Description
from workbench.plant.multibody import add_plant
from workbench.plant.payload import Payload, vehicle_with_payload
from workbench.plant.reach import ReachSphere, reach_sphere
from workbench.plant.sensors import Imu
from workbench.plant.tree import without_loads
from workbench.plant.vehicle import BatteryPack, Vehicle
from workbench.plant.worlds.world import EMPTY_WORLD, World
from workbench.scenario.scenario import Rates
from workbench.systems.battery import BATTERY_PERIOD_S, Battery, ChargeGauge
from workbench.systems.body_forces import BodyForces
from workbench.systems.cables import Cables
from workbench.systems.flight_imu import FlightImu
from workbench.systems.noise import CountedNoise, add_counted_noise
from workbench.systems.push import PushSystem
from workbench.systems.rotors import Rotors
from workbench.systems.wind import Wind

MAX_ACCELERATION = 1000.0
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
        ball_frames: of its ball joints, None without any.
        contact_forces: port of those on the bodies of `Vehicle.contact_links` (3 each), None
            without any.
        setpoints: port of those of all servos, in the vehicle's order; None without any.
        modes: of its joints at their start, the fastest first.
        vehicle: as it flies, without its payload.
        rotors: their lag and forces.
        body_forces: drag, and the push.
        cables: that carry loads, None without any.
        loads: what flies freely, and hangs on cables.
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
    ball_frames: BallFrames | None
    contact_forces: OutputPort | None
    setpoints: InputPort | None
    modes: tuple[JointMode, ...]
    vehicle: Vehicle
    rotors: Rotors
    body_forces: BodyForces
    cables: Cables | None
    loads: tuple[FreeLoad, ...]
    push: PushSystem
    wind: Wind
    imu: FlightImu
    shapes: frozenset[GeometryId]
    around: ReachSphere
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

    def signals(
        self, commands: OutputPort, setpoints: OutputPort | None = None
    ) -> dict[str, OutputPort]:
        """Return the signals that every flight records.

        Args:
            commands: of the rotors.
            setpoints: of the servos, None without any, or where they stay at their start.
        """
        joints = {"joints": self.joints} if self.joints else {}
        if setpoints:
            joints["joint_setpoints"] = setpoints
        if self.cables:
            joints["tensions"] = self.cables.GetOutputPort("tensions")
        if self.contact_forces:
            joints["contact_forces"] = self.contact_forces
        return joints | {
            "state": self.state,
            "acceleration": self.acceleration,
            "thrusts": self.rotors.GetOutputPort("thrusts"),
            "speeds": self.rotors.GetOutputPort("speeds"),
            "wind": self.wind.get_output_port(),
            "commands": commands,
        }

    def place_of(self, link: str) -> tuple[int, RigidTransform]:
        """Return the index of the body L that a link F is part of, and X_LF."""
        frame = self.plant.GetFrameByName(link, self.body.model_instance())
        return int(frame.body().index()), frame.GetFixedPoseInBodyFrame()

    def motion_of(self, builder: DiagramBuilder, body: RigidBody) -> tuple[OutputPort, OutputPort]:
        """Return ports of the state (13) and the acceleration (6) of a body on a joint.

        They are in the form of those of the base link; a body gets one system, however many ask.
        """
        name = f"motion_{body.index()}"
        if not builder.HasSubsystemNamed(name):
            add_body_motion(builder, self.plant, name, [body.index()])
            motion = builder.GetSubsystemByName(name)
            accelerations = self.plant.get_body_spatial_accelerations_output_port()
            builder.Connect(accelerations, motion.GetInputPort("spatial_accelerations"))
        motion = builder.GetSubsystemByName(name)
        return motion.GetOutputPort("state"), motion.GetOutputPort("acceleration")

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
        center = vehicle_with_payload(self.vehicle, payload).p_BoBcm_B
        forces.get_mutable_numeric_parameter(1).SetFromVector(list(center))

    def place(self, root: Context, state: np.ndarray, speeds: np.ndarray) -> None:
        """Begin at a state of the body (13), with the rotors at speeds (n) [rad/s]."""
        context = self.plant.GetMyMutableContextFromRoot(root)
        whole = self.plant.GetPositionsAndVelocities(context).copy()
        whole[self.places] = state
        self.plant.SetPositionsAndVelocities(context, whole)
        if self.ground:
            for load in self.loads:
                load.lift_above_ground(self.plant, context)
        self.rotors.GetMyMutableContextFromRoot(root).SetContinuousState(speeds)
        self.imu.begin(self.imu.GetMyMutableContextFromRoot(root), state)

    def may_touch(self, root: Context, period: float) -> bool:
        """Return whether the vehicle may touch something within a time [s]."""
        state = self.body_state(root)
        p_WC = state[4:7] + into_world(rotation(state[0:4]), self.around.p_BC)
        spheres = [(np.array(p_WC), self.around.radius, float(np.linalg.norm(state[10:13])))]
        context = self.plant.GetMyContextFromRoot(root)
        spheres += [load.sphere(self.plant, context) for load in self.loads]
        return any(self._sphere_may_touch(root, period, *sphere) for sphere in spheres)

    def _sphere_may_touch(
        self, root: Context, period: float, p_WC: np.ndarray, radius: float, speed: float
    ) -> bool:
        """Return whether a sphere of the vehicle with a speed [m/s] may touch something."""
        way = speed * period + 0.5 * MAX_ACCELERATION * period**2
        if not self.obstacles:
            return bool(self.ground and p_WC[2] - radius < way)
        query = self.scene_graph.get_query_output_port().Eval(
            self.scene_graph.GetMyContextFromRoot(root)
        )
        return any(
            each.distance < radius + way and each.id_G not in self.shapes
            for each in query.ComputeSignedDistanceToPoint(p_WC, radius + way)
        )

    def refuse_closing_hooks(self, root: Context) -> None:
        """Refuse to close the hooks of cables that do not reach their loads.

        Raises:
            WorkbenchError: if there is one.
        """
        context = self.plant.GetMyContextFromRoot(root)
        for row in self.cables.rows if self.cables else ():
            if row.hooked:
                refuse_out_of_reach(self.plant, context, row)

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
    vehicle: Vehicle,
    rates: Rates,
    world: World = EMPTY_WORLD,
    imu: Imu | None = None,
) -> Airframe:
    """Add a vehicle and its world.

    Args:
        builder: the diagram being built.
        description: of the vehicle, with or without drawn shapes.
        values: of parameters by name; those of air and gyro are used.
        vehicle: record of the description.
        rates: of physics and control.
        world: the surroundings.
        imu: of the estimator; None without one.
    """
    plant, scene_graph = add_plant(builder, description, time_step=0.0, world=world)
    plant.set_name("plant")
    body = plant.GetBodyByName(description.base_link)
    turning = description.rotors
    if not world.ground:
        turning = tuple(replace(rotor, ground_effect_coefficient=0.0) for rotor in turning)
    rotors, body_forces = add_forces(builder, plant, description, turning, vehicle, values)
    air = AirSettings(*(values[name] for name in AirSettings._fields))
    push = builder.AddNamedSystem("push", PushSystem(settings=air, period=rates.control_period))
    wind = builder.AddNamedSystem("wind", Wind(settings=air, period=rates.control_period))
    flight_imu = builder.AddNamedSystem(
        "flight_imu",
        FlightImu(
            settings=GyroSettings(*(values[name] for name in GyroSettings._fields)),
            step=rates.physics_step,
            readout=rates.control_steps,
            imu=imu,
        ),
    )
    places = body_places(plant, body)
    state = chosen_values(builder, "body_state", plant.get_state_output_port(), places)
    accelerations = plant.get_generalized_acceleration_output_port()
    moving = places[7:] - plant.num_positions()
    acceleration = chosen_values(builder, "body_acceleration", accelerations, moving)
    cables = add_cables(builder, plant, description)
    connect_forces(builder, plant, state, rotors, body_forces, cables)
    driven = [each.joint for each in vehicle.servos]
    rows, balls, setpoints = add_joint_forces(builder, plant, description, driven)
    ball_frames = (
        BallFrames(plant, builder.GetSubsystemByName(JOINT_FORCES_SYSTEM)) if balls else None
    )
    others = np.setdiff1d(np.arange(plant.num_multibody_states()), places)
    joints = None
    if len(others):
        whole = ball_frames.state if ball_frames else plant.get_state_output_port()
        joints = chosen_values(builder, "joints", whole, others)
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
        ball_frames=ball_frames,
        contact_forces=add_contact_forces(
            builder, plant, vehicle.contact_links, body, "contact_forces"
        ),
        setpoints=setpoints,
        modes=joint_modes(plant, rows, balls, cables.rows if cables else ()),
        vehicle=vehicle,
        rotors=rotors,
        body_forces=body_forces,
        cables=cables,
        loads=free_loads(plant, description),
        push=push,
        wind=wind,
        imu=flight_imu,
        shapes=frozenset(
            shape
            for index in plant.GetBodyIndices(body.model_instance())
            for shape in plant.GetCollisionGeometriesForBody(plant.get_body(index))
        ),
        around=reach_sphere(
            without_loads(description.undrawn().model), description.base_link, description.rotors
        ),
        ground=world.ground,
        obstacles=bool(world.names),
    )


def add_battery_systems(
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
    """Add an estimator of a battery's charge; `add_battery_systems` connects the two.

    Args:
        builder: the diagram being built.
        pack: the known properties of the battery.
        voltage_noise: standard deviation of the measured voltage [V].
    """
    gauge = builder.AddNamedSystem("gauge", ChargeGauge(pack=pack, voltage_noise=voltage_noise))
    return Gauge(gauge, add_counted_noise(builder, gauge.noise_input, BATTERY_PERIOD_S))
