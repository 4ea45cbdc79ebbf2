"""When a process that dies again and again is given up."""

from concurrent.futures import Future

import pytest

from workbench.analysis import analyst
from workbench.analysis.analyst import MAX_ANALYST_DEATHS, AnalysisProcess
from workbench.analysis.queries import Judge
from workbench.common.errors import WorkbenchError
from workbench.scenario.scenario import Scenario


class Mortal:
    """A process that dies at its first request, after it has answered it or not."""

    answers = False

    def __init__(self, *_: object) -> None:
        self.answered, self.ended = False, ""

    def send(self, _: object) -> None:
        pass

    def do(self, _: object, answer: "Future[bool]") -> None:
        self.answered, self.ended = self.answers, "it was killed"
        answer.set_result(True)


@pytest.mark.parametrize("answers", [True, False])
def test_only_who_dies_again_and_again_without_an_answer_is_given_up(monkeypatch, answers):
    monkeypatch.setattr(analyst, "WorkerProcess", type("M", (Mortal,), {"answers": answers}))
    process = AnalysisProcess((Scenario(), {}, 0), lambda _: None)
    for _ in range(MAX_ANALYST_DEATHS):
        answer: Future[bool] = Future()
        process.ask(Judge({}), answer)
        assert answer.result(0.0)
    last: Future[bool] = Future()
    process.ask(Judge({}), last)
    assert process.has_given_up is not answers
    if answers:
        assert last.result(0.0)
    else:
        with pytest.raises(WorkbenchError, match="has failed 3 times: it was killed"):
            last.result(0.0)
