"""The vehicle in its world: rigid body, rotors, air and contact as one sampled LeafSystem."""

import math
from dataclasses import replace
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

from workbench.common.compiled import compile_cached
from workbench.common.jitable import register_jitable, taking
from workbench.common.machine_code import OtherKindError
from workbench.dynamics.air.normals import COUNT, draw_normals
from workbench.dynamics.air.settings import AirSettings
from workbench.dynamics.air.update import EDDIES, push_at, wind_at
from workbench.dynamics.rigid_body import rigid_body
from workbench.dynamics.vehicle_step import (
    FULL,
    ROW,
    changes_thrust,
    given,
    rotor_rows,
    rotor_thrusts,
    static_thrust,
    step_vehicle,
    voltage_share,
)
from workbench.estimation.filters import after, lowpass, output
from workbench.estimation.gyro import (
    STATES,
    UNFILTERED,
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
    CONSTANTS,
    FROZEN,
    MEAN,
    ON,
    PLACE,
    SILENT,
    SOURCE,
    SPREAD,
    TURN,
    drawn_bias,
    measured,
    noisy_sample,
    packed,
    six,
    step_drift,
)
from workbench.plant.contact import Contact
from workbench.plant.description import Description
from workbench.plant.loading import make_vehicle
from workbench.plant.payload import NO_PAYLOAD, Payload, laden
from workbench.plant.sensors import Imu
from workbench.plant.worlds.world import EMPTY, World
from workbench.systems.noise import noise_seed
from workbench.systems.weak_callback import weakly

BODY, MEMORY = range(2)
"""Groups of the discrete state."""
LAST, WIND, EDDY, AWAY = 0, 6, 9, 9 + EDDIES
GYRO, RATES = AWAY + 1, AWAY + 1 + STATES
ACCEL = RATES + 3
SAMPLE, SUMS, ELAPSED, BIAS = ACCEL + 6, ACCEL + 12, ACCEL + 18, ACCEL + 19
DRIFT, SPEEDS = BIAS + 6, BIAS + 12
"""Indices of the memory: acceleration in the middle of the previous step (6), velocity of the air
at the vehicle in W (3), states of the turbulence, number of steps that are free of contact (1),
states of the gyro's filters (12) and the angular velocity in B of its last sample (3), states of
the accelerometer's low-pass (6), the last IMU sample (6), the integral of its samples since the
last reading (6) and their number, -1 before the first (1), its biases (6) and their drift (6),
rotor speeds (n), and shares of thrust that rotors gave in the previous step (n)."""
SEED = len(AirSettings._fields)
SETTINGS = SEED + 1
FAULT = SETTINGS + len(GyroSettings._fields)
IMU_SEED, SHARES = FAULT + 1, FAULT + 2
"""Indices of numeric parameter 0 after `AirSettings`: the seed, `GyroSettings`, fault and seed of
the IMU, shares (n), and the body (16)."""
AIR, PAYLOAD = range(2)
"""Numeric parameters."""
TOUCHED = -1.0
"""As the number of steps free of contact: there was contact in the previous step."""
DONE, NEAR, BROKEN = range(3)
"""Results of a step, see `advance`."""
SUPPLY, READOUT, IMU = 2, 6, 7
ROTORS = IMU + CONSTANTS
"""Places of the battery's supply, of the steps between two readings of the IMU, of that, and of the
rotors, in the constants of `advance`."""
TURBULENCE, AREA, DENSITY = (
    AirSettings._fields.index(name) for name in ("turbulence", "drag_area", "air_density")
)

take_state, take_six, take_four, take_body = taking(13), taking(6), taking(4), taking(16)

SOURCES = (
    "dynamics",
    "estimation/filters.py",
    "estimation/gyro.py",
    "estimation/imu.py",
    "systems/vehicle_dynamics.py",
    "plant/contact.py",
    "plant/gravity.py",
)
"""Sources of the compiled steps below `workbench/`."""


