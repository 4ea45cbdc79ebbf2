"""An analyst's process: `python -m workbench.analysis.worker FD`, a socket to the caller.

It ends when its caller's end of the socket does, whatever it is doing.
"""

import importlib
import logging
import os
import sys
from multiprocessing.connection import Connection

from workbench.analysis.messages import Begin, Preparing
from workbench.analysis.questions import (
    DrawMap,
    FindRanges,
    Fork,
    Judge,
    JudgePlantInput,
    Pin,
    Predict,
    Tune,
    Weigh,
)
from workbench.analysis.request_queue import RequestQueue
from workbench.analysis.scheduler import Answerer, Scheduler
from workbench.analysis.subject import Subject
from workbench.common.cache import PROGRESS_LOGGER
from workbench.ipc.send_queue import LogPoster, SendQueue

ANSWERERS = {
    Judge: "judging:judge",
    JudgePlantInput: "judging:judge_plant_input",
    FindRanges: "ranges:find_ranges",
    Predict: "predicting:predict",
    DrawMap: "mapping:draw_map",
    Weigh: "weighing:weigh",
    Tune: "tuning:tune",
    Fork: "forking:fork",
    Pin: "pinning:pin",
}
"""File and function that answer a kind of question; loaded when it is first asked."""


def main(connection: Connection) -> int:
    """Answer what is asked about the first message's vehicle, and return the exit code."""
    try:
        begin = connection.recv()
    except (EOFError, OSError):
        return 0
    if not isinstance(begin, Begin):
        return 1
    os.nice(begin.niceness)
    send_queue = SendQueue(connection)
    logging.getLogger(PROGRESS_LOGGER).addHandler(LogPoster(send_queue, Preparing))
    requests = RequestQueue(connection, send_queue)
    subject = Subject(begin.scenario, begin.settings)
    Scheduler(subject, requests, send_queue, find_answerer).run()
    return 0


def find_answerer(kind: type) -> Answerer:
    """Return who answers a kind of question."""
    file, name = ANSWERERS[kind].split(":")
    found: Answerer = getattr(importlib.import_module(f"workbench.analysis.{file}"), name)
    return found


if __name__ == "__main__":
    os._exit(main(Connection(int(sys.argv[1]))))
