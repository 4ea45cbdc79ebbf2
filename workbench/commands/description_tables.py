"""Print a description of a vehicle as tables."""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from workbench.commands.printing import print_table
from workbench.common.plain_text import plain_name
from workbench.plant.remarks import REMARK_HEADINGS, DescriptionRemark

if TYPE_CHECKING:
    from workbench.plant.description import Description
    from workbench.plant.vehicle import Vehicle


def print_description(
    description: "Description", vehicle: "Vehicle", unlikely: Sequence[str]
) -> None:
    """Print body, rotors, sensors, frames and remarks of a drone that flies."""
    print(f"{vehicle.name}, from {vehicle.source}")
    print_table(_body(vehicle), left=(0, 1))
    if unlikely:
        print("\nunlikely")
        for doubt in unlikely:
            print(f"  {doubt}")
    print(f"\nrotors ({len(vehicle.rotors)})")
    print_table(_rotors(vehicle), left=(0,))
    if vehicle.joints:
        print(f"\njoints that move ({len(vehicle.joints)})")
        print_table(_joint_rows(description, vehicle), left=(0, 1, 2))
        if vehicle.cables:
            print_table(_cable_rows(description), left=(0, 1, 2))
        print_table(_joint_motion(description, vehicle), left=(0, 1))
    if vehicle.servos:
        print(f"\nservos ({len(vehicle.servos)})")
        print_table(_servo_rows(vehicle), left=(0, 1, 2))
    if vehicle.sensors:
        print(f"\nsensors ({len(vehicle.sensors)})")
        print_table(_sensors(vehicle), left=(0, 1, 2))
        print(
            "\nnoise of the sensors: of a sample, its mean, a bias drawn once, and density of drift"
        )
        print_table(_noise_rows(vehicle), left=(0, 1))
    _print_frames(description)
    _print_remarks(description)


def print_parts(description: "Description") -> None:
    """Print the parts of a description that cannot fly: links, their masses, remarks."""
    print(f"{description.name}, from {description.source}")
    masses = [link.inertial.mass for link in description.model.links if link.inertial]
    print_table([("mass", f"{sum(masses):.5g} kg"), ("rotors", str(len(description.rotors)))])
    _print_frames(description)
    _print_remarks(description)


def _print_frames(description: "Description") -> None:
    """Print the tree of links."""
    print("\nframes, with the origins of links in the base link in m, and masses in kg")
    for line in _tree(description, description.base_link, "", ""):
        print(line)


def _print_remarks(description: "Description") -> None:
    """Print remarks, by kind."""
    for kind, heading in REMARK_HEADINGS.items():
        remarks = [remark for remark in description.remarks if remark.kind == kind]
        if remarks:
            print(f"\n{heading}")
            for remark in remarks:
                print(f"  {_remark_text(remark, description)}")


def _body(vehicle: "Vehicle") -> list[tuple[str, str]]:
    """Return the rows about the body as a whole."""
    from workbench.plant.drag import drag_area

    inertia = vehicle.inertia
    hover = [
        f"{speed:.0f} rad/s ({100.0 * speed / rotor.max_rot_velocity:.0f} %)"
        for speed, rotor in zip(vehicle.hover_speeds, vehicle.rotors, strict=True)
    ]
    return [
        ("mass", f"{vehicle.mass:.5g} kg"),
        ("centre of mass", f"{_vector(vehicle.p_BoBcm_B)} m in {vehicle.base_link}"),
        ("moments of inertia", f"{_exact(inertia.diagonal())} kg m² about x, y, z"),
        ("products of inertia", f"{_exact(inertia[[0, 0, 1], [1, 2, 2]])} kg m² xy, xz, yz"),
        ("thrust to weight", f"{vehicle.thrust_to_weight:.2f}"),
        ("hover speed", hover[0] if len(set(hover)) == 1 else ", ".join(hover)),
        (
            "body drag",
            f"{drag_area(vehicle.mass):.4g} m² of coefficient times area, estimated from the mass",
        ),
        ("rotor drag", _rotor_drag(vehicle)),
        *_stated(vehicle),
        ("ground clearance", f"{vehicle.ground_clearance:.3f} m from {vehicle.base_link}"),
    ]


def _rotor_drag(vehicle: "Vehicle") -> str:
    """Return the drag coefficients perpendicular to the axes, of each rotor if they differ."""
    found = [
        f"{rotor.rotor_drag_coefficient:.4g} N, {rotor.rolling_moment_coefficient:.4g} N m"
        for rotor in vehicle.rotors
    ]
    if not any(
        rotor.rotor_drag_coefficient or rotor.rolling_moment_coefficient for rotor in vehicle.rotors
    ):
        return "not stated"
    each = found[0] if len(set(found)) == 1 else "; ".join(found)
    return f"{each} per rad/s of the rotor and m/s across its axis"


