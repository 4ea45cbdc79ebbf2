"""Replay a log, and compare every state to the bit."""

import dataclasses
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.resources import existing_path
from workbench.control.controller import Controller
from workbench.control.installed_laws import is_shipped
from workbench.control.schedule import split_label, with_label
from workbench.estimation.settings import ESTIMATORS
from workbench.link.backplane import Sampled
from workbench.logs.contents import software_versions
from workbench.logs.record import LogRecord
from workbench.scenario.flown_controller import flown_controller
from workbench.scenario.scenario import Scenario
from workbench.session.script import repeat_scenario
from workbench.session.session import Session
from workbench.systems.bridge import Bridge

STATE_PART_STARTS = {"orientation": 0, "position": 4, "angular velocity": 7, "velocity": 10}
"""Index at which each part of a state begins."""
COMPARISON_PERIOD_S = 0.25
"""Time flown between two comparisons [s]."""


@dataclass(frozen=True)
class StateDifference:
    """The first state that differs.

    Attributes:
        time: of that state [s].
        part: orientation, position, angular velocity or velocity.
        size: largest difference of its components, in SI units.
    """

    time: float
    part: str
    size: float


@dataclass(frozen=True)
class ReplayResult:
    """The result of a replay.

    Attributes:
        states: number of states compared.
        duration: covered by them [s].
        first: first difference; None if all states are equal to the bit.
        changed: versions that differ, such as "numpy 2.4.6, was 2.3.0", and a changed text of the
            controller.
    """

    states: int
    duration: float
    first: StateDifference | None
    changed: tuple[str, ...]

    @property
    def equal(self) -> bool:
        """Whether every state is equal to the bit."""
        return self.first is None


def replay(
    record: LogRecord,
    progress: Callable[[float], None] | None = None,
    controller: str = "",
    estimator: str = "",
) -> ReplayResult:
    """Replay a log, up to its end or the first difference.

    Args:
        record: the log.
        progress: takes the share done, 0 .. 1.
        controller: the one that flew: the name of a shipped one, the path of a file, or the path of
            the log itself, for the texts in it. Python that only the log names is not executed.
        estimator: the one used in the flight, in the same form.

    Raises:
        WorkbenchError: if the log has no states, or cannot be flown here.
    """
    if not len(record.states):
        raise WorkbenchError(f"{record.path}: has no states, so there is nothing to fly again")
    with TemporaryDirectory() as folder:
        return _replayed(record, progress, controller, estimator, Path(folder))


def _replayed(
    record: LogRecord,
    progress: Callable[[float], None] | None,
    controller: str,
    estimator: str,
    folder: Path,
) -> ReplayResult:
    first, compared = None, 0
    logged = dict(zip(record.state_ns, record.states, strict=True))
    scenario = replay_scenario(record, controller, folder, estimator)
    law, whose = flown_controller(scenario), record.controller.get("name")
    if whose not in (None, law.name):
        raise WorkbenchError(
            f"{record.path}: was flown by {whose}, and {law.name} is another law with other gains: "
            f"name the file of {whose}, as --controller {record.controller['file']}"
        )
    table = law.table
    if record.estimator and not all(name in table for name in record.values):
        raise WorkbenchError(
            f"{record.path}: was flown on {record.estimator['name']}, and {scenario.estimator} has "
            f"other parameters: name its file, as --estimator {record.estimator['file']}"
        )
    for sampled in _replayed_samples(record, scenario, progress):
        state = logged.get(sampled.published.t_ns)
        if state is None:
            continue
        compared += 1
        first = _difference(sampled, state)
        if first is not None:
            break
    if first is None and compared < len(logged):
        raise WorkbenchError(
            f"{record.path}: only {compared} of its {len(logged)} states come at the same times "
            f"again: it was flown at other rates than its scenario says"
        )
    return ReplayResult(compared, record.duration, first, _changes_since_log(record, law))