# counting references to views of arrays would take two thirds of the time
@register_jitable(forceinline=True, _nrt=False)
def advance(time, commands, values, constants, places, state, memory):
    """Do a step in the air, in place; this is what gets compiled.

    A step of length zero does not move the body, but writes the present acceleration. Neither this
    function nor those that it calls may make an array.

    Args:
        time: now [s].
        commands: of the rotor speeds (n) [rad/s].
        values: of numeric parameter 0.
        constants: the physics step [s]; the step to do [s]; the battery's supply (4), see
            `vehicle_step.loaded`; steps between two readings of the IMU; that, see `imu.packed`,
            or zeros where nobody reads it; and a row a rotor for that step, see
            `vehicle_step.rotor_rows`.
        places: for numbers of the step, see `step_places`.
        state: of the body (13).
        memory: see `MEMORY`.

    Returns:
        DONE; NEAR if there may be contact, then nothing was done; or BROKEN if the result is not a
        finite number.
    """
    if memory[AWAY] < 1.0:
        return NEAR
    memory[AWAY] -= 1.0
    period, step = constants[0], constants[1]
    rotors = constants[ROTORS:].reshape(-1, ROW)
    n = len(rotors)
    shares, body = values[SHARES : SHARES + n], values[SHARES + n :]
    noise, middles, slopes = places[:COUNT], places[COUNT : COUNT + n], places[COUNT + n :]
    number = int(time / period + 0.5)
    if step > 0.0:
        _sample_imu(number, values[SETTINGS:SHARES], constants, state, memory)
    if values[TURBULENCE] != 0.0:
        draw_normals(values[SEED], number, noise)
    eddies = memory[EDDY:AWAY]
    air = wind_at(time, state, noise, values, period, eddies, eddies)
    memory[WIND], memory[WIND + 1], memory[WIND + 2] = air
    after, acceleration = step_vehicle(
        take_state(state),
        take_six(memory[LAST:WIND]),
        memory[SPEEDS : SPEEDS + n],
        commands,
        shares,
        air,
        push_at(time, state, values, period),
        0.5 * values[DENSITY] * values[AREA],
        take_four(constants[SUPPLY:READOUT]),
        take_body(body),
        rotors,
        step,
        middles,
        slopes,
        memory[SPEEDS : SPEEDS + n],
    )
    for i in range(n):
        memory[SPEEDS + n + i] = given(shares[i])
    total = 0.0
    for i in range(13):
        state[i] = after[i]
        total += after[i]
    for i in range(6):
        memory[LAST + i] = acceleration[i]
        total += acceleration[i]
    return DONE if math.isfinite(total) else BROKEN


@register_jitable
def step_places(n: int) -> np.ndarray:
    """Return places for the numbers of a step with n rotors, which steps may use again."""
    return np.empty(COUNT + 2 * n)


@register_jitable(forceinline=True)
def _sample(number, every, settings, imu, state, memory):
    """Return the sample (6) at a step: of a perfect gyro alone where nobody reads the IMU."""
    if imu[ON] == 0.0:
        return body_rates(state) + (0.0, 0.0, 0.0)
    fault, seed = settings[FAULT - SETTINGS], settings[IMU_SEED - SETTINGS]
    bias, drift = six(memory[BIAS:DRIFT]), six(memory[DRIFT:SPEEDS])
    if memory[ELAPSED] < 0.0:
        bias = drawn_bias(imu[MEAN:SPREAD], imu[SPREAD:CONSTANTS], seed)
    elif fault in (FROZEN, SILENT):
        return six(memory[SAMPLE:SUMS])
    exact = measured(state, memory[LAST:WIND], imu[PLACE:TURN])
    return noisy_sample(exact, number, every, fault, bias + drift, imu, seed)


