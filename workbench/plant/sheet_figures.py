"""Figures of a model that follow from a data sheet: body, rotors and battery."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from workbench.common.errors import WorkbenchError
from workbench.plant.data_sheet import DataSheet
from workbench.plant.gravity import AIR_DENSITY, GRAVITY
from workbench.plant.rotors import PROPELLER_DENSITY

ARM_END_MASS_SHARE = 0.35
"""Share of the mass at the ends of the arms: motors, speed controllers and propellers."""
ARM_MASS_SHARE = 0.10
"""Share of the mass in the arms."""
BODY_SIDE_PER_ARM = 0.6
"""Side of the body, as a share of the length of an arm."""
_PITCH_RATIOS = (0.47, 0.75)
_THRUST_COEFFICIENTS = (0.1185, 0.134)
_POWER_COEFFICIENTS = (0.048, 0.0825)
"""Static power coefficients, means of APC 10x4.7 Slow Flyer and DA4002 9x6.75, by pitch over
diameter."""
_MIN_PITCH_RATIO, _MAX_PITCH_RATIO = 0.4, 0.8
"""Limits of pitch over diameter: the interpolation between two propellers ends there."""
_DEFAULT_PITCH_RATIO = 0.47
_BLADE_EXPONENT = 0.75
_COAXIAL_PAIR_FACTOR = 0.85
_LOADED_SPEED_SHARE = 0.65
"""Speed at full throttle under the load of the propeller, over KV times nominal voltage."""
_REFERENCE_LAG_S, _REFERENCE_LAG_DIAMETER_M = 0.033, 0.1295
"""Time constant [s] of the rotor of a 5.1-inch propeller, and that diameter [m]."""
_MOTOR_EFFICIENCY = 0.7
"""Efficiency of motor and speed controller."""
_USABLE_CHARGE_SHARE = 0.8
"""Usable share of the charge of a battery."""
_NOMINAL_CELL_V = 3.7
"""Nominal voltage of a lithium-polymer cell [V]."""
_CELL_RESISTANCE = 0.015
"""Resistance of a lithium-polymer cell times its capacity [ohm A h]: 3 mohm at 5 A h."""
UIUC_SOURCE = "UIUC Propeller Data Site, static tests"
GIVEN_SOURCE = "as given"
HOVER_TIME_SOURCE = (
    f"{100 * _USABLE_CHARGE_SHARE:.0f} % of the battery's energy, motors and speed controllers "
    f"{100 * _MOTOR_EFFICIENCY:.0f} % efficient, nothing else drawing power"
)


@dataclass(frozen=True)
class SheetFigure:
    """A number of a description.

    Attributes:
        name: of the xacro property.
        value: [SI].
        unit: "1" for none.
        label: its meaning in words.
        source: its origin, as a clause.
        formula: its xacro expression of other figures; "" for a plain number.
    """

    name: str
    value: float
    unit: str
    label: str
    source: str
    formula: str = ""


class _SheetFigures:
    """Collects figures, each after those that its formula uses."""

    def __init__(self) -> None:
        self.found: list[SheetFigure] = []

    def state(
        self, name: str, value: float, unit: str, label: str, source: str = GIVEN_SOURCE
    ) -> None:
        """Add a plain number."""
        self.found.append(SheetFigure(name, value, unit, label, source))

    def derive(self, name: str, formula: str, unit: str, label: str, source: str) -> None:
        """Add what a formula yields; xacro evaluates it as Python, too."""
        names = {"pi": math.pi, **{each.name: each.value for each in self.found}}
        value = float(eval(formula, {"__builtins__": {}}, names))
        self.found.append(SheetFigure(name, value, unit, label, source, formula))


def sheet_figures(sheet: DataSheet) -> list[SheetFigure]:
    """Return the figures of a description, each after those that its formula uses."""
    made = _SheetFigures()
    _add_body(made, sheet)
    _add_rotor(made, sheet)
    if sheet.has_battery:
        _add_battery(made, sheet)
    for sensor in sheet.sensors:
        for name, formula, unit, label in sensor.numbers:
            made.derive(name, formula, unit, label, sensor.source)
    return made.found


def _add_body(made: _SheetFigures, sheet: DataSheet) -> None:
    """Add masses, sizes and moments of inertia."""
    made.state("mass", sheet.mass, "kg", "mass, all-up")
    made.state("arm", sheet.arm, "m", "centre to rotor axis")
    label = "one motor, propeller, speed controller"
    if sheet.motor_mass is None:
        formula = f"{ARM_END_MASS_SHARE:g}*mass/{sheet.rotors}"
        share = f"{100 * ARM_END_MASS_SHARE:.0f} % of the mass"
        source = f"{share} is at the ends of the arms (usual: 25 to 40 %)"
        made.derive("motor_mass", formula, "kg", label, source)
    else:
        made.state("motor_mass", sheet.motor_mass, "kg", label)
    source = f"{100 * ARM_MASS_SHARE:.0f} % of the mass"
    made.derive("arms_mass", f"{ARM_MASS_SHARE:g}*mass", "kg", "all arms", source)
    formula = f"mass - arms_mass - {sheet.rotors}*motor_mass"
    made.derive("body_mass", formula, "kg", "frame and battery", "the rest")
    source = f"{BODY_SIDE_PER_ARM:g} of an arm"
    made.derive("body_side", f"{BODY_SIDE_PER_ARM:g}*arm", "m", "body, a square box", source)
    made.derive("body_height", "body_side/2", "m", "its height", "half its side")
    shapes = "points at the ends of the arms, rods for the arms, a box for the body"
    for name, formula, label in (
        (
            "spread",
            f"{sheet.rotors}*motor_mass*arm**2 + arms_mass*arm**2/3",
            "second moment of arms and motors about z",
        ),
        (
            "ixx",
            "spread/2 + body_mass*(body_side**2 + body_height**2)/12",
            "moment of inertia about x and y",
        ),
        ("izz", "spread + body_mass*body_side**2/6", "moment of inertia about z"),
    ):
        made.derive(name, formula, "kg m²", label, shapes)


def _add_rotor(made: _SheetFigures, sheet: DataSheet) -> None:
    """Add the constants of one rotor."""
    propeller, measured = sheet.propeller, sheet.measured
    pitch = (
        _DEFAULT_PITCH_RATIO if propeller.pitch is None else propeller.pitch / propeller.diameter
    )
    place = min(max(pitch, _MIN_PITCH_RATIO), _MAX_PITCH_RATIO)
    blades = (propeller.blades / 2.0) ** _BLADE_EXPONENT
    pair = _COAXIAL_PAIR_FACTOR if sheet.layout == "coaxial" else 1.0
    thrust_coefficient = round(_between_propellers(_THRUST_COEFFICIENTS, place) * blades * pair, 4)
    power_coefficient = round(_between_propellers(_POWER_COEFFICIENTS, place) * blades, 4)
    tested = f"{UIUC_SOURCE}: APC 10x4.7 and DA4002 9x6.75, by pitch over diameter"
    if propeller.pitch is None:
        tested += f" ({_DEFAULT_PITCH_RATIO:g} assumed)"
    if propeller.blades != 2:
        tested += f", times (blades/2)^{_BLADE_EXPONENT:g} (its propellers of 3 blades)"
    behind = f", times {_COAXIAL_PAIR_FACTOR:g} for two rotors on one arm" if pair != 1.0 else ""
    made.state("diameter", propeller.diameter, "m", "propeller's diameter")
    made.state("thrust_coefficient", thrust_coefficient, "1", "C_T", tested + behind)
    made.state("power_coefficient", power_coefficient, "1", "C_P", tested)
    name, unit, label = "motor_constant", "N s²", "thrust over squared speed"
    if measured:
        made.state(name, pair * measured.motor_constant, unit, label, measured.source + behind)
    else:
        formula = f"thrust_coefficient*{AIR_DENSITY:g}*diameter**4/(2*pi)**2"
        source = f"C_T rho D^4/(2 pi)^2, air of {AIR_DENSITY:g} kg/m³"
        made.derive(name, formula, unit, label, source)
    name, unit, label = "moment_constant", "m", "torque over thrust"
    if measured and measured.moment_constant is not None:
        made.state(name, measured.moment_constant / pair, unit, label, measured.source)
    else:
        formula = "power_coefficient*diameter/(2*pi*thrust_coefficient)"
        made.derive(name, formula, unit, label, "C_P D/(2 pi C_T)")
    _add_largest_speed(made, sheet, pair)
    made.derive(
        "time_constant",
        f"{_REFERENCE_LAG_S:g}*(diameter/{_REFERENCE_LAG_DIAMETER_M:g})**0.5",
        "s",
        "time constant of a rotor",
        f"{_REFERENCE_LAG_S:g} s at 5.1 in, usual for racers, with the square root of the "
        "diameter; published "
        "values for one size differ by a factor of two",
    )
    made.derive(
        "rotor_inertia",
        f"{propeller.blades}/2*{PROPELLER_DENSITY:g}*diameter**5/12",
        "kg m²",
        "inertia of a rotor about its axis",
        f"blades as thin rods, two of them weighing {PROPELLER_DENSITY:g} kg/m³ D^3 (12 g at 10 "
        "in), without the motor's bell; right within a factor of two or three",
    )


def _add_largest_speed(made: _SheetFigures, sheet: DataSheet, pair: float) -> None:
    """Add the largest speed of a rotor, with a factor on the thrust of two rotors on one arm."""
    name, unit, label = "max_speed", "rad/s", "largest rotor speed"
    if sheet.measured:
        made.state(name, sheet.measured.max_speed, unit, label, sheet.measured.source)
    elif sheet.max_thrust is not None:
        formula = f"({pair * sheet.max_thrust:.6g}/motor_constant)**0.5"
        source = f"at the largest thrust of one motor, {sheet.max_thrust:.4g} N as given"
        made.derive(name, formula, unit, label, source)
    else:
        formula = f"{_LOADED_SPEED_SHARE:g}*{sheet.motor_kv:g}*{sheet.voltage:g}*2*pi/60"
        source = f"{_LOADED_SPEED_SHARE:g} of KV times voltage: under load, 0.55 to 0.8 is usual"
        made.derive(name, formula, unit, label, source)


def _add_battery(made: _SheetFigures, sheet: DataSheet) -> None:
    """Add voltages, capacity and resistance of a lithium-polymer battery."""
    assert sheet.voltage is not None and sheet.capacity is not None
    made.state("battery_voltage", sheet.voltage, "V", "nominal voltage of the battery")
    made.state("capacity", sheet.capacity, "A h", "its capacity")
    for name, volts, when in (("full", 4.2, "full"), ("empty", 3.5, "empty")):
        made.derive(
            f"{name}_voltage",
            f"{volts:g}/{_NOMINAL_CELL_V:g}*battery_voltage",
            "V",
            f"voltage of the {when} battery without load",
            f"{volts:g} V a cell, of {_NOMINAL_CELL_V:g} V nominal",
        )
    made.derive(
        "battery_resistance",
        f"{_CELL_RESISTANCE:g}*battery_voltage/{_NOMINAL_CELL_V:g}/capacity",
        "ohm",
        "resistance of the battery",
        f"{1000 * _CELL_RESISTANCE:g} mohm A h a cell; packs differ by a factor of two",
    )
    weight = f"mass*{GRAVITY:g}"
    made.derive(
        "hover_power",
        f"{weight}*moment_constant*({weight}/{sheet.rotors}/motor_constant)**0.5",
        "W",
        "torque times speed of the rotors in hover",
        "from the constants of a rotor",
    )
    made.derive(
        "hover_duration",
        f"{_USABLE_CHARGE_SHARE:g}*{_MOTOR_EFFICIENCY:g}*3600*battery_voltage*capacity/hover_power",
        "s",
        "hover time of the full battery",
        HOVER_TIME_SOURCE,
    )


def _between_propellers(values: Sequence[float], pitch: float) -> float:
    """Return the value at a pitch over diameter, interpolated between two propellers."""
    low, high = _PITCH_RATIOS
    return values[0] + (values[1] - values[0]) * (pitch - low) / (high - low)


def check_lift(sheet: DataSheet, found: Sequence[SheetFigure]) -> None:
    """Check that the rotors can lift the drone.

    Raises:
        WorkbenchError: if they cannot.
    """
    by_name = {figure.name: figure.value for figure in found}
    thrust = by_name["motor_constant"] * by_name["max_speed"] ** 2
    weight = sheet.mass * GRAVITY
    if sheet.rotors * thrust <= weight:
        raise WorkbenchError(
            f"it cannot fly: {sheet.rotors} rotors of at most {thrust:.3g} N lift less than its "
            f"weight, {weight:.3g} N; look at mass, propeller, motors and battery again"
        )
