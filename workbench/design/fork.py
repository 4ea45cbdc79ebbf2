"""Fork a flight: continue it from a checkpoint with each of several gains or controllers."""

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.control.controller import Controller
from workbench.control.controller_file import load_controller
from workbench.design.branches import Branch, FlownBranch
from workbench.design.lost import find_loss
from workbench.scenario.axes import AXIS_NAMES
from workbench.scenario.scenario import Action, Scenario
from workbench.scenario.sensors_config import SensorsConfig
from workbench.session.checkpoint import Checkpoint
from workbench.session.session import Session

MAX_BRANCH_DURATION_S = 120.0
"""Limit of the duration of a branch [s]."""
FORK_SLICE_S = 0.25
"""Flown between two checks whether to stop [s]."""


class SetpointStep(Protocol):
    """A step added to the setpoint."""

    @property
    def axis(self) -> str:
        """One of x, y, z in W, or yaw."""

    @property
    def amplitude(self) -> float:
        """In m/s or rad/s."""


class Forker:
    """Flies forks of one scenario's flights, and keeps what it has built for the next one.

    A fork has the vehicle, world, rates and script of the flight. It has no sensors, as no law
    reads them. A branch without its own gains or controller equals the flight to the bit.

    Args:
        scenario: the scenario of the flights to fork.
    """

    def __init__(self, scenario: Scenario) -> None:
        unseen = SensorsConfig(seed=scenario.sensors.seed)
        self._scenario = dataclasses.replace(scenario, sensors=unseen)
        self._actions = sorted(scenario.script, key=lambda action: action.at)
        self._sessions: dict[str, tuple[Controller, Session]] = {}
        self._acted = 0

    def fly(
        self,
        checkpoint: Checkpoint,
        branches: Sequence[Branch],
        duration: float,
        step: SetpointStep | None = None,
        stop: Callable[[], bool] | None = None,
    ) -> tuple[FlownBranch, ...]:
        """Fly every branch from a checkpoint on.

        Args:
            checkpoint: of a flight of the scenario.
            branches: to be flown.
            duration: of each [s].
            step: commanded at once, added to the setpoint; None for no step.
            stop: called for every quarter of a second flown; when it returns true, the complete
                branches are returned.

        Raises:
            WorkbenchError: if a controller cannot be read or built, or a gain is unknown or out of
                range, before anything is flown, if the checkpoint is of another flight, or if the
                scenario cannot be built.
        """
        if not 0.0 < duration <= MAX_BRANCH_DURATION_S:
            raise WorkbenchError(
                f"cannot fork a flight for {duration:g} s: give it up to "
                f"{MAX_BRANCH_DURATION_S:g} s"
            )
        self._build(checkpoint.acted)
        laws = [self._law(branch, checkpoint) for branch in branches]
        values = [
            law.table.checked(branch.gains) for branch, law in zip(branches, laws, strict=True)
        ]
        flown = []
        for branch, law, gains in zip(branches, laws, values, strict=True):
            _, session = self._sessions[law.digest]
            if session.controller is not law:  # the script has let another one take over
                session.reset()
            _restore_branch(session, checkpoint, gains, step)
            lost = _fly_on(session, duration, stop or _never_stopped)
            if lost is None:
                break
            flown.append(_flown_branch(session, branch.name, lost))
        return tuple(flown)

    def _build(self, acted: int) -> None:
        """Build what continues checkpoints after this number of actions, or after more.

        Those actions are over: only which controllers took over counts. The others may have been
        for one that the scenario, which is that of a flight in progress, no longer names.
        """
        if self._sessions and acted >= self._acted:
            return
        over = [Action(each.at, controller=each.controller) for each in self._actions[:acted]]
        script = [*over, *self._actions[acted:]]
        self._scenario = dataclasses.replace(self._scenario, script=script)
        first = Session(self._scenario)
        self._acted, self._first = acted, first.controller
        self._sessions = {self._first.digest: (self._first, first)}

    def _law(self, branch: Branch, checkpoint: Checkpoint) -> Controller:
        """Return the controller that flies a branch; a new one has a session from now on.

        The one that flew is that of the checkpoint's text, whatever its file has by now.
        """
        name = branch.controller
        if not name and checkpoint.source in self._sessions:
            return self._sessions[checkpoint.source][0]
        name = name or self._scripted(checkpoint)
        law = load_controller(name) if name else self._first
        if law.digest not in self._sessions:
            session = Session(self._scenario)
            session.fly_controller(name)  # without gains and settings that are of another one
            self._sessions[law.digest] = session.controller, session
        return self._sessions[law.digest][0]

    def _scripted(self, checkpoint: Checkpoint) -> str:
        """Return which controller of the script flew at a checkpoint, "" where none did."""
        actions = reversed(self._actions[: checkpoint.acted])
        named = [action.controller for action in actions if action.controller]
        for name in named if checkpoint.source else ():
            if load_controller(name).digest == checkpoint.source:
                return name
        return ""


def _restore_branch(
    session: Session, checkpoint: Checkpoint, gains: Mapping[str, float], step: SetpointStep | None
) -> None:
    """Be where the flight was, with a branch's gains."""
    session.begin_from(checkpoint)
    for name, value in gains.items():
        session.set(name, value)
    if step is None:
        return
    if step.axis not in AXIS_NAMES:
        raise unknown_name("axis", step.axis, AXIS_NAMES)
    asked = [*checkpoint.velocity, checkpoint.yaw_rate]
    asked[AXIS_NAMES.index(step.axis)] += step.amplitude
    session.command(asked[:3], asked[3])


def _fly_on(session: Session, duration: float, stop: Callable[[], bool]) -> str | None:
    """Fly, and return why it broke off, "" if it did not; None where it was to stop."""
    slices = math.ceil(duration / FORK_SLICE_S)
    try:
        for _ in range(slices):
            if stop():
                return None
            session.tick(duration / slices)
    except WorkbenchError as error:  # a script may set what another controller does not have
        return str(error)
    return ""


def _flown_branch(session: Session, name: str, broken: str) -> FlownBranch:
    """Return what was flown until it was lost, if it was."""
    recording = session.recording()
    loss = find_loss(recording)
    kept = recording.time < loss.time if loss else np.full(len(recording.time), True)
    return FlownBranch(
        name=name,
        time=recording.time[kept],
        velocity=recording.v_WB[kept],
        yaw_rate=recording.w_WB[kept, 2],
        position=recording.p_WB[kept],
        tilt=recording.tilt[kept],
        rotor_use=recording.rotor_use[kept],
        lost=loss.sentence if loss else broken,
    )


def fly_fork(
    scenario: Scenario,
    instant: Checkpoint,  # the argument keeps the name that callers may have written
    branches: Sequence[Branch],
    duration: float,
    step: SetpointStep | None = None,
    stop: Callable[[], bool] | None = None,
) -> tuple[FlownBranch, ...]:
    """Fly every branch from a checkpoint on, once; `Forker` is quicker the second time."""
    return Forker(scenario).fly(instant, branches, duration, step, stop)


def _never_stopped() -> bool:
    return False
