"""Fly a scenario's script in compiled code, and record it as a session does."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext

import numpy as np

from workbench.common.own_file import user_code_errors
from workbench.control.flight_mode import MAX_GPS_AGE_S, MAX_HEADING_AGE_S
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.rollout.flights import FlightSchedule, make_delay_rings
from workbench.design.rollout.lane_times import make_lane_times
from workbench.design.rollout.lanes import make_lane_workspace
from workbench.design.rollout.recorded import compiled_recorded, sample_dtype
from workbench.design.rollout.sensor_set import why_not_compiled
from workbench.diagram.airframe import MAX_ACCELERATION
from workbench.dynamics.air.settings import AirSettings
from workbench.dynamics.air.update import steady_wind
from workbench.dynamics.rigid_body import into_world, rotation
from workbench.estimation.settings import AIDING_SENSORS
from workbench.plant.placing import body_state
from workbench.plant.reach import reach_sphere
from workbench.plant.thrust_frame import thrust_frame
from workbench.scenario.scenario import Action, Scenario
from workbench.session.live_context import start_position
from workbench.session.recording import Recording
from workbench.session.script import acting_step
from workbench.setup import Setup, log_setup
from workbench.systems.navigation import AIDING_USE_CHANNELS
from workbench.systems.pilot import PilotCommand, with_velocity_command

SCRIPT_SLICE_S = 0.25
"""Time flown between two reports of the progress, as in a session [s]."""


def why_no_script(setup: Setup) -> str:
    """Return why a script cannot be flown in compiled code, whatever flies; "" if it can."""
    scenario = setup.scenario
    if not setup.controller.compiles:
        return f"{setup.controller.name} is not compiled"
    if scenario.start.mode != "hovering":
        return "a start on the ground is not compiled"
    if scenario.world != Scenario.world:
        return f"the world {scenario.world} is not compiled"
    if scenario.figure_eight:
        return "a figure of eight is not compiled"
    every = setup.rates.record_period / setup.rates.control_period
    if every < 1.0 or not every.is_integer():
        return "compiled code records at control updates only"
    for action in scenario.script:
        others = action.go_to, action.request, action.gust, action.push, action.injection
        others = *others, action.setpoint
        if action.set or action.controller or any(each is not None for each in others):
            return "a script with more than velocities and yaw rates is not compiled"
    return ""


class ScriptedFlight:
    """Flights in compiled code of a scenario, and of others that differ in script and duration.

    Attributes:
        values: of all parameters, by name.
        why_not: why the scenario is not compiled, "" if it is.

    Args:
        setup: what to fly; `why_no_script` has nothing against it.

    Raises:
        WorkbenchError: as `Session` does.
    """

    def __init__(self, setup: Setup) -> None:
        scenario, vehicle, description = setup.scenario, setup.vehicle, setup.description
        self._setup, self.values = setup, setup.values
        self.why_not = why_not_compiled(setup)
        kinds = [each.sensor.kind for each in setup.sensors]
        heard = AIDING_SENSORS if setup.estimator else ()
        if any(kind not in heard or kinds.count(kind) > 1 for kind in kinds):
            self.why_not = "sensors that nothing but a log hears are not compiled"
        if setup.estimator and "gps" not in kinds:
            self.why_not = "what an estimator does without GPS is not compiled"
        if self.why_not:
            return
        log_setup(setup)
        self._around = reach_sphere(
            description.undrawn().model, description.base_link, description.rotors
        )
        engine = RolloutEngine.of(setup, threads=1)
        start, frame = scenario.start, thrust_frame(vehicle)
        state = body_state(
            p_WB=start_position(start, vehicle),
            roll_pitch_yaw=frame.roll_pitch_yaw(start.roll_pitch_yaw),
            v_WB=start.velocity,
            w_WB=start.angular_velocity,
        )
        self._planned = engine.plan(
            [{}], np.zeros(4), state, FlightSchedule(0, 0.0, 0, 1), None, None
        )
        air = AirSettings(*(self.values[name] for name in AirSettings._fields))
        flights = self._planned.flights
        flights["wind"] = steady_wind(air, 0.5 * setup.rates.control_period)
        self._kind = sample_dtype(flights.dtype)
        self._estimator = engine.senses.estimator if engine.senses else None
        self._fly = compiled_recorded(
            setup.controller, self._estimator, f"{flights.dtype} {self._kind}"
        )

    @property
    def is_kept(self) -> bool:
        """Whether there is machine code for it."""
        return self._fly.is_kept

    def fly(
        self,
        script: Sequence[Action],
        duration: float,
        progress: Callable[[float], None] | None = None,
    ) -> tuple[Recording | None, str]:
        """Return the recording of a flight; or None, and why the diagram has to fly it.

        Args:
            script: of velocities and yaw rates.
            duration: flown [s].
            progress: called with the flown share, 0 .. 1.
        """
        planned, period = self._planned, self._setup.rates.control_period
        updates = int(duration / period + 1e-6)
        references = self._references(script, updates)
        samples = np.zeros(updates + 1, self._kind)
        flights = planned.flights.copy()
        vehicles = planned.vehicles.chosen(planned.which)
        room, rings, times = (
            make_lane_workspace(len(self._setup.vehicle.rotors)),
            make_delay_rings(vehicles),
            make_lane_times(),
        )
        vehicles.furnish(room)
        sensors = planned.senses.inputs if planned.senses else None
        file = self._estimator.file if self._estimator else None
        count = max(1, round(SCRIPT_SLICE_S / period))
        for first in range(0, len(samples), count):
            part = slice(first, first + count)
            with user_code_errors(file, "update") if file else nullcontext():
                self._fly(
                    flights,
                    rings,
                    room,
                    times,
                    planned.clock,
                    sensors,
                    references[part],
                    first,
                    samples[part],
                )
            if 0 <= flights["lost_at"][0] <= updates:
                return None, "it is lost"
            if progress:
                progress(min(1.0, (first + count) / len(samples)))
        signals = self._signals(samples)
        if why_not := self._why_different(signals):
            return None, why_not
        every = round(self._setup.rates.record_period / period)
        time = period * np.arange(len(samples))[::every]
        kept = {name: values[::every] for name, values in signals.items()}
        return Recording.from_signals(self._setup.vehicle, time, kept), ""

    def _references(self, script: Sequence[Action], updates: int) -> np.ndarray:
        """Return the pilot's command from each control instant on (M, 8)."""
        rates, wish, rows = self._setup.rates, PilotCommand(), []
        waiting = sorted(script, key=lambda action: action.at)
        for instant in range(updates + 1):
            while waiting and acting_step(waiting[0].at, rates) <= instant * rates.control_steps:
                action = waiting.pop(0)
                wish = with_velocity_command(wish, action.velocity, action.yaw_rate)
            rows.append(wish.reference)
        return np.array(rows, dtype=float)

    def _signals(self, samples: np.ndarray) -> dict[str, np.ndarray]:
        """Return the signals of samples, as a recorder has them."""
        signals = {
            name: np.ascontiguousarray(samples[name]).reshape(len(samples), -1)
            for name in samples.dtype.names or ()
        }
        if self._estimator:
            memories = signals.pop("estimator")
            for name in ("deviations", "covariance", "innovations"):
                tell = getattr(self._estimator, name)
                signals[name] = np.array([tell(memory) for memory in memories])
        return signals

    def _why_different(self, signals: Mapping[str, np.ndarray]) -> str:
        """Return what happens in a flight that compiled code leaves out; "" for nothing."""
        period, around = self._setup.rates.control_period, self._around
        states = signals["state"]
        centres = [into_world(rotation(state[:4]), around.p_BC)[2] for state in states.tolist()]
        way = np.linalg.norm(states[:, 10:13], axis=1) * period + 0.5 * MAX_ACCELERATION * period**2
        if (states[:, 6] + centres - around.radius < way).any():
            return "it comes near the ground"
        if (signals["charge"] <= max(0.0, self.values["battery_reserve"])).any():
            return "its battery is low"
        if self._estimator and self._doubts(signals):
            return "its estimate is in doubt"
        return ""

    def _doubts(self, signals: Mapping[str, np.ndarray]) -> bool:
        """Return whether a flight mode may doubt the estimate, see `flight_mode.EstimateHealth`."""
        deviations = signals["deviations"]
        across = np.hypot(deviations[:, 3], deviations[:, 4])
        if (across > self.values["position_deviation_limit"]).any():
            return True
        if not (self._estimator and self._estimator.measured):
            return False
        gate = self.values.get("ekf_gate", np.inf)
        told = signals["innovations"].reshape(len(across), -1, 2)
        fields = self._planned.senses.inputs.periods if self._planned.senses else ()
        for kind, late in (("gps", MAX_GPS_AGE_S), ("magnetometer", MAX_HEADING_AGE_S)):
            channels = told[:, AIDING_USE_CHANNELS[kind][1]]
            good = (channels[:, :, 0] ** 2 <= gate**2 * channels[:, :, 1]).all(axis=1)
            used = np.flatnonzero(good)
            gaps = np.diff([0, *used, len(across)]) * self._setup.rates.control_period
            if fields[AIDING_SENSORS.index(kind)] > 0.0 and gaps.max() > late:
                return True
        return False
