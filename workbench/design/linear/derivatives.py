"""Exact derivatives of one control update, of the gyro, and of the vehicle in between."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from pydrake.autodiffutils import ExtractValue, InitializeAutoDiff

from workbench.common.own_file import own_errors
from workbench.control.controller import Controller
from workbench.control.flight_law import (
    ALL_PARTS,
    FILTERED,
    ComputerSettings,
    allocate,
    commanded_wrench,
    flight_law,
    known_vehicle,
    law_constants,
)
from workbench.control.guidance import Guidance, Setpoint
from workbench.design.linear.seeds import STATE, gradient, state_seeds, whole
from workbench.design.linear.update import Update, averaged
from workbench.design.linear.vehicle import Step, VehicleDerivatives
from workbench.diagram.core import full_supply, make_vehicle_core
from workbench.dynamics.rotors import loaded_voltage, power_share, static_thrusts
from workbench.estimation.filters import lowpass
from workbench.estimation.gyro import (
    STATES,
    GyroSettings,
    body_rates,
    filtered_rates,
    filters_gyro,
    gyro_filter,
    sample_steps,
    sensed,
    stepped_filters,
)
from workbench.estimation.imu import carried, mean_force
from workbench.plant.description import Description
from workbench.plant.loading import make_vehicle
from workbench.plant.payload import Payload, payload_of
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Rates
from workbench.systems.acceleration_estimate import sampled_estimate

REFERENCE = 4
HELD = 3
"""Commanded velocity and yaw rate, and the position held."""
HOLD_X = Guidance._fields.index("p_x")
Result = TypeVar("Result")


class Gyro(NamedTuple):
    """The filters of the gyro, and derivatives of a reading.

    Attributes:
        A: of the filters, from their states to those after a sample (12, 12).
        B: from the angular velocity in B (12, 3).
        C: from the states to the output (3, 12).
        D: from the angular velocity to the output (3, 3).
        rates_by: angular velocity in B by the motion (3, 12).
        sensed_by: sensed angular velocity in W, by the motion (3, 12).
        sensed_by_rates: the same by the output of the filters (3, 3).
        force_by: mean specific force between two samples in B, by the motions at both (3, 24).
        kept: of the accelerometer's low-pass, from its states to those after a sample (6, 6).
        taken: from a specific force to its states (6, 3).
        smooth: from its states to its output (3, 6).
        through: from a specific force to its output (3, 3).
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    rates_by: np.ndarray
    sensed_by: np.ndarray
    sensed_by_rates: np.ndarray
    force_by: np.ndarray
    kept: np.ndarray
    taken: np.ndarray
    smooth: np.ndarray
    through: np.ndarray


