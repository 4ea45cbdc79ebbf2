"""Exact derivatives of one control update, of the gyro, and of the vehicle in between."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from pydrake.autodiffutils import ExtractValue, InitializeAutoDiff

from workbench.common.own_file import user_code_errors
from workbench.control.flight_law import (
    ALL_PARTS,
    ComputerSettings,
    allocate,
    commanded_wrench,
    flight_law,
)
from workbench.control.guidance import Guidance, LawSetpoint
from workbench.control.law_constants import known_vehicle, law_constants
from workbench.control.law_signals import FILTER_STATE_COUNT
from workbench.design.linear.last_call import LastCall
from workbench.design.linear.seeds import MOTION_STATE_SIZE, autodiff_values, gradient, state_seeds
from workbench.design.linear.setpoint_filter import SetpointFilter
from workbench.design.linear.update import ControlUpdate, averaged_update
from workbench.design.linear.vehicle import (
    HeldCommandStep,
    VehicleDerivatives,
    built_in_values,
)
from workbench.diagram.core import full_supply, make_vehicle_core
from workbench.dynamics.rotors import loaded_voltage, power_share, static_thrusts
from workbench.estimation.filters import lowpass
from workbench.estimation.gyro import (
    GYRO_STATE_COUNT,
    GyroSettings,
    filtered_rates,
    filters_gyro,
    gyro_filter,
    sample_steps,
    state_body_rates,
    stepped_filters,
    with_sensed_rates,
)
from workbench.estimation.imu import imu_velocity_state, mean_force
from workbench.plant.payload import payload_of
from workbench.setup import Setup
from workbench.systems.acceleration_estimate import sampled_estimate

REFERENCE_SIZE = 4
HELD_SIZE = 3
"""Commanded velocity and yaw rate, and the position held."""
HOLD_X_INDEX = Guidance._fields.index("p_x")


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
    guidance, memory) -> Update`, see `averaged_update` for laws with slow parts; `whole_update`,
    the same with all parts; `settled_update`, that of a law without spin-up torque, as there is
    none in a steady flight; `slopes(state, speeds, commands, joints)`, see
    `VehicleDerivatives`; `step(state, speeds, commands, joints, yaw_rate) -> HeldCommandStep`, over
    a physics step; and `steady_commands(speeds)`, which returns the commands that keep rotors at
    speeds (n), and their derivatives. A battery is full.

    Args:
        setup: what flies.
        like: others, whose plant is used if it is the same: it depends neither on rates nor on
            sensors, and takes most of the time to make.

    Attributes:
        vehicle: as its law knows it, without loads that open hooks have dropped.
        plant: derivatives of the vehicle alone, for the present `built_in_values`.
    """

    def __init__(self, setup: Setup, like: "Derivatives | None" = None) -> None:
        gains, rates = setup.values, setup.rates
        self._setup, self.vehicle, self.controller = setup, setup.vehicle, setup.controller
        self._law = flight_law(self.controller)
        shared = like if like and like.has_plant_of(setup) else None
        self._flown = shared._flown if shared else setup.flown_vehicle
        self._carry(gains, shared.plant if shared else None)
        self._physics_step, self._control_period = rates.physics_step, rates.control_period
        self._whole = [1.0] * len(self._flown.rotors)
        self._estimate = sampled_estimate(rates.control_period)
        self._supply, self._voltage = full_supply(setup.vehicle, gains), 1.0
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
        if built_in_values(self.controller, gains) != self._built_in:
            self._carry(gains)
        known, dt = known_vehicle(self._constants), self._control_period
        self._gains = self._settled = self.controller.gains(gains, known, dt)
        if gains["spin_up_feedforward"] and self._constants.spin_up_time:
            settled = {**gains, "spin_up_feedforward": 0.0}
            self._settled = self.controller.gains(settled, known, dt)
        self._settings = [gains[name] for name in ComputerSettings._fields]
        gyro = GyroSettings(*(gains[name] for name in GyroSettings._fields))
        steps = round(self._control_period / self._physics_step)
        self.gyro_every = sample_steps(gyro.gyro_rate, self._physics_step, steps)
        sample_period = self.gyro_every * self._physics_step
        self.gyro_filters = filters_gyro(gyro, sample_period)
        self._gyro_filter = gyro_filter(gyro, sample_period)
        self._accel_filter = lowpass(gyro.accel_lowpass, gyro.accel_lowpass_order, sample_period)
        for known_call in (self.gyro, self.update, self.whole_update, self.settled_update):
            known_call.forget()
        supply = full_supply(self._setup.vehicle, gains)
        air = (gains["drag_area"], gains["air_density"], *supply)
        if air != self._air:
            self._air, self._supply, self._air_gains = air, supply, dict(gains)
            self._voltage = self._voltage_at(self.vehicle.hover_speeds.tolist())
            for known_call in (self.step, self.slopes, self.steady_commands):
                known_call.forget()

    def _carry(self, gains: Mapping[str, float], plant: VehicleDerivatives | None = None) -> None:
        """Let vehicle and law carry what parameter values say.

        Args:
            gains: parameter values by name, of which those of `built_in_values` are used.
            plant: derivatives of that vehicle, if already made.
        """
        own = self._setup  # as it is, its vehicles are made already
        setup = (own if gains is own.values else replace(own, values=gains)).without_dropped_loads()
        self._constants = law_constants(setup.vehicle, payload_of(gains))
        self.vehicle, self._built_in = setup.vehicle, built_in_values(self.controller, gains)
        self.plant = plant or VehicleDerivatives(
            make_vehicle_core(setup), setup.vehicle, self.controller.servos, self._setup.vehicle
        )
        self._air = ()

    def has_plant_of(self, setup: Setup) -> bool:
        """Return whether the plant is that of a setup, whatever its law, rates and sensors."""
        own = self._setup
        return (
            own.description is setup.description
            and own.vehicle is setup.vehicle
            and own.variation == setup.variation
            and self.controller.servos == setup.controller.servos
            and self._built_in == built_in_values(setup.controller, setup.values)
        )

    @property
    def commanded_joints(self) -> tuple[str, ...]:
        """Joints whose servos the law commands, in the order of its commands."""
        return self.plant.commanded_joints

    @property
    def setpoint_filter(self) -> SetpointFilter:
        """What delays and low-passes the setpoints of those servos."""
        servos = {each.joint: each for each in self._flown.servos}
        commanded = [servos[joint] for joint in self.commanded_joints]
        return SetpointFilter(commanded, len(self._flown.rotors), self._control_period)

    @property
    def measured_joints(self) -> np.ndarray:
        """Places of what the law measures of joints among their states (h)."""
        return self.plant.measured_joints

    def _voltage_at(self, speeds: Sequence[float]) -> float:
        """Return the voltage with rotors at speeds (n), over that of a full battery."""
        statics = static_thrusts(self._flown.rotors, self._whole, speeds)
        return loaded_voltage(self._supply[0], self._supply[1], sum(map(power_share, statics)))

    def _update(self, *signals: np.ndarray) -> ControlUpdate:
        dividers = self.controller.dividers
        if not dividers:
            return self.whole_update(*signals)
        return averaged_update(lambda count: self._updated(self._gains, count, *signals), dividers)

    def _whole_update(self, *signals: np.ndarray) -> ControlUpdate:
        return self._updated(self._gains, ALL_PARTS, *signals)

    def _settled_update(self, *signals: np.ndarray) -> ControlUpdate:
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
    ) -> ControlUpdate:
        """Return a control update.

        Args:
            gains: of the law.
            count: number of previous updates, see `ALL_PARTS`.
            state: of the body (13), and what the law measures of joints (h).
            filtered: states of the stages before the law, see `law_signals.FilterStates`.
            before: commands of the previous update (c).
            reference: see `guidance.Reference` (8).
            guidance: see `guidance.Guidance` (22).
            memory: of the law (k).
        """
        points, closed = len(self.controller.points), np.array(self.controller.closed)
        sizes = (
            MOTION_STATE_SIZE + self.measured_joints.size,
            FILTER_STATE_COUNT,
            before.size,
            REFERENCE_SIZE,
            HELD_SIZE,
            points,
            memory.size,
        )
        columns = sum(sizes)
        seeds = np.split(np.eye(columns), np.cumsum(sizes)[:-1])
        asked = np.zeros((reference.size, columns))
        asked[:REFERENCE_SIZE] = seeds[3]
        kept = np.zeros((guidance.size, columns))
        kept[HOLD_X_INDEX : HOLD_X_INDEX + HELD_SIZE] = seeds[4]
        probes = np.zeros((closed.size, columns))
        probes[points:] = seeds[5]
        loops: list[Any] = [*_seeded(closed, probes), *[0.0] * points]
        commands = _seeded(before, seeds[2])
        with user_code_errors(self.controller.file, "update"):
            after, remembered = self._law.update(
                _seeded(
                    state,
                    np.vstack(
                        [
                            state_seeds(state[:4]) @ seeds[0][:MOTION_STATE_SIZE],
                            seeds[0][MOTION_STATE_SIZE:],
                        ]
                    ),
                ),
                self._voltage,
                LawSetpoint(_seeded(reference, asked), _seeded(guidance, kept), (0.0, 0.0, 0.0)),
                gains,
                self._constants,
                loops,
                self._estimate,
                self._settings,
                _seeded(filtered, seeds[1]),
                _seeded(memory, seeds[6]) if memory.size else [],
                commands,
                count,
            )
        return ControlUpdate(
            ExtractValue(autodiff_values(commands)).ravel(),
            gradient(commands, columns),
            gradient(after, columns),
            ExtractValue(autodiff_values(remembered)).ravel() if memory.size else memory,
            gradient(remembered, columns) if memory.size else np.zeros((0, columns)),
            gradient(loops[closed.size :], columns),
        )

    def _slopes(
        self, state: np.ndarray, speeds: np.ndarray, commands: np.ndarray, joints: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        self.plant.set_air(self._air_gains)  # others may have set theirs
        return self.plant.slopes(state, speeds, commands, joints)

    def _step(
        self,
        state: np.ndarray,
        speeds: np.ndarray,
        commands: np.ndarray,
        joints: np.ndarray,
        yaw_rate: np.ndarray,
    ) -> HeldCommandStep:
        """Return a physics step in a trimmed flight, see `VehicleDerivatives.step`."""
        self.plant.set_air(self._air_gains)  # others may have set theirs
        return self.plant.step(state, speeds, commands, joints, float(yaw_rate), self._physics_step)

    def _gyro(self, state: np.ndarray, last: np.ndarray) -> Gyro:
        """Return the gyro filters and derivatives at a state (13) and an acceleration (6)."""
        known = _seeded(state, state_seeds(state[:4]))
        w_B = state_body_rates(known)
        rates = ExtractValue(autodiff_values(w_B)).ravel()
        columns = MOTION_STATE_SIZE + 3
        seeds = np.eye(columns)
        moving = _seeded(state, state_seeds(state[:4]) @ seeds[:MOTION_STATE_SIZE])
        seen = gradient(
            with_sensed_rates(moving, _seeded(rates, seeds[MOTION_STATE_SIZE:]))[7:10], columns
        )
        seeds = np.eye(GYRO_STATE_COUNT + 3)
        x, u = (
            _seeded(np.zeros(GYRO_STATE_COUNT), seeds[:GYRO_STATE_COUNT]),
            _seeded(np.zeros(3), seeds[GYRO_STATE_COUNT:]),
        )
        after = gradient(stepped_filters(self._gyro_filter, x, u), GYRO_STATE_COUNT + 3)
        out = gradient(filtered_rates(self._gyro_filter, x, u), GYRO_STATE_COUNT + 3)
        return Gyro(
            A=after[:, :GYRO_STATE_COUNT],
            B=after[:, GYRO_STATE_COUNT:],
            C=out[:, :GYRO_STATE_COUNT],
            D=out[:, GYRO_STATE_COUNT:],
            rates_by=gradient(w_B, MOTION_STATE_SIZE),
            sensed_by=seen[:, :MOTION_STATE_SIZE],
            sensed_by_rates=seen[:, MOTION_STATE_SIZE:],
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
        seeds = np.eye(2 * MOTION_STATE_SIZE)
        before = _seeded(state, state_seeds(state[:4]) @ seeds[:MOTION_STATE_SIZE])
        now = _seeded(later, state_seeds(later[:4]) @ seeds[MOTION_STATE_SIZE:])
        ends = imu_velocity_state(before, self.p_BI), imu_velocity_state(now, self.p_BI)
        return gradient(mean_force(*ends, period), 2 * MOTION_STATE_SIZE)

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
        n = len(self._flown.rotors)
        turning = _seeded(speeds, np.eye(n))
        share = self._voltage_at(turning)
        known = 1.0 + self._supply[2] * (share - 1.0)
        found = [speed / share * known for speed in turning]
        return ExtractValue(autodiff_values(found)).ravel(), gradient(found, n)

    def allocation_at(self, commands: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return derivatives of the wrench by commands (4, c), and of commands by it (c, 4).

        The wrench is the one that the law expects from commanded speeds, and commands are those of
        the allocation for it.
        """
        n = commands.size
        made = commanded_wrench(_seeded(commands, np.eye(n)), self._constants)
        asked = ExtractValue(autodiff_values(made)).ravel()
        speeds: list[Any] = [0.0] * n
        force, m_x, m_y, m_z = _seeded(asked, np.eye(asked.size))
        allocate((force, m_x, m_y, m_z), 1.0, 1.0, self._constants, speeds)
        return gradient(made, n), gradient(speeds, asked.size)


def _seeded(values: np.ndarray, rows: np.ndarray) -> list[Any]:
    """Return numbers with derivatives."""
    return InitializeAutoDiff(values, rows).ravel().tolist()
