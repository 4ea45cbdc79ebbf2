"""The workbench diagram: the sampled core with everything around it."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from pydrake.geometry import Meshcat, MeshcatVisualizer, MeshcatVisualizerParams
from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort
from pydrake.systems.primitives import TrajectorySource

from workbench.control.flight_mode import FlightModeSettings
from workbench.diagram.airframe import Airframe, Gauge, add_airframe, add_battery_systems, add_gauge
from workbench.diagram.core import add_computer
from workbench.diagram.forces import add_contact_forces
from workbench.diagram.mounting import (
    deviations_at_start,
    find_imu,
    gps_repeats,
    magnetometer_turn,
    mounting_of,
)
from workbench.diagram.sensing import Sensing, add_sensor_systems
from workbench.diagram.servos import rotor_commands, servo_setpoints
from workbench.estimation.settings import AIDING_SENSORS
from workbench.plant.frame_tree import frames_in_world
from workbench.plant.reach import reach_sphere
from workbench.plant.sensors import Imu
from workbench.plant.tree import without_loads
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import FigureEight, Rates
from workbench.setup import Setup
from workbench.systems.flight_computer import FlightComputer
from workbench.systems.frame_poses import FramePoses, JointFrame
from workbench.systems.mode_manager import ModeManager
from workbench.systems.moving_obstacles import add_moving_obstacles
from workbench.systems.nearest_obstacle import NearestObstacle, drone_and_ground
from workbench.systems.pilot import PilotSystem
from workbench.systems.propeller_display import add_propeller_display
from workbench.systems.recorder import SignalRecorder, add_recorder
from workbench.systems.reference import add_reference, figure_eight, path_acceleration
from workbench.systems.sensors.sampled_sensor import SampledSensor

if TYPE_CHECKING:
    from workbench.link.topics import Topic
    from workbench.systems.bridge import Bridge
    from workbench.systems.navigation import Navigation
    from workbench.systems.telemetry import Telemetry

WALL_PERIOD_S = 1 / 32
"""Approximate time between obstacle measurements [s]: at 8 m/s a quarter of a metre."""

MESHCAT_PERIOD_S = 1 / 32
"""Between pictures in Meshcat [s]."""

NAVIGATION_SYSTEM = "navigation"
"""Name of the system that estimates the motion."""

NEVER_PERIOD_S = 1e9
"""Longer than any flight [s]: Drake 1.58 and later refuse an infinite period."""


@dataclass(frozen=True)
class Workbench:
    """The full diagram of a setup, with the systems that a session reads and writes."""

    diagram: Diagram
    setup: Setup
    airframe: Airframe
    computer: FlightComputer
    pilot: PilotSystem
    modes: ModeManager
    recorder: SignalRecorder
    sensing: Sensing
    frames: FramePoses
    obstacles: NearestObstacle | None
    visualizer: MeshcatVisualizer | None = None
    telemetry: "Telemetry | None" = None
    navigation: "Navigation | None" = None
    gauge: Gauge | None = None
    topics: "tuple[Topic, ...]" = ()


def make_workbench(
    setup: Setup,
    meshcat: Meshcat | None = None,
    bridge: "Bridge | None" = None,
    picture_period: float = MESHCAT_PERIOD_S,
) -> Workbench:
    """Return the core with pilot, path, flight mode, battery, sensors and recorder around it.

    Args:
        setup: what flies; the seed of the air is set with its Context.
        meshcat: the Meshcat to draw in, if any.
        bridge: to the network, or to a log; without one nothing is published.
        picture_period: between pictures in Meshcat [s]; infinite for only the first picture.

    Raises:
        WorkbenchError: if the vehicle has no IMU, which every estimator needs.
    """
    builder = DiagramBuilder()
    controller, vehicle, values = setup.controller, setup.vehicle, setup.values
    rates, world = setup.rates, setup.world
    imu = find_imu(vehicle, setup.scenario.sensors.noise) if setup.estimator else None
    airframe = add_airframe(
        builder,
        setup.flown if meshcat else setup.flown.undrawn(),
        values,
        rates=rates,
        vehicle=setup.flown_vehicle,
        world=world,
        imu=imu,
    )
    add_moving_obstacles(builder, airframe.scene_graph, world)
    navigation = _add_navigation(builder, airframe, setup, imu) if imu else None
    known = navigation.GetOutputPort("state") if navigation else airframe.state
    sensed = navigation.GetOutputPort("state") if navigation else None
    gauge = None
    if navigation and vehicle.battery:
        gauge = add_gauge(builder, vehicle.battery, **setup.of_system("gauge"))
    voltage = gauge.system.GetOutputPort("voltage") if gauge else None
    computer = add_computer(builder, setup, airframe, sensed, voltage)
    pilot = builder.AddNamedSystem("pilot", _make_pilot(bridge, rates))
    reference = _add_path(builder, pilot, computer, setup.scenario.figure_eight)
    own_links = [link.name for link in without_loads(setup.flown.model).links]
    contact = add_contact_forces(builder, airframe.plant, own_links, airframe.body, "body_contact")
    assert contact
    modes = builder.AddNamedSystem(
        "modes",
        ModeManager(
            period=rates.mode_period,
            settings=FlightModeSettings(**setup.of_system("modes")),
            standing_height=vehicle.ground_clearance,
            wall_period=_wall_period(rates) if world.names else None,
            bodies=contact.size() // 3,
        ),
    )
    battery = add_battery_systems(
        builder, airframe, vehicle, **setup.of_system("battery"), gauge=gauge
    )
    builder.Connect(reference, computer.GetInputPort("reference"))
    builder.Connect(modes.GetOutputPort("guidance"), computer.GetInputPort("guidance"))
    if controller.program:
        builder.Connect(computer.GetOutputPort("ended"), modes.GetInputPort("ended"))
    builder.Connect(known, modes.GetInputPort("state"))
    builder.Connect(contact, modes.GetInputPort("contact_forces"))
    if navigation:
        builder.Connect(navigation.GetOutputPort("health"), modes.GetInputPort("health"))
        builder.Connect(modes.GetOutputPort("mode"), navigation.GetInputPort("mode"))
    builder.Connect(reference, modes.GetInputPort("reference"))
    builder.Connect(pilot.GetOutputPort("request"), modes.GetInputPort("request"))
    builder.Connect(battery.GetOutputPort("charge"), modes.GetInputPort("charge"))
    asked = computer.GetOutputPort("commands")
    spun = rotor_commands(builder, asked, len(vehicle.rotors), "recorded_commands")
    signals = airframe.signals(spun, servo_setpoints(builder)) | {
        "reference": reference,
        "mode": modes.GetOutputPort("mode"),
        "charge": battery.GetOutputPort("charge"),
    }
    if gauge:
        known_charge = gauge.system.GetOutputPort("charge")
        builder.Connect(known_charge, modes.GetInputPort("known_charge"))
        signals |= {"known_charge": known_charge}
    if navigation:
        signals |= {
            "estimate": navigation.GetOutputPort("state"),
            "deviations": navigation.GetOutputPort("deviations"),
            "covariance": navigation.GetOutputPort("covariance"),
            "innovations": navigation.GetOutputPort("innovations"),
        }
    frames = _add_frames(builder, airframe, setup)
    obstacles = None
    if world.names:
        obstacles = _add_obstacles(builder, airframe, setup)
        builder.Connect(obstacles.walls_output, modes.GetInputPort("walls"))
        signals |= {"obstacle": obstacles.obstacle_output}
    recorder = add_recorder(builder, signals, rates.record_period)
    visualizer = None
    if meshcat is not None:
        visualizer = _draw(builder, airframe, vehicle, meshcat, picture_period)
    sensing = add_sensor_systems(
        builder,
        airframe,
        setup.flown,
        setup.sensors,
        home=setup.home,
        seed=setup.scenario.sensors.seed,
        aiding=AIDING_SENSORS if navigation else (),
    )
    if navigation:
        for kind in AIDING_SENSORS:
            for mounted in sensing.of_kind(kind)[:1]:
                assert isinstance(mounted.system, SampledSensor)
                builder.Connect(mounted.system.measurement_output, navigation.GetInputPort(kind))
    telemetry: Telemetry | None = None
    topics: tuple[Topic, ...] = ()
    if bridge:
        from workbench.diagram.telemetry import add_telemetry  # slow to load, as all of the network

        builder.Connect(modes.GetOutputPort("mode"), pilot.GetInputPort("mode"))
        telemetry, topics = add_telemetry(
            builder,
            setup,
            bridge,
            recorder,
            frames,
            sensing,
            battery.GetOutputPort("terminals") if vehicle.battery else None,
        )
    diagram = builder.Build()
    diagram.set_name("workbench")
    return Workbench(
        diagram=diagram,
        setup=setup,
        airframe=airframe,
        computer=computer,
        pilot=pilot,
        modes=modes,
        recorder=recorder,
        sensing=sensing,
        frames=frames,
        obstacles=obstacles,
        visualizer=visualizer,
        telemetry=telemetry,
        navigation=navigation,
        gauge=gauge,
        topics=topics,
    )


def _add_path(
    builder: DiagramBuilder,
    pilot: PilotSystem,
    computer: FlightComputer,
    eight: FigureEight | None,
) -> OutputPort:
    """Return the port of the pilot's command, together with a figure of eight if there is one."""
    asked = pilot.GetOutputPort("reference")
    if eight is None:
        return asked
    path = figure_eight(eight.center, eight.length, eight.width, eight.period, eight.laps)
    if eight.feedforward:
        source = TrajectorySource(path_acceleration(path))
        builder.AddNamedSystem("feedforward", source)
        builder.Connect(source.get_output_port(), computer.GetInputPort("feedforward"))
    return add_reference(builder, asked, path)


