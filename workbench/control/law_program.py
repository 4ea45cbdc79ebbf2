"""A law that is a separate program."""

from collections.abc import Mapping
from typing import Protocol

from workbench.common.errors import WorkbenchError
from workbench.control.guidance import (
    Gains,
    KnownBody,
    LawResult,
    LawSetpoint,
    MeasuredMotion,
    Memory,
)
from workbench.control.loop_points import Probes


class LawProgram(Protocol):
    """A law that a separate program runs, for one flight."""

    def update(
        self,
        measured: MeasuredMotion,
        setpoint: LawSetpoint,
        g: Gains,
        vehicle: KnownBody,
        memory: Memory,
        dt: float,
        loops: Probes,
    ) -> LawResult:
        """Return what a law's `update` does.

        Raises:
            FlightBrokenError: if the program has ended, or does not answer: the rotors stop, and
                the flight goes on.
        """

    def report(self) -> Mapping[str, float]:
        """Return statistics of the exchange by name: `packets` sent, `lost` ones, and others."""

    def records(self) -> Mapping[str, bytes]:
        """Return its recordings of the flight: files, by the ending of their name."""

    def close(self) -> None:
        """End the program, and remove its files."""


def not_repeatable_error(name: str) -> WorkbenchError:
    """Return why a law that is a program cannot be used where flights must be repeatable."""
    return WorkbenchError(
        f"{name} runs in a separate process, has no linear model, and flies only in `fly`, `step`, "
        "`check`, `serve` and the app, from the beginning of a flight: its flights are not "
        "bit-for-bit repeatable, so it cannot be compiled, forked, replayed, swept, tuned or pinned"
    )
