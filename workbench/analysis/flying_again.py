"""How a logged flight would have gone with other gains, or with another law."""

import logging
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from workbench.analysis.questions import FlyAgain
from workbench.analysis.replies import FlownAgain
from workbench.analysis.subject import Subject
from workbench.analysis.work import Work, Working
from workbench.common.cache import PROGRESS_LOGGER
from workbench.common.errors import WorkbenchError
from workbench.control.schedule import split_label

if TYPE_CHECKING:
    from workbench.design.predict.what_if import Explained, Law, WhatIf
    from workbench.logs.flight_record import FlightRecord

SHOWN = 0.01
"""Between two samples of an answer [s], or one update where they are farther apart."""
PLACES = (4, 5, 6, 10, 11, 12)
"""Of position and velocity in a state."""


def fly_again(subject: Subject, question: FlyAgain, _: Work) -> Working:
    """Answer how a logged flight would have gone with other gains, or with another law.

    What the vehicles cannot explain of the log is kept, so that the next gains take one flight a
    vehicle.
    """
    flight, explained = _read(subject, question)
    flights: list[np.ndarray] = []
    for states in islice(explained.flights(_other(subject, question)), 1 + question.draws):
        flights.append(states)
        yield None
    yield _answer(question, flight, explained, explained.compare(flights))


def _read(subject: Subject, question: FlyAgain) -> "tuple[FlightRecord, Explained]":
    """Return a log and what the vehicle cannot explain of it, as before if the file is the same.

    Raises:
        WorkbenchError: if it cannot be read, or flown again.
    """
    from workbench.design.predict.what_if import Explained
    from workbench.logs.flight_reader import read_flight
    from workbench.logs.motion import flown_law, law_name, motion_of

    path = question.log
    try:
        status = path.stat()
    except OSError as error:
        raise WorkbenchError(f"{path} cannot be read: {error.strerror}") from error
    key = (path, status.st_mtime_ns, status.st_size, question.flown)
    if subject.log is not None and subject.log[0] == key:
        return subject.log[1:]
    logging.getLogger(PROGRESS_LOGGER).warning(f"reading {path.name}")
    flight, vehicle = read_flight(path), subject.study.vehicle
    name = question.flown or law_name(flight, {subject.flown.name: subject.flown.reference})
    if not name:
        raise WorkbenchError(f"{path.name} does not say which controller flew: choose it")
    values = {}
    if split_label(name)[0] == split_label(subject.flown.reference)[0]:
        values = {each: subject.own[each] for each in subject.law}
    law = flown_law(flight, vehicle, name, values)
    explained = Explained(motion_of(flight, vehicle), vehicle, law)
    subject.log = key, flight, explained
    return flight, explained


def _other(subject: Subject, question: FlyAgain) -> "Law":
    from workbench.design.predict.what_if import Law

    if question.controller:
        other = subject.other(question.controller)
        return Law(other.flown, other.own)
    return Law(subject.flown, subject.flown_gains(question.gains))


def _answer(
    question: FlyAgain, flight: "FlightRecord", explained: "Explained", found: "WhatIf"
) -> FlownAgain:
    law, other = explained.flown, found.other[:, PLACES]
    other[found.stays :] = np.nan
    period = float(found.time[1] - found.time[0])
    kept = slice(None, None, max(1, round(SHOWN / period)))
    return FlownAgain(
        asked=question,
        vehicle=explained.vehicle.name,
        logged_vehicle=str(flight.parameters.get("vehicle", "")),
        doubt=explained.doubt,
        flown=law.controller.name,
        flown_gains={row.name: law.gains[row.name] for row in law.controller.parameters},
        time=found.time[kept],
        setpoint=found.setpoint[kept],
        logged=found.logged[kept][:, PLACES],
        other=other[kept],
        low=found.low[kept],
        high=found.high[kept],
        off_setpoint=found.off_setpoint,
        difference=np.sqrt(np.mean(found.difference**2, axis=0)),
        band=0.5 * np.mean(found.high - found.low, axis=0),
        stays=found.stays == len(found.time),
        lost=found.lost,
        drawn=found.drawn,
    )
