"""A file of wishes (YAML): the wishes, the steps they are about, and how unsure the vehicle is."""

import dataclasses
import math
from dataclasses import dataclass, field
from pathlib import Path

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.yaml_files import YamlFile, check_schema, read_yaml
from workbench.control.controller import DEFAULT, Controller, load_controller
from workbench.design.hover_check import STEPS
from workbench.design.tune.case import Robustness
from workbench.design.tune.wish import Wish, merged, parse_wish
from workbench.scenario.axes import AXES


@dataclass(frozen=True)
class Wishes:
    """What is wished for.

    Attributes:
        wishes: a bound each; what else a good flight needs is added, if `defaults`.
        steps: amplitude of the step that each axis flies [m/s, rad/s].
        robustness: the vehicles that it is asked of.
        defaults: whether the wishes that follow from the vehicle are added.
    """

    wishes: tuple[Wish, ...] = ()
    steps: tuple[tuple[str, float], ...] = STEPS
    robustness: Robustness = Robustness()
    defaults: bool = True


def wishes_for(*texts: str, defaults: bool = True, controller: str | Path = DEFAULT) -> Wishes:
    """Return wishes as texts, `x.rise_time <= 0.4 s`.

    Args:
        texts: a wish each.
        defaults: whether the wishes that follow from the vehicle are added.
        controller: whose loops, see `load_controller`.

    Raises:
        WorkbenchError: if one is none, or two contradict each other.
    """
    law = load_controller(controller)
    wishes = [wish for text in texts for wish in parse_wish(text, "asked", law)]
    return Wishes(wishes=tuple(merged(wishes)), defaults=defaults)


@dataclass
class _File:
    """The schema."""

    wishes: list[str] = field(default_factory=list)
    steps: dict[str, float] = field(default_factory=dict)
    robustness: Robustness = field(default_factory=Robustness)
    defaults: bool = True


def load_wishes(path: Path, law: Controller | None = None) -> Wishes:
    """Read and check a file of wishes.

    Args:
        path: of the file.
        law: whose loops; the default one's where none is given.

    Raises:
        WorkbenchError: naming file and line of what is wrong.
    """
    file = read_yaml(path)
    check_schema(file, _File)
    wishes: list[Wish] = []
    for index, text in enumerate(file.data.get("wishes") or []):
        where = file.where("wishes", index)
        try:
            wishes += parse_wish(text, where.rstrip(": "), law)
        except WorkbenchError as error:
            raise WorkbenchError(f"{where}{error}") from None
    try:
        merged(wishes)
    except WorkbenchError as error:
        raise WorkbenchError(f"{file.where('wishes')}{error}") from None
    return Wishes(
        wishes=tuple(merged(wishes)),
        steps=_steps(file),
        robustness=_robustness(file),
        defaults=bool(file.data.get("defaults", True)),
    )


def _steps(file: YamlFile) -> tuple[tuple[str, float], ...]:
    """Return the amplitudes with those of the file."""
    steps = dict(STEPS)
    for axis, amplitude in (file.data.get("steps") or {}).items():
        if axis not in AXES:
            raise WorkbenchError(f"{file.where('steps', axis)}{unknown_name('axis', axis, AXES)}")
        if not 0.0 < abs(amplitude) < math.inf:
            raise WorkbenchError(
                f"{file.where('steps', axis)}the step along {axis} is {amplitude:g}: give it a "
                "finite number, and not 0"
            )
        steps[axis] = float(amplitude)
    return tuple(steps.items())


def _robustness(file: YamlFile) -> Robustness:
    """Return what the file says of the vehicle's uncertainty."""
    values = file.data.get("robustness") or {}
    limits = {"margin_share": (0.0, 1.0), "overshoot_factor": (1.0, 100.0)}
    for name, value in values.items():
        low, high = limits.get(name, (0.0, 0.9))
        if not low <= value <= high:
            raise WorkbenchError(
                f"{file.where('robustness', name)}{name} is {value:g}: keep it within "
                f"{low:g} .. {high:g}"
            )
    return dataclasses.replace(Robustness(), **{name: float(v) for name, v in values.items()})
