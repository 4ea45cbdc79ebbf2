"""Wishes as they are typed: what may stand in one, and what is wrong with another."""

import re

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
    ),
    "rotors": ("rotors",),
}
"""Names of each kind; `level` is x and y, `tilt` is roll and pitch."""
METRICS = {
    "step": ("rise_time", "settling_time", "overshoot", "steady_state_error", "peak_rotor_use"),
    "loop": (
        "phase_margin",
        "gain_margin",
        "delay_margin",
        "disk_margin",
        "peak_sensitivity",
        "bandwidth",
    ),
    "rotors": ("noise_amplification",),
}
"""Numbers of each kind."""
_LARGER = ("phase_margin", "gain_margin", "delay_margin", "disk_margin", "bandwidth")
_FORM = re.compile(
    r"(\w+)\s*\.\s*(\w+)\s*(<=|>=|≤|≥|<|>)\s*[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
    r"\s*([A-Za-z%°]\S*)?"
)


def completions() -> tuple[str, ...]:
    """Return the beginnings that a wish may have, as `x.rise_time <= `."""
    return tuple(
        f"{subject}.{metric} {'>=' if metric in _LARGER else '<='} "
        for kind, subjects in SUBJECTS.items()
        for subject in subjects
        for metric in METRICS[kind]
    )


def what_is_wrong(text: str) -> str:
    """Return what is wrong with a wish, as a sentence; "" where nothing is seen to be."""
    form = _FORM.fullmatch(text.strip())
    if form is None:
        return "Write SUBJECT.METRIC <= VALUE or >=, as x.rise_time <= 0.4 s."
    subject, metric = form[1], form[2]
    kinds = [kind for kind, metrics in METRICS.items() if metric in metrics]
    if not kinds:
        known = ", ".join(each for metrics in METRICS.values() for each in metrics)
        return f"There is no metric {metric}: use one of {known}."
    if subject not in SUBJECTS[kinds[0]]:
        return f"{subject} has no {metric}: that is of {', '.join(SUBJECTS[kinds[0]])}."
    return ""


def wishes_in(text: str) -> tuple[str, ...]:
    """Return the wishes of a text, a line each; empty lines are none."""
    return tuple(line.strip() for line in text.splitlines() if line.strip())
