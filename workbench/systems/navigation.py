"""An estimator as a LeafSystem: from sensor samples to the motion for the controller."""

import math
from collections.abc import Mapping

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from workbench.control.flight_mode import GPS_LATE, Health, ModeState
from workbench.control.mode import FlightMode
from workbench.estimation import ekf
from workbench.estimation.estimators import TRIANGLE, Estimator, checked_update, known_motion
from workbench.estimation.samples import (
    AGES,
    BAROMETER,
    GPS,
    MAGNETOMETER,
    RANGE_FINDER,
    SAMPLES,
    Mounting,
)
from workbench.estimation.settings import HEARD
from workbench.plant.geodesy import in_world
from workbench.plant.home import Home
from workbench.systems.discrete_system import DiscreteSystem

SIZES = {"gps": 7, "barometer": 3, "magnetometer": 4, "range_finder": 2}
"""Size of a delivered sample with its stamp, for each of `HEARD`."""


DECIDING = {"gps": slice(0, 2), "magnetometer": slice(7, 8)}
"""Channels of `ekf.update` that show whether it used a sample: east and north, heading."""


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
        health (4): see `flight_mode.Health`.
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
        memory = estimator.begin(still, mounting, np.zeros(ekf.ERRORS), known)
        names = estimator.settings._fields
        self.DeclareNumericParameter(BasicVector([settings[name] for name in names]))
        self._memory_state = self.DeclareDiscreteState(memory)
        self._stamps = self.DeclareDiscreteState(np.full(len(HEARD), np.nan))
        self._held = self.DeclareDiscreteState(still)
        self._since = self.DeclareDiscreteState(len(Health._fields) - 1)
        self._rates = self.DeclareDiscreteState(np.full(3, np.nan))
        self._fix = self.DeclareDiscreteState(np.full(SIZES["gps"] - 1, np.nan))
        self._imu = self.DeclareVectorInputPort("imu", 9)
        self._heard = [self.DeclareVectorInputPort(name, SIZES[name]) for name in HEARD]
        self._mode = self.DeclareVectorInputPort("mode", len(ModeState._fields))
        self._memory = self.DeclareVectorOutputPort("memory", memory.size, self._calc_memory)
        self._state = self.DeclareVectorOutputPort("state", 13, self._calc_state)
        self.DeclareVectorOutputPort("deviations", ekf.ERRORS, self._calc_deviations)
        self.DeclareVectorOutputPort("health", len(Health._fields), self._calc_health)
        self.DeclareVectorOutputPort("covariance", len(TRIANGLE[0]), self._calc_covariance)
        self.DeclareVectorOutputPort("innovations", 2 * ekf.CHANNELS, self._calc_innovations)
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
        context.SetDiscreteState(self._stamps, np.full(len(HEARD), np.nan))
        context.SetDiscreteState(self._held, state)
        context.SetDiscreteState(self._since, np.zeros(len(Health._fields) - 1))
        context.SetDiscreteState(self._rates, np.full(3, np.nan))
        context.SetDiscreteState(self._fix, np.full(SIZES["gps"] - 1, np.nan))

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
        self._run(memory, self._samples(context), settings, self._places, dt)
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
        discrete_state.set_value(self._memory_state, self._memory.Eval(context))
        discrete_state.set_value(self._held, self._state.Eval(context))
        stamps = [
            port.Eval(context)[0] if port.HasValue(context) else np.nan for port in self._heard
        ]
        discrete_state.set_value(self._stamps, stamps)
        gps = self._heard[HEARD.index("gps")]
        if gps.HasValue(context):
            discrete_state.set_value(self._fix, gps.Eval(context)[1:])
        renewed = np.array(
            [
                self._takes_in(context, "gps"),
                self._repeats or not self._gyro_repeats(context),
                self._takes_in(context, "magnetometer"),
            ]
        )
        ages = context.get_discrete_state(self._since).value() + self._period
        discrete_state.set_value(self._since, np.where(renewed, 0.0, ages))
        discrete_state.set_value(self._rates, self._imu.Eval(context)[:3])

    def _takes_in(self, context: Context, kind: str) -> bool:
        """Return whether a sensor has a new sample that the estimate uses, or is absent."""
        place = HEARD.index(kind)
        if not self._heard[place].HasValue(context):
            return kind != "gps"  # without GPS the position is soon unknown
        before = context.get_discrete_state(self._stamps).value()[place]
        if self._fresh(context, place, before) is None:
            return False
        memory, gate = self._memory.Eval(context), self._gate(context)
        told = self.estimator.innovations(memory).reshape(-1, 2)[DECIDING[kind]]
        return not (told[:, 0] ** 2 > gate**2 * told[:, 1]).any()

    def _gate(self, context: Context) -> float:
        """Return the number of standard deviations beyond which a sample is rejected."""
        names = self.estimator.settings._fields
        if "ekf_gate" not in names:
            return np.inf
        return float(context.get_numeric_parameter(0)[names.index("ekf_gate")])

    def _samples(self, context: Context) -> np.ndarray:
        """Return what sensors gave since the update before, see `estimation.samples`."""
        found = np.zeros(SAMPLES)
        found[:6] = self._imu.Eval(context)[:6]
        before = context.get_discrete_state(self._stamps).value()
        gps, barometer, magnetometer, range_finder = (
            self._fresh(context, place, before[place]) for place in range(len(HEARD))
        )
        if gps is not None:
            stamp, latitude, longitude, altitude = gps[:4].tolist()
            place = in_world(latitude, longitude, altitude, self._home)
            found[GPS : GPS + 8] = 1.0, context.get_time() - stamp, *place, *gps[4:]
        if barometer is not None:
            found[BAROMETER : BAROMETER + 2] = 1.0, barometer[2]
            found[AGES] = context.get_time() - barometer[0]
        if magnetometer is not None:
            found[MAGNETOMETER] = 1.0
            found[MAGNETOMETER + 1 : MAGNETOMETER + 4] = self._R_BM @ magnetometer[1:]
            found[AGES + 1] = context.get_time() - magnetometer[0]
        if range_finder is not None and np.isfinite(range_finder[1]):
            found[RANGE_FINDER : RANGE_FINDER + 2] = 1.0, range_finder[1]
            found[AGES + 2] = context.get_time() - range_finder[0]
        return found

    def _fresh(self, context: Context, place: int, before: float) -> np.ndarray | None:
        """Return a new sample with its stamp, None without one."""
        port = self._heard[place]
        if not port.HasValue(context):
            return None
        sample: np.ndarray = port.Eval(context)
        stamp = float(sample[0])
        if math.isnan(stamp) or stamp == before:
            return None
        frozen = HEARD[place] == "gps" and self._is_frozen(context, sample)
        return None if frozen else sample

    def _is_frozen(self, context: Context, gps: np.ndarray) -> bool:
        """Return whether a GPS sample with its stamp (7) repeats the previous one."""
        if self._gps_repeats or self._gyro_repeats(context):
            return False
        late = context.get_discrete_state(self._since).value()[0] > GPS_LATE
        if not late and not self._in_the_air(context):
            return False
        return np.array_equal(gps[1:], context.get_discrete_state(self._fix).value())

    def _gyro_repeats(self, context: Context) -> bool:
        """Return whether the gyro's readings equal those of the previous update."""
        rates = self._imu.Eval(context)[:3]
        return np.array_equal(rates, context.get_discrete_state(self._rates).value())

    def _in_the_air(self, context: Context) -> bool:
        """Return whether the drone flies, from take-off to landing."""
        if not self._mode.HasValue(context):
            return True
        return self._mode.Eval(context)[0] not in (FlightMode.OFF, FlightMode.ARMED)
