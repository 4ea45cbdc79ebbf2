"""Makes a law's machine code in a process of its own, while the law flies interpreted."""

import threading
from queue import Empty, SimpleQueue
from typing import Any

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller, unpickled
from workbench.ipc.limited import run_limited, serve
from workbench.systems.flight_computer import FlightComputer

LONGEST, MOST_MEMORY = 300.0, 16_000
"""Of making machine code [s, MB]."""


class LawCompiler:
    """Makes machine code of one law at a time, in the background.

    While one is made, the law that was wanted last waits; those before it are forgotten.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._making: Controller | None = None
        self._waiting: Controller | None = None
        self._failed: list[Controller] = []
        self._ends: SimpleQueue[tuple[Controller, str]] = SimpleQueue()

    def begin(self, law: Controller) -> bool:
        """Make machine code of a law, unless that is under way already, or has failed before.

        Returns:
            Whether it is begun, at once or after the one that is being made.
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
        """Return a law of which there is machine code now, or why there is none, else ""."""
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
    """Make the machine code of a controller's text, by flying one update."""
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
