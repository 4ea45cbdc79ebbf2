"""Compiles a law to machine code in a separate process, while the law flies interpreted."""

import threading
from queue import Empty, SimpleQueue
from typing import Any

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller, unpickled
from workbench.ipc.limited import run_limited, serve
from workbench.systems.flight_computer import FlightComputer

LONGEST, MOST_MEMORY = 300.0, 16_000
"""Limits of the compilation [s, MB]."""


class LawCompiler:
    """Compiles one law at a time, in the background.

    During a compilation only the newest requested law waits; earlier ones are forgotten.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._making: Controller | None = None
        self._waiting: Controller | None = None
        self._failed: list[Controller] = []
        self._ends: SimpleQueue[tuple[Controller, str]] = SimpleQueue()

    def begin(self, law: Controller) -> bool:
        """Compile a law, unless its compilation is in progress or has failed before.

        Returns:
            Whether it is started, at once or after the present compilation.
        """
        with self._lock:
            if law in (self._making, self._waiting, *self._failed):
                return False
            if self._making is not None:
                self._waiting = law
                return True
            self._making = law
        threading.Thread(target=self._run, daemon=True).start()
        return True

    def made(self) -> tuple[Controller, str] | None:
        """Return a law whose machine code is ready, or why a compilation failed, else ""."""
        try:
            return self._ends.get_nowait()
        except Empty:
            return None

    def _run(self) -> None:
        while (law := self._making) is not None:
            failure = ""
            request = {"name": law.name, "file": str(law.file), "text": law.text}
            try:
                run_limited(__name__, request, seconds=LONGEST, megabytes=MOST_MEMORY)
            except WorkbenchError as error:
                failure = str(error)
            with self._lock:
                if failure:
                    self._failed.append(law)
                self._making, self._waiting = self._waiting, None
            self._ends.put((law, failure))


def make(request: dict[str, Any]) -> None:
    """Compile a controller's text by flying one update."""
    from pydrake.systems.analysis import Simulator

    from workbench.common.resources import find_model
    from workbench.control.guidance import Guidance, Reference
    from workbench.plant.loading import load_vehicle
    from workbench.scenario.parameters import parameter_table

    law = unpickled(request["name"], request["file"], request["text"])
    computer = FlightComputer(
        controller=law,
        vehicle=load_vehicle(find_model("dh_drone")),
        gains=parameter_table(law).defaults(),
        period=1 / 128,
    )
    simulator = Simulator(computer)
    context = simulator.get_mutable_context()
    for name, values in (
        ("state", [1.0, *[0.0] * 12]),
        ("reference", [0.0] * len(Reference._fields)),
        ("guidance", [0.0] * len(Guidance._fields)),
    ):
        computer.GetInputPort(name).FixValue(context, values)
    simulator.AdvanceTo(1 / 64)


if __name__ == "__main__":
    serve(make)
