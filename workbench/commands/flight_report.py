"""Print the outcome of a flight."""

import argparse
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.commands.estimate import print_estimate
from workbench.commands.printing import (
    autopilot_json,
    lost_replies,
    print_message,
    print_result,
    print_table,
)

if TYPE_CHECKING:
    from workbench.design.flight_summary import FlightSummary
    from workbench.plant.worlds.world import World
    from workbench.session.recording import Recording
    from workbench.session.snapshot import SensorStatus
    from workbench.systems.sensors.samples import RecordedSamples


@dataclass(frozen=True)
class FlightOutcome:
    """A flight with its world and sensors, and why it or its log broke off.

    It also has the statistics of the exchange with a program that ran the law, why that ended in
    flight, and its recording.
    """

    recording: "Recording"
    world: "World"
    sensors: "tuple[SensorStatus, ...]" = ()
    samples: "tuple[RecordedSamples, ...]" = ()
    broken: str = ""
    log_said: str = ""
    exchange: "Mapping[str, float]" = field(default_factory=dict)
    ended: str = ""
    records: "Mapping[str, bytes]" = field(default_factory=dict)


def report_flight(
    args: argparse.Namespace, title: str, flight: FlightOutcome, files: list[Path]
) -> None:
    """Print the summary, and the table of sensors."""
    import dataclasses

    from workbench.control.mode import Reason
    from workbench.design.flight_summary import summarise

    summary = summarise(flight.recording)
    estimate = None
    if flight.recording.estimated:  # its judgement loads scipy
        from workbench.design.estimation_errors import judge_estimate

        estimate = judge_estimate(flight.recording)
    if summary.turned_over is not None:
        print_message(f"the drone turned over at {summary.turned_over:.1f} s")
    for failsafe in summary.failsafes:
        if failsafe.reason != Reason.AUTOPILOT_ENDED.label:  # which is reported with its cause
            print_message(failsafe.said)

    def show() -> None:
        print(title)
        lines = _lines(summary)
        if flight.exchange:
            lines.append(("lost replies", *lost_replies(flight.exchange)))
        print_table(lines, left=(0, 2))
        if flight.sensors:
            print()
            print_table(_sensor_lines(flight.sensors), left=(0, 1))
        if estimate:
            print()
            print_estimate(estimate)

    result = {"title": title, **dataclasses.asdict(summary), "sensors": flight.sensors}
    result |= {"estimate": estimate, "files": files}
    print_result(args, result | autopilot_json(flight.exchange, flight.ended), show)


def _lines(summary: "FlightSummary") -> list[tuple[str, str, str]]:
    """Return the summary's rows."""
    lines = [
        ("duration", f"{summary.duration:.2f}", "s"),
        ("distance", f"{summary.distance:.2f}", "m"),
        ("max speed", f"{summary.max_speed:.2f}", "m/s"),
        ("max height", f"{summary.max_height:.2f}", "m"),
        ("lowest height", f"{summary.min_height:.2f}", "m"),
        ("end", " ".join(f"{number:z.2f}" for number in summary.end), "m"),
        ("max tilt", f"{math.degrees(summary.max_tilt):.1f}", "deg"),
        ("max yaw rate", f"{math.degrees(summary.max_yaw_rate):.1f}", "deg/s"),
        ("max rotor use", f"{100.0 * summary.max_rotor_use:.1f}", "% of the speed limit"),
        ("final mode", summary.final_mode, ""),
    ]
    if not math.isnan(summary.battery_used):
        lines.append(("battery used", f"{100.0 * summary.battery_used:.1f}", "%"))
    if summary.least_clearance is not None:
        lines.append(("least clearance", f"{summary.least_clearance:.2f}", "m from obstacles"))
    if summary.slack_time is not None:
        lines.append(("slack cable", f"{summary.slack_time:.2f}", "s"))
    if summary.touch_down_speed is not None:
        lines.append(("touch-down speed", f"{summary.touch_down_speed:.2f}", "m/s"))
    return lines


def _sensor_lines(sensors: "tuple[SensorStatus, ...]") -> list[tuple[str, ...]]:
    """Return the table of sensors with its heading."""
    rows = [
        (
            sensor.name,
            sensor.kind.replace("_", " "),
            f"{sensor.asked_rate:g}",
            f"{sensor.rate:.2f}",
            f"{1000.0 * sensor.age:.0f}" if math.isfinite(sensor.age) else "-",
        )
        for sensor in sensors
    ]
    return [("sensor", "kind", "asked Hz", "delivered Hz", "age ms"), *rows]
