"""The linear model of a flight in discrete time, from one control period to the next."""

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.control.law_signals import FILTER_STATE_COUNT
from workbench.design.linear.derivatives import HELD_SIZE, REFERENCE_SIZE, Derivatives
from workbench.design.linear.estimation import EstimatorModel
from workbench.design.linear.model import (
    MEASURED_SIGNALS,
    LinearModel,
    ModelSignal,
    Trim,
    accel_states,
    filter_signals,
    gyro_states,
    imu_signals,
    law_memory_signals,
    loop_point_signals,
    motion_signals,
    output_signals,
    reference_signals,
    rotor_signals,
    sensor_noise,
)
from workbench.design.linear.seeds import MOTION_STATE_SIZE, heading_turn
from workbench.design.linear.trim import update_inputs
from workbench.design.linear.update import ControlUpdate
from workbench.design.linear.vehicle import HeldCommandStep, command_signals
from workbench.estimation.gyro import GYRO_STATE_COUNT
from workbench.plant.variation import Delays
from workbench.scenario.scenario import Rates

ACCEL_FILTER_SIZE = 6
IMU_READING_SIZE = 6
"""Number of states of the accelerometer's filter, two an axis, and numbers in a reading of the
IMU."""
RATE_STATES = slice(6, 9)
"""Indices of the angular velocity in the motion."""


