"""Write the model of a data sheet as xacro."""

import textwrap
from collections.abc import Sequence
from xml.sax.saxutils import quoteattr

from workbench.plant.data_sheet import DataSheet
from workbench.plant.sheet_figures import GIVEN_SOURCE, SheetFigure

_XACRO_LINE_CHARS = 96
_XACRO_TEMPLATE = """\
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
_BATTERY_TEMPLATE = """
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
_SENSORS_TEMPLATE = """
  <!-- THE SENSORS, on the base link. -->
{}
"""


def write_xacro(sheet: DataSheet, figures: Sequence[SheetFigure]) -> str:
    """Return the text of the description.

    Args:
        sheet: name, rotors and their layout.
        figures: in an order with each after those that its formula uses.
    """
    name = quoteattr(sheet.name)
    rotors = "\n".join(f"  {line}" for line in _xacro_rotor_lines(sheet))
    return _XACRO_TEMPLATE.format(
        name=name,
        title=f"{sheet.rotors} rotors, {sheet.layout}, propellers {sheet.propeller.label}",
        given=_properties([figure for figure in figures if figure.source == GIVEN_SOURCE]),
        estimated=_properties([figure for figure in figures if figure.source != GIVEN_SOURCE]),
        rotors=rotors,
        more=_battery_and_sensors(sheet),
    )


def _battery_and_sensors(sheet: DataSheet) -> str:
    """Return battery and sensors."""
    battery = _BATTERY_TEMPLATE if sheet.has_battery else ""
    blocks = "\n".join(each.text for each in sheet.sensors)
    return battery + (_SENSORS_TEMPLATE.format(blocks) if blocks else "")


def _properties(figures: Sequence[SheetFigure]) -> str:
    """Return a commented property for each figure."""
    return "\n".join(line for figure in figures for line in _property(figure))


def _property(figure: SheetFigure) -> list[str]:
    """Return the lines of one figure."""
    unit = "" if figure.unit == "1" else f" [{figure.unit}]"
    source = "" if figure.source == GIVEN_SOURCE else f": {figure.source}"
    comment = f"{figure.label}{unit}{source}"
    lines = textwrap.wrap(comment.replace("--", "- "), _XACRO_LINE_CHARS - 14)
    head = [f"  <!-- {lines[0]}", *(f"       {line}" for line in lines[1:])]
    head[-1] += " -->"
    value = f"${{{figure.formula}}}" if figure.formula else f"{figure.value:.6g}"
    return [*head, f'  <xacro:property name="{figure.name}" value="{value}"/>']


def _xacro_rotor_lines(sheet: DataSheet) -> list[str]:
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
