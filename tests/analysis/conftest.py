"""A vehicle to judge, and somebody who answers in this process."""

from collections.abc import Callable
from typing import Any

import pytest

from workbench.analysis.queries import Query
from workbench.analysis.replies import Searched
from workbench.analysis.subject import AnalysedVehicle
from workbench.analysis.work import Work
from workbench.analysis.worker import find_answerer
from workbench.scenario.scenario import Scenario


class Caller:
    """A request queue and a send queue in one, with nobody at the other end.

    Attributes:
        stopped: number up to which questions are stopped.
        heard: what was told.
    """

    def __init__(self) -> None:
        self.stopped = 0
        self.heard: list[Any] = []

    def on_stop(self, number: int, act: Callable[[], None]) -> None:
        self.act = act

    def show(self, searched: Searched) -> None:
        self.heard.append(searched)


@pytest.fixture(scope="session")
def subject() -> AnalysedVehicle:
    """The shipped drone."""
    return AnalysedVehicle(Scenario(), {})


@pytest.fixture
def caller() -> Caller:
    return Caller()


@pytest.fixture
def work(caller) -> Work:
    return Work(1, caller, caller)


@pytest.fixture
def answer(subject, work):
    """What answers a question about the shipped drone, or about another subject."""

    def answered(question: Query, about: AnalysedVehicle = subject) -> Any:
        *rests, reply = find_answerer(type(question))(about, question, work)
        assert set(rests) <= {None}
        return reply

    return answered
