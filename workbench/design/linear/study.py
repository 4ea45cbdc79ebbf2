"""Linear models of one vehicle, read once, at any point and with any gains."""

import dataclasses
import math
from collections.abc import Mapping, Sequence

import numpy as np
from pydrake.autodiffutils import InitializeAutoDiff
from pydrake.systems.framework import Diagram

from workbench.common.errors import WorkbenchError, sentences
from workbench.control.controller import Controller
from workbench.control.flight_law import FILTERED
from workbench.design.linear.derivatives import (
    HELD,
    HOLD_X,
    REFERENCE,
    Derivatives,
    LastCall,
)
from workbench.design.linear.estimation import EstimatorModel, estimator_model
from workbench.design.linear.model import (
    FILTERS,
    MEASURED,
    LinearModel,
    Signal,
    Trim,
    accel_states,
    estimated,
    filtered,
    gyro_states,
    imu,
    memory_of,
    motion,
    numbered,
    outputs,
    points,
    references,
    sensor_noise,
    wrench,
)
from workbench.design.linear.operating_point import HOVER, OperatingPoint
from workbench.design.linear.seeds import (
    STATE,
    gradient,
    heading_turn,
    turn_with_heading,
)
from workbench.design.linear.trim import find_trim, guidance_of, reference_of, update_inputs
from workbench.design.linear.update import Update
from workbench.design.linear.vehicle import Step, VehicleDerivatives
from workbench.diagram.core import law_gains, make_flight_core, make_vehicle_core
from workbench.diagram.mounting import find_imu, mounting_of
from workbench.diagram.sensor_choice import choose_sensors
from workbench.estimation.estimators import find_estimator
from workbench.estimation.gyro import sample_steps
from workbench.estimation.samples import Mounting
from workbench.estimation.settings import HEARD, TRUTH
from workbench.gains.gains import flight_gains
from workbench.plant.description import Description
from workbench.plant.home import DEFAULT_HOME
from workbench.plant.loading import make_vehicle
from workbench.plant.payload import Payload, payload_of
from workbench.plant.variation import Delays, varied
from workbench.plant.vehicle import Vehicle
from workbench.scenario.configured import read_configured, read_configured_world
from workbench.scenario.parameters import parameter_table
from workbench.scenario.scenario import (
    Rates,
    Scenario,
    at_own_period,
    check_scenario,
    flown_controller,
)
from workbench.systems.acceleration_estimate import TIME_CONSTANT, sampled_estimate

GYRO = 12
ACCEL = 6
IMU = 6
"""Number of states of the filters of gyro, see `gyro.STATES`, and accelerometer, and of numbers in
a reading of the IMU."""
RATE = slice(6, 9)
"""Indices of the angular velocity in the motion."""
REMOVABLE = frozenset(
    signal.name
    for signal in (*gyro_states(), *filtered()[3:], *accel_states(), *imu(), *estimated())
)
"""States of filters and estimators, which a model has only if they are on."""


