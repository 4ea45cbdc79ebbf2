"""Sixteen candidates side by side: where their numbers stand, and how to get at them.

A block is a flat array of rows, and a row holds one number of each of 16 candidates. Compiled loops
over the candidates, innermost and over rows at constant places, become vector instructions: one
source flies four candidates, or eight, at the price of one. That asks for plain code in the loop,
which is why numbers are taken out and put back one by one here, without loops of their own.
"""

from typing import Any

from workbench.common.jitable import register_jitable
from workbench.control.flight_law import BODY as BODY_SIZE
from workbench.control.flight_law import FILTERED as FILTERED_SIZE
from workbench.control.guidance import Reference
from workbench.dynamics.air.settings import AirSettings
from workbench.dynamics.vehicle_step import ROW
from workbench.estimation.gyro import COEFFICIENTS, STATES

LANES = 16
"""Candidates in a block: four vectors of four, so that one's wait is another's work."""

STATE_SIZE = 13
COMMAND_SIZE, AIR_SIZE = len(Reference._fields), len(AirSettings._fields)
RIGID_SIZE = 16

STATE = 0
KNOWN = STATE + STATE_SIZE
"""The state that the law sees, which may be an older one."""
FILTERED = KNOWN + STATE_SIZE
"""What the stages before the law remember, see `flight_law.FILTERED` (10)."""
LAST = FILTERED + FILTERED_SIZE
"""Acceleration in the middle of the step before, see `rigid_body.middle` (6)."""
R_WB = LAST + 6
LOAD = R_WB + 9
"""What acts on the body, see `dynamics.Load` (9)."""
EFFORT = LOAD + 9
"""Wanted force and moment (4)."""
BEFORE = EFFORT + 4
"""Force and moment that the commands before make, see `flight_law.commanded_wrench` (4)."""
COMMAND = BEFORE + 4
HOLD = COMMAND + COMMAND_SIZE
"""Point to hold while no pilot steers (3)."""
BODY = HOLD + 3
"""Mass, inertia, q_BT, p_BoBcm_B, drag and spin-up as the law knows them, see
`flight_law.packed`."""
RIGID = BODY + BODY_SIZE
"""Mass, inertia, inverse and centre of mass of what flies, see `rigid_body.RigidBody`."""
WIND = RIGID + RIGID_SIZE
PUSH = WIND + 3
"""See `air.update.push_at` (6)."""
WAY = PUSH + 6
"""Velocity relative to the air, and angular velocity, in B (6)."""
PRESSURE = WAY + 6
"""Half the air's density times the drag area."""
CLEARANCE = PRESSURE + 1
STOPPED = CLEARANCE + 1
"""1 where a rotor has stopped."""
HARD = STOPPED + 1
"""1 where thrusts need more than a sum of columns."""
LOST = HARD + 1
"""Instant at which it was lost, -1 if it was not."""
CHARGE = LOST + 1
OPEN_CIRCUIT = CHARGE + 1
"""Voltage without load, see `vehicle_step.loaded`; and so the next two, under load."""
POWER = OPEN_CIRCUIT + 1
VOLTAGE = POWER + 1
SECTIONS = VOLTAGE + 1
"""Low-passes on the setpoint and behind the acceleration estimate, see `filters` (2 x 9)."""
COMMAND_STEPS = SECTIONS + 18
GYRO_FILTER = COMMAND_STEPS + 1
"""See `gyro.gyro_filter` (18)."""
GYRO = GYRO_FILTER + COEFFICIENTS
"""States of the gyro's filters (12), and the angular velocity in B of its last sample (3)."""
GYRO_EVERY = GYRO + STATES + 3
"""Steps of physics between two of its samples; 0 where it filters nothing."""
COUNT = GYRO_EVERY + 1
"""Control periods since it began."""
MODE = COUNT + 1
"""See `mode.FlightMode`, where the flight mode runs; and so the next one."""
HOLDING = MODE + 1
"""1 while a place is held that no pilot steers away from."""
GAINS = HOLDING + 1
"""Those of the controller, as many as it has; and behind them what its law remembers."""

