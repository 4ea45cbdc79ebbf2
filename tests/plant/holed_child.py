"""The child that expands xacro files, with a hole: Python evaluates expressions, with all names."""

import builtins
from collections.abc import Mapping
from typing import Any

from workbench.ipc.limited import serve_one_request
from workbench.plant.formats import xacro_child


def evaluate(text: str, symbols: Mapping[str, Any], _: object = None) -> Any:
    return eval(text, vars(builtins) | {"__builtins__": builtins})


if __name__ == "__main__":
    vars(xacro_child)["evaluate"] = evaluate
    serve_one_request(xacro_child.expand)
