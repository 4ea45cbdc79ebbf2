"""Fly a scenario's script in compiled code, and record it as a session does."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext

import numpy as np

from workbench.common.own_file import own_errors
from workbench.control.flight_mode import GPS_LATE, HEADING_LATE
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.rollout.flights import Schedule, make_rings
from workbench.design.rollout.motion import make_room
from workbench.design.rollout.period import make_times
from workbench.design.rollout.recorded import compiled_recorded, sample_dtype
from workbench.design.rollout.senses import make_senses
from workbench.design.rollout.senses import why_not as why_not_sensed
from workbench.diagram.airframe import FASTEST_CHANGE
from workbench.diagram.sensor_choice import choose_sensors
from workbench.dynamics.air.settings import AirSettings
from workbench.dynamics.air.update import steady_wind
from workbench.dynamics.rigid_body import into_world, rotation
from workbench.estimation.settings import HEARD, TRUTH
from workbench.gains.gains import flight_gains, remark_on_owner
from workbench.plant.loading import make_vehicle
from workbench.plant.model import MOVING
from workbench.plant.placing import body_state
from workbench.plant.reach import reach
from workbench.plant.thrust_frame import thrust_frame
from workbench.scenario.configured import read_configured, tell_gyro_bias, tell_remarks
from workbench.scenario.scenario import Action, Scenario, check_scenario, flown_controller
from workbench.session.live_context import start_position
from workbench.session.recording import Recording
from workbench.session.script import acting_step
from workbench.systems.navigation import DECIDING
from workbench.systems.pilot import Wish, commanded

SLICE = 0.25
"""Time flown between two reports of the progress, as in a session [s]."""


def why_no_script(scenario: Scenario) -> str:
    """Return why a script cannot be flown in compiled code, whatever flies; "" if it can."""
    if not (law := flown_controller(scenario)).compiles:
        return f"{law.name} is not compiled"
    if scenario.start.mode != "hovering":
        return "a start on the ground is not compiled"
    if scenario.world != Scenario.world:
        return f"the world {scenario.world} is not compiled"
    if scenario.figure_eight:
        return "a figure of eight is not compiled"
    every = scenario.rates.record_period / scenario.rates.control_period
    if every < 1.0 or not every.is_integer():
        return "compiled code records at control updates only"
    for action in scenario.script:
        others = action.go_to, action.request, action.gust, action.push, action.injection
        if action.set or action.controller or any(each is not None for each in others):
            return "a script with more than velocities and yaw rates is not compiled"
    return ""


class ScriptedFlight:
    """Flights in compiled code of a scenario, and of others that differ in script and duration.

    Attributes:
        values: of all parameters, by name.
        why_not: why the scenario is not compiled, "" if it is.

    Args:
        scenario: what to fly, at its own period; `why_no_script` has nothing against it.
        settings: parameter values that override those of the scenario's gains.

    Raises:
        WorkbenchError: as `Session` does.
    """

    def __init__(self, scenario: Scenario, settings: Mapping[str, float]) -> None:
        check_scenario(scenario)
        description = read_configured(scenario.vehicle)
        vehicle = make_vehicle(description)
        law = flown_controller(scenario)
        self.values = flight_gains(vehicle, scenario.vehicle.gains, settings, law)
        self._scenario, self._vehicle = scenario, vehicle
        self.why_not = why_not_sensed(vehicle, scenario, self.values)
        if any(joint.kind in MOVING for joint in description.model.joints):
            self.why_not = "joints that move in flight are not compiled"
        if any(
            self.values.get(f"rotor_{1 + number}") == 0.0 for number in range(len(vehicle.rotors))
        ):
            self.why_not = "a lost rotor is not compiled, as its mixer makes rounding visible"
        kinds = [each.sensor.kind for each in choose_sensors(vehicle, scenario)]
        heard = HEARD if scenario.estimator != TRUTH else ()
        if any(kind not in heard or kinds.count(kind) > 1 for kind in kinds):
            self.why_not = "sensors that nothing but a log hears are not compiled"
        if scenario.estimator != TRUTH and "gps" not in kinds:
            self.why_not = "what an estimator does without GPS is not compiled"
        if self.why_not:
            return
        tell_remarks(description, vehicle)
        tell_gyro_bias(vehicle, scenario, self.values)
        remark_on_owner(scenario.vehicle.gains, vehicle.name, law)
        self._around = reach(description.undrawn().model, description.base_link, description.rotors)
        engine = RolloutEngine(
            vehicle,
            scenario.rates,
            scenario.vehicle.variation,
            seed=scenario.sensors.seed,
            threads=1,
            own=self.values,
            controller=law,
            senses=make_senses(vehicle, scenario),
        )
        start, frame = scenario.start, thrust_frame(vehicle)
        state = body_state(
            p_WB=start_position(start, vehicle),
            roll_pitch_yaw=frame.roll_pitch_yaw(start.roll_pitch_yaw),
            v_WB=start.velocity,
            w_WB=start.angular_velocity,
        )
        self._planned = engine.plan([{}], np.zeros(4), state, Schedule(0, 0.0, 0, 1), None, None)
        air = AirSettings(*(self.values[name] for name in AirSettings._fields))
        flights = self._planned.flights
        flights["wind"] = steady_wind(air, 0.5 * scenario.rates.control_period)
        self._kind = sample_dtype(flights.dtype)
        self._estimator = engine.senses.estimator if engine.senses else None
        self._fly = compiled_recorded(law, self._estimator, f"{flights.dtype} {self._kind}")

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
        planned, period = self._planned, self._scenario.rates.control_period
        updates = int(duration / period + 1e-6)
        references = self._references(script, updates)
        samples = np.zeros(updates + 1, self._kind)
        flights = planned.flights.copy()
        crafts = planned.crafts.chosen(planned.which)
        room, rings, times = make_room(len(self._vehicle.rotors)), make_rings(crafts), make_times()
        crafts.furnish(room)
        sensors = planned.senses.hearing if planned.senses else None
        file = self._estimator.file if self._estimator else None
        count = max(1, round(SLICE / period))
        for first in range(0, len(samples), count):
            part = slice(first, first + count)
            with own_errors(file, "update") if file else nullcontext():
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
        every = round(self._scenario.rates.record_period / period)
        time = period * np.arange(len(samples))[::every]
        kept = {name: values[::every] for name, values in signals.items()}
        return Recording.from_signals(self._vehicle, time, kept), ""

    def _references(self, script: Sequence[Action], updates: int) -> np.ndarray:
        """Return the pilot's command from each control instant on (M, 8)."""
        rates, wish, rows = self._scenario.rates, Wish(), []
        waiting = sorted(script, key=lambda action: action.at)
        for instant in range(updates + 1):
            while waiting and acting_step(waiting[0].at, rates) <= instant * rates.control_steps:
                action = waiting.pop(0)
                wish = commanded(wish, action.velocity, action.yaw_rate)
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
        period, around = self._scenario.rates.control_period, self._around
        states = signals["state"]
        centres = [into_world(rotation(state[:4]), around.p_BC)[2] for state in states.tolist()]
        way = np.linalg.norm(states[:, 10:13], axis=1) * period + 0.5 * FASTEST_CHANGE * period**2
        if (states[:, 6] + centres - around.radius < way).any():
            return "it comes near the ground"
        if (signals["charge"] <= max(0.0, self.values["battery_reserve"])).any():
            return "its battery is low"
        if self._estimator and self._doubts(signals):
            return "its estimate is in doubt"
        return ""

    def _doubts(self, signals: Mapping[str, np.ndarray]) -> bool:
        """Return whether a flight mode may doubt the estimate, see `flight_mode.Health`."""
        deviations = signals["deviations"]
        across = np.hypot(deviations[:, 3], deviations[:, 4])
        if (across > self.values["position_deviation_limit"]).any():
            return True
        if not (self._estimator and self._estimator.measured):
            return False
        gate = self.values.get("ekf_gate", np.inf)
        told = signals["innovations"].reshape(len(across), -1, 2)
        fields = self._planned.senses.hearing.periods if self._planned.senses else ()
        for kind, late in (("gps", GPS_LATE), ("magnetometer", HEADING_LATE)):
            channels = told[:, DECIDING[kind][1]]
            good = (channels[:, :, 0] ** 2 <= gate**2 * channels[:, :, 1]).all(axis=1)
            used = np.flatnonzero(good)
            gaps = np.diff([0, *used, len(across)]) * self._scenario.rates.control_period
            if fields[HEARD.index(kind)] > 0.0 and gaps.max() > late:
                return True
        return False
