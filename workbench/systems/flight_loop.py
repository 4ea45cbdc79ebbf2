"""A flight's control updates and physics steps in one call of compiled code.

It does the same as `FlightComputer` and `VehicleDynamics` in the diagram, with the same functions
and in the same order: everything that is due at one time reads the state before that time. So the
results are equal to the bit.
"""

import math
from functools import lru_cache
from typing import Any

import numpy as np

from workbench.common.compiled import Compiled, compile_cached
from workbench.common.jitable import register_jitable, unique
from workbench.control.controller import Controller
from workbench.control.flight_law import ALL_PARTS, flight_law
from workbench.control.flight_law import SOURCES as LAW
from workbench.dynamics.rigid_body import into_body, rotation
from workbench.dynamics.vehicle_step import ROW, rotor_thrust, voltage_share
from workbench.plant.contact import sphere_centre, steps_to
from workbench.systems.vehicle_dynamics import (
    AWAY,
    BROKEN,
    DONE,
    EDDY,
    LAST,
    NEAR,
    READOUT,
    ROTORS,
    SPEEDS,
    SUPPLY,
    TOUCHED,
    WIND,
    advance,
    gyro_reading,
    step_places,
)
from workbench.systems.vehicle_dynamics import SOURCES as VEHICLE

REFUSED = BROKEN + 1
"""Result of a step that was not done, because the law returns numbers that are not finite."""


@lru_cache(maxsize=64)
def compiled_loop(controller: Controller) -> Compiled:
    """Return the loop with a controller's law, compiled at its first call."""
    whose = "" if controller.shipped else f" with {controller.name}"
    return compile_cached(
        make_flight_loop(controller),
        (*LAW, *VEHICLE, "systems/flight_loop.py"),
        f"whole flights{whose}",
        parts=120,
        text=controller.digest,
        file=str(controller.file),
        nogil=True,
    )


def make_flight_loop(controller: Controller) -> Any:
    """Return the loop with a controller's law, as a function that compiles."""
    update: Any = register_jitable(flight_law(controller).packed_update)
    divides = bool(controller.dividers)
    straight = (0.0, 0.0, 0.0)

    def flight_loop(
        first,
        last,
        control,
        record,
        reference,
        guidance,
        supply,
        law,
        values,
        constants,
        sphere,
        state,
        memory,
        commands,
        filtered,
        remembered,
        rows,
    ):
        """Do the steps from `first` up to before `last`, in place; this is what gets compiled.

        Args:
            first: number of the first step.
            last: number of the step before which it ends.
            control: steps between control updates.
            record: steps between recorded rows.
            reference: see `guidance.Reference` (8).
            guidance: see `guidance.Guidance`: in the first step, and in those behind it (2, 22).
            supply: likewise, see `vehicle_step.loaded` (2, 4).
            law: gains, shares, known constants, probes, share and rate of the acceleration
                estimate, and settings, as `flight_law.packed_update` takes them.
            values: see `vehicle_dynamics.advance`.
            constants: see `vehicle_dynamics.advance`.
            sphere: see `VehicleDynamics.above_ground`.
            state: see `vehicle_dynamics.advance`.
            memory: see `vehicle_dynamics.advance`.
            commands: of the rotor speeds (n) [rad/s].
            filtered: see `flight_law.packed_update`.
            remembered: likewise.
            rows: places for what is recorded behind steps, one for each multiple of `record`:
                state (13), acceleration (6), thrusts and speeds of the rotors (n each), wind (3)
                and commands (n), as `airframe.Airframe.signals` has them, and others behind.

        Returns:
            The number of the next step, and the result of the last one: DONE, NEAR or REFUSED (the
            step was not done; the law returns what is not finite), or BROKEN.
        """
        gains, shares, known, probes, estimate, settings = law
        period, n = constants[0], len(commands)
        held, reading, voltage = np.empty(n), np.empty(13), np.empty(1)
        filtered_before, remembered_before = np.empty(len(filtered)), np.empty(len(remembered))
        places = step_places(n)
        rotors = constants[ROTORS:].reshape(-1, ROW)
        speeds, given = memory[SPEEDS : SPEEDS + n], memory[SPEEDS + n : SPEEDS + 2 * n]
        row = 0
        for number in range(first, last):
            if memory[AWAY] < 1.0:
                if memory[AWAY] != TOUCHED and len(sphere) > 0:
                    distance = sphere_centre(state, sphere[0:3])[2] - sphere[3]
                    memory[AWAY] = steps_to(distance, state, sphere[0:3], period)
                if memory[AWAY] < 1.0:
                    return number, NEAR
            part = min(number - first, 1)
            if number < first + 2:
                constants[SUPPLY:READOUT] = supply[part]
            time = number * period
            acting = commands
            if number % control == 0:
                held[:] = commands
                filtered_before[:] = filtered
                remembered_before[:] = remembered
                acting = held
                gyro_reading(time, values, constants, state, memory, reading)
                voltage[0] = voltage_share(speeds, given, supply[part], rotors)
                total = update(
                    reading,
                    voltage,
                    reference,
                    guidance[part],
                    straight,
                    gains,
                    shares,
                    known,
                    probes,
                    estimate,
                    settings,
                    filtered,
                    remembered,
                    commands,
                    1.0 * (number // control) if divides else ALL_PARTS,
                )
                if not math.isfinite(total):
                    commands[:] = held
                    filtered[:] = filtered_before
                    remembered[:] = remembered_before
                    return number, REFUSED
            if advance(time, acting, values, constants, places, state, memory) == BROKEN:
                return number, BROKEN
            if (number + 1) % record == 0:
                _write(state, memory, commands, speeds, given, rotors, rows[row])
                row += 1
        return last, DONE

    return unique(flight_loop, controller.key)


@register_jitable
def _write(state, memory, commands, speeds, shares, rotors, row):
    """Write what is recorded now."""
    n = len(commands)
    thrusts, turning, air, asked = 19, 19 + n, 19 + 2 * n, 22 + 2 * n
    for i in range(13):
        row[i] = state[i]
    for i in range(6):
        row[13 + i] = memory[LAST + i]
    wind = memory[WIND:EDDY]
    for i in range(3):
        row[air + i] = wind[i]
    R_WB = rotation(state[0:4])
    w_B = into_body(R_WB, state[7:10])
    v_B = into_body(R_WB, (state[10] - wind[0], state[11] - wind[1], state[12] - wind[2]))
    for i in range(n):
        row[thrusts + i] = rotor_thrust(
            v_B, w_B, R_WB[6:9], state[6], speeds[i], shares[i], rotors[i]
        )
        row[turning + i] = speeds[i]
        row[asked + i] = commands[i]