def _stated(vehicle: "Vehicle") -> Iterator[tuple[str, str]]:
    """Yield rows about rarely stated numbers; for rotors, the constants of the first one."""
    rotor = vehicle.rotors[0]
    if rotor.linear_motor_constant:
        yield "linear thrust", f"{rotor.linear_motor_constant:.4g} N s, in addition to that over ω²"
    if rotor.inflow_coefficient:
        yield "inflow", f"{rotor.inflow_coefficient:.4g} N per rad/s and m/s along the axis, lost"
    if rotor.ground_effect_coefficient:
        coefficient, radius = rotor.ground_effect_coefficient, rotor.propeller_radius
        yield "ground effect", f"{coefficient:.4g} (r/4h)² of thrust, r = {radius:.4g} m"
    if vehicle.battery:
        points = vehicle.battery.open_circuit_voltage
        text = f"{vehicle.battery.capacity:.4g} C, {points[-1][1]:.4g} V full, {points[0][1]:.4g} V"
        hover, sag = vehicle.battery.hover_duration, vehicle.battery.sag_compensation
        more = "" if hover is None else f", hovers {hover / 60.0:.3g} min"
        more += "" if sag is None else f", {100.0 * sag:.3g} % of its sag compensated"
        yield "battery", f"{text} empty, {vehicle.battery.resistance:.3g} ohm{more}"


def _joint_rows(description: "Description", vehicle: "Vehicle") -> list[tuple[str, ...]]:
    """Return the table of joints with its heading, a row for each freedom."""
    rows: list[tuple[str, ...]] = [
        ("name", "type", "moves", "limits", "damping", "friction", "spring", "moved kg")
    ]
    for joint in vehicle.joints:
        declared = description.model.joint(joint.name)
        assert declared
        for name, freedom in zip(declared.freedom_names, declared.freedoms, strict=True):
            limits = f"{freedom.lower:.4g} .. {freedom.upper:.4g}"
            kind = joint.kind
            if declared.mimic:
                kind += f", follows {plain_name(declared.mimic.joint)}"
            rows.append(
                (
                    plain_name(name),
                    kind,
                    f"{plain_name(joint.child)} about {_vector(freedom.axis_J)}"
                    if freedom.kind == "revolute"
                    else f"{plain_name(joint.child)} along {_vector(freedom.axis_J)}"
                    if freedom.kind == "prismatic"
                    else f"{plain_name(joint.child)} freely"
                    if freedom.kind == "free"
                    else plain_name(joint.child),
                    "none" if limits == "-inf .. inf" else limits,
                    *(
                        f"{value:.4g}" if value else "-"
                        for value in (freedom.damping, freedom.friction, freedom.stiffness)
                    ),
                    f"{joint.mass:.4g}",
                )
            )
    return rows


def _cable_rows(description: "Description") -> list[tuple[str, ...]]:
    """Return the table of cables with its heading."""
    rows: list[tuple[str, ...]] = [("cable", "from", "to", "length m", "stiffness N/m")]
    for cable in description.model.cables:
        ends = (
            f"{plain_name(link)} at {_vector(p)}"
            for link, p in ((cable.parent, cable.p_parent), (cable.child, cable.p_child))
        )
        stiffness = f"{cable.stiffness:.4g}" if cable.stiffness else "hardly stretches"
        rows.append((plain_name(cable.name), *ends, f"{cable.length:.4g}", stiffness))
    return rows


def _servo_rows(vehicle: "Vehicle") -> list[tuple[str, ...]]:
    """Return the table of servos with its heading."""
    from workbench.parameters.servo_parameters import servo_parameters

    commanded = {tilt.joint: "the law, for yaw" for tilt in vehicle.tilts}
    named = zip(vehicle.free_servos(), servo_parameters(vehicle), strict=True)
    commanded |= {each.joint: row.name for each, row in named}
    rows: list[tuple[str, ...]] = [
        ("joint", "of", "commanded by", "stiffness", "damping", "setpoints", "effort", "rate")
    ]
    for each in vehicle.servos:
        servo = each.servo
        limits = f"{servo.lower:.4g} .. {servo.upper:.4g}"
        rows.append(
            (
                plain_name(each.joint),
                servo.kind,
                commanded[each.joint],
                *(f"{value:.4g}" if value else "-" for value in (servo.spring, servo.damper)),
                limits if math.isfinite(servo.upper - servo.lower) else "-",
                *(
                    f"{value:.4g}" if math.isfinite(value) else "-"
                    for value in (servo.max_effort, servo.max_rate)
                ),
            )
        )
    return rows


def _joint_motion(description: "Description", vehicle: "Vehicle") -> list[tuple[str, str]]:
    """Return rows about the motion of all joints, and how it is integrated."""
    from workbench.diagram.joint_modes import joint_study
    from workbench.scenario.scenario import Rates
    from workbench.session.integration import integrator_in_hover

    modes, lows, highs = joint_study(description)
    integrator = integrator_in_hover(Rates(), vehicle, modes)
    ends = [
        (round(least, 9), round(most, 9))  # without rounding errors
        for least, most in zip(lows.tolist(), highs.tolist(), strict=True)
    ]
    moved = {link for joint in vehicle.joints for link in joint.links}
    links = (link for link in description.model.links if link.name in moved)
    mass = sum(link.inertial.mass for link in links if link.inertial)
    rows = [
        ("moving mass", f"{mass:.4g} of {vehicle.mass:.5g} kg"),
        (
            "centre of mass",
            ", ".join(f"{a:z.4g} .. {b:z.4g}" for a, b in ends)
            + " m in x, y, z, each joint through its range alone",
        ),
    ]
    if modes:
        fastest = modes[0]
        rows.append(("fastest mode", f"{fastest.rate:.4g} rad/s, of {plain_name(fastest.joint)}"))
    return [*rows, ("integrator in hover", integrator)]


