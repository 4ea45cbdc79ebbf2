"""An estimator as a LeafSystem: from sensor samples to the motion for the controller."""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from workbench.control.flight_mode import MAX_GPS_AGE_S, EstimateHealth, ModeState
from workbench.control.mode import FlightMode
from workbench.estimation import ekf, ekf_state
from workbench.estimation.estimators import (
    COVARIANCE_TRIANGLE,
    Estimator,
    checked_update,
    known_motion,
)
from workbench.estimation.samples import (
    AGES,
    BAROMETER,
    GPS,
    MAGNETOMETER,
    RANGE_FINDER,
    SAMPLE_ARRAY_SIZE,
    Mounting,
)
from workbench.estimation.settings import AIDING_SENSORS
from workbench.plant.geodesy import point_in_world
from workbench.plant.home import Home
from workbench.systems.cached import cached
from workbench.systems.discrete_system import DiscreteSystem

AIDING_SAMPLE_SIZES = {"gps": 7, "barometer": 3, "magnetometer": 4, "range_finder": 2}
"""Size of a delivered sample with its stamp, for each of `AIDING_SENSORS`."""


AIDING_USE_CHANNELS = {"gps": (GPS, slice(0, 2)), "magnetometer": (MAGNETOMETER, slice(7, 8))}
"""Flag of a new sample, and channels of `ekf.update` that show whether it used it: east and north,
heading."""


class ReceivedSamples(NamedTuple):
    """What sensors gave since the update before.

    Attributes:
        z: see `estimation.samples` (25).
        stamps: of the last sample of each of `AIDING_SENSORS` (4) [s], NaN without one.
        fix: the last sample of the GPS without its stamp (6); empty if it is unconnected.
        gyro_repeats: whether the gyro's readings equal those of the update before.
    """

    z: np.ndarray
    stamps: list[float]
    fix: list[float]
    gyro_repeats: bool


