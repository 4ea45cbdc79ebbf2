"""Does the drone hold its position whatever happens to the pilot: `python benchmarks/link_hold.py`.

A flight is served in real time. A client in a separate process takes control, starts from neutral
and flies at about 1 m/s. Then it, its connection or the server fails: see `link_faults.FAULTS`.
Every time, HOLD must follow within 0.5 s and one control step of simulated time after the last
command that took effect; if the connection ends, HOLD must come at once. A process that was stopped
continues afterwards, and nothing that it sends may move the drone.
"""

import random
import statistics
import sys
import time
from dataclasses import dataclass

from link_faults import FAULTS, OF_THE_SERVER, harmed, serve

from workbench.link.authority import HOLD_AFTER_S
from workbench.live.flight import LiveFlight
from workbench.scenario.scenario import Rates

FLIGHTS = 100
SPEED = 5.0
"""Simulated seconds in a second, so that it takes minutes."""
LONGEST_DELAY = 0.2
"""Flown before the fault, at random up to this [s of wall]."""
ALLOWED = HOLD_AFTER_S + Rates().control_period


@dataclass(frozen=True)
class HoldRow:
    """How flights with one fault went; times from the last command to HOLD, simulated [s].

    Attributes:
        fault: see `link_faults.FAULTS`.
        flights: number of flights.
        late: flights in which HOLD came later than allowed.
        least: shortest time to HOLD.
        median: median time.
        most: longest time.
        commands: number of commands that took effect.
        revived: number of these after HOLD.
    """

    fault: str
    flights: int
    late: int
    least: float
    median: float
    most: float
    commands: int
    revived: int


@dataclass(frozen=True)
class HoldFigures:
    """All rows, and what was allowed [s]."""

    rows: list[HoldRow]
    allowed: float


def measure(flights: int = FLIGHTS) -> HoldFigures:
    """Return a row for each fault."""
    generator = random.Random(7)
    with LiveFlight() as flight:
        flight.wait()
        flight.set_speed(SPEED)
        rows = [_row(flight, fault, flights, generator) for fault in FAULTS]
    return HoldFigures(rows, ALLOWED)


def _row(flight: LiveFlight, fault: str, flights: int, generator: random.Random) -> HoldRow:
    begun = time.monotonic()
    found = []
    address = serve(flight)
    for number in range(flights):
        if number and fault in OF_THE_SERVER:
            address = serve(flight)
        found.append(harmed(flight, address, fault, generator.uniform(0.0, LONGEST_DELAY)))
    if fault not in OF_THE_SERVER:
        flight.stop_serving().result()
    gaps = [each.gap for each in found]
    row = HoldRow(
        fault=fault,
        flights=flights,
        late=sum(gap > ALLOWED + 1e-9 for gap in gaps),
        least=min(gaps),
        median=statistics.median(gaps),
        most=max(gaps),
        commands=sum(each.commands for each in found),
        revived=sum(each.revived for each in found),
    )
    print(f"{row}: {time.monotonic() - begun:.0f} s", file=sys.stderr, flush=True)
    return row


def show(figures: HoldFigures) -> None:
    """Print the table."""
    print(
        f"from the last command to HOLD, in ms of simulated time; "
        f"{1000 * figures.allowed:.1f} are allowed"
    )
    print("fault            flights  late   least  median    most   commands  revived")
    for row in figures.rows:
        least, median, most = (1000 * each for each in (row.least, row.median, row.most))
        print(
            f"{row.fault:16s} {row.flights:7d} {row.late:5d} {least:7.1f} {median:7.1f} "
            f"{most:7.1f} {row.commands:10d} {row.revived:8d}"
        )


if __name__ == "__main__":
    show(measure())
