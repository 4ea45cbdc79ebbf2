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
from workbench.control.flight_law import reader, writer
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
"""What acts on the body, see `vehicle_step.Load` (9)."""
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
"""See `vehicle_step.rotor_rows` (26)."""
ROTOR_ROWS = TURN + ROW
"""Rows of a rotor's own block."""
_ROW = f"b[(row + {{}}) * {LANES} + i]"


@register_jitable(forceinline=True)
def take(b: Any, row: int, i: int) -> Any:
    """Return a candidate's number."""
    return b[row * LANES + i]


take3, take4, take6, take7, take8, take9, take13, take16, take18, take19 = (
    reader(None, size, f"rows_{size}", _ROW, "b, row, i")
    for size in (3, 4, 6, 7, 8, 9, 13, 16, 18, 19)
)
"""As `take`, of so many numbers from a row on."""


@register_jitable(forceinline=True)
def put(b: Any, row: int, i: int, value: Any) -> None:
    """Put a candidate's number into its place."""
    b[row * LANES + i] = value


put3, put4, put6, put9, put13 = (
    writer(size, f"rows_{size}", _ROW, "b, row, i") for size in (3, 4, 6, 9, 13)
)
"""As `put`, of so many numbers from a row on."""
