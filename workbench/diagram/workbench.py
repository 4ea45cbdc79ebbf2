"""The workbench diagram: the sampled core with everything around it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pydrake.geometry import Meshcat, MeshcatVisualizer, MeshcatVisualizerParams
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from workbench.control.controller import Controller
from workbench.control.flight_mode import Settings
from workbench.diagram.airframe import Airframe, Gauge, add_airframe, add_battery, add_gauge
from workbench.diagram.core import add_computer, parameter_values
from workbench.diagram.mounting import (
    deviations_at_start,
    find_imu,
    gps_repeats,
    magnetometer_turn,
    mounting_of,
)
from workbench.diagram.sensing import Sensing, add_sensors
from workbench.diagram.sensor_choice import SensorChoice
from workbench.estimation.estimators import Estimator, find_estimator
from workbench.estimation.settings import HEARD, TRUTH
from workbench.plant.description import Description
from workbench.plant.frame_tree import frames_in_world
from workbench.plant.home import DEFAULT_HOME, Home
from workbench.plant.reach import reach
from workbench.plant.sensors import Imu
from workbench.plant.variation import NOMINAL, Variation
from workbench.plant.vehicle import Vehicle
from workbench.plant.worlds.world import EMPTY, World
from workbench.scenario.scenario import Rates
from workbench.systems.flight_computer import FlightComputer
from workbench.systems.frame_poses import FramePoses
from workbench.systems.mode_manager import ModeManager
from workbench.systems.moving_obstacles import add_moving_obstacles
from workbench.systems.nearest_obstacle import NearestObstacle, drone_and_ground
from workbench.systems.pilot import Pilot
from workbench.systems.propeller_display import add_propeller_display
from workbench.systems.recorder import Recorder, add_recorder
from workbench.systems.reference import add_reference
from workbench.systems.sensors.sampled_sensor import SampledSensor

if TYPE_CHECKING:
    from workbench.link.topics import Topic
    from workbench.systems.bridge import Bridge
    from workbench.systems.navigation import Navigation
    from workbench.systems.telemetry import Telemetry

WALL_PERIOD = 1 / 32
"""Approximate time between obstacle measurements [s]: at 8 m/s a quarter of a metre."""

PICTURE_PERIOD = 1 / 32
"""Between pictures in Meshcat [s]."""

NAVIGATION = "navigation"
"""Name of the system that estimates the motion."""

NEVER = 1e9
"""Longer than any flight [s]: Drake 1.58 and later refuse an infinite period."""


@dataclass(frozen=True)
class Workbench:
    """The full diagram, with the systems that a session reads and writes."""

    diagram: Diagram
    vehicle: Vehicle
    airframe: Airframe
    controller: Controller
    computer: FlightComputer
    pilot: Pilot
    modes: ModeManager
    recorder: Recorder
    sensing: Sensing
    frames: FramePoses
    obstacles: NearestObstacle | None
    visualizer: MeshcatVisualizer | None = None
    telemetry: "Telemetry | None" = None
    navigation: "Navigation | None" = None
    gauge: Gauge | None = None
    topics: "tuple[Topic, ...]" = ()


def make_workbench(
    controller: Controller,
    description: Description,
    vehicle: Vehicle,
    gains: Mapping[str, float],
    rates: Rates,
    path: PiecewisePolynomial | None = None,
    meshcat: Meshcat | None = None,
    world: World = EMPTY,
    sensors: Sequence[SensorChoice] = (),
    seed: int = 0,
    variation: Variation = NOMINAL,
    bridge: "Bridge | None" = None,
    picture_period: float = PICTURE_PERIOD,
    feedforward: PiecewisePolynomial | None = None,
    estimator: str = TRUTH,
    noise: bool = True,
) -> Workbench:
    """Return the core with pilot, path, flight mode, battery, sensors and recorder around it.

    Args:
        controller: whose law runs.
        description: of the simulated vehicle, which may be a variation, see `plant.variation`.
        vehicle: as the controller knows it.
        gains: a value for every row of the parameter table, by name.
        rates: periods of all sampled systems.
        path: `guidance.Reference` vectors over time, added to the pilot's, if any.
        meshcat: the Meshcat to draw in, if any.
        world: the surroundings.
        sensors: the active ones.
        seed: of their noise; the seed of the air is set with its Context.
        variation: has the delays of the flight.
        bridge: to the network, or to a log; without one nothing is published.
        picture_period: between pictures in Meshcat [s]; infinite for only the first picture.
        feedforward: acceleration of the path in W (3) [m/s²], for laws that use it.
        estimator: one of `ESTIMATORS`, which provides the motion to the controller unless that has
            a user's own estimator; `sensors` include those that it uses.
        noise: whether the IMU of the estimator has noise.

    Raises:
        WorkbenchError: if the description has no IMU, which every estimator needs.
    """
    builder = DiagramBuilder()
    estimates = controller.estimator or find_estimator(estimator)
    imu = find_imu(vehicle, noise) if estimates else None
    airframe = add_airframe(
        builder,
        description if meshcat else description.undrawn(),
        gains,
        rates=rates,
        world=world,
        imu=imu,
    )
    add_moving_obstacles(builder, airframe.plant, airframe.scene_graph, world)
    home = world.home or DEFAULT_HOME
    navigation = None
    if estimates and imu:
        navigation = _add_navigation(
            builder, airframe, estimates, imu, gains, sensors, home, rates.control_period
        )
    known = navigation.GetOutputPort("state") if navigation else airframe.state
    sensed = navigation.GetOutputPort("state") if navigation else None
    gauge = None
    if navigation and vehicle.battery:
        gauge = add_gauge(builder, vehicle.battery, **parameter_values("gauge", gains))
    voltage = gauge.system.GetOutputPort("voltage") if gauge else None
    computer = add_computer(
        builder, controller, airframe, vehicle, gains, rates, variation, sensed, voltage
    )
    pilot = builder.AddNamedSystem("pilot", _make_pilot(bridge, rates))
    reference = add_reference(builder, pilot.GetOutputPort("reference"), path)
    if feedforward is not None:
        source = builder.AddNamedSystem("feedforward", TrajectorySource(feedforward))
        builder.Connect(source.get_output_port(), computer.GetInputPort("feedforward"))
    modes = builder.AddNamedSystem(
        "modes",
        ModeManager(
            period=rates.mode_period,
            settings=Settings(**parameter_values("modes", gains)),
            standing_height=vehicle.ground_clearance,
            wall_period=_wall_period(rates) if world.names else None,
        ),
    )
    battery = add_battery(
        builder, airframe, vehicle, **parameter_values("battery", gains), gauge=gauge
    )
    builder.Connect(reference, computer.GetInputPort("reference"))
    builder.Connect(modes.GetOutputPort("guidance"), computer.GetInputPort("guidance"))
    if controller.program:
        builder.Connect(computer.GetOutputPort("ended"), modes.GetInputPort("ended"))
    builder.Connect(known, modes.GetInputPort("state"))
    if navigation:
        builder.Connect(navigation.GetOutputPort("health"), modes.GetInputPort("health"))
        builder.Connect(modes.GetOutputPort("mode"), navigation.GetInputPort("mode"))
    builder.Connect(reference, modes.GetInputPort("reference"))
    builder.Connect(pilot.GetOutputPort("request"), modes.GetInputPort("request"))
    builder.Connect(battery.GetOutputPort("charge"), modes.GetInputPort("charge"))
    signals = airframe.signals(computer.GetOutputPort("commands")) | {
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
    frames = _add_frames(builder, airframe, description, vehicle, world)
    obstacles = None
    if world.names:
        obstacles = _add_obstacles(builder, airframe, description, gains, rates)
        builder.Connect(obstacles.walls_output, modes.GetInputPort("walls"))
        signals |= {"obstacle": obstacles.obstacle_output}
    recorder = add_recorder(builder, signals, rates.record_period)
    visualizer = None
    if meshcat is not None:
        visualizer = _draw(builder, airframe, vehicle, meshcat, picture_period)
    sensing = add_sensors(
        builder,
        airframe,
        vehicle.base_link,
        sensors,
        home=home,
        seed=seed,
        heard=HEARD if navigation else (),
    )
    if navigation:
        for kind in HEARD:
            for mounted in sensing.of_kind(kind)[:1]:
                assert isinstance(mounted.system, SampledSensor)
                builder.Connect(mounted.system.measurement_output, navigation.GetInputPort(kind))
    telemetry: Telemetry | None = None
    topics: tuple[Topic, ...] = ()
    if bridge:
        from workbench.diagram.telemetry import add_telemetry  # slow to load, as all of the network

        builder.Connect(modes.GetOutputPort("mode"), pilot.GetInputPort("mode"))
        limits = (gains["max_speed"], gains["max_climb_rate"], gains["max_yaw_rate"])
        telemetry, topics = add_telemetry(
            builder, bridge, vehicle, recorder, frames, sensing, limits, rates.control_period
        )
    diagram = builder.Build()
    diagram.set_name("workbench")
    return Workbench(
        diagram=diagram,
        vehicle=vehicle,
        airframe=airframe,
        controller=controller,
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


def _make_pilot(bridge: "Bridge | None", rates: Rates) -> Pilot:
    """Return the pilot, with network commands if there is a bridge."""
    if bridge is None:
        return Pilot()
    from workbench.systems.bridge import CommandBridge

    return CommandBridge(
        bridge,
        period=rates.control_period,
        physics_step=rates.physics_step,
    )


def _add_navigation(
    builder: DiagramBuilder,
    airframe: Airframe,
    estimator: Estimator,
    imu: Imu,
    gains: Mapping[str, float],
    sensors: Sequence[SensorChoice],
    home: Home,
    period: float,
) -> "Navigation":
    """Add the system that estimates the motion; its sensors are connected later."""
    from workbench.systems.navigation import Navigation  # with it comes pymap3d

    navigation = builder.AddNamedSystem(
        NAVIGATION,
        Navigation(
            estimator=estimator,
            settings=gains,
            mounting=mounting_of(imu, sensors, home),
            turn_BM=magnetometer_turn(sensors),
            known=deviations_at_start(imu),
            home=home,
            period=period,
            repeats=not any(each.stddev for each in imu.angular_velocity),
            gps_repeats=gps_repeats(sensors),
        ),
    )
    builder.Connect(airframe.imu.GetOutputPort("imu"), navigation.GetInputPort("imu"))
    return navigation


def _add_frames(
    builder: DiagramBuilder,
    airframe: Airframe,
    description: Description,
    vehicle: Vehicle,
    world: World,
) -> FramePoses:
    """Add the port of all frames."""
    tree = frames_in_world(vehicle, description.model, world)
    frames = builder.AddNamedSystem("frames", FramePoses(tree))
    builder.Connect(airframe.state, frames.get_input_port())
    return frames


def _add_obstacles(
    builder: DiagramBuilder,
    airframe: Airframe,
    description: Description,
    gains: Mapping[str, float],
    rates: Rates,
) -> NearestObstacle:
    """Add the measurement of the nearest obstacle."""
    inspector = airframe.scene_graph.model_inspector()
    obstacles = builder.AddNamedSystem(
        "obstacles",
        NearestObstacle(
            reach=reach(description.model, description.base_link, description.rotors),
            not_obstacles=drone_and_ground(airframe.plant, inspector, description.base_link),
            period=_wall_period(rates),
            lead=rates.physics_step,
            warning_distance=gains["warning_distance"],
        ),
    )
    builder.Connect(airframe.state, obstacles.GetInputPort("state"))
    builder.Connect(
        airframe.scene_graph.get_query_output_port(), obstacles.GetInputPort("geometry_query")
    )
    return obstacles


def _wall_period(rates: Rates) -> float:
    """Return the period of obstacle measurements [s], in whole physics steps."""
    return rates.physics_step * max(1, round(WALL_PERIOD / rates.physics_step))


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
        period=PICTURE_PERIOD,
    )
    return MeshcatVisualizer.AddToBuilder(
        builder,
        airframe.scene_graph,
        meshcat,
        MeshcatVisualizerParams(publish_period=min(period, NEVER)),
    )
