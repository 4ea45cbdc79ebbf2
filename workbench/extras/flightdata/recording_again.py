"""Fly a recording of the workbench again with other gains: its scenario, with all that was done."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from workbench.analysis.subject import AnalysedVehicle
from workbench.analysis.work import Work, Working
from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.common.series import interpolated_on_grid
from workbench.control.controller import LIMITS_GROUP, Controller
from workbench.design.lost import find_loss
from workbench.extras.flightdata.flying_again_question import FlownAgain, FlyAgain
from workbench.extras.flightdata.predict.motion import POSITION_VELOCITY_ROWS
from workbench.logs.logged_signal import SETPOINT_SIGNALS
from workbench.logs.record import WORKBENCH_LOG_FORMAT, LogRecord
from workbench.logs.replay import replay_scenario
from workbench.scenario.flown_controller import flown_controller
from workbench.scenario.scenario import Action, Scenario
from workbench.session.recording import Recording
from workbench.session.session import Session

SLICE_S = 0.5
"""Time flown between two checks for more urgent work [s]."""
RECORD_PERIODS = 2
"""Control periods between two samples of the repeated flight."""


def is_repeated(flight: Flight) -> bool:
    """Return whether a log is a recording of the workbench that is flown again as a scenario.

    One with points to go to alone has a setpoint of the position, as logs of others have, and is
    flown again like them, with a band.
    """
    return flight.format == WORKBENCH_LOG_FORMAT and not flight.has(SETPOINT_SIGNALS)


def fly_recording_again(
    subject: AnalysedVehicle, question: FlyAgain, record: LogRecord, work: Work
) -> Working:
    """Fly a recording again with other gains, or with another law, and answer with a `FlownAgain`.

    The vehicle, the world and the air are those of the recording, so only the gains differ, and
    there is no band. With the gains that flew, the flight is equal to the bit.

    Raises:
        WorkbenchError: if the recording cannot be read, or cannot be flown here.
    """
    if not len(record.states):
        raise WorkbenchError(f"{question.log.name} has no states, so it cannot be flown again")
    with TemporaryDirectory() as folder:
        own = subject.flown.reference
        given = own if Path(own).is_file() and record.controller.get("name") == own else ""
        logged = replay_scenario(record, given, Path(folder))
        law = flown_controller(logged)
        scenario, values, doubt = _with_other_gains(subject, question, record, logged, law)
        session = Session(scenario, values)
        while session.time < record.duration - 1e-9:
            session.tick(min(SLICE_S, record.duration - session.time))
            work.check()
            yield None
        yield _compared(record, law, session.recording(), doubt)


def _with_other_gains(
    subject: AnalysedVehicle,
    question: FlyAgain,
    record: LogRecord,
    logged: Scenario,
    law: Controller,
) -> tuple[Scenario, dict[str, float], str]:
    """Return the scenario with other gains, the values at its start, and a doubt as a sentence."""
    other = subject.other(question.controller) if question.controller else subject
    reference, flown = other.flown.reference, other.flown
    gains = {name: other.own[name] for name in other.law if name in other.own}
    if flown.name == law.name:
        gains |= _flown_gains(record.values, law)
    gains |= {} if question.controller else question.gains
    own = {row.name for row in (*law.parameters, *flown.parameters)}
    limits = {row.name for row in flown.parameters if row.group == LIMITS_GROUP}
    script, changes = [], 0
    for action in logged.script:
        kept = {name: value for name, value in action.set.items() if name not in own}
        changes += (len(kept) != len(action.set) and action.at > 0.0) or bool(action.controller)
        script.append(replace(action, set=kept, controller=None))
    rates = replace(logged.rates, record_period=RECORD_PERIODS * logged.rates.control_period)
    scenario = replace(logged, controller=reference, script=_without_nothing(script), rates=rates)
    known = {row.name for row in flown.table}
    values = {name: value for name, value in record.values.items() if name in known - own}
    values |= {name: value for name, value in gains.items() if name in known}
    values |= {name: record.values[name] for name in limits if name in record.values}
    doubt = (
        f"{changes} changes of gains or of the controller in the recording are left out"
        if changes
        else ""
    )
    return scenario, values, doubt


def _without_nothing(script: list[Action]) -> list[Action]:
    """Return the actions of a script that still do something."""
    return [action for action in script if action != Action(action.at, height=action.height)]


def _compared(record: LogRecord, law: Controller, flown: Recording, doubt: str) -> FlownAgain:
    """Return the recording beside the other flight."""
    logged_time = np.array(record.state_ns, dtype=float) * 1e-9
    inside = (flown.time >= logged_time[0]) & (flown.time <= logged_time[-1])
    time = flown.time[inside]
    logged = interpolated_on_grid(logged_time, record.states[:, POSITION_VELOCITY_ROWS], time)
    other = np.hstack([flown.p_WB, flown.v_WB])[inside]
    loss = find_loss(flown)
    if loss:
        other[time >= loss.time] = np.nan
    apart = other - logged
    nothing = np.full((len(time), 3), np.nan)
    return FlownAgain(
        vehicle=record.vehicle,
        logged_vehicle=record.vehicle,
        doubt=doubt,
        flown=law.name,
        flown_gains=_flown_gains(record.values, law),
        time=time,
        setpoint=nothing,
        logged=logged,
        other=other,
        low=other,
        high=other,
        off_setpoint=np.full((2, 3), np.nan),
        difference=np.sqrt(np.nanmean(apart**2, axis=0)),
        band=np.zeros(6),
        stays=loss is None,
        lost=int(loss is not None),
        drawn=1,
        has_band=False,
    )


def _flown_gains(values: Mapping[str, float], law: Controller) -> dict[str, float]:
    return {row.name: values.get(row.name, row.default) for row in law.parameters}