def _rotors(vehicle: "Vehicle") -> list[tuple[str, ...]]:
    """Return the rotor table with its heading."""
    rows = [
        (
            rotor.name,
            _vector(rotor.p_BR),
            _vector(rotor.axis_B),
            "ccw" if rotor.direction > 0 else "cw",
            f"{rotor.motor_constant:.6g}",
            f"{rotor.moment_constant:.5g}",
            f"{rotor.time_constant_up:g} / {rotor.time_constant_down:g}",
            f"{rotor.max_rot_velocity:.5g}",
            f"{rotor.inertia:.4g}" if rotor.inertia else "not stated",
        )
        for rotor in vehicle.rotors
    ]
    return [
        (
            "name",
            "position m",
            "axis",
            "turns",
            "thrust/ω² N s²",
            "moment/thrust m",
            "lag up / down s",
            "max rad/s",
            "inertia kg m²",
        ),
        *rows,
    ]


def _sensors(vehicle: "Vehicle") -> list[tuple[str, ...]]:
    """Return the sensor table with its heading."""
    rows = [
        (
            sensor.name,
            sensor.type,
            sensor.frame,
            _vector(sensor.p_BS),
            f"{sensor.rate or sensor.usual_rate:g}",
        )
        for sensor in vehicle.sensors
    ]
    return [("name", "type", "frame", "position m", "rate Hz"), *rows]


_NOISE_UNITS = (
    ("angular_velocity", "rad/s"),
    ("linear_acceleration", "m/s²"),
    ("horizontal_position", "m"),
    ("vertical_position", "m"),
    ("horizontal_velocity", "m/s"),
    ("vertical_velocity", "m/s"),
    ("magnetic_field", "T"),
)
"""Units of a sensor's numbers with noise, by attribute."""


def _noise_rows(vehicle: "Vehicle") -> list[tuple[str, ...]]:
    """Return the table of the sensors' noise with its heading; "-" for none."""
    rows: list[tuple[str, ...]] = [
        (
            *("name", "of", "unit", "stddev", "mean"),
            *("bias mean", "bias stddev", "drift", "rounded to"),
        )
    ]
    for sensor in vehicle.sensors:
        for name, values in sensor.stated_noises.items():
            unit = dict(_NOISE_UNITS).get(name, sensor.noise_unit)
            what = name.replace("_", " ")
            if name == "noise":
                what = {"m": "distance", "Pa": "pressure"}.get(unit, sensor.kind)
            rows.append(
                (
                    sensor.name,
                    what,
                    unit,
                    *(
                        _joined_values(getattr(each, attribute) for each in values)
                        for attribute in (
                            "stddev",
                            "mean",
                            "bias_mean",
                            "bias_stddev",
                            "dynamic_bias_stddev",
                            "precision",
                        )
                    ),
                )
            )
    return rows


def _joined_values(values: Iterable[float]) -> str:
    """Return numbers, one for all if they are alike, "-" if they are 0."""
    found = [f"{value:.4g}" if value else "-" for value in values]
    return found[0] if len(set(found)) == 1 else " ".join(found)


def _tree(description: "Description", name: str, first: str, rest: str) -> Iterator[str]:
    """Yield lines of the tree of links below one."""
    model = description.model
    link, base, joint = model.link(name), model.link(description.base_link), model.joint_of(name)
    assert link and base
    hung = ""
    if joint and name != description.base_link:
        hung = f" by {plain_name(joint.name)}" + (f", {joint.kind}," if joint.moves else "")
    mass = f", {link.inertial.mass:.4g} kg" if link.inertial else ""
    place = _vector((base.X_ML.inverse() @ link.X_ML).translation())
    yield f"{first}{plain_name(name)}{hung} ({place}{mass})"
    children = [each.child for each in model.joints if each.parent == name]
    for child in children:
        last = child == children[-1]
        yield from _tree(
            description,
            child,
            rest + ("└─ " if last else "├─ "),
            rest + ("   " if last else "│  "),
        )


def _remark_text(remark: DescriptionRemark, description: "Description") -> str:
    """Return a remark, without the name of the file in the title."""
    if remark.file == description.source:
        return f"{remark.element}: {remark.text}"
    return str(remark)


def _vector(values: Iterable[float]) -> str:
    return " ".join(f"{value + 0.0:.4g}" if abs(value) >= 5e-7 else "0" for value in values)


def _exact(values: Iterable[float]) -> str:
    return " ".join(f"{value:.5g}" if abs(value) > 1e-12 else "0" for value in values)
