"""From a data sheet to a description: known numbers of a multirotor not yet built, and estimates.

Each estimate states its source. `write_xacro` writes every `Figure` with its formula. So a
description states what was estimated and how, and changes with a number in it that is replaced by a
measured one.
"""

import csv
import io
import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import quoteattr

from workbench.common.errors import LONGEST_ECHO, WorkbenchError
from workbench.common.plain_files import read_plain_text
from workbench.common.plain_text import plain_name
from workbench.plant.drag import AIR_DENSITY
from workbench.plant.gravity import GRAVITY
from workbench.plant.rotors import PROPELLER_DENSITY
from workbench.plant.sensor_blocks import SensorBlock

COUNTS = {"x": (4, 6, 8, 10, 12), "plus": (4, 6, 8, 10, 12), "coaxial": (6, 8, 12)}
"""Numbers of rotors by layout: two arms in front, one arm in front, or two with two rotors each."""
MOST_END_SHARE = 0.8
"""Largest share of the mass at the ends of the arms; the frame has mass, too."""
MOST_BYTES = 16_000_000
"""Size limit of a table."""
COLUMNS = {
    "rpm": 2.0 * math.pi / 60.0,
    "rad/s": 1.0,
    "thrust_N": 1.0,
    "thrust_g": 0.001 * 9.80665,
    "torque_Nm": 1.0,
}
"""Allowed heads of columns, with the factor to the SI unit."""
_SPEEDS, _THRUSTS, _TORQUES = ("rpm", "rad/s"), ("thrust_N", "thrust_g"), ("torque_Nm",)
END_SHARE = 0.35
"""Share of the mass at the ends of the arms: motors, speed controllers and propellers."""
ARM_SHARE = 0.10
"""Share of the mass in the arms."""
BODY_SIDE = 0.6
"""Side of the body, as a share of the length of an arm."""
_PITCHES = (0.47, 0.75)
_THRUST_COEFFICIENTS = (0.1185, 0.134)
_POWER_COEFFICIENTS = (0.048, 0.0825)
"""Static power coefficients, means of APC 10x4.7 Slow Flyer and DA4002 9x6.75, by pitch over
diameter."""
_NARROWEST_PITCH, _WIDEST_PITCH = 0.4, 0.8
"""Limits of pitch over diameter: the interpolation between two propellers ends there."""
_USUAL_PITCH = 0.47
_BLADE_EXPONENT = 0.75
_COAXIAL = 0.85
_LOADED = 0.65
"""Speed at full throttle under the load of the propeller, over KV times nominal voltage."""
_LAG, _LAG_DIAMETER = 0.033, 0.1295
"""Time constant [s] of the rotor of a 5.1-inch propeller, and that diameter [m]."""
_MOTOR_EFFICIENCY = 0.7
"""Efficiency of motor and speed controller."""
_USABLE = 0.8
"""Usable share of the charge of a battery."""
_CELL = 3.7
"""Nominal voltage of a lithium-polymer cell [V]."""
_CELL_RESISTANCE = 0.015
"""Resistance of a lithium-polymer cell times its capacity [ohm A h]: 3 mohm at 5 A h."""
UIUC = "UIUC Propeller Data Site, static tests"
GIVEN = "as given"
HOVER_TIME_SOURCE = (
    f"{100 * _USABLE:.0f} % of the battery's energy, motors and speed controllers "
    f"{100 * _MOTOR_EFFICIENCY:.0f} % efficient, nothing else drawing power"
)
_WIDTH = 96
_TEXT = """\
<?xml version="1.0"?>
<!-- {title}.
     Written by `workbench new` from a data sheet. SI units; x forward, y left, z up.
     Replace an estimate when you have measured it: what follows from it follows. -->
<robot name={name} xmlns:xacro="http://www.ros.org/wiki/xacro">
  <!-- FROM THE DATA SHEET -->
{given}

  <!-- ESTIMATED -->
{estimated}

  <!-- THE BODY: all mass is in the base link. -->
  <link name="base_link">
    <inertial>
      <mass value="${{mass}}"/>
      <inertia ixx="${{ixx}}" iyy="${{ixx}}" izz="${{izz}}" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <visual>
      <geometry><box size="${{body_side}} ${{body_side}} ${{body_height}}"/></geometry>
    </visual>
    <!-- What touches the ground. -->
    <collision>
      <geometry><box size="${{arm}} ${{arm}} ${{body_height}}"/></geometry>
    </collision>
  </link>

  <!-- THE ROTORS: angle in degrees from the front to the left; level 1 above the arm, -1 below;
       turns as seen from above. -->
  <xacro:macro name="rotor" params="number angle level turns">
    <xacro:property name="gap" value="${{body_height/2 + 0.02*diameter}}"/>
    <link name="rotor_${{number}}">
      <visual>
        <geometry><cylinder radius="${{diameter/2}}" length="${{0.02*diameter}}"/></geometry>
      </visual>
    </link>
    <joint name="rotor_${{number}}_joint" type="continuous">
      <parent link="base_link"/>
      <child link="rotor_${{number}}"/>
      <origin xyz="${{arm*cos(radians(angle))}} ${{arm*sin(radians(angle))}} ${{level*gap}}"/>
      <axis xyz="0 0 1"/>
    </joint>
    <gazebo>
      <plugin filename="gz-sim-multicopter-motor-model-system"
              name="gz::sim::systems::MulticopterMotorModel">
        <jointName>rotor_${{number}}_joint</jointName>
        <linkName>rotor_${{number}}</linkName>
        <turningDirection>${{turns}}</turningDirection>
        <timeConstantUp>${{time_constant}}</timeConstantUp>
        <timeConstantDown>${{time_constant}}</timeConstantDown>
        <maxRotVelocity>${{max_speed}}</maxRotVelocity>
        <motorConstant>${{motor_constant}}</motorConstant>
        <momentConstant>${{moment_constant}}</momentConstant>
        <!-- Not Gazebo's: there a rotor's link has it. -->
        <rotorInertia>${{rotor_inertia}}</rotorInertia>
        <commandSubTopic>command/motor_speed</commandSubTopic>
        <motorNumber>${{number - 1}}</motorNumber>
        <motorType>velocity</motorType>
      </plugin>
    </gazebo>
  </xacro:macro>

{rotors}
{more}</robot>
"""
_BATTERY = """
  <!-- THE BATTERY: as it empties, and under load, it weakens the rotors. -->
  <gazebo>
    <plugin filename="gz-sim-linear-battery-plugin-system"
            name="gz::sim::systems::LinearBatteryPlugin">
      <battery_name>battery</battery_name>
      <voltage>${full_voltage}</voltage>
      <open_circuit_voltage_constant_coef>${full_voltage}</open_circuit_voltage_constant_coef>
      <open_circuit_voltage_linear_coef>
        ${empty_voltage - full_voltage}
      </open_circuit_voltage_linear_coef>
      <capacity>${capacity}</capacity>
      <resistance>${battery_resistance}</resistance>
      <!-- Not Gazebo's: the second is the share of the sag that rotor commands make up for, as a
           flight controller's do that measures its battery. -->
      <hoverDuration>${hover_duration}</hoverDuration>
      <sagCompensation>1</sagCompensation>
    </plugin>
  </gazebo>
"""
_SENSORS = """
  <!-- THE SENSORS, on the base link. -->
{}
"""


