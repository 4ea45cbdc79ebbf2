"""The IMU of the flight computer: samples of gyro and accelerometer, their filters, and readings.

Once a control period it takes the samples of the period that ends, as many as its rate asks for. A
sample is the angular velocity at its time, and the mean specific force since the sample before. The
motion between the two ends is that of `dynamics.motion_between`, so the integrator need not stop at
each sample. A reading is the mean of both in the period: of the angular velocity the turn of the
body, and the mean noise. Without an IMU there is an exact gyro alone, and its filters.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from workbench.common.vectors import Numbers
from workbench.dynamics.motion_between import (
    body_rate,
    mean_specific_force,
    motions_between,
    point_motion,
)
from workbench.estimation.filters import filter_is_on, lowpass, mean_smoothed
from workbench.estimation.gyro import (
    GyroSettings,
    filtered_rates,
    filters_gyro,
    gyro_filter,
    sample_steps,
    state_body_rates,
    steady_gyro_states,
    stepped_filters,
    with_sensed_rates,
)
from workbench.estimation.imu import (
    IMU_NOISE_SOURCE,
    drawn_imu_bias,
    ideal_imu_sample,
    imu_noise,
    imu_noise_rows,
    mean_rate,
    next_drift,
)
from workbench.plant.faults import Fault
from workbench.plant.gravity import GRAVITY
from workbench.plant.sensors import Imu
from workbench.systems.cached import cached
from workbench.systems.discrete_system import DiscreteSystem
from workbench.systems.noise import noise_seed

UPDATE_TIME_TOLERANCE = 1e-6
"""Largest share of a physics step by which an update is off its time."""


class _Sampling(NamedTuple):
    """How samples are taken: physics steps between two, what of them is filtered, and the filters.

    Attributes:
        gyro: coefficients of the gyro's filters, see `gyro_filter`.
        accel: of the accelerometer's low-pass, see `lowpass`.
    """

    steps: int
    filters_gyro: bool
    filters_force: bool
    gyro: Sequence[float]
    accel: Sequence[float]


class ImuPeriodSamples(NamedTuple):
    """What the samples of a period lead to.

    Attributes:
        gyro_filters: states of the gyro's filters (12).
        rates: filtered angular velocity in B (3) [rad/s].
        accel_filters: states of the low-pass of the accelerometer (6).
        last: sample (6): angular velocity [rad/s], specific force [m/s²].
        reading: the mean of both (6).
    """

    gyro_filters: Sequence[float]
    rates: Sequence[float]
    accel_filters: Sequence[float]
    last: Sequence[float]
    reading: Sequence[float]


class FlightImu(DiscreteSystem):
    """Samples the motion of the body.

    Input ports:
        state (13): of the body: q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        acceleration (6): angular, and of the origin, in W [rad/s², m/s²]; for the first sample,
            which has none before it; only with an IMU.
    Output ports:
        sensed (13): the state with the gyro's filtered angular velocity.
        imu (9): mean angular velocity [rad/s] and specific force [m/s²] since the last reading, and
            filtered angular velocity, in B; between updates those of the last one; only with an
            IMU.
    Discrete state: see `ImuPeriodSamples`; the biases (6) and their drift (6); of the last update
    the motion of the IMU (14), see `point_motion`, and the number in physics steps (1), -1 without
    a sample. Numeric parameters: `GyroSettings`, the fault of the IMU, and the seed of its noise.

    Args:
        settings: initial ones.
        step: of the physics, of which all times are multiples [s].
        readout: steps between two readings.
        imu: its noise and place; None for an exact gyro.
    """

    def __init__(
        self, *, settings: GyroSettings, step: float, readout: int, imu: Imu | None = None
    ) -> None:
        super().__init__()
        self._step, self._readout = step, readout
        self._imu, self._p_BS = imu, imu.p_BS if imu else (0.0, 0.0, 0.0)
        self._noise = imu_noise(imu, step, readout * step) if imu else None
        self.settings_index = int(self.DeclareNumericParameter(BasicVector(list(settings))))
        self.fault_index = int(self.DeclareNumericParameter(BasicVector([0.0])))
        self._seed = self.DeclareNumericParameter(BasicVector([0.0]))
        self._state = self.DeclareVectorInputPort("state", 13)
        self._gyro_filters = self.DeclareDiscreteState(12)
        self._rates = self.DeclareDiscreteState(3)
        self._accel_filters = self.DeclareDiscreteState(6)
        self._last = self.DeclareDiscreteState(6)
        self._reading = self.DeclareDiscreteState(6)
        self._bias = self.DeclareDiscreteState(6)
        self._drift = self.DeclareDiscreteState(6)
        self._motion = self.DeclareDiscreteState(14)
        self._number = self.DeclareDiscreteState(1)
        needs = {self._state.ticket(), self.xd_ticket(), self.time_ticket(), self.pn_ticket()}
        if imu:
            self._acceleration = self.DeclareVectorInputPort("acceleration", 6)
            needs |= {self._acceleration.ticket()}
        self.DeclareVectorOutputPort("sensed", 13, self._calc_sensed, needs)
        if imu:
            self.DeclareVectorOutputPort("imu", 9, self._calc_imu, needs)
        self._sampled = cached(self._calc_sampled, "sampling", {self.pn_ticket()})
        self._samples = cached(self._calc_samples, "samples", needs)
        self.DeclarePeriodicDiscreteUpdateEvent(readout * step, 0.0, self._update)

    def set_seed(self, context: Context, seed: int) -> None:
        """Set the seed of the noise; equal seeds give equal noise."""
        own = float(noise_seed(seed, IMU_NOISE_SOURCE))
        context.get_mutable_numeric_parameter(self._seed).SetAtIndex(0, own)

    def begin(self, context: Context, state: np.ndarray) -> None:
        """Begin at a state of the body (13)."""
        rates = state_body_rates(state)
        for group in range(context.num_discrete_state_groups()):
            context.SetDiscreteState(group, np.zeros(context.get_discrete_state(group).size()))
        context.SetDiscreteState(self._gyro_filters, steady_gyro_states(rates))
        context.SetDiscreteState(self._rates, rates)
        context.SetDiscreteState(self._number, [-1.0])

    def _values(self, context: Context, group: int) -> list[float]:
        return context.get_discrete_state(group).value().tolist()

    def _calc_sampled(self, context: Context) -> _Sampling:
        live = context.get_numeric_parameter(self.settings_index).value()
        settings = GyroSettings(*live.tolist())
        steps = sample_steps(settings.gyro_rate, self._step, self._readout)
        period = steps * self._step
        return _Sampling(
            steps,
            filters_gyro(settings, period),
            filter_is_on(settings.accel_lowpass, period),
            gyro_filter(settings, period),
            lowpass(settings.accel_lowpass, settings.accel_lowpass_order, period),
        )

    def _began(self, context: Context) -> bool:
        """Return whether the last update took a sample."""
        return self._values(context, self._number)[0] >= 0.0

    def _is_due(self, context: Context) -> bool:
        """Return whether an update is due now that has not been done."""
        updates = context.get_time() / (self._readout * self._step)
        passed = self._passed(context)
        return abs(updates - round(updates)) < UPDATE_TIME_TOLERANCE and (
            passed < 0.0 or passed > UPDATE_TIME_TOLERANCE
        )

    def _passed(self, context: Context) -> float:
        """Return the physics steps since the last update, negative if it took no sample."""
        number = self._values(context, self._number)[0]
        return context.get_time() / self._step - number if number >= 0.0 else -1.0

    def _count(self, context: Context) -> int:
        """Return the number of samples since the last update, up to now."""
        passed = self._passed(context)
        return (
            math.floor(passed / self._sampled(context).steps + UPDATE_TIME_TOLERANCE)
            if passed >= 0.0
            else 1
        )

    def _calc_samples(self, context: Context) -> ImuPeriodSamples:
        """Return what the samples since the last update lead to."""
        fault = context.get_numeric_parameter(self.fault_index)[0]
        if self._began(context) and fault in (Fault.FROZEN, Fault.SILENT):
            last = self._values(context, self._last)
            return self._filtered(context, np.tile(last, (self._count(context), 1)), last[0:3])
        samples, turn = self._exact(context)
        if self._imu is not None:
            noise = self._drawn(context, fault)
            turn = turn + noise[:, 0:3].mean(axis=0)
            # of what one exact sample stands for: the last rate, and the mean force
            each = noise.reshape(len(samples), -1, 6)
            samples[:, 0:3] += each[:, -1, 0:3]
            samples[:, 3:6] += each[:, :, 3:6].mean(axis=1)
        return self._filtered(context, samples, turn)

    def _exact(self, context: Context) -> tuple[np.ndarray, np.ndarray]:
        """Return exact samples (K, 6), and the mean angular velocity in B (3).

        Where nothing is filtered, two stand for all.
        """
        state = self._state.Eval(context).tolist()
        if not self._began(context):
            rates, force = state_body_rates(state), (0.0, 0.0, 0.0)
            if self._imu is not None:
                acceleration = self._acceleration.Eval(context).tolist()
                force = ideal_imu_sample(state, acceleration, self._p_BS)[3:6]
            return np.array([[*rates, *force]]), np.array(rates)
        passed, count, found = self._passed(context), self._count(context), self._sampled(context)
        before, now = self._values(context, self._motion), point_motion(state, self._p_BS)
        filtered = found.filters_gyro or found.filters_force
        parts = count if filtered else math.gcd(count, 2)
        steps, period = found.steps * count / parts, passed * self._step
        ends, middles = motions_between(before, now, period, parts, steps / passed).tolist()
        forces = [(0.0, 0.0, 0.0)] * len(ends)
        if self._imu is not None:
            forces = [
                mean_specific_force(*three, steps * self._step, GRAVITY)
                for three in zip([before, *ends[:-1]], middles, ends, strict=True)
            ]
        samples = [(*body_rate(end), *force) for end, force in zip(ends, forces, strict=True)]
        return np.array(samples), np.array(mean_rate(before[0:4], now[0:4], period))

    def _drawn(self, context: Context, fault: float) -> np.ndarray:
        """Return bias and noise of the samples since the last update, in B (K, 6)."""
        assert self._imu and self._noise  # who asks has them
        steps = self._sampled(context).steps
        numbers = np.array([round(context.get_time() / self._step)])
        if self._began(context):
            number = round(self._values(context, self._number)[0])
            numbers = number + steps * np.arange(1, self._count(context) + 1)
        bias = np.add(self._begun_bias(context), self._values(context, self._drift))
        seed = context.get_numeric_parameter(self._seed)[0]
        return imu_noise_rows(self._noise, numbers, steps, fault, bias, seed, self._imu.R_BS)

    def _begun_bias(self, context: Context) -> Sequence[float]:
        """Return the biases of the flight (6), which are drawn at the first update."""
        if self._began(context):
            return self._values(context, self._bias)
        assert self._noise
        with np.errstate(over="ignore"):  # integers of the noise wrap around
            seed = context.get_numeric_parameter(self._seed)[0]
            return drawn_imu_bias(self._noise.mean, self._noise.spread, seed)

    def _filtered(self, context: Context, samples: np.ndarray, turn: Numbers) -> ImuPeriodSamples:
        """Return what samples (K, 6) lead to, given the mean of the angular velocity (3)."""
        rows: list[list[float]] = samples.tolist()
        began, found = self._began(context), self._sampled(context)
        filters: Sequence[float] = steady_gyro_states(rows[0][0:3])
        if began:
            filters = self._values(context, self._gyro_filters)
        before = filters
        for row in rows:
            before, filters = filters, stepped_filters(found.gyro, filters, row[0:3])
        rates = filtered_rates(found.gyro, before, rows[-1][0:3])
        if self._imu is None:
            return ImuPeriodSamples(filters, rates, [0.0] * 6, rows[-1], [0.0] * 6)
        accel = self._values(context, self._accel_filters)
        if not began:
            accel = [0.0, rows[0][3], 0.0, rows[0][4], 0.0, rows[0][5]]
        force, accel = mean_smoothed(found.accel, accel, [row[3:6] for row in rows])
        return ImuPeriodSamples(filters, rates, accel, rows[-1], [*turn, *force])

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        if self._imu is None and not self._sampled(context).filters_gyro:
            if self._began(context):
                discrete_state.set_value(self._number, [-1.0])
            return
        samples = self._samples(context)
        groups = (self._gyro_filters, self._rates, self._accel_filters, self._last, self._reading)
        for group, values in zip(groups, samples, strict=True):
            discrete_state.set_value(group, values)
        number = round(context.get_time() / self._step)
        motion = point_motion(self._state.Eval(context).tolist(), self._p_BS)
        discrete_state.set_value(self._motion, motion)
        discrete_state.set_value(self._number, [number])
        if self._noise is None:
            return
        discrete_state.set_value(self._bias, self._begun_bias(context))
        drift, seed = self._values(context, self._drift), context.get_numeric_parameter(self._seed)
        discrete_state.set_value(self._drift, next_drift(self._noise, drift, number, seed[0]))

    def _calc_sensed(self, context: Context, output_vector: BasicVector) -> None:
        state = self._state.Eval(context)
        if not self._sampled(context).filters_gyro:
            output_vector.SetFromVector(state)
            return
        rates: Sequence[float] = self._values(context, self._rates)
        if self._count(context):
            rates = self._samples(context).rates
        output_vector.SetFromVector(with_sensed_rates(state.tolist(), rates))

    def _calc_imu(self, context: Context, output_vector: BasicVector) -> None:
        if self._is_due(context):
            samples = self._samples(context)
            output_vector.SetFromVector([*samples.reading, *samples.rates])
        else:
            held = [self._values(context, group) for group in (self._reading, self._rates)]
            output_vector.SetFromVector(sum(held, []))
