"""Flights under an external autopilot: a drone in its world that takes rotor speeds."""

import math
from collections.abc import Sequence

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RotationMatrix
from pydrake.systems.analysis import Simulator
from pydrake.systems.primitives import ConstantVectorSource

from workbench.common.errors import WorkbenchError, drake_error_sentences
from workbench.diagram.core import make_open_loop
from workbench.extras.autopilots.programs.motion import (
    AutopilotMotion,
    attitude_ned,
    to_frd,
    to_ned,
)
from workbench.plant.gravity import GRAVITY
from workbench.plant.vehicle import Vehicle
from workbench.scenario.configured import log_world_remarks
from workbench.scenario.scenario import Scenario
from workbench.session.integration import Integration
from workbench.session.open_loop import place_at_start, recorded
from workbench.session.recording import Recording
from workbench.setup import make_setup
from workbench.systems.sensors.barometer import altitude_at, pressure_at

AUTOPILOT_SENSOR_NOISE = {"gyro": 0.001, "force": 0.02, "field": 2e-7, "pressure": 1.0}
"""Standard deviations of a sample [rad/s, m/s², T, Pa]: PX4 treats a constant sensor as failed."""


class AutopilotFlight:
    """A drone in its world that takes rotor speeds and returns its motion.

    Attributes:
        vehicle: the flying vehicle.
        period: time between two commands [s].

    Args:
        scenario: source of vehicle, world, start and rates; the air is calm.
        rate: rate of commands [Hz].
        order: rotor of each output, counted from 0; () for that of a quad X.
        noise: whether sensors are noisy.

    Raises:
        WorkbenchError: if it cannot be built, or the period is not a whole number of physics steps.
    """

    def __init__(
        self, scenario: Scenario, rate: float, order: Sequence[int] = (), *, noise: bool = True
    ) -> None:
        from workbench.plant.magnetic_field import earth_magnetic_field  # imports pymap3d

        self._setup = setup = make_setup(scenario)
        step = setup.rates.physics_step
        self._steps = round(1.0 / (rate * step))
        if self._steps < 1 or abs(self._steps * step * rate - 1.0) > 1e-9:
            exact = ", ".join(f"{1.0 / (n * step):.6g}" for n in (1, 2, 4, 8))
            raise WorkbenchError(
                f"a period of {rate:g} Hz is not a whole number of physics steps of {step:g} s: "
                f"take one of {exact} Hz, or a scenario with another physics_step"
            )
        self._step, self.period = step, self._steps * step
        self.vehicle = setup.vehicle
        self._order = checked_order(self.vehicle, order)
        log_world_remarks(setup.world)
        self._source = ConstantVectorSource(np.zeros(len(self.vehicle.rotors)))
        self._diagram, self._airframe, self._recorder = make_open_loop(setup, self._source)
        self._home = setup.home
        self._field = earth_magnetic_field(self._home)
        self._noise = (
            AUTOPILOT_SENSOR_NOISE if noise else dict.fromkeys(AUTOPILOT_SENSOR_NOISE, 0.0)
        )
        self.reset()

    def reset(self) -> None:
        """Restart at time 0."""
        scenario = self._setup.scenario
        self._random = np.random.default_rng(scenario.sensors.seed)
        self._simulator = Simulator(self._diagram)
        self._context = self._simulator.get_mutable_context()
        self._integration = Integration(self._simulator, self._airframe, scenario.rates)
        speeds = np.zeros(len(self.vehicle.rotors))
        if scenario.start.mode == "hovering":
            speeds = self.vehicle.hover_speeds
        place_at_start(self._context, self._airframe, self._setup, speeds)
        self._command(speeds)
        self._count = 0
        with drake_error_sentences("the flight could not begin"):
            self._simulator.Initialize()

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._count * self._steps * self._step

    def fly(self, outputs: Sequence[float]) -> None:
        """Fly one period with outputs of the autopilot, 0 .. 1: shares of the full speed."""
        speeds = np.zeros(len(self.vehicle.rotors))
        for output, rotor in zip(outputs, self._order, strict=False):
            speeds[rotor] = output * self.vehicle.rotors[rotor].max_rot_velocity
        self._command(speeds)
        self._count += 1
        self._integration.advance(self._count * self._steps)

    def stop(self) -> None:
        """Stop the rotors, and fly on until that is recorded."""
        for _ in range(math.ceil(2.0 * self._setup.rates.record_period / self.period)):
            self.fly(())

    def motion(self) -> AutopilotMotion:
        """Return what sensors at the base link measure now."""
        from workbench.plant.geodesy import geodetic  # see above

        airframe = self._airframe
        context = airframe.plant.GetMyContextFromRoot(self._context)
        state, vdot = airframe.state.Eval(context), airframe.acceleration.Eval(context)[3:6]
        q, p, w, v = state[:4], state[4:7], state[7:10], state[10:13]
        q = q / np.linalg.norm(q)
        into_body = RotationMatrix(Quaternion(q)).matrix().T
        place = geodetic((float(p[0]), float(p[1]), float(p[2])), self._home)
        pressure = pressure_at(place.altitude) + self._draw("pressure", 1)[0]
        return AutopilotMotion(
            time=self.time,
            attitude=attitude_ned(q.tolist()),
            gyro=to_frd((into_body @ w + self._draw("gyro", 3)).tolist()),
            force=to_frd(
                (into_body @ (vdot + [0.0, 0.0, GRAVITY]) + self._draw("force", 3)).tolist()
            ),
            velocity=to_ned(v.tolist()),
            position=to_ned(p.tolist()),
            field=to_frd((into_body @ self._field + self._draw("field", 3)).tolist()),
            pressure=float(pressure),
            pressure_altitude=altitude_at(float(pressure)),
            place=(place.latitude, place.longitude, place.altitude),
        )

    def recording(self) -> Recording:
        """Return everything flown since the last reset; absent signals are NaN."""
        return recorded(self._context, self._recorder, self.vehicle)

    def _draw(self, what: str, size: int) -> np.ndarray:
        return self._noise[what] * self._random.standard_normal(size)

    def _command(self, speeds: np.ndarray) -> None:
        own = self._source.GetMyMutableContextFromRoot(self._context)
        self._source.get_mutable_source_value(own).set_value(speeds)


def checked_order(vehicle: Vehicle, order: Sequence[int]) -> tuple[int, ...]:
    """Return the rotor of each output, counted from 0.

    Without an order it is that of PX4's and ArduPilot's quad X: front right and rear left, which
    turn counter-clockwise, then front left and rear right, which turn clockwise.

    Raises:
        WorkbenchError: if it does not name each rotor once, or the vehicle is not such a quad.
    """
    rotors = vehicle.rotors
    if order:
        if sorted(order) != list(range(len(rotors))):
            raise WorkbenchError(
                f"--order must name each of the {len(rotors)} rotors once, counted from 1"
            )
        return tuple(order)
    x_cm, y_cm, _ = vehicle.p_BoBcm_B
    wanted = ((True, False, 1), (False, True, 1), (True, True, -1), (False, False, -1))
    found = {
        (each.p_BR[0] > x_cm, each.p_BR[1] > y_cm, each.direction): number
        for number, each in enumerate(rotors)
    }
    if len(rotors) != 4 or set(found) != set(wanted):
        raise WorkbenchError(
            f"{vehicle.name} is not a quad X whose front right and rear left rotors turn "
            "counter-clockwise: set its geometry in the autopilot, and name the rotor of each "
            "output, as --order 1,2,3,4"
        )
    return tuple(found[place] for place in wanted)