SPEED, MIDDLE, SLOPE, THRUST, COMMANDED, HELD, SHARE, IDLE, MOST, MOTOR, HALF, PEAK = range(12)
"""Of a rotor; the second and third are its speed, and the slope of that, in a step's middle, and
the last but one is half its linear speed."""
ALLOCATION = PEAK + 1
EFFECTS = ALLOCATION + 4
"""Force and moments over thrust, as the law knows them (4) [1, m]."""
TURN = EFFECTS + 4
"""See `dynamics.rotor_rows` (26)."""
ROTOR_ROWS = TURN + ROW
"""Rows of a rotor's own block."""


@register_jitable(forceinline=True)
def take(b: Any, row: int, i: int) -> Any:
    """Return a candidate's number."""
    return b[row * LANES + i]


@register_jitable(forceinline=True)
def take3(b: Any, row: int, i: int) -> Any:
    """Return three numbers from a row on; and so the next ones, which take more."""
    return take(b, row, i), take(b, row + 1, i), take(b, row + 2, i)


@register_jitable(forceinline=True)
def take4(b: Any, row: int, i: int) -> Any:
    """See `take3`."""
    return take(b, row, i), take(b, row + 1, i), take(b, row + 2, i), take(b, row + 3, i)


@register_jitable(forceinline=True)
def take6(b: Any, row: int, i: int) -> Any:
    """See `take3`."""
    return take3(b, row, i) + take3(b, row + 3, i)


@register_jitable(forceinline=True)
def take7(b: Any, row: int, i: int) -> Any:
    """See `take3`."""
    return take6(b, row, i) + (take(b, row + 6, i),)


@register_jitable(forceinline=True)
def take8(b: Any, row: int, i: int) -> Any:
    """See `take3`."""
    return take4(b, row, i) + take4(b, row + 4, i)


@register_jitable(forceinline=True)
def take9(b: Any, row: int, i: int) -> Any:
    """See `take3`."""
    return take6(b, row, i) + take3(b, row + 6, i)


@register_jitable(forceinline=True)
def take12(b: Any, row: int, i: int) -> Any:
    """See `take3`."""
    return take6(b, row, i) + take6(b, row + 6, i)


@register_jitable(forceinline=True)
def take13(b: Any, row: int, i: int) -> Any:
    """See `take3`."""
    return take9(b, row, i) + take4(b, row + 9, i)


@register_jitable(forceinline=True)
def take16(b: Any, row: int, i: int) -> Any:
    """See `take3`."""
    return take13(b, row, i) + take3(b, row + 13, i)


@register_jitable(forceinline=True)
def take18(b: Any, row: int, i: int) -> Any:
    """See `take3`."""
    return take9(b, row, i) + take9(b, row + 9, i)


@register_jitable(forceinline=True)
def take19(b: Any, row: int, i: int) -> Any:
    """See `take3`."""
    return take18(b, row, i) + (take(b, row + 18, i),)


@register_jitable(forceinline=True)
def put(b: Any, row: int, i: int, value: Any) -> None:
    """Put a candidate's number into its place."""
    b[row * LANES + i] = value


@register_jitable(forceinline=True)
def put3(b: Any, row: int, i: int, values: Any) -> None:
    """Put three numbers from a row on; and so the next ones, which put more."""
    put(b, row, i, values[0])
    put(b, row + 1, i, values[1])
    put(b, row + 2, i, values[2])


@register_jitable(forceinline=True)
def put4(b: Any, row: int, i: int, values: Any) -> None:
    """See `put3`."""
    put3(b, row, i, values[0:3])
    put(b, row + 3, i, values[3])


@register_jitable(forceinline=True)
def put6(b: Any, row: int, i: int, values: Any) -> None:
    """See `put3`."""
    put3(b, row, i, values[0:3])
    put3(b, row + 3, i, values[3:6])


@register_jitable(forceinline=True)
def put9(b: Any, row: int, i: int, values: Any) -> None:
    """See `put3`."""
    put6(b, row, i, values[0:6])
    put3(b, row + 6, i, values[6:9])


@register_jitable(forceinline=True)
def put13(b: Any, row: int, i: int, values: Any) -> None:
    """See `put3`."""
    put6(b, row, i, values[0:6])
    put6(b, row + 6, i, values[6:12])
    put(b, row + 12, i, values[12])
