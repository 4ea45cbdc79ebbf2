"""The sensors in the diagram: wires them to plant, scene and noise, and reads them.

A kind of sensor is loaded when the first of it is added: rays come with embree and, for meshes,
with trimesh and all of scipy, which take longer to load than Drake.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import Context, DiagramBuilder
from pydrake.systems.primitives import RandomSource

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.diagram.airframe import Airframe
from workbench.diagram.sensor_choice import SensorChoice
from workbench.plant.gravity import GRAVITY
from workbench.plant.home import Home
from workbench.plant.sensors import (
    Barometer,
    DepthCamera,
    Gps,
    Imu,
    Lidar,
    Magnetometer,
    RangeFinder,
    free_name,
)
from workbench.systems.noise import (
    CountedNoise,
    add_counted_noise,
    add_noise,
    noise_seed,
    seed_noise,
)
from workbench.systems.sensors.readings import Reading

if TYPE_CHECKING:
    from workbench.systems.casting.caster import Caster
    from workbench.systems.sensors.barometer import Barometer as BarometerSystem
    from workbench.systems.sensors.depth_camera import DepthCameraSystem
    from workbench.systems.sensors.gps import Gps as GpsSystem
    from workbench.systems.sensors.imu import Imu as ImuSystem
    from workbench.systems.sensors.lidar import Lidar as LidarSystem
    from workbench.systems.sensors.magnetometer import Magnetometer as MagnetometerSystem
    from workbench.systems.sensors.range_finder import RangeFinder as RangeFinderSystem

    SensorSystem = (
        ImuSystem
        | GpsSystem
        | BarometerSystem
        | MagnetometerSystem
        | RangeFinderSystem
        | LidarSystem
        | DepthCameraSystem
    )


@dataclass(frozen=True)
class Mounted:
    """A sensor in the diagram, with the source of its noise if that is a system of its own."""

    choice: SensorChoice
    system: "SensorSystem"
    noise: RandomSource | CountedNoise | None = None

    def reading(self, root_context: Context) -> Reading | None:
        """Return what it delivered last, None if nothing yet."""
        return self.system.reading(self.system.GetMyContextFromRoot(root_context))

    def samples_taken(self, root_context: Context) -> int:
        """Return how many samples it took since the start."""
        return self.system.samples_taken(self.system.GetMyContextFromRoot(root_context))


@dataclass(frozen=True)
class Sensing:
    """All sensors that measure."""

    mounted: tuple[Mounted, ...] = ()

    def find(self, name: str) -> Mounted:
        """Return the sensor of a name, or the first of a kind.

        Raises:
            WorkbenchError: if none of that name measures.
        """
        for mounted in self.mounted:
            if mounted.choice.sensor.name == name:
                return mounted
        of_kind = self.of_kind(name)
        if of_kind:
            return of_kind[0]
        known = [mounted.choice.sensor.name for mounted in self.mounted]
        if not known:
            raise WorkbenchError(
                f"'{name}' measures nothing: the flight has no sensors switched on"
            )
        raise unknown_name("sensor of this flight", name, known)

    def of_kind(self, kind: str) -> tuple[Mounted, ...]:
        """Return the sensors of a kind."""
        return tuple(each for each in self.mounted if each.choice.sensor.kind == kind)

    def seed(self, root_context: Context, seed: int) -> None:
        """Let all sources of noise begin anew with the seed of a flight."""
        for mounted in self.mounted:
            if mounted.noise:
                seed_noise(mounted.noise, root_context, seed)


def add_sensors(
    builder: DiagramBuilder,
    airframe: Airframe,
    base_link: str,
    choices: Sequence[SensorChoice],
    *,
    home: Home,
    seed: int,
    heard: Collection[str] = (),
) -> Sensing:
    """Add sensors to a diagram whose scene is complete.

    Args:
        builder: of the diagram.
        airframe: what is registered later with its scene graph is not seen.
        base_link: of the vehicle in the plant.
        choices: what to add.
        home: where the world's origin lies.
        seed: of all noise.
        heard: kinds that decide how the flight goes on: an estimator listens to them.
    """
    casting = any(isinstance(choice.sensor, Lidar | RangeFinder) for choice in choices)
    # The caster takes the scene as it is now: cameras change it for their renderer.
    mount = _Mount(
        builder=builder,
        airframe=airframe,
        base=airframe.plant.GetBodyByName(base_link),
        home=home,
        seed=seed,
        heard=heard,
        caster=_caster(airframe, base_link) if casting else None,
    )
    return Sensing(tuple(map(mount.add, choices)))


@dataclass(frozen=True)
class _Mount:
    """What sensors are hung on."""

    builder: DiagramBuilder
    airframe: Airframe
    base: RigidBody
    home: Home
    seed: int
    heard: Collection[str]
    caster: "Caster | None"

    def add(self, choice: SensorChoice) -> Mounted:
        """Add a sensor and connect it."""
        timing = {"period": choice.period, "latency": choice.latency}
        sensor = choice.sensor
        # No two systems have one name: of a sensor's own, this one alone ends so; `a::b` and `a/b`
        # are two sensors.
        taken = [system.get_name() for system in self.builder.GetSystems()]
        name = free_name(taken, f"{sensor.name.replace('::', '/')}_sensor")
        if isinstance(sensor, DepthCamera):
            from workbench.systems.sensors.depth_camera import add_depth_camera

            camera = add_depth_camera(
                self.builder,
                self.airframe.plant,
                self.airframe.scene_graph,
                self.base,
                sensor,
                name=name,
                seed=noise_seed(self.seed, sensor.name),
                **timing,
            )
            return Mounted(choice, camera)
        system: SensorSystem
        match sensor:
            case Imu():
                from workbench.systems.sensors.imu import Imu as ImuSystem

                system = ImuSystem(sensor=sensor, **timing)
            case Gps():
                from workbench.systems.sensors.gps import Gps as GpsSystem

                system = GpsSystem(sensor=sensor, home=self.home, **timing)
            case Barometer():
                from workbench.systems.sensors.barometer import Barometer as BarometerSystem

                dynamics, plant = self.airframe.dynamics, self.airframe.plant
                system = BarometerSystem(
                    sensor=sensor,
                    home=self.home,
                    rotors=dynamics.GetOutputPort("thrusts").size(),
                    weight=GRAVITY * plant.CalcTotalMass(plant.CreateDefaultContext()),
                    **timing,
                )
            case Magnetometer():
                from workbench.systems.sensors.magnetometer import (
                    Magnetometer as MagnetometerSystem,
                )

                system = MagnetometerSystem(sensor=sensor, home=self.home, **timing)
            case RangeFinder():
                from workbench.systems.sensors.range_finder import (
                    RangeFinder as RangeFinderSystem,
                )

                assert self.caster
                system = RangeFinderSystem(sensor=sensor, caster=self.caster, **timing)
            case Lidar():
                from workbench.systems.sensors.lidar import Lidar as LidarSystem

                assert self.caster
                seed = noise_seed(self.seed, sensor.name)
                system = LidarSystem(sensor=sensor, caster=self.caster, seed=seed, **timing)
            case _:
                raise TypeError(f"no system measures what a {type(sensor).__name__} does")
        self.builder.AddNamedSystem(name, system)
        return Mounted(choice, system, self._connect(system, choice))

    def _connect(
        self, system: "SensorSystem", choice: SensorChoice
    ) -> RandomSource | CountedNoise | None:
        """Connect a sensor's inputs by their names; return the source of its noise."""
        outputs = {
            "state": self.airframe.state,
            "thrusts": self.airframe.dynamics.GetOutputPort("thrusts"),
            "acceleration": self.airframe.dynamics.GetOutputPort("acceleration"),
            "geometry_query": self.airframe.scene_graph.get_query_output_port(),
        }
        noise: RandomSource | CountedNoise | None = None
        add = add_counted_noise if choice.sensor.kind in self.heard else add_noise
        for index in range(system.num_input_ports()):
            port = system.get_input_port(index)
            if port.get_name() == "noise":
                noise = add(self.builder, port, choice.period)
            else:
                self.builder.Connect(outputs[port.get_name()], port)
        return noise


def _caster(airframe: Airframe, base_link: str) -> "Caster":
    """Return a caster against everything but the vehicle."""
    from workbench.systems.casting.caster import Caster
    from workbench.systems.casting.scene import anchored_frames, collect_scene

    plant = airframe.plant
    bodies = plant.GetBodiesWeldedTo(plant.GetBodyByName(base_link))
    own = [plant.GetBodyFrameIdOrThrow(body.index()) for body in bodies]
    inspector = airframe.scene_graph.model_inspector()
    return Caster(collect_scene(inspector, leave_out=own, anchored=anchored_frames(plant)))