@register_jitable(forceinline=True)
def _sample_imu(number, settings, constants, state, memory):
    """Let the IMU take a sample, if one is due at this step."""
    period, readout, imu = constants[0], int(constants[READOUT]), constants[IMU:ROTORS]
    every = sample_steps(settings[0], period, readout)
    if number % every:
        return
    sample = _sample(number, every, settings, imu, state, memory)
    coefficients = gyro_filter(settings, every * period)
    x = memory[GYRO:RATES]
    rates = filtered_rates(coefficients, x, sample[0:3])
    states = stepped_filters(coefficients, x, sample[0:3])
    for i in range(STATES):
        memory[GYRO + i] = states[i]
    for i in range(3):
        memory[RATES + i] = rates[i]
    if imu[ON] == 0.0:
        return
    seed, first = settings[IMU_SEED - SETTINGS], memory[ELAPSED] < 0.0
    if first:
        bias = drawn_bias(imu[MEAN:SPREAD], imu[SPREAD:CONSTANTS], seed)
        for i in range(6):
            memory[BIAS + i] = bias[i]
    section = lowpass(settings[5], settings[6], every * period)
    for i in range(3):
        row, force = ACCEL + 2 * i, sample[3 + i]
        if first:
            memory[row + 1] = force
        smooth = output(section, memory[row], memory[row + 1], force)
        memory[row], memory[row + 1] = after(section, memory[row], memory[row + 1], force)
        memory[SUMS + 3 + i] += every * smooth
        memory[SUMS + i] += 0.5 * every * (memory[SAMPLE + i] + sample[i])
    for i in range(6):
        memory[SAMPLE + i] = sample[i]
    memory[ELAPSED] += every
    if first or number % readout == 0:
        memory[ELAPSED] = 0.0
        for i in range(6):
            memory[SUMS + i] = 0.0
        step_drift(memory[DRIFT:SPEEDS], number, imu, seed)


def read_imu(time, values, constants, state, memory, reading):
    """Write a reading of the IMU (9); this is compiled, too.

    It is the mean angular velocity and specific force since the previous reading, and the filtered
    angular velocity of the gyro, in B. The arguments are those of `advance`, with places for the
    result instead of those of the step.
    """
    settings, period, readout = values[SETTINGS:SHARES], constants[0], int(constants[READOUT])
    every = sample_steps(settings[0], period, readout)
    sample = _sample(
        int(time / period + 0.5), every, settings, constants[IMU:ROTORS], state, memory
    )
    coefficients = gyro_filter(settings, every * period)
    rates = filtered_rates(coefficients, memory[GYRO:RATES], sample[0:3])
    section = lowpass(settings[5], settings[6], every * period)
    for i in range(3):
        reading[i], reading[3 + i], reading[6 + i] = sample[i], sample[3 + i], rates[i]
        if memory[ELAPSED] >= 0.0:
            row, elapsed = ACCEL + 2 * i, memory[ELAPSED] + every
            turned = 0.5 * every * (memory[SAMPLE + i] + sample[i])
            pushed = every * output(section, memory[row], memory[row + 1], sample[3 + i])
            reading[i] = (memory[SUMS + i] + turned) / elapsed
            reading[3 + i] = (memory[SUMS + 3 + i] + pushed) / elapsed


@register_jitable
def gyro_reading(time, values, constants, state, memory, reading):
    """Write the state (13) with the gyro's filtered angular velocity; this is compiled, too.

    The arguments are those of `advance`, with places for the result instead of those of the step.
    """
    settings, period, readout = values[SETTINGS:SHARES], constants[0], int(constants[READOUT])
    every = sample_steps(settings[0], period, readout)
    if not filters_gyro(settings, every * period):
        reading[:] = state
        return
    rates = (memory[RATES], memory[RATES + 1], memory[RATES + 2])
    if int(time / period + 0.5) % every == 0:
        coefficients = gyro_filter(settings, every * period)
        rates = filtered_rates(coefficients, memory[GYRO:RATES], body_rates(state))
    found = sensed(state, rates)
    for i in range(13):
        reading[i] = found[i]


compiled_imu = compile_cached(read_imu, SOURCES, "the IMU", parts=28)
compiled_reading = compile_cached(gyro_reading, SOURCES, "the gyro", parts=46)
compiled_advance = compile_cached(advance, SOURCES, "the vehicle's motion", parts=84, _nrt=False)


