"""A picture of a flight as lines of text."""

import math
from collections.abc import Iterator

from workbench.gateways.monitor.picture import Picture, number, numbers, text
from workbench.link.messages import Hand, Stage
from workbench.link.sample import Sample

BAR = 24
LABEL = 10
SEVERITIES = ("information", "warning", "failure")


def dashboard(picture: Picture, full: str = "#", empty: str = ".") -> list[str]:
    """Return the lines of a screen.

    Args:
        picture: what is known.
        full: sign for the part of a bar that counts.
        empty: sign for the rest.
    """
    when = "-" if picture.time is None else f"{picture.time:.2f}"
    lines = [f"{picture.vehicle} at {picture.address}, {when} s", ""]
    # First what must not be cut off where the screen is small.
    lines += _labelled("mode", _mode(picture))
    lines += _labelled("control", iter([control_line(picture)]))
    lines += _labelled("link", iter([link_line(picture)]))
    lines += [""]
    lines += _labelled("position", _position(picture))
    lines += _labelled("velocity", _velocity(picture))
    lines += _labelled("attitude", _attitude(picture))
    lines += _labelled("flown", _flown(picture))
    lines += [""]
    lines += _labelled("rotors", _rotors(picture, full, empty))
    lines += [""]
    lines += _labelled("imu", _imu(picture))
    lines += _labelled("gps", _gps(picture))
    lines += _labelled("lidar", _lidar(picture))
    lines += _labelled("field", _magnetic_field(picture))
    lines += _labelled("wind", _wind(picture))
    lines += _labelled("event", _event(picture))
    return [line for at, line in enumerate(lines) if line or (at and lines[at - 1])]


def one_line(picture: Picture) -> str:
    """Return the picture as one line, for a log."""
    when = "-" if picture.time is None else f"{picture.time:.2f}"
    parts = [f"{when} s", *_mode(picture)]
    for label, lines in (
        ("position", _position(picture)),
        ("velocity", _velocity(picture)),
        ("attitude", _attitude(picture)),
        ("control", iter([control_line(picture)])),
        ("link", iter([link_line(picture)])),
    ):
        parts += [f"{label} {' '.join(line.split())}" for line in lines]
    return "; ".join(parts)


def control_line(picture: Picture) -> str:
    """Return who flies, in words."""
    control = picture.control
    if control is None:
        return "not known yet"
    if control.hand is Hand.NOBODY:
        return f"nobody: {control.reason}"
    if control.hand is Hand.OPERATOR:
        return f"the operator at the screen: {control.reason}"
    who = "you" if picture.mine else control.name or f"client {control.peer}"
    stage = "" if control.stage is Stage.LIVE else f" ({control.stage.value})"
    return f"{who}{stage}, last command {control.age:.1f} s ago"


def link_line(picture: Picture) -> str:
    """Return how the connection does."""
    if picture.trouble:
        return f"no connection: {picture.trouble}"
    age = "" if picture.age is None else f", age {1000.0 * picture.age:.0f} ms"
    return f"{picture.rate:.0f} samples/s{age}"


def _labelled(label: str, lines: Iterator[str]) -> list[str]:
    return [f"{label if at == 0 else '':<{LABEL}}{line}" for at, line in enumerate(lines)]


def _mode(picture: Picture) -> Iterator[str]:
    sample = picture.samples.get("drone_state")
    if sample is None:
        return
    parts = [text(sample, "condition")]
    charge, clearance = number(sample, "charge"), number(sample, "clearance")
    if math.isfinite(charge):
        parts.append(f"charge {100.0 * charge:.0f} %")
    if math.isfinite(clearance):
        parts.append(f"{clearance:.2f} m to the next obstacle")
    yield ", ".join(parts)


def _position(picture: Picture) -> Iterator[str]:
    yield from _three(picture.samples.get("position_data"), ("x", "y", "z"), 1.0, "m")


def _velocity(picture: Picture) -> Iterator[str]:
    yield from _three(picture.samples.get("velocity_data"), ("v_x", "v_y", "v_z"), 1.0, "m/s")


def _attitude(picture: Picture) -> Iterator[str]:
    sample = picture.samples.get("position_data")
    yield from _three(sample, ("roll", "pitch", "yaw"), math.degrees(1.0), "deg")


def _flown(picture: Picture) -> Iterator[str]:
    sample = picture.samples.get("command_velocity")
    if sample is not None:
        turn = math.degrees(number(sample, "yaw_rate"))
        for line in _three(sample, ("v_x", "v_y", "v_z"), 1.0, "m/s"):
            yield f"{line}   yaw {turn:z.1f} deg/s"


def _three(
    sample: Sample | None, fields: tuple[str, str, str], factor: float, unit: str
) -> Iterator[str]:
    """Yield three numbers with their names, each in a place of its own."""
    if sample is not None:
        parts = [f"{name:>5} {factor * number(sample, name):z9.2f}" for name in fields]
        yield f"{' '.join(parts)} {unit}"


def _rotors(picture: Picture, full: str, empty: str) -> Iterator[str]:
    sample = picture.samples.get("rotors")
    if sample is None:
        return
    pairs = zip(numbers(sample, "thrust"), numbers(sample, "speed"), strict=False)
    for at, (thrust, speed) in enumerate(pairs, start=1):
        share = thrust / picture.strongest if picture.strongest > 0.0 else 0.0
        long = round(BAR * min(max(share, 0.0), 1.0)) if math.isfinite(share) else 0
        bar = full * long + empty * (BAR - long)
        yield f"{at:2} {bar} {thrust:z7.2f} N {speed:z7.0f} rad/s"


def _imu(picture: Picture) -> Iterator[str]:
    sample = picture.samples.get("imu")
    if sample is not None:
        force = " ".join(f"{each:z8.2f}" for each in numbers(sample, "specific_force"))
        turn = " ".join(f"{each:z8.2f}" for each in numbers(sample, "angular_velocity"))
        yield f"{force} m/s^2 {turn} rad/s"


def _gps(picture: Picture) -> Iterator[str]:
    sample = picture.samples.get("gps")
    if sample is not None:
        north = math.degrees(number(sample, "latitude"))
        east = math.degrees(number(sample, "longitude"))
        yield f"{north:11.6f} N {east:11.6f} E deg, {number(sample, 'altitude'):.1f} m high"


def _lidar(picture: Picture) -> Iterator[str]:
    sample = picture.samples.get("lidar")
    if sample is not None:
        hits, rays = number(sample, "returns"), number(sample, "rays")
        near = f", nearest {number(sample, 'nearest'):.2f} m" if hits else ""
        yield f"{hits:.0f} of {rays:.0f} rays hit something{near}"


def _magnetic_field(picture: Picture) -> Iterator[str]:
    sample = picture.samples.get("magnetometer")
    if sample is not None:
        field = " ".join(f"{1e6 * each:z8.2f}" for each in numbers(sample, "magnetic_field"))
        yield f"{field} uT"


def _wind(picture: Picture) -> Iterator[str]:
    sample = picture.samples.get("wind")
    if sample is not None:
        yield " ".join(f"{each:z8.2f}" for each in numbers(sample, "wind")) + " m/s"


def _event(picture: Picture) -> Iterator[str]:
    sample = picture.samples.get("events")
    if sample is not None:
        severity = number(sample, "severity")
        known = severity in range(len(SEVERITIES))
        kind = f"{SEVERITIES[int(severity)]}: " if known and severity > 0 else ""
        yield f"{kind}{text(sample, 'said')} (at {sample.time:.1f} s)"