class Navigation(DiscreteSystem):
    """Runs an estimator once a control period, right before the controller.

    At an update the outputs follow from state and inputs, so they include the samples of that time.
    The update stores them until the next one.

    A GPS sample that equals the previous one, in all its numbers and to the bit, is ignored: the
    receiver is frozen, whatever its stamps say. But an exact GPS at rest also repeats itself. So
    equal samples are used on the ground, unless the GPS was late before, and while the gyro's
    readings are equal, as in an exact flight without motion.

    Input ports:
        imu (9): see `FlightImu`.
        gps (7), barometer (3), magnetometer (4), range_finder (2): stamp and last delivered sample;
            may be unconnected.
        mode (10): see `flight_mode.ModeState`; in the air if unconnected.
    Output ports:
        memory: of the estimator.
        state (13): estimated q_WB, p_WB [m], w_WB_W [rad/s] and v_WB_W [m/s]; the angular velocity
            is that of the gyro's filters, less its bias.
        deviations (15): of the errors, see `ekf`.
        health (4): see `flight_mode.EstimateHealth`.
        covariance (45), innovations (20): see `Estimator`.
    Numeric parameter 0: the estimator's settings.

    Args:
        estimator: that runs.
        settings: its live numbers by name.
        mounting: of the sensors.
        turn_BM: orientation of the magnetometer, rows of the matrix (3, 3).
        known: standard deviations of the initial errors.
        home: where the world's origin lies.
        period: between updates [s].
        repeats: whether readings of the IMU may repeat without a fault, as without noise.
        gps_repeats: whether readings of the GPS may repeat in flight without a fault, as with
            rounding and without noise.
    """

    def __init__(
        self,
        *,
        estimator: Estimator,
        settings: Mapping[str, float],
        mounting: Mounting,
        turn_BM: np.ndarray,
        known: ekf.InitialDeviations,
        home: Home,
        period: float,
        repeats: bool = False,
        gps_repeats: bool = False,
    ) -> None:
        super().__init__()
        self._repeats, self._gps_repeats = repeats, gps_repeats
        self.estimator = estimator
        self._run = checked_update(estimator)
        self._mounting, self._places = mounting, mounting.packed()
        self._R_BM, self._home, self._period = np.array(turn_BM), home, period
        self._known = known
        still = np.array([1.0, *[0.0] * 12])
        memory = estimator.begin(still, mounting, np.zeros(ekf_state.ERRORS), known)
        names = estimator.settings._fields
        self.DeclareNumericParameter(BasicVector([settings[name] for name in names]))
        self._memory_state = self.DeclareDiscreteState(memory)
        self._stamps = self.DeclareDiscreteState(np.full(len(AIDING_SENSORS), np.nan))
        self._held = self.DeclareDiscreteState(still)
        self._since = self.DeclareDiscreteState(len(EstimateHealth._fields) - 1)
        self._rates = self.DeclareDiscreteState(np.full(3, np.nan))
        self._fix = self.DeclareDiscreteState(np.full(AIDING_SAMPLE_SIZES["gps"] - 1, np.nan))
        self._imu = self.DeclareVectorInputPort("imu", 9)
        self._ports = [
            self.DeclareVectorInputPort(name, AIDING_SAMPLE_SIZES[name]) for name in AIDING_SENSORS
        ]
        self._mode = self.DeclareVectorInputPort("mode", len(ModeState._fields))
        self._received = cached(self._calc_received, "received", {self.all_sources_ticket()})
        self._memory = self.DeclareVectorOutputPort("memory", memory.size, self._calc_memory)
        self._state = self.DeclareVectorOutputPort("state", 13, self._calc_state)
        self.DeclareVectorOutputPort("deviations", ekf_state.ERRORS, self._calc_deviations)
        self.DeclareVectorOutputPort("health", len(EstimateHealth._fields), self._calc_health)
        self.DeclareVectorOutputPort(
            "covariance", len(COVARIANCE_TRIANGLE[0]), self._calc_covariance
        )
        self.DeclareVectorOutputPort(
            "innovations", 2 * ekf_state.MEASUREMENT_CHANNELS, self._calc_innovations
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def begin(self, context: Context, state: np.ndarray, seed: int | None) -> None:
        """Begin at a motion (13), with errors as large as the estimator assumes.

        Args:
            context: of this system.
            state: of the body (13).
            seed: of the errors; None for an exact initial estimate.
        """
        memory = self.estimator.begin(state, self._mounting, ekf.start_errors(seed), self._known)
        context.SetDiscreteState(self._memory_state, memory)
        context.SetDiscreteState(self._stamps, np.full(len(AIDING_SENSORS), np.nan))
        context.SetDiscreteState(self._held, state)
        context.SetDiscreteState(self._since, np.zeros(len(EstimateHealth._fields) - 1))
        context.SetDiscreteState(self._rates, np.full(3, np.nan))
        context.SetDiscreteState(self._fix, np.full(AIDING_SAMPLE_SIZES["gps"] - 1, np.nan))

    def _is_update(self, context: Context) -> bool:
        """Return whether an update is due now."""
        updates = context.get_time() / self._period
        return abs(updates - round(updates)) < 1e-6

    def _calc_memory(self, context: Context, output: BasicVector) -> None:
        memory = context.get_discrete_state(self._memory_state).CopyToVector()
        if not self._is_update(context):
            output.SetFromVector(memory)
            return
        settings = context.get_numeric_parameter(0).CopyToVector()
        dt = self._period if context.get_time() > 0.5 * self._period else 0.0
        self._run(memory, self._received(context).z, settings, self._places, dt)
        output.SetFromVector(memory)

    def _calc_state(self, context: Context, output: BasicVector) -> None:
        if not self._is_update(context):
            output.SetFromVector(context.get_discrete_state(self._held).CopyToVector())
            return
        memory = self._memory.Eval(context)
        rates = self._imu.Eval(context)[6:9]
        output.SetFromVector(known_motion(memory, rates, self._mounting.p_BI))

    def _calc_deviations(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self.estimator.deviations(self._memory.Eval(context)))

    def _calc_health(self, context: Context, output: BasicVector) -> None:
        deviations = self.estimator.deviations(self._memory.Eval(context))
        ages = context.get_discrete_state(self._since).CopyToVector()
        output.SetFromVector([np.hypot(*deviations[3:5]), *ages])

    def _calc_covariance(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self.estimator.covariance(self._memory.Eval(context)))

    def _calc_innovations(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self.estimator.innovations(self._memory.Eval(context)))

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        memory, received = self._memory.Eval(context), self._received(context)
        discrete_state.set_value(self._memory_state, memory)
        discrete_state.set_value(self._held, self._state.Eval(context))
        discrete_state.set_value(self._stamps, received.stamps)
        if received.fix:
            discrete_state.set_value(self._fix, received.fix)
        renewed = (
            self._takes_in(context, received.z, memory, "gps"),
            self._repeats or not received.gyro_repeats,
            self._takes_in(context, received.z, memory, "magnetometer"),
        )
        ages = context.get_discrete_state(self._since).value().tolist()
        since = [0.0 if new else age + self._period for new, age in zip(renewed, ages, strict=True)]
        discrete_state.set_value(self._since, since)
        discrete_state.set_value(self._rates, self._imu.Eval(context)[:3])

    def _takes_in(self, context: Context, z: np.ndarray, memory: np.ndarray, kind: str) -> bool:
        """Return whether a sensor has a new sample that the estimate uses, or is absent."""
        flag, channels = AIDING_USE_CHANNELS[kind]
        if z[flag] > 0.0:
            innovations = self.estimator.innovations(memory).reshape(-1, 2)[channels]
            return not (innovations[:, 0] ** 2 > self._gate(context) ** 2 * innovations[:, 1]).any()
        # without GPS the position is soon unknown
        return kind != "gps" and not self._ports[AIDING_SENSORS.index(kind)].HasValue(context)

    def _gate(self, context: Context) -> float:
        """Return the number of standard deviations beyond which a sample is rejected."""
        names = self.estimator.settings._fields
        if "ekf_gate" not in names:
            return np.inf
        return float(context.get_numeric_parameter(0)[names.index("ekf_gate")])

    def _calc_received(self, context: Context) -> ReceivedSamples:
        """Return what sensors gave since the update before."""
        imu = self._imu.Eval(context).tolist()
        samples = [
            port.Eval(context).tolist() if port.HasValue(context) else [math.nan]
            for port in self._ports
        ]
        stamps = [sample[0] for sample in samples]
        before = context.get_discrete_state(self._stamps).value().tolist()
        gps, barometer, magnetometer, range_finder = (
            None if math.isnan(sample[0]) or sample[0] == stamp else sample
            for sample, stamp in zip(samples, before, strict=True)
        )
        repeats = imu[:3] == context.get_discrete_state(self._rates).value().tolist()
        z, time = np.zeros(SAMPLE_ARRAY_SIZE), context.get_time()
        z[:6] = imu[:6]
        if gps and not self._is_frozen(context, gps, repeats):
            stamp, latitude, longitude, altitude, *velocity = gps
            place = point_in_world(latitude, longitude, altitude, self._home)
            z[GPS : GPS + 8] = 1.0, time - stamp, *place, *velocity
        if barometer:
            z[BAROMETER : BAROMETER + 2] = 1.0, barometer[2]
            z[AGES] = time - barometer[0]
        if magnetometer:
            z[MAGNETOMETER] = 1.0
            z[MAGNETOMETER + 1 : MAGNETOMETER + 4] = self._R_BM @ magnetometer[1:]
            z[AGES + 1] = time - magnetometer[0]
        if range_finder and math.isfinite(range_finder[1]):
            z[RANGE_FINDER : RANGE_FINDER + 2] = 1.0, range_finder[1]
            z[AGES + 2] = time - range_finder[0]
        return ReceivedSamples(z, stamps, samples[AIDING_SENSORS.index("gps")][1:], repeats)

    def _is_frozen(self, context: Context, gps: list[float], gyro_repeats: bool) -> bool:
        """Return whether a GPS sample with its stamp (7) repeats the previous one."""
        if self._gps_repeats or gyro_repeats:
            return False
        late = context.get_discrete_state(self._since).value()[0] > MAX_GPS_AGE_S
        if not late and not self._in_the_air(context):
            return False
        fix: list[float] = context.get_discrete_state(self._fix).value().tolist()
        return gps[1:] == fix

    def _in_the_air(self, context: Context) -> bool:
        """Return whether the drone flies, from take-off to landing."""
        if not self._mode.HasValue(context):
            return True
        return self._mode.Eval(context)[0] not in (FlightMode.OFF, FlightMode.ARMED)
