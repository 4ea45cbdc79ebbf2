"""A flight of a scenario, as fast as it goes, with a log."""

from collections.abc import Callable, Mapping
from pathlib import Path

from workbench.logs.flight_log import FlightLog
from workbench.scenario.scenario import Scenario
from workbench.session.session import Session
from workbench.systems.bridge import Bridge


class LoggedFlight:
    """Flies a scenario and logs it.

    Args:
        path: of the log.
        scenario: what to fly.
        settings: parameter values that override those of the scenario's gains.

    Attributes:
        session: that is flown.

    Raises:
        WorkbenchError: if the scenario cannot be built, or the log cannot be written.
    """

    def __init__(self, path: Path, scenario: Scenario, settings: Mapping[str, float]) -> None:
        self.session = Session(scenario, settings, bridge=Bridge())
        self._log = FlightLog(
            path,
            self.session.topics,
            scenario,
            settings,
            self.session.parameters(),
            self.session.vehicle.name,
            self.session.controller,
        )

    @property
    def said(self) -> str:
        """Why the log is not whole, "" else."""
        return self._log.said

    def run(self, progress: Callable[[float], None]) -> None:
        """Fly to the end of the scenario, calling `progress` with the flown share, 0 .. 1.

        Raises:
            FlightBrokenError: if the simulation cannot go on; the log ends there.
        """

        def keep(share: float) -> None:
            self._drain()
            progress(share)

        try:
            self.session.run(keep)
        finally:
            self._drain()
            self._log.close()

    def _drain(self) -> None:
        for sampled in self.session.drain():
            self._log.write(sampled)
        self._log.look()
