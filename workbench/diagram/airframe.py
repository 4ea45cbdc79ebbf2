"""The vehicle and its world as systems of a diagram."""

from collections.abc import Mapping
from dataclasses import dataclass

from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder, InputPort, OutputPort

from workbench.dynamics.air.settings import AirSettings
from workbench.estimation.gyro import GyroSettings
from workbench.plant.description import Description
from workbench.plant.multibody import add_shapes
from workbench.plant.payload import payload_of
from workbench.plant.sensors import Imu
from workbench.plant.vehicle import BatteryPack, Vehicle
from workbench.plant.worlds.world import EMPTY, World
from workbench.scenario.parameters import parameter_table
from workbench.scenario.scenario import Rates
from workbench.systems.battery import PERIOD, Battery, ChargeGauge
from workbench.systems.noise import CountedNoise, add_counted_noise
from workbench.systems.vehicle_dynamics import VehicleDynamics


@dataclass(frozen=True)
class Airframe:
    """The vehicle in its world.

    Attributes:
        dynamics: system that integrates the motion.
        plant: plant with the bodies and shapes; not a system of the diagram.
        scene_graph: scene graph with all shapes.
    """

    dynamics: VehicleDynamics
    plant: MultibodyPlant
    scene_graph: SceneGraph

    @property
    def commands(self) -> InputPort:
        """Commanded rotor speeds (n) [rad/s]."""
        return self.dynamics.GetInputPort("commands")

    @property
    def state(self) -> OutputPort:
        """State of the body (13): q_WB, p_WB, w_WB_W, v_WB_W."""
        return self.dynamics.GetOutputPort("state")

    @property
    def sensed(self) -> OutputPort:
        """The same with the angular velocity of the gyro (13)."""
        return self.dynamics.GetOutputPort("sensed")

    def signals(self, commands: OutputPort) -> dict[str, OutputPort]:
        """Return the signals that every flight records, with the rotor commands."""
        names = ("state", "acceleration", "thrusts", "speeds", "wind")
        return {name: self.dynamics.GetOutputPort(name) for name in names} | {"commands": commands}


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
        values: of parameters by name; those of air, gyro and payload are used.
        rates: of physics and control.
        world: the surroundings.
        imu: of the estimator; None without one.
    """
    plant, scene_graph, state = add_shapes(builder, description, world)
    air, gyro = (
        {row.name: values[row.name] for row in parameter_table().of(system)}
        for system in ("air", "gyro")
    )
    dynamics = builder.AddNamedSystem(
        "dynamics",
        VehicleDynamics(
            description=description,
            settings=AirSettings(**air),
            step=rates.physics_step,
            world=world,
            payload=payload_of(values),
            gyro=GyroSettings(**gyro),
            readout=round(rates.control_period / rates.physics_step),
            imu=imu,
        ),
    )
    builder.Connect(dynamics.GetOutputPort("state"), state)
    return Airframe(dynamics, plant, scene_graph)


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
    dynamics = airframe.dynamics
    thrusts = "static_thrusts" if dynamics.HasOutputPort("static_thrusts") else "thrusts"
    builder.Connect(dynamics.GetOutputPort(thrusts), battery.GetInputPort("thrusts"))
    if dynamics.HasInputPort("supply"):
        builder.Connect(battery.GetOutputPort("supply"), dynamics.GetInputPort("supply"))
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
