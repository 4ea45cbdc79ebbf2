"""The IMU of the flight computer: samples of gyro and accelerometer, their filters, and readings.

A sample is the angular velocity at its time, and the mean specific force since the sample before,
see `estimation.imu.mean_force`. A reading is the mean of both since the reading before, once a
control period: of the angular velocity by the trapezoidal rule, with what that misses of the turn
in an impact. Without an IMU there is an exact gyro alone, and its filters.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    LeafSystem,
    ValueProducer,
)

from workbench.estimation.filters import after, lowpass, output, works
from workbench.estimation.gyro import (
    GyroSettings,
    at_rest,
    body_rates,
    filtered_rates,
    filters_gyro,
    gyro_filter,
    sample_steps,
    sensed,
    stepped_filters,
)
from workbench.estimation.imu import (
    FROZEN,
    MEAN,
    SILENT,
    SOURCE,
    SPREAD,
    carried,
    drawn_bias,
    mean_force,
    mean_rate,
    measured,
    noisy_sample,
    packed,
    step_drift,
)
from workbench.plant.sensors import Imu
from workbench.systems.noise import noise_seed
from workbench.systems.weak_callback import weakly

ON_TIME = 1e-6
"""Largest share of a physics step by which a sample is off its time."""


class FlightImu(LeafSystem):
    """Samples the motion of the body.

    Input ports:
        state (13): of the body: q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        acceleration (6): angular, and of the origin, in W [rad/s², m/s²]; for the first sample,
            which has none before it; only with an IMU.
    Output ports:
        sensed (13): the state with the gyro's filtered angular velocity.
        imu (9): mean angular velocity [rad/s] and specific force [m/s²] since the last reading, and
            filtered angular velocity, in B; only with an IMU.
    Discrete state: states of the gyro's filters (12), its filtered angular velocity in B (3),
    states of the accelerometer's low-pass (6), the last sample (6), the integral of samples since
    the last reading (6) and its length in physics steps, -1 before the first (1), the biases (6)
    and their drift (6), attitude and velocity of the IMU at the last sample (7), see `imu.carried`,
    its exact angular velocity (3), and its number in physics steps (1).
    Numeric parameters: `GyroSettings`, the fault of the IMU, and the seed of its noise.

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
        self._imu = packed(imu, step, readout * step) if imu else None
        self._p_BS = imu.p_BS if imu else (0.0, 0.0, 0.0)
        self.settings_index = int(self.DeclareNumericParameter(BasicVector(list(settings))))
        self.fault_index = int(self.DeclareNumericParameter(BasicVector([0.0])))
        self._seed = self.DeclareNumericParameter(BasicVector([0.0]))
        self._state = self.DeclareVectorInputPort("state", 13)
        self._gyro_filters = self.DeclareDiscreteState(12)
        self._gyro_rates = self.DeclareDiscreteState(3)
        self._accel_filters = self.DeclareDiscreteState(6)
        self._last_sample = self.DeclareDiscreteState(6)
        self._sums = self.DeclareDiscreteState(6)
        self._elapsed = self.DeclareDiscreteState(1)
        self._bias = self.DeclareDiscreteState(6)
        self._drift = self.DeclareDiscreteState(6)
        self._last_motion = self.DeclareDiscreteState(7)
        self._last_rates = self.DeclareDiscreteState(3)
        self._last_number = self.DeclareDiscreteState(1)
        needs = {self._state.ticket(), self.xd_ticket(), self.time_ticket(), self.pn_ticket()}
        self.DeclareVectorOutputPort("sensed", 13, self._calc_sensed, needs)
        if imu:
            self._acceleration = self.DeclareVectorInputPort("acceleration", 6)
            needs |= {self._acceleration.ticket()}
            self.DeclareVectorOutputPort("imu", 9, self._calc_imu, needs)
        self._sampling = self.DeclareCacheEntry(
            "settings, steps between samples, and whether the gyro has filters",
            ValueProducer(lambda: Value[object](()), weakly(self._calc_sampling)),
            {self.pn_ticket()},
        ).cache_index()
        self.DeclarePerStepDiscreteUpdateEvent(self._update)

    def set_seed(self, context: Context, seed: int) -> None:
        """Set the seed of the noise; equal seeds give equal noise."""
        own = float(noise_seed(seed, SOURCE))
        context.get_mutable_numeric_parameter(self._seed).SetAtIndex(0, own)

    def begin(self, context: Context, state: np.ndarray) -> None:
        """Begin at a state of the body (13)."""
        rates = body_rates(state)
        for group in range(context.num_discrete_state_groups()):
            context.SetDiscreteState(group, np.zeros(context.get_discrete_state(group).size()))
        context.SetDiscreteState(self._gyro_filters, at_rest(rates))
        context.SetDiscreteState(self._gyro_rates, rates)
        context.SetDiscreteState(self._elapsed, [-1.0])

    def sample_steps(self, context: Context) -> int:
        """Return the number of physics steps between two samples, a divisor of the readout.

        Without a stated rate, filters sample at each step, an IMU twice a reading.
        """
        return self._sampled(context)[1]

    def _sampled(self, context: Context) -> tuple[GyroSettings, int, bool]:
        """Return settings, steps between samples, and whether the gyro has filters."""
        found: tuple[GyroSettings, int, bool] = self.get_cache_entry(self._sampling).Eval(context)
        return found

    def _calc_sampling(self, context: Context, output: Any) -> None:
        live = context.get_numeric_parameter(self.settings_index).value()
        settings = GyroSettings(*live.tolist())
        every = self._readout if self._imu is None else max(1, self._readout // 2)
        if settings.gyro_rate > 0.0:
            every = sample_steps(settings.gyro_rate, self._step, self._readout)
        elif filters_gyro(settings, self._step) or works(settings.accel_lowpass, self._step):
            every = 1
        output.set_value((settings, every, bool(filters_gyro(settings, every * self._step))))

    def _number(self, context: Context) -> int:
        return round(context.get_time() / self._step)

    def _group(self, context: Context, group: int) -> np.ndarray:
        return context.get_discrete_state(group).CopyToVector()

    def _filter_states(self, context: Context, rates: Sequence[float]) -> np.ndarray:
        """Return the states of the gyro's filters, at rest if they were off at the last sample."""
        if self._group(context, self._last_number)[0] < 0.0:
            return np.array(at_rest(rates))
        return self._group(context, self._gyro_filters)

    def _passed(self, context: Context) -> float:
        """Return the physics steps since the last sample."""
        return context.get_time() / self._step - self._group(context, self._last_number)[0]

    def _missed(self, context: Context) -> np.ndarray:
        """Return the mean angular velocity since the last sample less that by both samples (3)."""
        passed, fault = self._passed(context), context.get_numeric_parameter(self.fault_index)[0]
        first = self._group(context, self._elapsed)[0] < 0.0
        if first or passed < ON_TIME or fault in (FROZEN, SILENT):
            return np.zeros(3)
        state = self._state.Eval(context).tolist()
        turned = mean_rate(
            self._group(context, self._last_motion)[:4], state[:4], passed * self._step
        )
        return np.array(turned) - 0.5 * (self._group(context, self._last_rates) + body_rates(state))

    def _sample(self, context: Context, every: int) -> tuple[float, ...]:
        """Return a sample now (6): of an exact gyro alone without an IMU."""
        state = self._state.Eval(context).tolist()
        if self._imu is None:
            return (*body_rates(state), 0.0, 0.0, 0.0)
        fault = context.get_numeric_parameter(self.fault_index)[0]
        seed = context.get_numeric_parameter(self._seed)[0]
        bias, passed = self._group(context, self._bias), self._passed(context)
        exact: tuple[float, ...]
        if self._group(context, self._elapsed)[0] < 0.0:
            bias = np.array(drawn_bias(self._imu[MEAN:SPREAD], self._imu[SPREAD:], seed))
            exact = measured(state, self._acceleration.Eval(context).tolist(), self._p_BS)
        elif fault in (FROZEN, SILENT) or passed < ON_TIME:
            return tuple(self._group(context, self._last_sample))
        else:
            before, now = (
                self._group(context, self._last_motion).tolist(),
                carried(state, self._p_BS),
            )
            exact = (*body_rates(state), *mean_force(before, now, passed * self._step))
        both = np.concatenate([bias, self._group(context, self._drift)])
        return noisy_sample(exact, self._number(context), every, fault, both, self._imu, seed)

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        settings, every, filters = self._sampled(context)
        number = self._number(context)
        # with error control, steps also end between the samples
        if number % every or abs(context.get_time() / self._step - number) > ON_TIME:
            return
        if self._imu is None and not filters:
            if discrete_state.value(self._last_number)[0] >= 0.0:
                discrete_state.set_value(self._last_number, [-1.0])
            return
        with np.errstate(over="ignore"):  # integers of the noise wrap around
            self._take_sample(context, discrete_state, settings, every, number)

    def _take_sample(
        self,
        context: Context,
        discrete_state: DiscreteValues,
        settings: GyroSettings,
        every: int,
        number: int,
    ) -> None:
        """Take a sample, and filter and add it up."""
        sample = self._sample(context, every)
        coefficients = gyro_filter(settings, every * self._step)
        x = self._filter_states(context, sample[0:3])
        discrete_state.set_value(self._gyro_rates, filtered_rates(coefficients, x, sample[0:3]))
        discrete_state.set_value(self._gyro_filters, stepped_filters(coefficients, x, sample[0:3]))
        discrete_state.set_value(self._last_number, [number])
        if self._imu is None:
            return
        seed = context.get_numeric_parameter(self._seed)[0]
        elapsed = self._group(context, self._elapsed)[0]
        first = elapsed < 0.0
        if first:
            bias = drawn_bias(self._imu[MEAN:SPREAD], self._imu[SPREAD:], seed)
            discrete_state.set_value(self._bias, bias)
        section = lowpass(settings[5], settings[6], every * self._step)
        accel, before = (
            self._group(context, self._accel_filters),
            self._group(context, self._last_sample),
        )
        sums, passed = self._group(context, self._sums), self._passed(context)
        missed = self._missed(context)
        for i in range(3):
            force = sample[3 + i]
            if first:
                accel[2 * i + 1] = force
            smooth = output(section, accel[2 * i], accel[2 * i + 1], force)
            accel[2 * i : 2 * i + 2] = after(section, accel[2 * i], accel[2 * i + 1], force)
            sums[i] += passed * (0.5 * (before[i] + sample[i]) + missed[i])
            sums[3 + i] += passed * smooth
        elapsed += passed
        if first or number % self._readout == 0:
            elapsed, sums = 0.0, np.zeros(6)
            drift = self._group(context, self._drift)
            step_drift(drift, number, self._imu, seed)
            discrete_state.set_value(self._drift, drift)
        state = self._state.Eval(context).tolist()
        discrete_state.set_value(self._last_motion, carried(state, self._p_BS))
        discrete_state.set_value(self._last_rates, body_rates(state))
        for group, values in (
            (self._accel_filters, accel),
            (self._last_sample, sample),
            (self._sums, sums),
            (self._elapsed, [elapsed]),
        ):
            discrete_state.set_value(group, values)

    def _calc_sensed(self, context: Context, output_vector: BasicVector) -> None:
        settings, every, filters = self._sampled(context)
        state = self._state.Eval(context)
        if not filters:
            output_vector.SetFromVector(state)
            return
        state = state.tolist()
        rates = self._group(context, self._gyro_rates)
        if self._number(context) % every == 0:
            coefficients, now = gyro_filter(settings, every * self._step), body_rates(state)
            rates = filtered_rates(coefficients, self._filter_states(context, now), now)
        output_vector.SetFromVector(sensed(state, rates))

    @np.errstate(over="ignore")
    def _calc_imu(self, context: Context, output_vector: BasicVector) -> None:
        settings, every, _ = self._sampled(context)
        sample, before = self._sample(context, every), self._group(context, self._last_sample)
        sums, accel = self._group(context, self._sums), self._group(context, self._accel_filters)
        elapsed, passed = self._group(context, self._elapsed)[0], self._passed(context)
        missed = self._missed(context)
        coefficients = gyro_filter(settings, every * self._step)
        rates = filtered_rates(coefficients, self._group(context, self._gyro_filters), sample[0:3])
        section = lowpass(settings[5], settings[6], every * self._step)
        reading = [*sample, *rates]
        if elapsed >= 0.0 and elapsed + passed > ON_TIME:
            for i in range(3):
                smooth = output(section, accel[2 * i], accel[2 * i + 1], sample[3 + i])
                turned = sums[i] + passed * (0.5 * (before[i] + sample[i]) + missed[i])
                reading[i] = turned / (elapsed + passed)
                reading[3 + i] = (sums[3 + i] + passed * smooth) / (elapsed + passed)
        output_vector.SetFromVector(reading)