def sampled_model(
    derivatives: Derivatives,
    trim: Trim,
    rates: Rates,
    rate: float,
    delays: Delays,
    estimator: EstimatorModel | None = None,
    samples: int = 0,
    injected: tuple[ModelSignal, ...] = (),
) -> LinearModel:
    """Return the linear model of a control period.

    States are those just before an update: the motion, rotor speeds, joints, the filters of the
    gyro, and of the accelerometer with the sample of the update, the reading of the IMU, the memory
    of the estimator, commands that act or are still to act, the stages before the law, the motions
    that a delayed controller has not yet seen, the memory of the law, and the setpoints of servos
    with a delay or a low-pass. Outputs are those at the update.
    Filters that are off have states, too; `LinearModel.lean` removes them.

    Between updates commands are held. The matrix of the period is the product of the exact
    derivatives of the update and of the exact model of the vehicle over each physics step, in axes
    that turn with the heading. Limits of servos, also of their rates, are left out.

    Args:
        derivatives: of vehicle and law.
        trim: where.
        rates: of physics and control.
        rate: of the acceleration estimate [1/s].
        delays: of sensing and commands.
        estimator: at the trim, if the law does not use the true motion.
        samples: number of IMU samples in a period, with the noise of each as an input; 0 leaves out
            the noise of sensors.
        injected: `wrench_signals`, to inject it on its way to the rotors, unknown to the law, with
            those of earlier updates that still wait as states; nothing for none.

    Raises:
        WorkbenchError: for a turn with a sensing delay, which has no such model.
    """
    late, look = delays.sensing_delay
    age, since = delays.command_delay
    waiting = max(1, age + 1 if since else age)  # the law remembers its last commands
    if late and trim.point.yaw_rate:
        raise WorkbenchError("a turn cannot be linearised with a delayed controller: leave one out")
    measured_joints = derivatives.measured_joints
    update = derivatives.update(*update_inputs(trim, rate, measured_joints))
    c, seen_size = trim.commands.size, MOTION_STATE_SIZE + measured_joints.size
    n, k, axes = trim.speeds.size, len(update.memory_by), len(injected)
    joint_signals = derivatives.plant.joint_signals
    count = len(derivatives.controller.points)
    e = len(estimator.names) if estimator else 0
    setpoint_filter = derivatives.setpoint_filter
    sizes = (
        MOTION_STATE_SIZE,
        n,
        len(joint_signals),
        GYRO_STATE_COUNT,
        ACCEL_FILTER_SIZE,
        IMU_READING_SIZE,
        e,
        *[c] * waiting,
        FILTER_STATE_COUNT,
        *[MOTION_STATE_SIZE] * late,
        k,
        len(setpoint_filter.states),
    )
    sizes += (axes,) * waiting
    at = np.cumsum([0, *sizes])
    size = int(at[-1])
    groups = [slice(int(a), int(b)) for a, b in zip(at[:-1], at[1:], strict=True)]
    s, speed, joint, gyro, accel, sample, known_motion = groups[:7]
    commands, before, older = groups[7 : 7 + waiting], groups[7 + waiting], groups[8 + waiting :]
    older, memory, driven, earlier = older[:late], *older[late : late + 2], older[late + 2 :]
    moving = slice(0, accel.stop)

    asked = slice(0, REFERENCE_SIZE + HELD_SIZE + count)
    noise = slice(asked.stop, asked.stop + MOTION_STATE_SIZE)
    sampling = slice(noise.stop, noise.stop + IMU_READING_SIZE * samples)
    measuring = slice(sampling.stop, sampling.stop + (len(MEASURED_SIGNALS) if samples else 0))
    inputs = measuring.stop + axes
    known = seen_size + FILTER_STATE_COUNT + c
    whole = np.eye(size)
    at_trim = derivatives.gyro(trim.state, np.concatenate([np.zeros(3), trim.vdot_WB]))
    rates_read = at_trim.C @ whole[gyro] + at_trim.D @ (at_trim.rates_by @ whole[s])
    now_seen = derivatives.sensed(at_trim, whole[s], rates_read)
    seen_in, read_in = np.zeros((MOTION_STATE_SIZE, inputs)), np.zeros((3, inputs))
    if samples:
        read_in[:, sampling][:, :3] = at_trim.D
        if derivatives.gyro_filters:
            seen_in[RATE_STATES] = at_trim.sensed_by_rates @ read_in
    if estimator:
        told = np.vstack([whole[s], whole[sample], rates_read, whole[known_motion]])
        measured_in = np.zeros((len(told), inputs))
        measured_in[
            MOTION_STATE_SIZE + IMU_READING_SIZE : MOTION_STATE_SIZE + IMU_READING_SIZE + 3
        ] = read_in
        parts = (
            np.eye(len(MEASURED_SIGNALS), inputs, measuring.start) if samples else measured_in[:0]
        )
        both_in = np.vstack([measured_in, parts])
        now_seen = estimator.seen_by[:, : len(told)] @ told
        seen_in = estimator.seen_by[:, : len(both_in)] @ both_in
    seen = np.zeros((known + k, size))
    seen[:MOTION_STATE_SIZE] = whole[older[-1]] if late else now_seen
    seen_now = np.zeros((MOTION_STATE_SIZE, inputs)) if late else seen_in
    seen[MOTION_STATE_SIZE:seen_size] = whole[joint][measured_joints]
    seen[seen_size : seen_size + FILTER_STATE_COUNT, before] = np.eye(FILTER_STATE_COUNT)
    seen[seen_size + FILTER_STATE_COUNT : known, commands[0]] = np.eye(c)
    seen[known:, memory] = np.eye(k)

    def of_update(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return rows of the update by states and by inputs."""
        by_inputs = np.zeros((rows.shape[0], inputs))
        by_inputs[:, asked] = rows[:, known : known + asked.stop]
        by_inputs += rows[:, :MOTION_STATE_SIZE] @ seen_now
        by_inputs[:, noise] += rows[:, :MOTION_STATE_SIZE]
        return np.hstack([rows[:, :known], rows[:, known + asked.stop :]]) @ seen, by_inputs

    A, B = np.zeros((size, size)), np.zeros((size, inputs))
    now = of_update(update.commands_by)
    # rows of commands by their age in updates, the newest first
    acting = [now, *((whole[each], np.zeros((c, inputs))) for each in commands)]
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
    waits = whole[driven], np.zeros((len(setpoint_filter.states), inputs))
    A[driven], B[driven] = map(setpoint_filter.after, waits, held[-1])
    held = [
        (
            setpoint_filter.setpoints(waits[0], by_state),
            setpoint_filter.setpoints(waits[1], by_input),
        )
        for by_state, by_input in held
    ]
    after, sampled, readings = _states_of_period(
        derivatives, trim, update, held, sampling if samples else None
    )
    A[moving], B[moving] = after
    A[sample], B[sample] = sampled
    if estimator:
        A[known_motion] = estimator.memory_by[:, : len(told)] @ told
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
    remembered = law_memory_signals(derivatives.controller)
    thrusts = np.zeros((n, size))
    vehicle = _vehicle_step(derivatives, trim, update)
    thrusts[:, : joint.stop] = vehicle.thrusts_by[:, : joint.stop]
    C = np.vstack([np.eye(MOTION_STATE_SIZE, size), signals, thrusts, whole[speed], whole[joint]])
    D = np.zeros((C.shape[0], inputs))
    D[MOTION_STATE_SIZE : MOTION_STATE_SIZE + count] = signals_in
    return LinearModel(
        A=A,
        input_matrix=B,
        output_matrix=C,
        feedthrough=D,
        period=rates.control_period,
        states=(
            *_states(n, derivatives.commanded_joints, joint_signals, waiting, late, estimator),
            *remembered,
            *(
                ModelSignal(f"{remembered[i].name}_{ago}_before", remembered[i].unit)
                for i, ago in update.earlier
            ),
            *setpoint_filter.states,
            *(
                ModelSignal(f"{signal.name}_{ago + 1}_before", signal.unit)
                for ago in range(waiting)
                for signal in injected
            ),
        ),
        inputs=(
            *reference_signals(),
            *loop_point_signals(derivatives.controller),
            *motion_signals("noise_"),
            *sensor_noise(samples),
            *injected,
        ),
        outputs=(*output_signals(n, derivatives.controller), *joint_signals),
        trim=trim,
        controller=derivatives.controller,
    )


UpdateRows = tuple[np.ndarray, np.ndarray]
"""Rows by states, and by inputs, at an update."""


def _vehicle_step(derivatives: Derivatives, trim: Trim, update: ControlUpdate) -> HeldCommandStep:
    """Return the vehicle over a physics step."""
    yaw_rate = np.array(trim.point.yaw_rate)
    return derivatives.step(trim.state, trim.speeds, update.commands, trim.joints, yaw_rate)


def _states_of_period(
    derivatives: Derivatives,
    trim: Trim,
    update: ControlUpdate,
    held: list[UpdateRows],
    sampling: slice | None = None,
) -> tuple[UpdateRows, UpdateRows, list[UpdateRows]]:
    """Return motion, speeds, joints and filters of the IMU after a control period.

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
    both = np.eye(count + GYRO_STATE_COUNT + ACCEL_FILTER_SIZE, columns + inputs)
    filters, accel = (
        slice(count, count + GYRO_STATE_COUNT),
        slice(count + GYRO_STATE_COUNT, count + GYRO_STATE_COUNT + ACCEL_FILTER_SIZE),
    )
    sums = np.zeros((IMU_READING_SIZE, columns + inputs))
    rates_read, before, moved = np.zeros((3, columns + inputs)), both[:0], both[:0]
    noise = np.zeros((IMU_READING_SIZE, columns + inputs))
    readings = []
    for number in range(len(held) + 1):
        moves = both[:count]
        if number % every == 0:
            w_B = gyro.rates_by @ moves[:MOTION_STATE_SIZE]
            if number:
                force = gyro.force_by @ np.vstack([moved, moves[:MOTION_STATE_SIZE]]) + noise[3:]
                smooth = gyro.smooth @ both[accel] + gyro.through @ force
                sums += every * np.vstack([0.5 * (before + w_B) + noise[:3], smooth])
                both[accel] = gyro.kept @ both[accel] + gyro.taken @ force
            before, moved = w_B, moves[:MOTION_STATE_SIZE].copy()
        if number == len(held):
            break
        if number % every == 0:
            if sampling:
                noise = np.zeros((IMU_READING_SIZE, columns + inputs))
                first = columns + sampling.start + IMU_READING_SIZE * (number // every)
                noise[:, first : first + IMU_READING_SIZE] = np.eye(IMU_READING_SIZE)
            # a gyro's sample counts by halves in two periods; here it fully counts in the one that
            # it begins, and stands beside the force that ends that
            w_B = w_B + noise[:3]
            rates_read = gyro.C @ both[filters] + gyro.D @ w_B
        readings.append(derivatives.sensed(gyro, moves[:MOTION_STATE_SIZE], rates_read))
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


def _parted(both: np.ndarray, columns: int) -> UpdateRows:
    """Return rows by states, in the first columns, and by inputs."""
    return both[:, :columns], both[:, columns:]


def _states(
    n: int,
    commanded: tuple[str, ...],
    joints: tuple[ModelSignal, ...],
    waiting: int,
    late: int,
    estimator: EstimatorModel | None,
) -> tuple[ModelSignal, ...]:
    commands = (
        signal
        for age in range(waiting)
        for signal in command_signals(
            n, commanded, "command" if age == 0 else f"command_{age}_before"
        )
    )
    seen = (signal for age in range(late) for signal in motion_signals(f"seen_{age + 1}_"))
    return (
        *motion_signals(),
        *rotor_signals("speed", n, "rad/s"),
        *joints,
        *gyro_states(),
        *accel_states(),
        *imu_signals(),
        *(ModelSignal(*each) for each in (estimator.names if estimator else ())),
        *commands,
        *filter_signals(),
        *seen,
    )
