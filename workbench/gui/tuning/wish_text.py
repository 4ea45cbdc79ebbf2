"""Wishes as they are typed: what may stand in one, and what is wrong with another."""

import re

from workbench.common.errors import WorkbenchError
from workbench.design.metrics import WISHED
from workbench.gui.typed_number import NUMBER, read_number

SUBJECTS = {
    "step": ("x", "y", "z", "yaw", "level"),
    "loop": (
        "velocity_x",
        "velocity_y",
        "velocity_z",
        "roll",
        "pitch",
        "yaw_rate",
        "position_x",
        "position_y",
        "position_z",
        "tilt",
        "position_x_error",
        "position_y_error",
        "position_z_error",
        "velocity_x_error",
        "velocity_y_error",
        "velocity_z_error",
        "acceleration_x",
        "acceleration_y",
        "acceleration_z",
        "roll_error",
        "pitch_error",
        "yaw_rate_error",
        "roll_acceleration",
        "pitch_acceleration",
        "yaw_acceleration",
    ),
    "rotors": ("rotors",),
}
"""Names of each kind; `level` is x and y, `tilt` is roll and pitch."""
ATTITUDES = ("roll", "pitch", "tilt")
ATTITUDE_METRICS = ("rise_time", "settling_time", "overshoot")
"""Angles that can be stepped, too, and what a step of one has."""
METRICS = {
    kind: tuple(metric.name for metric in WISHED if metric.kind == kind) for kind in SUBJECTS
}
"""Numbers of each kind."""
_LARGER = tuple(metric.name for metric in WISHED if metric.better > 0)
_FORM = re.compile(
    rf"(\w+)\s*\.\s*(\w+)\s*(<=|>=|≤|≥|<|>)\s*(?P<number>{NUMBER})\s*([A-Za-z%°]\S*)?"
)


def completions() -> tuple[str, ...]:
    """Return the beginnings that a wish may have, as `x.rise_time <= `."""
    return tuple(
        f"{subject}.{metric} {'>=' if metric in _LARGER else '<='} "
        for kind, metrics in METRICS.items()
        for metric in metrics
        for subject in subjects_of(kind, metric)
    )


def subjects_of(kind: str, metric: str) -> tuple[str, ...]:
    """Return what has a metric of a kind."""
    return SUBJECTS[kind] + (ATTITUDES if metric in ATTITUDE_METRICS else ())


def what_is_wrong(text: str) -> str:
    """Return what is wrong with a wish, as a sentence; "" where nothing is seen to be."""
    form = _FORM.fullmatch(text.strip())
    if form is None:
        return "Write SUBJECT.METRIC <= VALUE or >=, as x.rise_time <= 0.4 s."
    subject, metric = form[1], form[2]
    kinds = [kind for kind, metrics in METRICS.items() if metric in metrics]
    if not kinds:
        names = ", ".join(each for metrics in METRICS.values() for each in metrics)
        return f"There is no metric {metric}: use one of {names}."
    known = subjects_of(kinds[0], metric)
    if subject not in known:
        return f"{subject} has no {metric}: that is of {', '.join(known)}."
    try:
        read_number(form["number"])
    except WorkbenchError as error:
        return str(error)
    return ""


def with_point(text: str) -> str:
    """Return a wish with a point before the decimals of its number, where it has a comma."""
    form = _FORM.fullmatch(text.strip())
    if form is None:
        return text.strip()
    begin, end = form.span("number")
    return form.string[:begin] + form["number"].replace(",", ".") + form.string[end:]


def wishes_in(text: str) -> tuple[str, ...]:
    """Return the wishes of a text, a line each; empty lines are none."""
    return tuple(line.strip() for line in text.splitlines() if line.strip())