def _make_pilot(bridge: "Bridge | None", rates: Rates) -> PilotSystem:
    """Return the pilot, with network commands if there is a bridge."""
    if bridge is None:
        return PilotSystem()
    from workbench.systems.bridge import CommandBridge

    return CommandBridge(
        bridge,
        period=rates.control_period,
        physics_step=rates.physics_step,
    )


def _add_navigation(
    builder: DiagramBuilder, airframe: Airframe, setup: Setup, imu: Imu
) -> "Navigation":
    """Add the system that estimates the motion; its sensors are connected later."""
    from workbench.systems.navigation import Navigation  # with it comes pymap3d

    assert setup.estimator
    navigation = builder.AddNamedSystem(
        NAVIGATION_SYSTEM,
        Navigation(
            estimator=setup.estimator,
            settings=setup.values,
            mounting=mounting_of(imu, setup.sensors, setup.home),
            turn_BM=magnetometer_turn(setup.sensors),
            known=deviations_at_start(imu),
            home=setup.home,
            period=setup.rates.control_period,
            repeats=not any(each.stddev for each in imu.angular_velocity),
            gps_repeats=gps_repeats(setup.sensors),
        ),
    )
    builder.Connect(airframe.imu.GetOutputPort("imu"), navigation.GetInputPort("imu"))
    return navigation