@dataclass(frozen=True)
class Propeller:
    """A propeller as its name states it; lengths in m, pitch None if unknown."""

    diameter: float
    pitch: float | None = None
    blades: int = 2

    @property
    def label(self) -> str:
        """Its name in inches."""
        pitch = "" if self.pitch is None else f"x{self.pitch / 0.0254:.3g}"
        blades = "" if self.blades == 2 else f" with {self.blades} blades"
        return f"{self.diameter / 0.0254:.3g}{pitch} in{blades}"


@dataclass(frozen=True)
class Measured:
    """Measurements of one motor with its propeller.

    Attributes:
        motor_constant: thrust over squared speed [N s²].
        max_speed: largest speed [rad/s].
        moment_constant: torque over thrust [m]; None if no torque was measured.
        source: of the numbers.
    """

    motor_constant: float
    max_speed: float
    moment_constant: float | None
    source: str


@dataclass(frozen=True)
class DataSheet:
    """The known numbers of a multirotor before it is built.

    Attributes:
        name: of the drone.
        mass: all-up, with battery [kg].
        arm: distance from the centre to the axis of a rotor [m].
        propeller: of every rotor.
        rotors: their number.
        layout: one of `COUNTS`.
        measured: for one motor with this propeller, None without a thrust curve.
        max_thrust: of one motor with this propeller [N], None if unknown.
        motor_kv: speed over voltage without load [RPM/V], None if unknown.
        voltage: nominal voltage of the battery [V], None if unknown.
        capacity: of the battery [A·h], None if unknown.
        motor_mass: of one motor with its propeller and speed controller [kg], None if unknown.
        sensors: on it, with usual numbers.
    """

    name: str
    mass: float
    arm: float
    propeller: Propeller
    rotors: int = 4
    layout: str = "x"
    measured: Measured | None = None
    max_thrust: float | None = None
    motor_kv: float | None = None
    voltage: float | None = None
    capacity: float | None = None
    motor_mass: float | None = None
    sensors: tuple[SensorBlock, ...] = ()

    @property
    def has_battery(self) -> bool:
        """Whether voltage and capacity of the battery are known."""
        return self.voltage is not None and self.capacity is not None

    @property
    def arms(self) -> int:
        """Number of arms."""
        return self.rotors // 2 if self.layout == "coaxial" else self.rotors

    def check(self) -> None:
        """Check that the multirotor can be built and can fly.

        Raises:
            WorkbenchError: that names the contradicting numbers.
        """
        if self.rotors not in COUNTS[self.layout]:
            known = ", ".join(map(str, COUNTS[self.layout]))
            raise WorkbenchError(
                f"{self.rotors} rotors cannot be laid out as {self.layout}: it is for {known}"
            )
        gap = 2.0 * self.arm * math.sin(math.pi / self.arms)
        if self.propeller.diameter >= gap:
            raise WorkbenchError(
                f"propellers of {self.propeller.diameter:.3g} m touch each other: with arms of "
                f"{self.arm:.3g} m their axes are {gap:.3g} m apart; is the arm measured from the "
                "centre to a rotor, and the diagonal from rotor to rotor?"
            )
        if self.motor_mass and self.rotors * self.motor_mass > MOST_END_SHARE * self.mass:
            raise WorkbenchError(
                f"{self.rotors} motors of {self.motor_mass:.3g} kg leave too little of a mass of "
                f"{self.mass:.3g} kg: is the mass all-up, with the battery?"
            )
        if (
            self.measured is None
            and self.max_thrust is None
            and None in (self.motor_kv, self.voltage)
        ):
            raise WorkbenchError(
                "nothing says how strong the motors are: give the largest thrust of one motor "
                "(--max-thrust 850g), a thrust curve (--thrust-curve FILE), or KV and battery "
                "(--motor-kv 920KV --battery 4S)"
            )


