"""The scenario that was set up by hand last, kept for the next start."""

import threading
from concurrent.futures import Future
from pathlib import Path

from PyQt6.QtCore import QSettings

from workbench.errors import WorkbenchError
from workbench.scenario import Scenario, save_scenario

NAME = "last-flight.yaml"


def last_setup(store: QSettings) -> Path:
    """Return where it is kept: beside the preferences."""
    return Path(store.fileName()).parent / NAME


def keep_setup(store: QSettings, scenario: Scenario) -> "Future[Path]":
    """Write it in the background; the answer is its path."""
    path, answer = last_setup(store), Future[Path]()

    def write() -> None:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            save_scenario(scenario, path)
            answer.set_result(path)
        except OSError as error:
            answer.set_exception(WorkbenchError(f"{path}: cannot be written: {error.strerror}"))
        except WorkbenchError as error:
            answer.set_exception(error)

    threading.Thread(target=write, name="keeping a set-up").start()
    return answer
