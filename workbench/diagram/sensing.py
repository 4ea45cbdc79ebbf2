"""The sensors in the diagram: wires them to plant, scene and noise, and reads them.

The code of lidars and cameras is imported when the first one is added: rays need embree and, for
meshes, trimesh and scipy, which take longer to import than Drake.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import Context, DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, RandomSource, VectorLogSink

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.vectors import float_triple
from workbench.diagram.airframe import Airframe
from workbench.diagram.forces import carried_pose
from workbench.plant.description import Description
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
    Sensor,
    free_name,
)
from workbench.scenario.sensor_choice import SensorChoice
from workbench.systems.noise import (
    CountedNoise,
    add_counted_noise,
    add_noise,
    noise_seed,
    seed_noise,
    sensor_system_name,
)
from workbench.systems.sensors.barometer import barometer_instrument
from workbench.systems.sensors.measuring import MeasuringSensor, SensorInstrument, SensorSite
from workbench.systems.sensors.noisy_sensor import (
    NoisySensor,
    gps_instrument,
    imu_instrument,
    magnetometer_instrument,
    range_finder_instrument,
)
from workbench.systems.sensors.readings import Reading
from workbench.systems.sensors.sampled_sensor import SampledSensor
from workbench.systems.sensors.samples import RecordedSamples

if TYPE_CHECKING:
    from workbench.systems.casting.caster import Caster
    from workbench.systems.sensors.depth_camera import DepthCameraSystem
    from workbench.systems.sensors.lidar import LidarSensor as LidarSystem

    SensorSystem = NoisySensor | LidarSystem | DepthCameraSystem


@dataclass(frozen=True)
class MountedSensor:
    """A sensor in the diagram.

    Attributes:
        choice: which sensor, and how often it measures.
        system: its system.
        noise: source of its noise; None if the noise is part of the system.
        log: of its delivered samples; None if they are not kept.
    """

    choice: SensorChoice
    system: "SensorSystem"
    noise: RandomSource | CountedNoise | None = None
    log: VectorLogSink | None = None

    def reading(self, root_context: Context) -> Reading | None:
        """Return the last delivered sample, None if there is none."""
        return self.system.reading(self.system.GetMyContextFromRoot(root_context))

    def samples_taken(self, root_context: Context) -> int:
        """Return the number of samples taken since the start."""
        return self.system.samples_taken(self.system.GetMyContextFromRoot(root_context))

    def logged(self, builder: DiagramBuilder) -> "MountedSensor":
        """Return it with a log if its samples are kept; pictures are too large for a log."""
        system = self.system
        if not self.choice.kept or not isinstance(system, SampledSensor):
            return self
        log = LogVectorOutput(system.measurement_output, builder, self.choice.period)
        log.set_name(f"{system.get_name()}_log")
        return replace(self, log=log)

    def kept_rows(self, root_context: Context) -> np.ndarray:
        """Return stamp [s] and values of each sample delivered so far (N, 1 + size)."""
        assert self.log and isinstance(self.system, SampledSensor)
        # a log records before the update at that time, so the present sample is added
        present = self.system.delivered(self.system.GetMyContextFromRoot(root_context))
        rows = np.vstack([self.log.FindLog(root_context).data().T, present])
        known = rows[~np.isnan(rows[:, 0])]
        first = np.diff(known[:, 0], prepend=-np.inf) > 0.0  # a silent sensor repeats its last
        return known[first].copy()

    def samples(self, rows: np.ndarray) -> RecordedSamples:
        """Return its delivered samples from rows of its log, see `kept_rows`."""
        assert isinstance(self.system, SampledSensor)
        return self.system.recorded(self.choice.sensor.name, rows[:, 0], rows[:, 1:])


@dataclass(frozen=True)
class Sensing:
    """All sensors that measure."""

    mounted: tuple[MountedSensor, ...] = ()

    def find(self, name: str) -> MountedSensor:
        """Return a sensor by name, or the first of a kind.

        Raises:
            WorkbenchError: if it is not active.
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

    def of_kind(self, kind: str) -> tuple[MountedSensor, ...]:
        """Return the sensors of a kind."""
        return tuple(each for each in self.mounted if each.choice.sensor.kind == kind)

    @property
    def kept(self) -> tuple[MountedSensor, ...]:
        """The sensors whose samples are kept."""
        return tuple(each for each in self.mounted if each.log)

    def seed(self, root_context: Context, seed: int) -> None:
        """Restart all sources of noise with the seed of a flight."""
        for mounted in self.mounted:
            if mounted.noise:
                seed_noise(mounted.noise, root_context, seed)


def add_sensor_systems(
    builder: DiagramBuilder,
    airframe: Airframe,
    description: Description,
    choices: Sequence[SensorChoice],
    *,
    home: Home,
    seed: int,
    aiding: Collection[str] = (),
) -> Sensing:
    """Add sensors to a diagram whose scene is complete.

    Args:
        builder: of the diagram.
        airframe: sensors do not see shapes that are registered later with its scene graph.
        description: of the vehicle in the plant.
        choices: what to add.
        home: where the world's origin lies.
        seed: of all noise.
        aiding: kinds that an estimator uses, so that they affect the flight.
    """
    casting = any(choice.sensor.casts_rays for choice in choices)
    # The caster takes the scene as it is now: cameras change it for their renderer.
    mount = _SensorBuilder(
        builder=builder,
        airframe=airframe,
        description=description,
        home=home,
        seed=seed,
        aiding=aiding,
        caster=_caster(airframe, description.base_link) if casting else None,
    )
    mounted = [mount.add(choice) for choice in choices]
    return Sensing(tuple(each.logged(builder) for each in mounted))


