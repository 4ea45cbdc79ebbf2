"""What `workbench inspect` prints for people."""

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from workbench.commands.printing import print_table
from workbench.plant.remarks import Remark, RemarkKind

if TYPE_CHECKING:
    from workbench.plant.description import Description
    from workbench.plant.model import Model
    from workbench.plant.vehicle import Vehicle

_HEADINGS: dict[RemarkKind, str] = {
    "repaired": "repaired",
    "assumed": "assumed, as the description does not say it",
    "missing": "missing",
    "ignored": "not used",
}


def print_description(description: "Description", vehicle: "Vehicle") -> None:
    """Print body, rotors, sensors, frames and remarks."""
    print(f"{vehicle.name}, from {vehicle.source}")
    print_table(_body(vehicle), left=(0, 1))
    print(f"\nrotors ({len(vehicle.rotors)})")
    print_table(_rotors(vehicle), left=(0,))
    if vehicle.sensors:
        print(f"\nsensors ({len(vehicle.sensors)})")
        print_table(_sensors(vehicle), left=(0, 1, 2))
    print("\nframes, with the origins of links in m")
    for line in _tree(description.model, description.base_link, vehicle, "", ""):
        print(line)
    for kind, heading in _HEADINGS.items():
        remarks = [remark for remark in description.remarks if remark.kind == kind]
        if remarks:
            print(f"\n{heading}")
            for remark in remarks:
                print(f"  {_said(remark, vehicle)}")


def _body(vehicle: "Vehicle") -> list[tuple[str, str]]:
    """Return the rows about the body as a whole."""
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
        ("stands at", f"{vehicle.ground_clearance:.3f} m above the ground"),
    ]


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
            f"{sensor.rate:g}" if sensor.rate else "every step",
        )
        for sensor in vehicle.sensors
    ]
    return [("name", "type", "frame", "position m", "rate Hz"), *rows]


def _tree(model: "Model", link: str, vehicle: "Vehicle", first: str, rest: str) -> Iterator[str]:
    """Yield lines of the tree of links below one."""
    joint = model.joint_of(link)
    hung = f" by {joint.name}" if joint and link != vehicle.base_link else ""
    yield f"{first}{link}{hung} ({_vector(vehicle.frame(link).p_BF)})"
    children = [joint.child for joint in model.joints if joint.parent == link]
    for child in children:
        last = child == children[-1]
        yield from _tree(
            model,
            child,
            vehicle,
            rest + ("└─ " if last else "├─ "),
            rest + ("   " if last else "│  "),
        )


def _said(remark: Remark, vehicle: "Vehicle") -> str:
    """Return a remark, without the name of the file that the title has."""
    if remark.file == vehicle.source:
        return f"{remark.element}: {remark.text}"
    return str(remark)


def _vector(values: Iterable[float]) -> str:
    return " ".join(f"{value + 0.0:.4g}" if abs(value) >= 5e-7 else "0" for value in values)


def _exact(values: Iterable[float]) -> str:
    return " ".join(f"{value:.5g}" if abs(value) > 1e-12 else "0" for value in values)
