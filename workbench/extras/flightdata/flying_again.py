"""Answer the question how a logged flight would have gone, in the analyst's process."""

import logging
from itertools import islice

import numpy as np

from workbench.analysis.subject import AnalysedVehicle
from workbench.analysis.work import Work, Working
from workbench.common.cache import PROGRESS_LOGGER
from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.control.schedule import split_label
from workbench.extras.flightdata.flying_again_question import FlownAgain, FlyAgain
from workbench.extras.flightdata.predict.logged import flown_law, flown_law_name, motion_of
from workbench.extras.flightdata.predict.motion import POSITION_VELOCITY_ROWS
from workbench.extras.flightdata.predict.what_if import Explained, Law, WhatIf
from workbench.extras.flightdata.recording_again import (
    fly_recording_again,
    is_repeated,
)
from workbench.logs.flight_reader import read_flight
from workbench.logs.record import LogRecord, read_log

REPLAY_SAMPLE_TIME_S = 0.01
"""Sample time of a log that is flown again [s]; at least one control period."""
KEPT_FLIGHT = "flown again"
"""Key of the last log that was flown again: its key, the flight, and its explanation."""


def fly_again(subject: AnalysedVehicle, question: FlyAgain, work: Work) -> Working:
    """Fly a logged flight again with other gains, or with another law.

    The part of the log that the vehicles cannot explain is kept, so that the next gains take one
    flight per vehicle. A recording of the workbench is flown again as its scenario.
    """
    flight, explained = _read_log(subject, question)
    if isinstance(explained, LogRecord):
        yield from fly_recording_again(subject, question, explained, work)
        return
    flights: list[np.ndarray] = []
    for states in islice(explained.flights(_other_law(subject, question)), 1 + question.draws):
        flights.append(states)
        yield None
    yield _flown_again(flight, explained, explained.compare(flights))


def _read_log(subject: AnalysedVehicle, question: FlyAgain) -> tuple[Flight, Explained | LogRecord]:
    """Return a log and the part that the vehicle cannot explain; cached while the file is the same.

    A recording that is flown again as its scenario needs no explanation, but its record.

    Raises:
        WorkbenchError: if it cannot be read or flown again.
    """
    path = question.log
    try:
        status = path.stat()
    except OSError as error:
        raise WorkbenchError(f"{path} cannot be read: {error.strerror}") from error
    key = (path, status.st_mtime_ns, status.st_size, question.flown)
    if KEPT_FLIGHT in subject.kept and subject.kept[KEPT_FLIGHT][0] == key:
        return subject.kept[KEPT_FLIGHT][1:]
    logging.getLogger(PROGRESS_LOGGER).warning(f"reading {path.name}")
    flight, vehicle = read_flight(path), subject.study.vehicle
    if is_repeated(flight):
        record = read_log(path)
        subject.kept[KEPT_FLIGHT] = key, flight, record
        return flight, record
    name = question.flown or flown_law_name(flight, {subject.flown.name: subject.flown.reference})
    if not name:
        raise WorkbenchError(f"{path.name} does not say which controller flew: choose it")
    values = {}
    if split_label(name)[0] == split_label(subject.flown.reference)[0]:
        values = {each: subject.own[each] for each in subject.law}
    law = flown_law(flight, vehicle, name, values)
    explained = Explained(motion_of(flight, vehicle), vehicle, law)
    subject.kept[KEPT_FLIGHT] = key, flight, explained
    return flight, explained


def _other_law(subject: AnalysedVehicle, question: FlyAgain) -> Law:
    if question.controller:
        other = subject.other(question.controller)
        return Law(other.flown, other.own)
    return Law(subject.flown, subject.flown_gains(question.gains))


def _flown_again(flight: Flight, explained: Explained, found: WhatIf) -> FlownAgain:
    law, other = explained.flown, found.other[:, POSITION_VELOCITY_ROWS]
    period = float(found.time[1] - found.time[0])
    kept = slice(None, None, max(1, round(REPLAY_SAMPLE_TIME_S / period)))
    return FlownAgain(
        vehicle=explained.vehicle.name,
        logged_vehicle=str(flight.parameters.get("vehicle", "")),
        doubt="; ".join(filter(None, (explained.doubt, found.doubt))),
        flown=law.controller.name,
        flown_gains={row.name: law.gains[row.name] for row in law.controller.parameters},
        time=found.time[kept],
        setpoint=found.setpoint[kept],
        logged=found.logged[kept][:, POSITION_VELOCITY_ROWS],
        other=other[kept],
        low=found.low[kept],
        high=found.high[kept],
        off_setpoint=found.off_setpoint,
        difference=np.sqrt(np.mean(found.difference**2, axis=0)),
        band=0.5 * np.nanmean(found.high - found.low, axis=0),
        stays=found.stays == len(found.time),
        lost=found.lost,
        grounded=found.grounded,
        drawn=found.drawn,
    )