def read_thrust_curve(path: Path) -> Measured:
    """Return the constants fitted to a CSV file of one motor with its propeller.

    Its first line names the columns: `rpm` or `rad/s`, `thrust_g` or `thrust_N`, and `torque_Nm` if
    measured; others are ignored. Thrust is fitted by k w², torque by a multiple of thrust, both
    with least squares.

    Raises:
        WorkbenchError: with file and line, if something is missing or not a number.
    """
    try:
        text = read_plain_text(path, MOST_BYTES, "utf-8-sig")
        rows = list(csv.DictReader(io.StringIO(text), skipinitialspace=True))
    except csv.Error as error:
        raise WorkbenchError(f"{path}: cannot be read: {error}") from error
    speeds = _column(path, rows, _SPEEDS)
    thrusts = _column(path, rows, _THRUSTS)
    torques = _column(path, rows, _TORQUES) if rows and _head(rows[0], _TORQUES) else []
    squares = [speed**2 for speed in speeds]
    constant = sum(t * s for t, s in zip(thrusts, squares, strict=True)) / sum(
        s * s for s in squares
    )
    moment = (
        sum(q * t for q, t in zip(torques, thrusts, strict=True)) / sum(t * t for t in thrusts)
        if torques
        else None
    )
    source = f"least squares of the {len(rows)} points in {path.name}"
    return Measured(constant, max(speeds), moment, source)


def _head(row: dict[str, str], names: tuple[str, ...]) -> str | None:
    """Return the one of several columns that a table has."""
    return next((name for name in names if name in row), None)


def _column(path: Path, rows: list[dict[str, str]], names: tuple[str, ...]) -> list[float]:
    """Return a column [SI].

    Raises:
        WorkbenchError: if it is missing, or one of its cells is not a positive number.
    """
    head = _head(rows[0], names) if rows else None
    if head is None:
        raise WorkbenchError(
            f"{path}: has no column {' or '.join(names)}: its first line names them"
        )
    values = []
    for line, row in enumerate(rows, start=2):
        try:
            value = float(row[head] or "")
        except ValueError:
            value = math.nan
        if not 0.0 < value < 1e6:
            shown = plain_name(str(row[head]), LONGEST_ECHO)
            raise WorkbenchError(f"{path}:{line}: {head} '{shown}' is not a positive number")
        values.append(COLUMNS[head] * value)
    return values


