"""The lines of text that show a flight."""

import math
from collections.abc import Callable, Mapping

from workbench.gateways.monitor.picture import Picture, number, numbers, text
from workbench.link.messages import Hand, Stage
from workbench.link.sample import Sample

BAR = 24
LABEL = 10
SEVERITIES = ("information", "warning", "failure")


def dashboard(picture: Picture, full: str = "#", empty: str = ".") -> list[str]:
    """Return the lines of a screen.

    Args:
        picture: state of the flight.
        full: character for the filled part of a bar.
        empty: character for the rest.
    """
    when = "-" if picture.time is None else f"{picture.time:.2f}"
    lines = [f"{picture.vehicle} at {picture.address}, {when} s", ""]
    # The most important lines come first, as a small screen cuts off the last ones.
    for group in (
        ("mode", "control", "link"),
        ("position", "velocity", "attitude", "flown"),
        ("rotors",),
        ("imu", "gps", "lidar", "field", "wind", "event"),
    ):
        for label in group:
            found = _lines(picture, label) if label != "rotors" else _rotors(picture, full, empty)
            lines += [f"{label if at == 0 else '':<{LABEL}}{line}" for at, line in enumerate(found)]
        lines.append("")
    return [line for at, line in enumerate(lines[:-1]) if line or (at and lines[at - 1])]


def one_line(picture: Picture) -> str:
    """Return the picture as one line, for a log."""
    when = "-" if picture.time is None else f"{picture.time:.2f}"
    parts = [f"{when} s", *_lines(picture, "mode")]
    for label in ("position", "velocity", "attitude", "control", "link"):
        parts += [f"{label} {' '.join(line.split())}" for line in _lines(picture, label)]
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
    """Return the state of the connection, in words."""
    if picture.trouble:
        return f"no connection: {picture.trouble}"
    age = "" if picture.age is None else f", age {1000.0 * picture.age:.0f} ms"
    return f"{picture.rate:.0f} samples/s{age}"


def _lines(picture: Picture, label: str) -> list[str]:
    """Return the text of a label, empty if its topic has no sample."""
    if label == "control":
        return [control_line(picture)]
    if label == "link":
        return [link_line(picture)]
    topic, text_of = _TEXTS[label]
    sample = picture.samples.get(topic)
    return [] if sample is None else [text_of(sample)]


def _mode(sample: Sample) -> str:
    parts = [text(sample, "condition")]
    charge, clearance = number(sample, "charge"), number(sample, "clearance")
    if math.isfinite(charge):
        parts.append(f"charge {100.0 * charge:.0f} %")
    if math.isfinite(clearance):
        parts.append(f"{clearance:.2f} m to the next obstacle")
    return ", ".join(parts)


def _three(*fields: str, unit: str, factor: float = 1.0) -> Callable[[Sample], str]:
    """Return the text of three fields with their names, in columns."""

    def text_of(sample: Sample) -> str:
        parts = [f"{name:>5} {factor * number(sample, name):z9.2f}" for name in fields]
        return f"{' '.join(parts)} {unit}"

    return text_of


_VELOCITY = _three("v_x", "v_y", "v_z", unit="m/s")


def _flown(sample: Sample) -> str:
    return f"{_VELOCITY(sample)}   yaw {math.degrees(number(sample, 'yaw_rate')):z.1f} deg/s"


def _rotors(picture: Picture, full: str, empty: str) -> list[str]:
    """Return a line for each rotor, with a bar for its thrust."""
    sample = picture.samples.get("rotors")
    if sample is None:
        return []
    lines = []
    pairs = zip(numbers(sample, "thrust"), numbers(sample, "speed"), strict=False)
    for at, (thrust, speed) in enumerate(pairs, start=1):
        share = thrust / picture.strongest if picture.strongest > 0.0 else 0.0
        long = round(BAR * min(max(share, 0.0), 1.0)) if math.isfinite(share) else 0
        bar = full * long + empty * (BAR - long)
        lines.append(f"{at:2} {bar} {thrust:z7.2f} N {speed:z7.0f} rad/s")
    return lines


def _vector(field: str, unit: str, factor: float = 1.0) -> Callable[[Sample], str]:
    """Return the text of the numbers of a field, in columns."""
    return lambda sample: (
        " ".join(f"{factor * each:z8.2f}" for each in numbers(sample, field)) + f" {unit}"
    )


_FORCE = _vector("specific_force", "m/s^2")
_TURN = _vector("angular_velocity", "rad/s")


def _gps(sample: Sample) -> str:
    north = math.degrees(number(sample, "latitude"))
    east = math.degrees(number(sample, "longitude"))
    return f"{north:11.6f} N {east:11.6f} E deg, {number(sample, 'altitude'):.1f} m high"


def _lidar(sample: Sample) -> str:
    hits, rays = number(sample, "returns"), number(sample, "rays")
    near = f", nearest {number(sample, 'nearest'):.2f} m" if hits else ""
    return f"{hits:.0f} of {rays:.0f} rays hit something{near}"


def _event(sample: Sample) -> str:
    severity = number(sample, "severity")
    known = severity in range(len(SEVERITIES))
    kind = f"{SEVERITIES[int(severity)]}: " if known and severity > 0 else ""
    return f"{kind}{text(sample, 'said')} (at {sample.time:.1f} s)"


_TEXTS: Mapping[str, tuple[str, Callable[[Sample], str]]] = {
    "mode": ("drone_state", _mode),
    "position": ("position_data", _three("x", "y", "z", unit="m")),
    "velocity": ("velocity_data", _VELOCITY),
    "attitude": (
        "position_data",
        _three("roll", "pitch", "yaw", unit="deg", factor=math.degrees(1.0)),
    ),
    "flown": ("command_velocity", _flown),
    "imu": ("imu", lambda sample: f"{_FORCE(sample)} {_TURN(sample)}"),
    "gps": ("gps", _gps),
    "lidar": ("lidar", _lidar),
    "field": ("magnetometer", _vector("magnetic_field", "uT", 1e6)),
    "wind": ("wind", _vector("wind", "m/s")),
    "event": ("events", _event),
}
"""The topic and the text of each label."""
