"""Flights without a controller: under a table of rotor commands, or under an external autopilot."""

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RotationMatrix
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context
from pydrake.systems.primitives import ConstantVectorSource

from workbench.autopilots.motion import Motion, attitude_ned, to_frd, to_ned
from workbench.common.errors import WorkbenchError, sentences
from workbench.control.guidance import Reference
from workbench.diagram.core import ROTOR_COMMANDS, OpenLoop, make_open_loop
from workbench.plant.gravity import GRAVITY
from workbench.plant.home import DEFAULT_HOME
from workbench.plant.loading import make_vehicle
from workbench.plant.placing import body_state
from workbench.plant.variation import varied
from workbench.plant.vehicle import Vehicle
from workbench.scenario.configured import read_configured, read_configured_world, tell_world
from workbench.scenario.scenario import Scenario, check_scenario
from workbench.session.integration import Integration
from workbench.session.live_context import start_position
from workbench.session.recording import Recording
from workbench.systems.rotor_playback import load_rotor_commands
from workbench.systems.sensors.barometer import altitude_at, pressure_at

NOISE = {"gyro": 0.001, "force": 0.02, "field": 2e-7, "pressure": 1.0}
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
        from workbench.plant.magnetic_field import magnetic_field  # imports pymap3d

        check_scenario(scenario)
        step = scenario.rates.physics_step
        self._steps = round(1.0 / (rate * step))
        if self._steps < 1 or abs(self._steps * step * rate - 1.0) > 1e-9:
            exact = ", ".join(f"{1.0 / (n * step):.6g}" for n in (1, 2, 4, 8))
            raise WorkbenchError(
                f"a period of {rate:g} Hz is not a whole number of physics steps of {step:g} s: "
                f"take one of {exact} Hz, or a scenario with another physics_step"
            )
        self._step, self.period = step, self._steps * step
        description = read_configured(scenario.vehicle)
        self.vehicle = make_vehicle(description)
        self._order = checked_order(self.vehicle, order)
        world = read_configured_world(scenario)
        tell_world(world)
        flown = varied(description, self.vehicle, scenario.vehicle.variation)
        self._source = ConstantVectorSource(np.zeros(len(self.vehicle.rotors)))
        self._bench = make_open_loop(flown, self.vehicle, scenario.rates, self._source, world)
        self._scenario, self._home = scenario, world.home or DEFAULT_HOME
        self._field = magnetic_field(self._home)
        self._noise = NOISE if noise else dict.fromkeys(NOISE, 0.0)
        self.reset()

    def reset(self) -> None:
        """Restart at time 0."""
        scenario = self._scenario
        self._random = np.random.default_rng(scenario.sensors.seed)
        self._simulator = Simulator(self._bench.diagram)
        self._context = self._simulator.get_mutable_context()
        self._integration = Integration(self._simulator, self._bench.airframe, self._scenario.rates)
        speeds = np.zeros(len(self.vehicle.rotors))
        if scenario.start.mode == "hovering":
            speeds = self.vehicle.hover_speeds
        _place_at_start(self._context, self._bench, scenario, self.vehicle, speeds)
        self._command(speeds)
        self._count = 0
        with sentences("the flight could not begin"):
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
        with sentences(f"the flight broke off after {self.time:.3f} s"):
            self._integration.advance(self._count * self._steps)

    def stop(self) -> None:
        """Stop the rotors, and fly on until that is recorded."""
        for _ in range(math.ceil(2.0 * self._scenario.rates.record_period / self.period)):
            self.fly(())

    def motion(self) -> Motion:
        """Return what sensors at the base link measure now."""
        from workbench.plant.geodesy import geodetic  # see above

        airframe = self._bench.airframe
        context = airframe.plant.GetMyContextFromRoot(self._context)
        state, vdot = airframe.state.Eval(context), airframe.acceleration.Eval(context)[3:6]
        q, p, w, v = state[:4], state[4:7], state[7:10], state[10:13]
        q = q / np.linalg.norm(q)
        into_body = RotationMatrix(Quaternion(q)).matrix().T
        place = geodetic((float(p[0]), float(p[1]), float(p[2])), self._home)
        pressure = pressure_at(place.altitude) + self._draw("pressure", 1)[0]
        return Motion(
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
        return _recorded(self._context, self._bench, self.vehicle)

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


def fly_open_loop(
    scenario: Scenario, table: Path, progress: Callable[[float], None] | None = None
) -> Recording:
    """Fly a CSV file of rotor thrusts for a scenario's duration.

    The vehicle starts as the scenario states, with its rotors at the speeds of the first row;
    script, gains, sensors and flight mode have no effect. The commands pass through the rotors'
    lag. Absent signals are NaN in the recording: reference, mode and charge; clearance is not
    measured.

    Args:
        scenario: source of vehicle, world, start, rates and duration.
        table: see `systems.rotor_playback.load_rotor_commands`; its last row holds to the end.
        progress: called with the flown share, 0 .. 1.

    Raises:
        WorkbenchError: if scenario or table cannot be flown.
    """
    check_scenario(scenario)
    description = read_configured(scenario.vehicle)
    vehicle = make_vehicle(description)
    commands = load_rotor_commands(table, vehicle)
    world = read_configured_world(scenario)
    tell_world(world)
    flown = varied(description, vehicle, scenario.vehicle.variation)
    bench = make_open_loop(flown, vehicle, scenario.rates, commands, world)
    simulator = Simulator(bench.diagram)
    _place_at_start(simulator.get_mutable_context(), bench, scenario, vehicle, commands.speeds[0])
    held = bench.diagram.GetSubsystemByName(ROTOR_COMMANDS)
    held.GetMyMutableContextFromRoot(simulator.get_mutable_context()).SetDiscreteState(
        commands.speeds[0]
    )
    integration = Integration(simulator, bench.airframe, scenario.rates)
    slices = math.ceil(4.0 * scenario.duration)
    steps = scenario.duration / scenario.rates.physics_step
    with sentences("the flight could not continue"):
        simulator.Initialize()
        for index in range(slices):
            integration.advance(round(steps * (index + 1) / slices))
            if progress:
                progress((index + 1) / slices)
    return _recorded(simulator.get_context(), bench, vehicle)


def _place_at_start(
    context: Context, bench: OpenLoop, scenario: Scenario, vehicle: Vehicle, speeds: np.ndarray
) -> None:
    """Write a scenario's start and rotor speeds (n) [rad/s] to the Context."""
    start = scenario.start
    state = body_state(
        p_WB=start_position(start, vehicle),
        roll_pitch_yaw=start.roll_pitch_yaw,
        v_WB=start.velocity,
        w_WB=start.angular_velocity,
    )
    bench.airframe.place(context, state, speeds)


def _recorded(context: Context, bench: OpenLoop, vehicle: Vehicle) -> Recording:
    """Return everything flown; signals that only a controller has are NaN."""
    time = bench.recorder.times(context)
    none = np.full((len(time), len(Reference._fields)), math.nan)
    signals = dict(bench.recorder.signals(context))
    signals |= {"reference": none, "mode": none[:, :1], "charge": none[:, :1]}
    return Recording.from_signals(vehicle, time, signals)
