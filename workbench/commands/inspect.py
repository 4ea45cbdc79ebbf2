"""`workbench inspect`: show the interpretation of a drone description."""

import argparse
import dataclasses
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    MODEL_HELP,
    add_command,
    add_description_options,
    add_json_option,
    add_rotors_option,
    chosen_model,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import pick, print_result, print_table
from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import plain_name
from workbench.plant.remarks import HEADINGS, Remark

if TYPE_CHECKING:
    from workbench.plant.description import Description
    from workbench.plant.sensors import Noise, Sensor
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
    for kind, heading in HEADINGS.items():
        remarks = [remark for remark in description.remarks if remark.kind == kind]
        if remarks:
            print(f"\n{heading}")
            for remark in remarks:
                print(f"  {_said(remark, description)}")


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


def _noises(sensor: "Sensor") -> "Iterator[tuple[str, tuple[Noise, ...]]]":
    """Yield the attributes of a sensor that are noise, with one value, or one for each axis."""
    from workbench.plant.sensors import Noise

    for field in dataclasses.fields(sensor):
        value = getattr(sensor, field.name)
        values = value if isinstance(value, tuple) else (value,)
        if values and all(isinstance(each, Noise) for each in values):
            yield field.name, values


def _noise_rows(vehicle: "Vehicle") -> list[tuple[str, ...]]:
    """Return the table of the sensors' noise with its heading; "-" for none."""
    rows: list[tuple[str, ...]] = [
        (
            *("name", "of", "unit", "stddev", "mean"),
            *("bias mean", "bias stddev", "drift", "rounded to"),
        )
    ]
    for sensor in vehicle.sensors:
        for name, values in _noises(sensor):
            unit = dict(_NOISE_UNITS).get(name, "Pa" if sensor.kind == "barometer" else "m")
            what = "distance" if name == "noise" else name.replace("_", " ")
            rows.append(
                (
                    sensor.name,
                    "pressure" if unit == "Pa" else what,
                    unit,
                    *(
                        _alike(getattr(each, attribute) for each in values)
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


def _alike(values: Iterable[float]) -> str:
    """Return numbers, one for all if they are alike, "-" if they are 0."""
    found = [f"{value:.4g}" if value else "-" for value in values]
    return found[0] if len(set(found)) == 1 else " ".join(found)


def _tree(description: "Description", name: str, first: str, rest: str) -> Iterator[str]:
    """Yield lines of the tree of links below one."""
    model = description.model
    link, base, joint = model.link(name), model.link(description.base_link), model.joint_of(name)
    assert link and base
    hung = f" by {plain_name(joint.name)}" if joint and name != description.base_link else ""
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


def _said(remark: Remark, description: "Description") -> str:
    """Return a remark, without the name of the file in the title."""
    if remark.file == description.source:
        return f"{remark.element}: {remark.text}"
    return str(remark)


def _vector(values: Iterable[float]) -> str:
    return " ".join(f"{value + 0.0:.4g}" if abs(value) >= 5e-7 else "0" for value in values)


def _exact(values: Iterable[float]) -> str:
    return " ".join(f"{value:.5g}" if abs(value) > 1e-12 else "0" for value in values)


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "inspect",
        "Show what the workbench reads from a drone description: mass, rotors, sensors, frames, "
        "repairs, and unused parts.",
        "workbench inspect my_drone.urdf.xacro --arg mass:=2.1 --package my_drone=../my_drone",
        run,
    )
    parser.add_argument(
        "model",
        metavar="NAME|PATH",
        help=MODEL_HELP,
    )
    add_description_options(parser)
    add_rotors_option(parser)
    parser.add_argument(
        "--write",
        type=Path,
        metavar="DIR",
        help="store the resolved model there, as one URDF that Drake reads, with its meshes",
    )
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Print the interpretation, and write the resolved model if requested."""
    from workbench.plant.loading import make_vehicle
    from workbench.plant.plausible import doubts
    from workbench.scenario.configured import read_configured

    description = _with_lack(read_configured(chosen_model(args)))
    try:
        vehicle = make_vehicle(description)
    except WorkbenchError:
        if not args.json:  # show the parts, as they explain why it cannot fly
            print_parts(description)
        raise
    files = _write(description, args.write) if args.write else []
    unlikely = doubts(vehicle)
    result, shown = _json(description, vehicle, unlikely), (description, vehicle, unlikely)
    print_result(args, result, print_description, *shown, files=files)
    return ExitCode.DONE


def _with_lack(description: "Description") -> "Description":
    """Return a description with a remark if the kernel does not hold the processes that read it."""
    from workbench.ipc.sandbox import lacking

    missing = lacking()
    if not missing:
        return description
    text = (
        f"this kernel has no {' and no '.join(missing)}: a fault in a reader of xacro files or "
        "meshes could reach your files and the network"
    )
    remark = Remark("missing", description.source, "limits of the kernel", text)
    return dataclasses.replace(description, remarks=(*description.remarks, remark))


def _write(description: "Description", folder: Path) -> list[Path]:
    """Write the model completely or not at all."""
    from workbench.plant.formats.urdf_writer import stored_files

    with Outputs() as outputs:
        for relative, data in stored_files(description):
            target = folder / relative
            draft = outputs.add(target)  # refuses what is no name of a file
            if target.is_symlink() or target.parent.is_symlink() and target.parent != folder:
                raise WorkbenchError(f"{target}: is a link: name an empty folder")
            if target.exists() and target.samefile(description.source):
                raise WorkbenchError(f"{target}: is the description itself: name another folder")
            draft.write_bytes(data)
    return outputs.files


_OF_ROTORS = (
    "name joint link direction time_constant_up time_constant_down rotor_drag_coefficient "
    "rolling_moment_coefficient inertia inflow_coefficient ground_effect_coefficient "
    "propeller_radius linear_motor_constant"
)
"""Attributes of a rotor that --json has under their names."""


def _json(description: "Description", vehicle: "Vehicle", unlikely: list[str]) -> dict[str, Any]:
    """Return the vehicle in standard terms: all numbers of its plant, and more."""
    from workbench.plant.drag import AIR_DENSITY, drag_area
    from workbench.plant.gravity import GRAVITY
    from workbench.scenario.parameters import parameter_table

    hover = vehicle.hover_speeds
    return {
        **pick(vehicle, "name source base_link mass thrust_to_weight ground_clearance battery"),
        "com": vehicle.p_BoBcm_B,
        "inertia": vehicle.I_BBcm_B,
        "gravity": GRAVITY,
        "air_density": AIR_DENSITY,
        "drag_area": drag_area(vehicle.mass),
        "rotors": [
            {
                **pick(rotor, _OF_ROTORS),
                "position": rotor.p_BR,
                "axis": rotor.axis_B,
                "thrust_coefficient": rotor.motor_constant,
                "moment_coefficient": rotor.moment_constant,
                "max_speed": rotor.max_rot_velocity,
                "hover_speed": float(speed),
            }
            for rotor, speed in zip(vehicle.rotors, hover, strict=True)
        ],
        "battery_duration": (vehicle.battery and vehicle.battery.hover_duration)
        or parameter_table().find("battery_duration").default,
        "not_flown": [],  # everything read is used; programs may expect the key
        "sensors": [
            {
                **pick(sensor, "type name frame rate link"),
                "position": sensor.p_BS,
                "rotation": sensor.R_BS,
                "noise": {
                    name: [dataclasses.asdict(each) for each in values]
                    for name, values in _noises(sensor)
                },
            }
            for sensor in vehicle.sensors
        ],
        "frames": [
            {"name": frame.name, "position": frame.p_BF, "rotation": frame.R_BF}
            for frame in vehicle.frames
        ],
        "warnings": [
            *map(str, description.remarks),
            *(f"{vehicle.source}: {doubt}" for doubt in unlikely),
        ],
    }
