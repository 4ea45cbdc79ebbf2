"""Answers what the benchmarks ask another simulator, line by line, in its own environment.

A line of JSON on standard input names a task and its arguments. A line of JSON is the answer; it
goes to the file that the first argument numbers, as simulators print to the usual ones.
"""

import json
import os
import sys
from collections.abc import Callable, Mapping


def serve(tasks: Mapping[str, Callable[..., dict[str, float]]]) -> None:
    """Answer until the input ends."""
    with os.fdopen(int(sys.argv[1]), "w", encoding="utf-8") as answers:
        for line in sys.stdin:
            request = json.loads(line)
            answer = tasks[request.pop("task")](**request)
            print(json.dumps(answer), file=answers, flush=True)