def _add_frames(builder: DiagramBuilder, airframe: Airframe, setup: Setup) -> FramePoses:
    """Add the port of all frames."""
    tree = frames_in_world(setup.vehicle, setup.flown.model, setup.world)
    moved = [
        JointFrame(
            joint.child,
            *airframe.place_of(joint.parent),
            *airframe.place_of(joint.child),
        )
        for joint in setup.flown.model.joints
        if joint.moves
    ]
    frames = builder.AddNamedSystem("frames", FramePoses(tree, moved))
    builder.Connect(airframe.state, frames.GetInputPort("state"))
    if moved:
        poses = airframe.plant.get_body_poses_output_port()
        builder.Connect(poses, frames.GetInputPort("body_poses"))
    return frames


def _add_obstacles(builder: DiagramBuilder, airframe: Airframe, setup: Setup) -> NearestObstacle:
    """Add the measurement of the nearest obstacle."""
    inspector, flown = airframe.scene_graph.model_inspector(), setup.flown
    obstacles = builder.AddNamedSystem(
        "obstacles",
        NearestObstacle(
            reach=reach_sphere(flown.model, flown.base_link, flown.rotors),
            not_obstacles=drone_and_ground(airframe.plant, inspector, flown.base_link),
            period=_wall_period(setup.rates),
            lead=setup.rates.physics_step,
            warning_distance=setup.values["warning_distance"],
        ),
    )
    builder.Connect(airframe.state, obstacles.GetInputPort("state"))
    builder.Connect(
        airframe.scene_graph.get_query_output_port(), obstacles.GetInputPort("geometry_query")
    )
    return obstacles


def _wall_period(rates: Rates) -> float:
    """Return the period of obstacle measurements [s], in whole physics steps."""
    return rates.physics_step * max(1, round(WALL_PERIOD_S / rates.physics_step))


def _draw(
    builder: DiagramBuilder,
    airframe: Airframe,
    vehicle: Vehicle,
    meshcat: Meshcat,
    period: float,
) -> MeshcatVisualizer:
    """Draw the scene, with turning propellers."""
    add_propeller_display(
        builder,
        airframe.plant,
        airframe.scene_graph,
        vehicle,
        airframe.state,
        airframe.rotors.GetOutputPort("speeds"),
        period=MESHCAT_PERIOD_S,
    )
    return MeshcatVisualizer.AddToBuilder(
        builder,
        airframe.scene_graph,
        meshcat,
        MeshcatVisualizerParams(publish_period=min(period, NEVER_PERIOD_S)),
    )