class VehicleDynamics(LeafSystem):
    """Integrates a vehicle with its rotors, in air and in contact.

    In the air a step is second order, see `rigid_body`. In contact, Drake's contact solver makes
    the step, see `plant.contact`. The choice depends only on the state.

    Input ports:
        commands (n): rotor speeds [rad/s], clipped to the rotors' range.
        supply (4): of the battery, see `vehicle_step.loaded`; only if the description has a
            battery. If unconnected, its voltage is always the full one.
    Output ports:
        state (13): q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        sensed (13): the same with the gyro's filtered angular velocity.
        imu (9): a reading of the IMU, see `read_imu`; only if an estimator uses it.
        speeds (n): of the rotors [rad/s].
        wind (3): velocity of the air at the vehicle, in W [m/s].
        thrusts (n): of the rotors [N].
        static_thrusts (n): the same at rest far from the ground, which determine drag torque and
            power [N]; only if inflow or ground effect change thrusts.
        acceleration (6): angular, and of the origin, in W, mean of the last step [rad/s², m/s²].
        voltage (1): of the battery under load over that of the full one without load; only if the
            description has a battery.
    Numeric parameter 0: `AirSettings`, the seed of the turbulence, see `set_seed`, `GyroSettings`,
    the share of its thrust that each rotor gives (n), initially 1, and the body (16), which follows
    from the payload, see `set_payload`.
    Numeric parameter 1: `Payload`.

    The state is that of the body's origin, and is continuous when the payload changes: a payload
    that is picked up has the velocity of the body at its place, and adds its own momentum.

    Args:
        description: of the vehicle, without its payload.
        settings: initial ones of the air.
        step: of the physics [s].
        world: the surroundings.
        payload: initial one.
        gyro: initial settings.
        readout: physics steps between two readings of the IMU; each step may take a sample.
        imu: for an estimator, if any; without one the gyro is ideal.
    """

    def __init__(
        self,
        *,
        description: Description,
        settings: AirSettings,
        step: float,
        world: World = EMPTY,
        payload: Payload = NO_PAYLOAD,
        gyro: GyroSettings = UNFILTERED,
        readout: int = 1,
        imu: Imu | None = None,
    ) -> None:
        super().__init__()
        self._vehicle = make_vehicle(description)
        rotors = description.rotors
        if not world.ground:
            rotors = tuple(replace(rotor, ground_effect_coefficient=0.0) for rotor in rotors)
        n = self._n = len(rotors)
        self._step = step
        read = packed(imu, step, readout * step) if imu else np.zeros(CONSTANTS)
        self._constants, self._present = (
            np.concatenate(
                [[step, length], FULL, [readout], read, rotor_rows(rotors, length).ravel()]
            )
            for length in (step, 0.0)
        )
        self._rows = rotor_rows(rotors, step)
        self._changes = any(changes_thrust(row) for row in self._rows)
        touchable = world.ground or bool(world.names)
        self._contact = Contact(description, world, step) if touchable else None
        body = self._body(payload)
        values = [*settings, 0.0, *gyro, 0.0, 0.0, *[1.0] * n, *body]
        self.DeclareNumericParameter(BasicVector(values))
        self.DeclareNumericParameter(BasicVector(list(payload)))
        self._commands = self.DeclareVectorInputPort("commands", n)
        stated = description.battery is not None
        self._supply = self.DeclareVectorInputPort("supply", 4) if stated else None
        if self._supply:
            needs = {self.xd_ticket(), self._supply.ticket()}
            self.DeclareVectorOutputPort("voltage", 1, self._calc_voltage, needs)
        self.DeclareStateOutputPort("state", self.DeclareDiscreteState(13))
        self.DeclareDiscreteState(SPEEDS + 2 * n)
        for name, size, calc in (
            ("speeds", n, self._calc_speeds),
            ("wind", 3, self._calc_wind),
            ("thrusts", n, self._calc_thrusts),
            ("acceleration", 6, self._calc_acceleration),
        ):
            self.DeclareVectorOutputPort(name, size, calc, {self.xd_ticket()})
        needs = {self.xd_ticket(), self.time_ticket(), self.pn_ticket()}
        self.DeclareVectorOutputPort("sensed", 13, self._calc_sensed, needs)
        if imu:
            self.DeclareVectorOutputPort("imu", 9, self._calc_imu, needs)
        if self._changes:
            self.DeclareVectorOutputPort(
                "static_thrusts", n, self._calc_static_thrusts, {self.xd_ticket()}
            )
        self._kept = self.DeclareCacheEntry(
            "parameters and constants",
            ValueProducer(lambda: Value[object](()), weakly(self._calc_kept)),
            {self.pn_ticket(), *({self._supply.ticket()} if self._supply else ())},
        ).cache_index()
        self._held = self.DeclareCacheEntry(
            "commands, parameters and constants",
            ValueProducer(lambda: Value[object](()), weakly(self._calc_held)),
            {self._commands.ticket(), self.cache_entry_ticket(self._kept)},
        ).cache_index()
        self.DeclarePeriodicDiscreteUpdateEvent(step, 0.0, self._update)

    def set_seed(self, context: Context, seed: int) -> None:
        """Set the seed of turbulence and IMU; equal seeds give equal noise."""
        values = context.get_mutable_numeric_parameter(AIR)
        values.SetAtIndex(SEED, float(noise_seed(seed, "air")))
        values.SetAtIndex(IMU_SEED, float(noise_seed(seed, SOURCE)))

    def payload(self, context: Context) -> Payload:
        """Return the payload."""
        return Payload(*context.get_numeric_parameter(PAYLOAD).get_value().tolist())

    def set_payload(self, context: Context, payload: Payload) -> None:
        """Let the vehicle carry a payload from now on."""
        context.get_mutable_numeric_parameter(PAYLOAD).SetFromVector(list(payload))
        values = context.get_mutable_numeric_parameter(AIR).get_mutable_value()
        values[SHARES + self._n :] = self._body(payload)

    def place(self, context: Context, state: np.ndarray, speeds: np.ndarray) -> None:
        """Begin at a state of the body (13), with the rotors at speeds (n) [rad/s].

        The first step uses the velocities at its start, because there is no previous acceleration.
        """
        context.SetDiscreteState(BODY, state)
        memory = np.concatenate([np.zeros(SPEEDS), speeds, np.ones(self._n)])
        rates = body_rates(state)
        memory[GYRO:ACCEL] = (*at_rest(rates), *rates)
        memory[ELAPSED] = -1.0
        context.SetDiscreteState(MEMORY, memory)

    def body_state(self, context: Context) -> np.ndarray:
        """Return a copy of the state of the body (13)."""
        return np.array(context.get_discrete_state(BODY).value())

    @property
    def above_ground(self) -> np.ndarray:
        """See `Contact.above_ground`; empty if that is None (0 or 4)."""
        sphere = self._contact.above_ground if self._contact else None
        return np.empty(0) if sphere is None else sphere

    def step_constants(self) -> np.ndarray:
        """Return a copy of the constants of `advance`, with a battery that is full."""
        return self._constants.copy()

    def _body(self, payload: Payload) -> np.ndarray:
        """Return the body that flies with a payload, see `rigid_body.RigidBody` (16)."""
        flown = laden(self._vehicle, payload)
        return rigid_body(flown.mass, flown.inertia, flown.p_BoBcm_B).packed()

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        # Drake hands over the new state as a copy of the old one, and each number is read before
        # it is written; asking for the old one besides would take some microseconds.
        state = discrete_state.get_mutable_value(BODY)
        memory = discrete_state.get_mutable_value(MEMORY)
        held = self.get_cache_entry(self._held).Eval(context)
        known = (context.get_time(), *held, state, memory)
        try:
            found = compiled_advance.run(*known)
        except OtherKindError:
            found = compiled_advance(*known)
        if found == NEAR and self.find_free(state, memory):
            found = compiled_advance(*known)
        if found == DONE:
            return
        if found == BROKEN:
            raise RuntimeError("forces or motion of the vehicle are not finite")
        assert self._contact
        acceleration = self._free_acceleration(context, known[1])
        memory[AWAY] = 1.0
        compiled_advance(*known[:5], state.copy(), memory)  # rotors and air alone
        memory[AWAY] = TOUCHED
        before = state[7:13].copy()
        self._contact.carry(self.payload(context))
        state[:] = self._contact.moved(state, acceleration)
        memory[LAST:WIND] = (state[7:13] - before) / self._step

    def find_free(self, state: np.ndarray, memory: np.ndarray) -> bool:
        """Return whether the vehicle is free of contact, and write for how many steps.

        Args:
            state: of the body (13).
            memory: see `MEMORY`.
        """
        if memory[AWAY] == TOUCHED and self._contact and self._contact.touches(state):
            return False  # as in the last step: measuring the distance would cost as much as a step
        steps = self._contact.steps_away(state) if self._contact else np.inf
        free = steps >= 1.0 or not (self._contact and self._contact.touches(state))
        memory[AWAY] = max(steps, 1.0) if free else 0.0
        return free

    def _free_acceleration(self, context: Context, commands: np.ndarray) -> np.ndarray:
        """Return accelerations now, in W (6), as if nothing were touched; see the output port."""
        state = context.get_discrete_state(BODY).value().copy()
        memory = context.get_discrete_state(MEMORY).value().copy()
        memory[AWAY] = 1.0
        values = context.get_numeric_parameter(AIR).CopyToVector()  # of the kind that is compiled
        constants = self._supplied(context, self._present)
        known = context.get_time(), commands, values, constants, step_places(self._n)
        compiled_advance(*known, state, memory)
        return memory[LAST:WIND]

    def _calc_kept(self, context: Context, output: Any) -> None:
        """Copy what only changes with an action or the battery; say whether a gyro filter is on."""
        values = context.get_numeric_parameter(AIR).CopyToVector()
        settings = values[SETTINGS:SHARES].tolist()
        every = sample_steps(settings[0], self._step, int(self._constants[READOUT]))
        filters = filters_gyro(settings, every * self._step)
        output.set_value((values, self._supplied(context, self._constants), filters))

    def _calc_held(self, context: Context, output: Any) -> None:
        """Copy what only changes with a control update: reading it costs as much as a step."""
        commands = np.array(self._commands.Eval(context))
        values, constants, _ = self.get_cache_entry(self._kept).Eval(context)
        output.set_value((commands, values, constants, step_places(self._n)))

    def _supplied(self, context: Context, constants: np.ndarray) -> np.ndarray:
        """Return constants of `advance` with what the battery supplies now."""
        if self._supply and self._supply.HasValue(context):
            constants = constants.copy()
            constants[SUPPLY:READOUT] = self._supply.Eval(context)
        return constants

    def _calc_voltage(self, context: Context, output: BasicVector) -> None:
        memory = context.get_discrete_state(MEMORY).get_value()
        speeds, shares = memory[SPEEDS : SPEEDS + self._n], memory[SPEEDS + self._n :]
        supply = self._supplied(context, self._constants)[SUPPLY:READOUT]
        output.SetFromVector([voltage_share(speeds, shares, supply, self._rows)])

    def _calc_sensed(self, context: Context, output: BasicVector) -> None:
        state = context.get_discrete_state(BODY).get_value()
        values, _, filters = self.get_cache_entry(self._kept).Eval(context)
        if not filters:  # as `gyro_reading` does, for less
            output.SetFromVector(state)
            return
        compiled_reading(
            context.get_time(),
            values,
            self._constants,
            state,
            context.get_discrete_state(MEMORY).get_value(),
            output.get_mutable_value(),
        )

    def _calc_imu(self, context: Context, output: BasicVector) -> None:
        compiled_imu(
            context.get_time(),
            context.get_numeric_parameter(AIR).get_value(),
            self._constants,
            context.get_discrete_state(BODY).get_value(),
            context.get_discrete_state(MEMORY).get_value(),
            output.get_mutable_value(),
        )

    def _calc_acceleration(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(context.get_discrete_state(MEMORY).get_value()[LAST:WIND])

    def _calc_speeds(self, context: Context, output: BasicVector) -> None:
        memory = context.get_discrete_state(MEMORY).get_value()
        output.SetFromVector(memory[SPEEDS : SPEEDS + self._n])

    def _calc_wind(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(context.get_discrete_state(MEMORY).get_value()[WIND:EDDY])

    def _calc_static_thrusts(self, context: Context, output: BasicVector) -> None:
        memory = context.get_discrete_state(MEMORY).get_value()
        speeds, shares = memory[SPEEDS : SPEEDS + self._n], memory[SPEEDS + self._n :]
        output.SetFromVector(static_thrust(speeds, shares, self._rows.T))  # of all at once

    def _calc_thrusts(self, context: Context, output: BasicVector) -> None:
        if not self._changes:
            self._calc_static_thrusts(context, output)
            return
        state = context.get_discrete_state(BODY).get_value()
        memory = context.get_discrete_state(MEMORY).get_value()
        speeds, shares = memory[SPEEDS : SPEEDS + self._n], memory[SPEEDS + self._n :]
        wind = memory[WIND:EDDY]
        output.SetFromVector(rotor_thrusts(state, speeds, shares, wind, self._rows))