@dataclass(frozen=True)
class _SensorBuilder:
    """Adds sensors to a diagram, and connects them."""

    builder: DiagramBuilder
    airframe: Airframe
    description: Description
    home: Home
    seed: int
    aiding: Collection[str]
    caster: "Caster | None"

    def add(self, choice: SensorChoice) -> MountedSensor:
        """Add a sensor and connect it."""
        timing = {"period": choice.period, "latency": choice.latency}
        body, X_BL = carried_pose(self.airframe.plant, self.description, choice.sensor.link)
        if body.index() != self.airframe.body.index():
            choice = replace(choice, sensor=_on_body(choice.sensor, X_BL))
        sensor = choice.sensor
        # names of systems are unique, but sensors `a::b` and `a/b` would share one
        taken = [system.get_name() for system in self.builder.GetSystems()]
        name = free_name(taken, sensor_system_name(sensor.name))
        if isinstance(sensor, DepthCamera):
            from workbench.systems.sensors.depth_camera import add_depth_camera

            camera = add_depth_camera(
                self.builder,
                self.airframe.plant,
                self.airframe.scene_graph,
                body,
                sensor,
                name=name,
                seed=noise_seed(self.seed, sensor.name),
                **timing,
            )
            return MountedSensor(choice, camera)
        system: SensorSystem
        if isinstance(sensor, Lidar):
            from workbench.systems.sensors.lidar import LidarSensor as LidarSystem

            assert self.caster
            seed = noise_seed(self.seed, sensor.name)
            system = LidarSystem(sensor=sensor, caster=self.caster, seed=seed, **timing)
        else:
            system = NoisySensor(self._instrument(choice), **timing)
        self.builder.AddNamedSystem(name, system)
        return MountedSensor(choice, system, self._connect(system, choice, body))

    def _instrument(self, choice: SensorChoice) -> SensorInstrument:
        """Return what a sensor of a few numbers measures."""
        plant, home, period = self.airframe.plant, self.home, choice.period
        rotors = self.airframe.rotors.GetOutputPort("thrusts").size()
        weight = GRAVITY * plant.CalcTotalMass(plant.CreateDefaultContext())
        match choice.sensor:
            case Imu() as sensor:
                return imu_instrument(sensor, period)
            case Gps() as sensor:
                return gps_instrument(sensor, home)
            case Barometer() as sensor:
                return barometer_instrument(sensor, home, rotors, weight)
            case Magnetometer() as sensor:
                return magnetometer_instrument(sensor, home)
            case RangeFinder() as sensor:
                assert self.caster
                return range_finder_instrument(sensor, self.caster)
            case MeasuringSensor() as sensor:
                return sensor.instrument(SensorSite(home, period, rotors, weight, self.caster))
        raise TypeError(f"no system measures what a {type(choice.sensor).__name__} does")

    def _connect(
        self, system: "SensorSystem", choice: SensorChoice, body: RigidBody
    ) -> RandomSource | CountedNoise | None:
        """Connect a sensor's inputs by their names; return the source of its noise."""
        outputs = {
            "state": self.airframe.state,
            "thrusts": self.airframe.rotors.GetOutputPort("thrusts"),
            "acceleration": self.airframe.acceleration,
            "wind": self.airframe.wind.get_output_port(),
            "geometry_query": self.airframe.scene_graph.get_query_output_port(),
        }
        if body.index() != self.airframe.body.index():
            state, acceleration = self.airframe.motion_of(self.builder, body)
            outputs |= {"state": state, "acceleration": acceleration}
        noise: RandomSource | CountedNoise | None = None
        add = add_counted_noise if choice.sensor.kind in self.aiding else add_noise
        for index in range(system.num_input_ports()):
            port = system.get_input_port(index)
            if port.get_name() == "noise":
                noise = add(self.builder, port, choice.period)
            else:
                self.builder.Connect(outputs[port.get_name()], port)
        return noise


def _on_body(sensor: Sensor, X_BL: RigidTransform) -> Sensor:
    """Return a sensor with its pose in the frame of the body L that carries it."""
    R_BS = RotationMatrix(np.array(sensor.R_BS))
    X_LS = X_BL.InvertAndCompose(RigidTransform(R_BS, np.array(sensor.p_BS)))
    x, y, z = (float_triple(row) for row in X_LS.rotation().matrix())
    return replace(sensor, p_BS=float_triple(X_LS.translation()), R_BS=(x, y, z))


def _caster(airframe: Airframe, base_link: str) -> "Caster":
    """Return a caster against everything but the vehicle."""
    from workbench.systems.casting.caster import Caster
    from workbench.systems.casting.scene import anchored_frames, collect_scene

    plant = airframe.plant
    drone = plant.GetBodyByName(base_link).model_instance()
    own = [plant.GetBodyFrameIdOrThrow(body) for body in plant.GetBodyIndices(drone)]
    inspector = airframe.scene_graph.model_inspector()
    return Caster(collect_scene(inspector, leave_out=own, anchored=anchored_frames(plant)))