def sampled_model(
    derivatives: Derivatives,
    trim: Trim,
    rates: Rates,
    rate: float,
    delays: Delays,
    estimator: EstimatorModel | None = None,
    samples: int = 0,
    injected: tuple[Signal, ...] = (),
) -> LinearModel:
    """Return the linear model of a control period.

    States are those just before an update: the motion, rotor speeds, the filters of the gyro, and
    of the accelerometer with the sample of the update, the reading of the IMU, the memory of the
    estimator, commands that act or are still to act, the stages before the law, the motions that a
    delayed controller has not yet seen, and the memory of the law. Outputs are those at the update.
    Filters that are off have states, too; `LinearModel.lean` removes them.

    Between updates commands are held. The matrix of the period is the product of the exact
    derivatives of the update and of the exact model of the vehicle over each physics step, in axes
    that turn with the heading.

    Args:
        derivatives: of vehicle and law.
        trim: where.
        rates: of physics and control.
        rate: of the acceleration estimate [1/s].
        delays: of sensing and commands.
        estimator: at the trim, if the law does not use the true motion.
        samples: number of IMU samples in a period, with the noise of each as an input; 0 leaves out
            the noise of sensors.
        injected: `wrench`, to inject it on its way to the rotors, unknown to the law, with those of
            earlier updates that still wait as states; nothing for none.

    Raises:
        WorkbenchError: for a turn with a sensing delay, which has no such model.
    """
    late, look = delays.seen
    age, since = delays.acting
    waiting = max(1, age + 1 if since else age)  # the law remembers its last commands
    if late and trim.point.yaw_rate:
        raise WorkbenchError("a turn cannot be linearised with a delayed controller: leave one out")
    update = derivatives.update(*update_inputs(trim, rate))
    n, k, axes = trim.speeds.size, len(update.memory_by), len(injected)
    count = len(derivatives.controller.points)
    e = len(estimator.names) if estimator else 0
    sizes = (STATE, n, GYRO, ACCEL, IMU, e, *[n] * waiting, FILTERED, *[STATE] * late, k)
    sizes += (axes,) * waiting
    at = np.cumsum([0, *sizes])
    size = int(at[-1])
    groups = [slice(int(a), int(b)) for a, b in zip(at[:-1], at[1:], strict=True)]
    s, speed, gyro, accel, sample, known_motion = groups[:6]
    commands, before, older = groups[6 : 6 + waiting], groups[6 + waiting], groups[7 + waiting :]
    older, memory, earlier = older[:late], older[late], older[late + 1 :]
    moving = slice(0, accel.stop)

    asked = slice(0, REFERENCE + HELD + count)
    noise = slice(asked.stop, asked.stop + STATE)
    sampling = slice(noise.stop, noise.stop + IMU * samples)
    measuring = slice(sampling.stop, sampling.stop + (len(MEASURED) if samples else 0))
    inputs = measuring.stop + axes
    known = STATE + FILTERED + n
    whole = np.eye(size)
    at_trim = derivatives.gyro(trim.state, np.concatenate([np.zeros(3), trim.vdot_WB]))
    rates_read = at_trim.C @ whole[gyro] + at_trim.D @ (at_trim.rates_by @ whole[s])
    now_seen = derivatives.sensed(at_trim, whole[s], rates_read)
    seen_in, read_in = np.zeros((STATE, inputs)), np.zeros((3, inputs))
    if samples:
        read_in[:, sampling][:, :3] = at_trim.D
        if derivatives.gyro_filters:
            seen_in[RATE] = at_trim.sensed_by_rates @ read_in
    if estimator:
        heard = np.vstack([whole[s], whole[sample], rates_read, whole[known_motion]])
        heard_in = np.zeros((len(heard), inputs))
        heard_in[STATE + IMU : STATE + IMU + 3] = read_in
        parts = np.eye(len(MEASURED), inputs, measuring.start) if samples else heard_in[:0]
        both_in = np.vstack([heard_in, parts])
        now_seen = estimator.seen_by[:, : len(heard)] @ heard
        seen_in = estimator.seen_by[:, : len(both_in)] @ both_in
    seen = np.zeros((known + k, size))
    seen[:STATE] = whole[older[-1]] if late else now_seen
    seen_now = np.zeros((STATE, inputs)) if late else seen_in
    seen[STATE : STATE + FILTERED, before] = np.eye(FILTERED)
    seen[STATE + FILTERED : known, commands[0]] = np.eye(n)
    seen[known:, memory] = np.eye(k)

    def of_update(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return rows of the update by states and by inputs."""
        by_inputs = np.zeros((rows.shape[0], inputs))
        by_inputs[:, asked] = rows[:, known : known + asked.stop]
        by_inputs += rows[:, :STATE] @ seen_now
        by_inputs[:, noise] += rows[:, :STATE]
        return np.hstack([rows[:, :known], rows[:, known + asked.stop :]]) @ seen, by_inputs

    A, B = np.zeros((size, size)), np.zeros((size, inputs))
    now = of_update(update.commands_by)
    # rows of commands by their age in updates, the newest first
    acting = [now, *((whole[each], np.zeros((n, inputs))) for each in commands)]
    A[before], B[before] = of_update(update.filtered_by)
    if k:
        A[memory], B[memory] = of_update(update.memory_by)
    signals, signals_in = of_update(update.signals_by)
    wrenches = [(np.zeros((axes, size)), np.eye(axes, inputs, measuring.stop))]
    wrenches += [(whole[each], np.zeros((axes, inputs))) for each in earlier]
    loaded = acting
    if axes:
        _, by = derivatives.allocation_at(trim.commands)
        loaded = [
            (by_state + by @ more, by_input + by @ more_in)
            for (by_state, by_input), (more, more_in) in zip(acting, wrenches, strict=True)
        ]
    held = [loaded[age if step >= since else age + 1] for step in range(delays.steps)]
    after, sampled, readings = _states_of_period(
        derivatives, trim, update, held, sampling if samples else None
    )
    A[moving], B[moving] = after
    A[sample], B[sample] = sampled
    if estimator:
        A[known_motion] = estimator.memory_by[:, : len(heard)] @ heard
        B[known_motion] = estimator.memory_by[:, : len(both_in)] @ both_in
    for each, (by_state, by_input) in zip(
        (*commands, *earlier), (*acting[:waiting], *wrenches), strict=False
    ):
        A[each], B[each] = by_state, by_input
    for each, newer in zip(older[1:], older, strict=False):
        A[each] = whole[newer]
    if late and estimator:  # between updates the estimate is constant
        A[older[0]], B[older[0]] = now_seen, seen_in
    elif late:
        A[older[0]], B[older[0]] = readings[look]

    # the filter of the velocity is in W
    turn = heading_turn(trim.point.yaw_rate * rates.control_period, 1)
    velocity = slice(before.start, before.start + 3)
    A[velocity], B[velocity] = turn @ A[velocity], turn @ B[velocity]
    remembered = memory_of(derivatives.controller)
    thrusts = np.zeros((n, size))
    vehicle = _vehicle_step(derivatives, trim, update)
    thrusts[:, s], thrusts[:, speed] = (
        vehicle.thrusts_by[:, :STATE],
        vehicle.thrusts_by[:, STATE : STATE + n],
    )
    C = np.vstack([np.eye(STATE, size), signals, thrusts, whole[speed]])
    D = np.zeros((C.shape[0], inputs))
    D[STATE : STATE + count] = signals_in
    return LinearModel(
        A=A,
        input_matrix=B,
        output_matrix=C,
        feedthrough=D,
        period=rates.control_period,
        states=(
            *_states(n, waiting, late, estimator),
            *remembered,
            *(
                Signal(f"{remembered[i].name}_{ago}_before", remembered[i].unit)
                for i, ago in update.earlier
            ),
            *(
                Signal(f"{signal.name}_{ago + 1}_before", signal.unit)
                for ago in range(waiting)
                for signal in injected
            ),
        ),
        inputs=(
            *references(),
            *points(derivatives.controller),
            *motion("noise_"),
            *sensor_noise(samples),
            *injected,
        ),
        outputs=outputs(n, derivatives.controller),
        trim=trim,
        controller=derivatives.controller,
    )


Rows = tuple[np.ndarray, np.ndarray]
"""Rows by states, and by inputs, at an update."""


def _vehicle_step(derivatives: Derivatives, trim: Trim, update: Update) -> Step:
    """Return the vehicle over a physics step."""
    yaw_rate = np.array(trim.point.yaw_rate)
    return derivatives.step(trim.state, trim.speeds, update.commands, yaw_rate)


def _states_of_period(
    derivatives: Derivatives,
    trim: Trim,
    update: Update,
    held: list[Rows],
    sampling: slice | None = None,
) -> tuple[Rows, Rows, list[Rows]]:
    """Return motion, speeds and filters of the IMU after a control period.

    Args:
        derivatives: of vehicle and law.
        trim: where.
        update: at its beginning.
        held: rows of the commands that act in each physics step.
        sampling: indices of inputs with the noise of IMU samples, if any.

    Returns:
        Rows of all these after the period; rows of the reading of the IMU then (6), see
        `FlightImu`; and rows of the motion (12) before each physics step, as seen by a controller
        that uses the true motion.
    """
    step = _vehicle_step(derivatives, trim, update)
    gyro = derivatives.gyro(trim.state, np.concatenate([np.zeros(3), trim.vdot_WB]))
    count, every = step.by.shape[0], derivatives.gyro_every
    columns, inputs = held[0][0].shape[1], held[0][1].shape[1]
    both = np.eye(count + GYRO + ACCEL, columns + inputs)
    filters, accel = slice(count, count + GYRO), slice(count + GYRO, count + GYRO + ACCEL)
    sums = np.zeros((IMU, columns + inputs))
    rates_read, before, moved = np.zeros((3, columns + inputs)), both[:0], both[:0]
    noise = np.zeros((IMU, columns + inputs))
    readings = []
    for number in range(len(held) + 1):
        moves = both[:count]
        if number % every == 0:
            w_B = gyro.rates_by @ moves[:STATE]
            if number:
                force = gyro.force_by @ np.vstack([moved, moves[:STATE]]) + noise[3:]
                smooth = gyro.smooth @ both[accel] + gyro.through @ force
                sums += every * np.vstack([0.5 * (before + w_B) + noise[:3], smooth])
                both[accel] = gyro.kept @ both[accel] + gyro.taken @ force
            before, moved = w_B, moves[:STATE].copy()
        if number == len(held):
            break
        if number % every == 0:
            if sampling:
                noise = np.zeros((IMU, columns + inputs))
                first = columns + sampling.start + IMU * (number // every)
                noise[:, first : first + IMU] = np.eye(IMU)
            # a gyro's sample counts by halves in two periods; here it fully counts in the one that
            # it begins, and stands beside the force that ends that
            w_B = w_B + noise[:3]
            rates_read = gyro.C @ both[filters] + gyro.D @ w_B
        readings.append(derivatives.sensed(gyro, moves[:STATE], rates_read))
        after = both.copy()
        if number % every == 0:
            after[filters] = gyro.A @ both[filters] + gyro.B @ w_B
        after[:count] = step.by @ np.vstack([moves, np.hstack(held[number])])
        both = after
    sums /= len(held)
    return (
        _parted(both, columns),
        _parted(sums, columns),
        [_parted(each, columns) for each in readings],
    )


def _parted(both: np.ndarray, columns: int) -> Rows:
    """Return rows by states, in the first columns, and by inputs."""
    return both[:, :columns], both[:, columns:]


def _states(
    n: int, waiting: int, late: int, estimator: EstimatorModel | None
) -> tuple[Signal, ...]:
    commands = (
        signal
        for age in range(waiting)
        for signal in numbered("command" if age == 0 else f"command_{age}_before", n, "rad/s")
    )
    seen = (signal for age in range(late) for signal in motion(f"seen_{age + 1}_"))
    return (
        *motion(),
        *numbered("speed", n, "rad/s"),
        *gyro_states(),
        *accel_states(),
        *imu(),
        *(Signal(*each) for each in (estimator.names if estimator else ())),
        *commands,
        *filtered(),
        *seen,
    )


class FlightDerivatives(VehicleDerivatives):
    """The same for a flight core: vehicle and law.

    Args:
        core: from `make_flight_core`.
        controller: with the law that flies.
        vehicle: as known to its law.
    """

    def __init__(self, core: Diagram, controller: Controller, vehicle: Vehicle) -> None:
        super().__init__(core, vehicle)
        self._law = controller
        self._controller = self._diagram.GetSubsystemByName("controller")
        self._in_controller = self._controller.GetMyMutableContextFromRoot(self._root)

    def model(self, trim: Trim, gains: Mapping[str, float]) -> LinearModel:
        """Return the continuous model at a trim, in the axes of the heading.

        Args:
            trim: where.
            gains: parameter values by name.
        """
        n, k = trim.speeds.size, trim.memory.size
        count, closed = len(self._law.points), np.array(self._law.closed)
        # the law remembers a yaw moment only if rotors have an inertia
        moments = self._controller.num_continuous_states() - k
        states, inputs = STATE + n + 3 + moments + k, REFERENCE + HELD + count
        seeds = np.eye(states + inputs)
        at_states, at_inputs = seeds[:states], seeds[states:]
        self._fix("reference", reference_of(trim), 0, at_inputs[:REFERENCE])
        held = at_inputs[REFERENCE : REFERENCE + HELD]
        self._fix("guidance", guidance_of(trim), HOLD_X, held)
        flown = law_gains(self._law, self._vehicle, gains)
        self._set("controller", self._controller.gains_index, flown)
        self.set_air(gains)
        probes = np.zeros((closed.size, states + inputs))
        probes[count:] = at_inputs[REFERENCE + HELD :]
        loops = self._in_controller.get_mutable_numeric_parameter(self._controller.probes_index)
        loops.SetFromVector(InitializeAutoDiff(closed, probes).ravel())
        known = [trim.state, trim.speeds, trim.v_WB - trim.vdot_WB * TIME_CONSTANT]
        self._set_state(
            [*known, np.zeros(moments), trim.memory], trim.q_WB, np.zeros_like(at_states)
        )
        moment = self._controller.wanted_yaw_moment(self._in_controller).value()
        if math.isnan(moment):
            raise WorkbenchError(
                f"{self._law.name} uses the previously commanded wrench, so it has no continuous "
                "model: leave --time continuous out"
            )
        self._set_state([*known, np.full(moments, moment), trim.memory], trim.q_WB, at_states)
        _, slopes = self._slopes(trim.q_WB, states + inputs)
        signals = gradient(self._controller.loop_signals(self._in_controller), states + inputs)
        shown = np.vstack([seeds[:STATE], signals, *self._rotors(states + inputs)])
        A = slopes[:, :states]
        turn_with_heading(A, trim.point.yaw_rate, (3, 6, 9, STATE + n))
        return LinearModel(
            A=A,
            input_matrix=slopes[:, states:],
            output_matrix=shown[:, :states],
            feedthrough=shown[:, states:],
            period=0.0,
            states=(
                *motion(),
                *numbered("speed", n, "rad/s"),
                *filtered()[:3],
                *(Signal("yaw_moment", "N*m"),) * moments,
                *memory_of(self._law),
            ),
            inputs=(*references(), *points(self._law)),
            outputs=outputs(n, self._law),
            trim=trim,
            controller=self._law,
        )


class LinearStudy:
    """Reads the vehicle of a scenario, and computes its linear models in milliseconds.

    Args:
        scenario: its vehicle, variation, gains and rates are used; the air is calm.
        description: of its vehicle, if already read.
        vehicle: of that description, if already made.
        controller: in place of the scenario's.

    Raises:
        WorkbenchError: if the vehicle cannot be read.
    """

    def __init__(
        self,
        scenario: Scenario | None = None,
        description: Description | None = None,
        vehicle: Vehicle | None = None,
        controller: Controller | None = None,
    ) -> None:
        self.scenario = at_own_period(scenario or Scenario())
        check_scenario(self.scenario)
        config = self.scenario.vehicle
        self._description = description or read_configured(config)
        self.vehicle = vehicle or make_vehicle(self._description)
        self.controller = controller or flown_controller(self.scenario)
        self.gains: Mapping[str, float] = flight_gains(
            self.vehicle, config.gains, controller=self.controller
        )
        self._flown = varied(self._description, self.vehicle, config.variation)
        self._derivatives = Derivatives(
            self.controller, self._flown, self.vehicle, self.gains, self.scenario.rates
        )
        own = self.controller.estimator
        self._estimator = own or find_estimator(self.scenario.estimator)
        _, self._rate = sampled_estimate(self.scenario.rates.control_period)
        self.home = DEFAULT_HOME
        self._mounting: Mounting | None = None
        self._duties: dict[str, float] = {}
        if self.scenario.estimator != TRUTH:
            imu = find_imu(self.vehicle, noise=False)
            choices = choose_sensors(self.vehicle, self.scenario)
            self.home = read_configured_world(self.scenario).home or DEFAULT_HOME
            self._mounting = mounting_of(imu, choices, self.home)
            self._duties = {
                each.sensor.kind: min(1.0, self.scenario.rates.control_period / each.period)
                for each in reversed(choices)
                if each.sensor.kind in HEARD
            }
            self._derivatives.p_BI = imu.p_BS
        self._estimators = LastCall(self._estimator_with)
        self._bare_vehicle = LastCall(self._vehicle_with)
        self._continuous = LastCall(self._flight_with)

    def like(self, scenario: Scenario, controller: Controller | None = None) -> "LinearStudy":
        """Return a study of the same description with another variation, gains, rates or law.

        Most of the time of a study is for reading the description.
        """
        return LinearStudy(scenario, self._description, self.vehicle, controller)

    def trim(self, point: OperatingPoint = HOVER, gains: Mapping[str, float] | None = None) -> Trim:
        """Return the trim of an operating point.

        Args:
            point: the operating point.
            gains: parameter values by name that differ from the scenario's.

        Raises:
            WorkbenchError: if the vehicle cannot fly like that.
        """
        values = self._values(gains)
        self._derivatives.set_gains(values)
        with sentences("there is no trim"):
            return find_trim(self._derivatives, self.vehicle, values, point, self._rate)

    def sampled(
        self, point: OperatingPoint = HOVER, gains: Mapping[str, float] | None = None
    ) -> LinearModel:
        """Return the exact model of the flight, from one control update to the next.

        Arguments and exceptions are those of `trim`.
        """
        return self._sampled(point, gains).lean(REMOVABLE)

    def noisy(
        self, point: OperatingPoint = HOVER, gains: Mapping[str, float] | None = None
    ) -> LinearModel:
        """Return the sampled model, with the noise of every sample of every sensor as inputs.

        Arguments and exceptions are those of `trim`.
        """
        values, rates = self._values(gains), self.scenario.rates
        every = sample_steps(values["gyro_rate"], rates.physics_step, rates.control_steps)
        return self._sampled(point, gains, rates.control_steps // every).lean(REMOVABLE)

    def plant_input(
        self, point: OperatingPoint = HOVER, gains: Mapping[str, float] | None = None
    ) -> LinearModel:
        """Return the closed sampled loop from the plant's input to it.

        The plant's input is the wrench that an update commands: force along z and moment in T. The
        wrench is the output, and an injection is added on its way to the rotors, unknown to the
        law. So every law is judged at the same point, even one that uses its own commands.

        Arguments and exceptions are those of `trim`.
        """
        signals = wrench()
        model = self._sampled(point, gains, injected=signals)
        loop = dataclasses.replace(
            model,
            input_matrix=model.B([signal.name for signal in signals]),
            output_matrix=self._wrench(model, model.A),
            feedthrough=np.zeros((len(signals), len(signals))),
            inputs=signals,
            outputs=signals,
        )
        return loop.lean(REMOVABLE)

    def wrench_by(
        self, points: Sequence[str], gains: Mapping[str, float] | None = None
    ) -> np.ndarray:
        """Return the wrench that an update of all parts commands in hover per injection (4, P).

        Args:
            points: of the injections.
            gains: parameter values by name that differ from the scenario's.
        """
        trim, known = self.trim(HOVER, gains), list(self.controller.points)
        update = self._derivatives.whole_update(*update_inputs(trim, self._rate))
        first = update.commands_by.shape[1] - trim.memory.size - len(known)
        by_commands, _ = self._derivatives.allocation_at(trim.commands)
        columns = [first + known.index(point) for point in points]
        found: np.ndarray = by_commands @ update.commands_by[:, columns]
        return found

    def _wrench(self, model: LinearModel, rows: np.ndarray) -> np.ndarray:
        """Return rows (4, k) of the wrench that an update commands, by those of states (m, k)."""
        by_commands, _ = self._derivatives.allocation_at(model.trim.commands)
        newest = [model.state_names.index(f"command_{k + 1}") for k in range(by_commands.shape[1])]
        found: np.ndarray = by_commands @ rows[newest]
        return found

    def continuous(
        self, point: OperatingPoint = HOVER, gains: Mapping[str, float] | None = None
    ) -> LinearModel:
        """Return the model of the continuous core, which has no sampling, hold or delay.

        Arguments and exceptions are those of `trim`.
        """
        trim, values = self.trim(point, gains), self._values(gains)
        if self.scenario.estimator != TRUTH:
            raise WorkbenchError(
                f"the estimator {self.scenario.estimator} is sampled, so it has no continuous "
                "model: leave --time continuous out, or use `--estimator truth`"
            )
        if any(values[name] for name in FILTERS):
            raise WorkbenchError(
                "filters are sampled, so they have no continuous model: leave --time "
                "continuous out, or switch off " + ", ".join(n for n in FILTERS if values[n])
            )
        core = self._continuous(np.array(payload_of(values)))
        return core.model(trim, values)

    def bare_vehicle(
        self, point: OperatingPoint = HOVER, gains: Mapping[str, float] | None = None
    ) -> LinearModel:
        """Return the continuous model of the vehicle alone, from rotor commands to motion.

        Arguments and exceptions are those of `trim`.
        """
        trim, values = self.trim(point, gains), self._values(gains)
        core = self._bare_vehicle(np.array(payload_of(values)))
        return core.model(trim, values)

    def _sampled(
        self,
        point: OperatingPoint,
        gains: Mapping[str, float] | None,
        samples: int = 0,
        injected: tuple[Signal, ...] = (),
    ) -> LinearModel:
        trim = self.trim(point, gains)
        estimator = self._estimator_at(trim, self._values(gains))
        rates, delays = self.scenario.rates, self._delays
        return sampled_model(
            self._derivatives, trim, rates, self._rate, delays, estimator, samples, injected
        )

    def _estimator_at(self, trim: Trim, values: Mapping[str, float]) -> EstimatorModel | None:
        """Return the model of the estimator at a trim; the last one is cached.

        Raises:
            WorkbenchError: in a turn, which has no such model.
        """
        estimator = self._estimator
        if not estimator:
            return None
        if trim.point.yaw_rate:
            raise WorkbenchError(
                f"a turn cannot be linearised with the estimator {estimator.name}: set the yaw "
                "rate to 0, or use the true state"
            )
        settings = np.array([values[name] for name in estimator.settings._fields])
        return self._estimators(settings, trim.state, trim.vdot_WB)

    def _estimator_with(
        self, settings: np.ndarray, state: np.ndarray, vdot_WB: np.ndarray
    ) -> EstimatorModel:
        assert self._estimator and self._mounting
        period = self.scenario.rates.control_period
        return estimator_model(
            self._estimator, settings, self._mounting, self._duties, period, state, vdot_WB
        )

    @property
    def _delays(self) -> Delays:
        rates = self.scenario.rates
        return self.scenario.vehicle.variation.delays(rates.physics_step, rates.control_period)

    def _vehicle_with(self, payload: np.ndarray) -> VehicleDerivatives:
        """Return the vehicle with a payload, see `Payload` (8)."""
        values = {**self.gains, **Payload(*payload.tolist())._asdict()}
        return VehicleDerivatives(
            make_vehicle_core(self._flown, self.vehicle, values), self.vehicle
        )

    def _flight_with(self, payload: np.ndarray) -> FlightDerivatives:
        """Return vehicle and law with a payload, see `Payload` (8)."""
        values = {**self.gains, **Payload(*payload.tolist())._asdict()}
        core = make_flight_core(self.controller, self._flown, self.vehicle, values)
        return FlightDerivatives(core, self.controller, self.vehicle)

    def _values(self, gains: Mapping[str, float] | None) -> dict[str, float]:
        return {**self.gains, **parameter_table(self.controller).checked(gains or {})}