@dataclass(frozen=True)
class Figure:
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


class _Figures:
    """Collects figures, each after those that its formula uses."""

    def __init__(self) -> None:
        self.found: list[Figure] = []

    def state(self, name: str, value: float, unit: str, label: str, source: str = GIVEN) -> None:
        """Add a plain number."""
        self.found.append(Figure(name, value, unit, label, source))

    def derive(self, name: str, formula: str, unit: str, label: str, source: str) -> None:
        """Add what a formula yields; xacro evaluates it as Python, too."""
        names = {"pi": math.pi, **{each.name: each.value for each in self.found}}
        value = float(eval(formula, {"__builtins__": {}}, names))
        self.found.append(Figure(name, value, unit, label, source, formula))


def figures(sheet: DataSheet) -> list[Figure]:
    """Return the figures of a description, each after those that its formula uses."""
    made = _Figures()
    _add_body(made, sheet)
    _add_rotor(made, sheet)
    if sheet.has_battery:
        _add_battery(made, sheet)
    for sensor in sheet.sensors:
        for name, formula, unit, label in sensor.numbers:
            made.derive(name, formula, unit, label, sensor.source)
    return made.found


def _add_body(made: _Figures, sheet: DataSheet) -> None:
    """Add masses, sizes and moments of inertia."""
    made.state("mass", sheet.mass, "kg", "mass, all-up")
    made.state("arm", sheet.arm, "m", "centre to rotor axis")
    label = "one motor, propeller, speed controller"
    if sheet.motor_mass is None:
        formula = f"{END_SHARE:g}*mass/{sheet.rotors}"
        share = f"{100 * END_SHARE:.0f} % of the mass"
        source = f"{share} is at the ends of the arms (usual: 25 to 40 %)"
        made.derive("motor_mass", formula, "kg", label, source)
    else:
        made.state("motor_mass", sheet.motor_mass, "kg", label)
    source = f"{100 * ARM_SHARE:.0f} % of the mass"
    made.derive("arms_mass", f"{ARM_SHARE:g}*mass", "kg", "all arms", source)
    formula = f"mass - arms_mass - {sheet.rotors}*motor_mass"
    made.derive("body_mass", formula, "kg", "frame and battery", "the rest")
    source = f"{BODY_SIDE:g} of an arm"
    made.derive("body_side", f"{BODY_SIDE:g}*arm", "m", "body, a square box", source)
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


def _add_rotor(made: _Figures, sheet: DataSheet) -> None:
    """Add the constants of one rotor."""
    propeller, measured = sheet.propeller, sheet.measured
    pitch = _USUAL_PITCH if propeller.pitch is None else propeller.pitch / propeller.diameter
    place = min(max(pitch, _NARROWEST_PITCH), _WIDEST_PITCH)
    blades = (propeller.blades / 2.0) ** _BLADE_EXPONENT
    pair = _COAXIAL if sheet.layout == "coaxial" else 1.0
    thrust_coefficient = round(_between(_THRUST_COEFFICIENTS, place) * blades * pair, 4)
    power_coefficient = round(_between(_POWER_COEFFICIENTS, place) * blades, 4)
    tested = f"{UIUC}: APC 10x4.7 and DA4002 9x6.75, by pitch over diameter"
    if propeller.pitch is None:
        tested += f" ({_USUAL_PITCH:g} assumed)"
    if propeller.blades != 2:
        tested += f", times (blades/2)^{_BLADE_EXPONENT:g} (its propellers of 3 blades)"
    behind = f", times {_COAXIAL:g} for two rotors on one arm" if pair != 1.0 else ""
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
        f"{_LAG:g}*(diameter/{_LAG_DIAMETER:g})**0.5",
        "s",
        "time constant of a rotor",
        f"{_LAG:g} s at 5.1 in, usual for racers, with the square root of the diameter; published "
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