class Derivatives:
    """The vehicle and its law, as functions of numbers with derivatives.

    Its functions, which cache their last call: `update(state, filtered, before, reference,
    guidance, memory) -> Update`, see `averaged` for laws with slow parts; `whole_update`, the
    same with all parts; `settled_update`, that of a law without spin-up torque, as there is none in
    a steady flight;
    `slopes(state, speeds, commands)`, see `VehicleDerivatives`; `step(state, speeds, commands,
    yaw_rate) -> Step`, over a physics step; and `steady_commands(speeds)`, which returns the
    commands that keep rotors at speeds (n), and their derivatives. A battery is full.

    Args:
        controller: with the law that flies.
        flown: description of the flying vehicle, without its payload.
        vehicle: as known to the law, without its payload.
        gains: parameter values by name.
        rates: of physics and control.
    """

    def __init__(
        self,
        controller: Controller,
        flown: Description,
        vehicle: Vehicle,
        gains: Mapping[str, float],
        rates: Rates,
    ) -> None:
        self.controller = controller
        self._law = flight_law(controller)
        self._flown, self._vehicle = flown, vehicle
        self._rotors = make_vehicle(flown).rotors
        self._carry(payload_of(gains), gains)
        self._physics_step, self._control_period = rates.physics_step, rates.control_period
        self._whole = [1.0] * len(self._rotors)
        self._estimate = sampled_estimate(rates.control_period)
        self._supply, self._voltage = full_supply(vehicle, gains), 1.0
        self._air: tuple[float, ...] = ()
        self.update = LastCall(self._update)
        self.whole_update = LastCall(self._whole_update)
        self.settled_update = LastCall(self._settled_update)
        self.step = LastCall(self._step)
        self.slopes = LastCall(self._slopes)
        self.steady_commands = LastCall(self._steady_commands)
        self.gyro = LastCall(self._gyro)
        self.p_BI = (0.0, 0.0, 0.0)
        self.set_gains(gains)

    def set_gains(self, gains: Mapping[str, float]) -> None:
        """Set parameter values by name, of the law, the air and the payload.

        Raises:
            WorkbenchError: if the law cannot hover with its known payload.
        """
        payload = payload_of(gains)
        if payload != self._payload:
            self._carry(payload, gains)
        known, dt = known_vehicle(self._constants), self._control_period
        self._gains = self._settled = self.controller.gains(gains, known, dt)
        if gains["spin_up_feedforward"] and self._constants.spin_up_time:
            settled = {**gains, "spin_up_feedforward": 0.0}
            self._settled = self.controller.gains(settled, known, dt)
        self._settings = [gains[name] for name in ComputerSettings._fields]
        gyro = [gains[name] for name in GyroSettings._fields]
        steps = round(self._control_period / self._physics_step)
        self.gyro_every = sample_steps(gyro[0], self._physics_step, steps)
        self.gyro_filters = filters_gyro(gyro, self.gyro_every * self._physics_step)
        self._gyro_filter = gyro_filter(gyro, self.gyro_every * self._physics_step)
        self._accel_filter = lowpass(gyro[5], gyro[6], self.gyro_every * self._physics_step)
        self.gyro.forget()
        self.update.forget()
        self.whole_update.forget()
        self.settled_update.forget()
        supply = full_supply(self._vehicle, gains)
        air = (gains["drag_area"], gains["air_density"], *supply)
        if air != self._air:
            self._air, self._supply = air, supply
            self._plant.set_air(gains)
            self._voltage = self._voltage_at(self._vehicle.hover_speeds.tolist())
            self.step.forget()
            self.slopes.forget()
            self.steady_commands.forget()

    def _carry(self, payload: Payload, gains: Mapping[str, float]) -> None:
        """Add a payload to the flying vehicle, and to the one known to the law."""
        self._constants = law_constants(self._vehicle, payload)
        self._payload = payload
        self._plant = VehicleDerivatives(
            make_vehicle_core(self._flown, self._vehicle, gains), self._vehicle
        )
        self._air = ()

    def _voltage_at(self, speeds: Sequence[Any]) -> Any:
        """Return the voltage with rotors at speeds (n), over that of a full battery."""
        statics = static_thrusts(self._rotors, self._whole, speeds)
        return loaded_voltage(self._supply[0], self._supply[1], sum(map(power_share, statics)))

    def _update(self, *signals: np.ndarray) -> Update:
        dividers = self.controller.dividers
        if not dividers:
            return self.whole_update(*signals)
        return averaged(lambda count: self._updated(self._gains, count, *signals), dividers)

    def _whole_update(self, *signals: np.ndarray) -> Update:
        return self._updated(self._gains, ALL_PARTS, *signals)

    def _settled_update(self, *signals: np.ndarray) -> Update:
        if self._gains == self._settled:
            return self.whole_update(*signals)
        return self._updated(self._settled, ALL_PARTS, *signals)

    def _updated(
        self,
        gains: list[float],
        count: float,
        state: np.ndarray,
        filtered: np.ndarray,
        before: np.ndarray,
        reference: np.ndarray,
        guidance: np.ndarray,
        memory: np.ndarray,
    ) -> Update:
        """Return a control update.

        Args:
            gains: of the law.
            count: number of previous updates, see `ALL_PARTS`.
            state: of the body (13).
            filtered: states of the stages before the law, see `flight_law.FilterStates`.
            before: commands of the previous update (n).
            reference: see `guidance.Reference` (8).
            guidance: see `guidance.Guidance` (22).
            memory: of the law (k).
        """
        points, closed = len(self.controller.points), np.array(self.controller.closed)
        sizes = (STATE, FILTERED, before.size, REFERENCE, HELD, points, memory.size)
        columns = sum(sizes)
        seeds = np.split(np.eye(columns), np.cumsum(sizes)[:-1])
        asked = np.zeros((reference.size, columns))
        asked[:REFERENCE] = seeds[3]
        kept = np.zeros((guidance.size, columns))
        kept[HOLD_X : HOLD_X + HELD] = seeds[4]
        probes = np.zeros((closed.size, columns))
        probes[points:] = seeds[5]
        loops: list[Any] = [*_seeded(closed, probes), *[0.0] * points]
        commands = _seeded(before, seeds[2])
        with own_errors(self.controller.file, "update"):
            after, remembered = self._law.update(
                _seeded(state, state_seeds(state[:4]) @ seeds[0]),
                self._voltage,
                Setpoint(_seeded(reference, asked), _seeded(guidance, kept), (0.0, 0.0, 0.0)),
                gains,
                self._whole,
                self._constants,
                loops,
                self._estimate,
                self._settings,
                _seeded(filtered, seeds[1]),
                _seeded(memory, seeds[6]) if memory.size else [],
                commands,
                count,
            )
        return Update(
            ExtractValue(whole(commands)).ravel(),
            gradient(commands, columns),
            gradient(after, columns),
            ExtractValue(whole(remembered)).ravel() if memory.size else memory,
            gradient(remembered, columns) if memory.size else np.zeros((0, columns)),
            gradient(loops[closed.size :], columns),
        )

    def _slopes(
        self, state: np.ndarray, speeds: np.ndarray, commands: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        return self._plant.slopes(state, speeds, commands)

    def _step(
        self, state: np.ndarray, speeds: np.ndarray, commands: np.ndarray, yaw_rate: np.ndarray
    ) -> Step:
        """Return a physics step in a trimmed flight, see `VehicleDerivatives.step`."""
        return self._plant.step(state, speeds, commands, float(yaw_rate), self._physics_step)

    def _gyro(self, state: np.ndarray, last: np.ndarray) -> Gyro:
        """Return the gyro filters and derivatives at a state (13) and an acceleration (6)."""
        known = _seeded(state, state_seeds(state[:4]))
        w_B = body_rates(known)
        rates = ExtractValue(whole(w_B)).ravel()
        columns = STATE + 3
        seeds = np.eye(columns)
        moving = _seeded(state, state_seeds(state[:4]) @ seeds[:STATE])
        seen = gradient(sensed(moving, _seeded(rates, seeds[STATE:]))[7:10], columns)
        seeds = np.eye(STATES + 3)
        x, u = _seeded(np.zeros(STATES), seeds[:STATES]), _seeded(np.zeros(3), seeds[STATES:])
        after = gradient(stepped_filters(self._gyro_filter, x, u), STATES + 3)
        out = gradient(filtered_rates(self._gyro_filter, x, u), STATES + 3)
        return Gyro(
            A=after[:, :STATES],
            B=after[:, STATES:],
            C=out[:, :STATES],
            D=out[:, STATES:],
            rates_by=gradient(w_B, STATE),
            sensed_by=seen[:, :STATE],
            sensed_by_rates=seen[:, STATE:],
            force_by=self._force_by(state, last),
            kept=np.kron(np.eye(3), np.array(self._accel_filter[:4]).reshape(2, 2)),
            taken=np.kron(np.eye(3), np.array(self._accel_filter[4:6])[:, None]),
            smooth=np.kron(np.eye(3), np.array(self._accel_filter[6:8])[None, :]),
            through=self._accel_filter[8] * np.eye(3),
        )

    def _force_by(self, state: np.ndarray, last: np.ndarray) -> np.ndarray:
        """Return the derivatives of the force between two samples by the motions at both."""
        period = self.gyro_every * self._physics_step
        later = state.copy()
        later[10:13] += period * last[3:]
        seeds = np.eye(2 * STATE)
        before = _seeded(state, state_seeds(state[:4]) @ seeds[:STATE])
        now = _seeded(later, state_seeds(later[:4]) @ seeds[STATE:])
        ends = carried(before, self.p_BI), carried(now, self.p_BI)
        return gradient(mean_force(*ends, period), 2 * STATE)

    def sensed(self, gyro: Gyro, motion: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """Return rows of the motion (12) seen by a controller that uses the true motion.

        Args:
            gyro: at that point.
            motion: rows of the motion (12).
            rates: rows of the output of the gyro's filters (3).
        """
        seen = motion.copy()
        if self.gyro_filters:
            seen[6:9] = gyro.sensed_by @ motion + gyro.sensed_by_rates @ rates
        return seen

    def _steady_commands(self, speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the commands that keep rotors at speeds, and their derivatives (n, n)."""
        n = len(self._rotors)
        turning = _seeded(speeds, np.eye(n))
        share = self._voltage_at(turning)
        known = 1.0 + self._supply[2] * (share - 1.0)
        found = [speed / share * known for speed in turning]
        return ExtractValue(whole(found)).ravel(), gradient(found, n)

    def allocation_at(self, commands: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return derivatives of the wrench by commands (4, n), and of commands by it (n, 4).

        The wrench is the one that the law expects from commanded speeds, and commands are those of
        the allocation for it.
        """
        n = len(self._rotors)
        made = commanded_wrench(_seeded(commands, np.eye(n)), self._constants)
        asked = ExtractValue(whole(made)).ravel()
        speeds: list[Any] = [0.0] * n
        wanted = _seeded(asked, np.eye(asked.size))
        allocate(wanted, 1.0, 1.0, self._whole, self._constants, speeds)
        return gradient(made, n), gradient(speeds, asked.size)


def _seeded(values: np.ndarray, rows: np.ndarray) -> list[Any]:
    """Return numbers with derivatives."""
    return InitializeAutoDiff(values, rows).ravel().tolist()


class LastCall(Generic[Result]):
    """Caches the last call of a function of arrays.

    A live screen linearises the same hover repeatedly with other gains, where the part of the plant
    does not change.
    """

    def __init__(self, function: Callable[..., Result]) -> None:
        self._function = function
        self._result: tuple[bytes, Result] | None = None

    def __call__(self, *arrays: np.ndarray) -> Result:
        key = b"".join(array.tobytes() for array in arrays)
        if self._result is None or self._result[0] != key:
            self._result = (key, self._function(*arrays))
        return self._result[1]

    def forget(self) -> None:
        """Clear the cache."""
        self._result = None