def replay_scenario(
    record: LogRecord, controller: str, folder: Path, estimator: str = ""
) -> Scenario:
    """Return the scenario that replays a log; its script has all actions.

    Args:
        record: the log.
        controller: see `replay`.
        folder: an empty folder, for the texts of laws.
        estimator: see `replay`.

    Raises:
        WorkbenchError: if a controller or an estimator that is not shipped is named only in the
            log.
    """
    scenario = record.scenario()
    actions = [done.action for done in record.done]
    for action in (*scenario.script, *actions):
        named = action.controller
        if named is not None and named not in record.laws and not is_shipped(named):
            raise WorkbenchError(
                f"{record.path}: {named} takes over, but the log does not have its text: it is "
                "damaged, or was made by hand"
            )
    others = [name for name, text in record.laws.items() if text != record.law]
    given, _ = split_label(controller)
    files = {name: with_label(given, split_label(name)[1]) for name in record.laws}
    if controller and Path(controller).suffix != ".py" and _same_file(controller, record.path):
        controller, files = _written_laws(record, folder)
    elif others:
        raise WorkbenchError(
            f"{record.path}: Python code that only the log has took over in flight: if you trust "
            f"it, name the log itself, as --controller {record.path}"
        )
    elif controller and controller == given:  # scheduled as before
        controller = with_label(given, split_label(record.controller.get("name", ""))[1])
    actions = [
        dataclasses.replace(action, controller=files.get(action.controller, action.controller))
        if action.controller is not None
        else action
        for action in actions
    ]
    if not controller and not is_shipped(scenario.controller):
        raise WorkbenchError(
            f"{record.path}: was flown by {scenario.controller}, Python code that would run here: "
            f"if you trust it, name it yourself, as --controller {scenario.controller}"
        )
    scenario.controller = controller or scenario.controller
    scenario.estimator = estimator or logged_estimator(record)
    # the gain file may have changed since: the log has all values
    vehicle = dataclasses.replace(scenario.vehicle, gains="")
    return repeat_scenario(
        dataclasses.replace(scenario, vehicle=vehicle), {}, actions, record.duration
    )


def logged_estimator(record: LogRecord) -> str:
    """Return the estimator used in the flight of a log.

    Raises:
        WorkbenchError: if it is Python code that only the log names.
    """
    name = record.scenario().estimator
    if name in ESTIMATORS:
        return name
    raise WorkbenchError(
        f"{record.path}: was flown on {name}, Python code that would run here: if you trust it, "
        f"name it yourself, as --estimator {name}"
    )


def _same_file(one: str, other: Path) -> bool:
    named = existing_path(one)
    return named is not None and named.samefile(other)


def _written_laws(record: LogRecord, folder: Path) -> tuple[str, dict[str, str]]:
    """Write the texts in a log; return the file of the first, and those of the others by name."""

    def written(name: str, text: str) -> str:
        file, label = split_label(name)
        path = folder / Path(file).parent.name / Path(file).name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return with_label(str(path), label)

    first = record.controller["name"]
    if not is_shipped(first):
        whose, label = split_label(first)
        first = written(with_label(f"first/{whose}.py", label), record.law)
    own = record.controller["sha256"][:12]
    return first, {
        name: first if Path(split_label(name)[0]).parent.name == own else written(name, text)
        for name, text in record.laws.items()
    }


def _replayed_samples(
    record: LogRecord, scenario: Scenario, progress: Callable[[float], None] | None
) -> Iterator[Sampled]:
    """Yield the published topics during the flight."""
    session = Session(scenario, record.values, bridge=Bridge())
    # the last state may be of a sensor's sample, between two control updates
    period = session.scenario.rates.control_period
    steps = max(1, math.ceil(record.duration / period - 1e-6))
    each = max(1, round(COMPARISON_PERIOD_S / period))
    for begin in range(0, steps, each):
        session.tick(min(each, steps - begin) * period)
        yield from session.drain()
        if progress:
            progress(min(1.0, (begin + each) / steps))


def _difference(sampled: Sampled, state: np.ndarray) -> StateDifference | None:
    """Return the difference of a state from that of the log, None if they are equal to the bit."""
    flown = np.array(sampled.state)
    if flown.tobytes() == np.ascontiguousarray(state).tobytes():
        return None
    away = np.abs(flown - state)
    index = int(np.argmax(np.where(np.isnan(away), np.inf, away)))
    part = [name for name, begin in STATE_PART_STARTS.items() if begin <= index][-1]
    return StateDifference(sampled.published.t_ns * 1e-9, part, float(away[index]))


def _changes_since_log(record: LogRecord, law: Controller) -> tuple[str, ...]:
    """Return what has changed, in words: the text of the controller, and versions."""
    now, whose = software_versions(), record.controller
    found = []
    if whose and whose["sha256"] != law.digest:
        found.append(
            f"controller {law.name} with SHA-256 {law.digest[:12]}..., was {whose['name']} with "
            f"{whose['sha256'][:12]}..."
        )
    own, was = law.estimator, record.estimator
    if was and (own is None or own.digest != was["sha256"]):
        flown = f"{own.name} with SHA-256 {own.digest[:12]}..." if own else "a shipped one"
        found.append(f"estimator {flown}, was {was['name']} with {was['sha256'][:12]}...")
    found += (
        f"{name} {now.get(name, 'unknown')}, was {was}"
        for name, was in {"physics": "1", **record.versions}.items()
        if now.get(name) != was
    )
    return tuple(found)