def _add_largest_speed(made: _Figures, sheet: DataSheet, pair: float) -> None:
    """Add the largest speed of a rotor, with a factor on the thrust of two rotors on one arm."""
    name, unit, label = "max_speed", "rad/s", "largest rotor speed"
    if sheet.measured:
        made.state(name, sheet.measured.max_speed, unit, label, sheet.measured.source)
    elif sheet.max_thrust is not None:
        formula = f"({pair * sheet.max_thrust:.6g}/motor_constant)**0.5"
        source = f"at the largest thrust of one motor, {sheet.max_thrust:.4g} N as given"
        made.derive(name, formula, unit, label, source)
    else:
        formula = f"{_LOADED:g}*{sheet.motor_kv:g}*{sheet.voltage:g}*2*pi/60"
        source = f"{_LOADED:g} of KV times voltage: under load, 0.55 to 0.8 is usual"
        made.derive(name, formula, unit, label, source)


def _add_battery(made: _Figures, sheet: DataSheet) -> None:
    """Add voltages, capacity and resistance of a lithium-polymer battery."""
    assert sheet.voltage is not None and sheet.capacity is not None
    made.state("battery_voltage", sheet.voltage, "V", "nominal voltage of the battery")
    made.state("capacity", sheet.capacity, "A h", "its capacity")
    for name, volts, when in (("full", 4.2, "full"), ("empty", 3.5, "empty")):
        made.derive(
            f"{name}_voltage",
            f"{volts:g}/{_CELL:g}*battery_voltage",
            "V",
            f"voltage of the {when} battery without load",
            f"{volts:g} V a cell, of {_CELL:g} V nominal",
        )
    made.derive(
        "battery_resistance",
        f"{_CELL_RESISTANCE:g}*battery_voltage/{_CELL:g}/capacity",
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
        f"{_USABLE:g}*{_MOTOR_EFFICIENCY:g}*3600*battery_voltage*capacity/hover_power",
        "s",
        "hover time of the full battery",
        HOVER_TIME_SOURCE,
    )


def _between(values: Sequence[float], pitch: float) -> float:
    """Return the value at a pitch over diameter, interpolated between two propellers."""
    low, high = _PITCHES
    return values[0] + (values[1] - values[0]) * (pitch - low) / (high - low)


def check_lift(sheet: DataSheet, found: Sequence[Figure]) -> None:
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


def write_xacro(sheet: DataSheet, figures: Sequence[Figure]) -> str:
    """Return the text of the description.

    Args:
        sheet: name, rotors and their layout.
        figures: in an order with each after those that its formula uses.
    """
    name = quoteattr(sheet.name)
    rotors = "\n".join(f"  {line}" for line in _rotors(sheet))
    return _TEXT.format(
        name=name,
        title=f"{sheet.rotors} rotors, {sheet.layout}, propellers {sheet.propeller.label}",
        given=_properties([figure for figure in figures if figure.source == GIVEN]),
        estimated=_properties([figure for figure in figures if figure.source != GIVEN]),
        rotors=rotors,
        more=_more(sheet),
    )


def _more(sheet: DataSheet) -> str:
    """Return battery and sensors."""
    battery = _BATTERY if sheet.has_battery else ""
    blocks = "\n".join(each.text for each in sheet.sensors)
    return battery + (_SENSORS.format(blocks) if blocks else "")


def _properties(figures: Sequence[Figure]) -> str:
    """Return a commented property for each figure."""
    return "\n".join(line for figure in figures for line in _property(figure))


def _property(figure: Figure) -> list[str]:
    """Return the lines of one figure."""
    unit = "" if figure.unit == "1" else f" [{figure.unit}]"
    source = "" if figure.source == GIVEN else f": {figure.source}"
    comment = f"{figure.label}{unit}{source}"
    lines = textwrap.wrap(comment.replace("--", "- "), _WIDTH - 14)
    head = [f"  <!-- {lines[0]}", *(f"       {line}" for line in lines[1:])]
    head[-1] += " -->"
    value = f"${{{figure.formula}}}" if figure.formula else f"{figure.value:.6g}"
    return [*head, f'  <xacro:property name="{figure.name}" value="{value}"/>']


def _rotors(sheet: DataSheet) -> list[str]:
    """Return a line for each rotor; arms count from the front to the left."""
    first = 0.0 if sheet.layout == "plus" else 180.0 / sheet.arms
    levels = (1, -1) if sheet.layout == "coaxial" else (1,)
    lines: list[str] = []
    for level in levels:
        for arm in range(sheet.arms):
            turns = "cw" if (arm % 2 == 0) == (level == 1) else "ccw"
            angle = first + 360.0 * arm / sheet.arms
            lines.append(
                f'<xacro:rotor number="{len(lines) + 1}" angle="{angle:g}" level="{level}" '
                f'turns="{turns}"/>'
            )
    return lines
