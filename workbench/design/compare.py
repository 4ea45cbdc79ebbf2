"""Compare controllers and gains: the same flights, vehicles and margins, one column for each."""

import copy
import dataclasses
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.resources import find_file
from workbench.control.controller import Controller
from workbench.control.controller_file import load_controller
from workbench.control.installed_laws import is_shipped
from workbench.control.law_program import not_repeatable_error
from workbench.control.schedule import split_label
from workbench.design.comparison import (
    COMPARISON_PARTS,
    COMPARISON_ROWS,
    UNMET_WISHES_ROW,
    ControllerCandidate,
    ControllerComparison,
    ControllerResult,
)
from workbench.design.comparison_bench import PART_MEASURES, ComparisonBench
from workbench.design.tune.tuner import Tuner
from workbench.design.tune.tuning import Tuning
from workbench.design.tune.wish import Wishes, load_wishes, merged_wishes, parse_wish
from workbench.gains.gains import flown_by, load_gains, owner_of, save_gains
from workbench.scenario.scenario import Scenario


def find_candidates(texts: Sequence[str]) -> tuple[ControllerCandidate, ...]:
    """Return what to compare.

    Args:
        texts: each a shipped controller or a .py file, a gain file (.yaml) of a shipped one, or
            both as CONTROLLER=GAINS.yaml.

    Raises:
        WorkbenchError: for one that does not load, or if two have the same name.
    """
    found: list[ControllerCandidate] = []
    for text in texts:
        names_gains = text.endswith((".yaml", ".yml"))
        reference, sign, gains = text.rpartition("=") if names_gains else (text, "", "")
        if gains:
            path = find_file(gains)
            reference = reference if sign else flown_by(_shipped_owner(path), gains)
            law = load_controller(reference)
            load_gains(path, law)
            candidate = ControllerCandidate(path.stem, reference, law, str(path))
        else:
            law = load_controller(reference)
            candidate = ControllerCandidate(law.name, reference, law)
        if law.program:
            raise not_repeatable_error(law.name)
        if candidate.name in [other.name for other in found]:
            raise WorkbenchError(
                f"two controllers are called {candidate.name}: name each controller and gain "
                "file once, and call files otherwise"
            )
        found.append(candidate)
    return tuple(found)


def _shipped_owner(path: Path) -> str:
    """Return the shipped controller that a gain file names."""
    owner, _ = split_label(owner_of(path))
    if not is_shipped(owner):
        raise WorkbenchError(
            f"{path}: its gains are of the controller {owner}: name its file, too, as "
            f"{owner}.py={path.name}"
        )
    return owner


def chosen_parts(names: Sequence[str]) -> tuple[str, ...]:
    """Return the named parts of a comparison, or all if none is named.

    Raises:
        WorkbenchError: for an unknown one.
    """
    for name in names:
        if name not in COMPARISON_PARTS:
            raise unknown_name("part of a comparison", name, COMPARISON_PARTS)
    return tuple(part for part in COMPARISON_PARTS if part in names or not names)


def compare_controllers(
    controllers: Sequence[str],
    scenario: Scenario | None = None,
    *,
    parts: Sequence[str] = (),
    wishes: Sequence[str] | None = None,
    progress: Callable[[float], None] | None = None,
) -> ControllerComparison:
    """Fly and judge controllers on one vehicle, each with its gains for that vehicle.

    With wishes, each controller is first tuned for them. The comparison is then of structures, not
    of how well their gains were set.

    Args:
        controllers: see `find_candidates`.
        scenario: its vehicle, world and rates are used, and its figure of eight if it has one. Its
            gain file is used for the controller that it belongs to, unless that has its own.
        parts: names from `COMPARISON_PARTS`; all if empty.
        wishes: texts, or paths of wish files, see docs/tuning.md; an empty sequence uses the wishes
            that follow from the vehicle. None does no tuning.
        progress: called with the share done, 0 .. 1.

    Raises:
        WorkbenchError: if a controller, the vehicle or a wish cannot be read.
    """
    candidates, chosen = find_candidates(controllers), chosen_parts(parts)
    scenario = scenario or Scenario()
    asked = [wishes_of(wishes or (), each.law) for each in candidates]
    count, done = len(candidates) * (len(chosen) + (wishes is not None)), 0

    def say(share: float) -> None:
        if progress:
            progress((done + share) / count)

    found, vehicle = [], ""
    rows = [UNMET_WISHES_ROW] * (wishes is not None) + [
        row for row in COMPARISON_ROWS if row.part in chosen
    ]
    with TemporaryDirectory() as folder:
        for candidate, each in zip(candidates, asked, strict=True):
            flown = _flown_by(scenario, candidate)
            tuned = None
            if wishes is not None:
                tuned = Tuner(flown, each).run(lambda progress: say(progress.share))
                flown.vehicle.gains = str(Path(folder) / f"{candidate.name}.yaml")
                save_gains(Path(flown.vehicle.gains), tuned.profile)
                done += 1
            bench = ComparisonBench(flown, candidate, say)
            if tuned:
                _note_tuned(bench.found, tuned)
            vehicle = bench.study.vehicle.name
            for part in chosen:
                names = [row.name for row in COMPARISON_ROWS if row.part == part]
                try:
                    PART_MEASURES[part](bench)
                except WorkbenchError as error:
                    bench.found.none([n for n in names if n not in bench.found.numbers], str(error))
                done += 1
                say(0.0)
            found.append(bench.found)
    return ControllerComparison(vehicle, tuple(rows), tuple(found))


def wishes_of(texts: Sequence[str], law: Controller) -> Wishes:
    """Return wishes about a controller, given as texts or paths of wish files.

    Raises:
        WorkbenchError: if a wish is invalid, or about a loop that the controller does not have.
    """
    files = [text for text in texts if text.endswith((".yaml", ".yml"))]
    if len(files) > 1:
        raise WorkbenchError(f"{len(files)} files of wishes are named: name one")
    from_file = load_wishes(find_file(files[0]), law) if files else Wishes()
    typed = [wish for text in texts if text not in files for wish in parse_wish(text, law=law)]
    return dataclasses.replace(from_file, wishes=tuple(merged_wishes([*from_file.wishes, *typed])))


def _note_tuned(found: ControllerResult, tuned: Tuning) -> None:
    """Note the results of the tuning."""
    unmet = [result.required for result in tuned.as_described if not result.met]
    said = "; ".join(map(str, unmet or tuned.conflicts))
    found.note(UNMET_WISHES_ROW.name, float(len(unmet)), said)
    if not (unmet or tuned.met):
        found.remarks[UNMET_WISHES_ROW.name] = (
            said or "met as described, and not by all vehicles near it"
        )
    found.gains.update(tuned.gains)


def _flown_by(scenario: Scenario, candidate: ControllerCandidate) -> Scenario:
    """Return a scenario with another controller and its gains, or those that belong to it."""
    flight = copy.deepcopy(scenario)
    flight.controller = candidate.reference
    gains = flight.vehicle.gains
    if candidate.gains:
        flight.vehicle.gains = candidate.gains
    elif gains and owner_of(find_file(gains)) != candidate.law.name:
        flight.vehicle.gains = ""
    return flight
