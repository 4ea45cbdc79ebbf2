"""`workbench estimate`: run an estimator over a logged flight, and report its errors."""

import argparse
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.commands import ExitCode
from workbench.commands.options import (
    Subcommands,
    add_command,
    add_json_option,
    add_output_options,
    add_repeated,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import print_message, print_result, print_table
from workbench.commands.progress import progress_bar
from workbench.common.errors import WorkbenchError, unknown_name
from workbench.estimation.settings import AIDING_SENSORS, EKF, ESTIMATORS, TRUTH
from workbench.parameters.parameter_table import split_setting

if TYPE_CHECKING:
    from workbench.design.estimation_errors import EstimateOverTruth, EstimateReport, Innovations
    from workbench.estimation.estimators import Estimator
    from workbench.estimation.run import ImuGap
    from workbench.logs.record import LogRecord


_ESTIMATOR_NAMES = [name for name in ESTIMATORS if name != TRUTH]
_DISPLAY_UNITS = {
    "rad": ("deg", math.degrees(1.0)),
    "rad/s": ("deg/s", math.degrees(1.0)),
    "1": ("%", 100.0),
}
"""Displayed unit for a unit, and the factor on its numbers."""


def add_parser(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "estimate",
        "Run an estimator on the sensors of a logged flight, and compare it with the true motion: "
        "errors and innovations, as a table and a picture.",
        "workbench estimate flight.mcap --estimator ekf --set ekf_gps_position=0.3",
        run,
    )
    parser.add_argument("log", type=Path, metavar="LOG", help="log of a flight (.mcap)")
    parser.add_argument(
        "--estimator",
        metavar="NAME|FILE",
        help=f"{', '.join(_ESTIMATOR_NAMES)}, or a .py file of your own, which runs; see "
        f"docs/estimation.md (default: the flight's, or {EKF})",
    )
    add_repeated(
        parser,
        "--set",
        "NAME=VALUE",
        split_setting,
        "setting of the estimator, as ekf_gps_position=0.3; `workbench params` lists them; "
        "may be repeated (default: those that the flight began with)",
    )
    add_output_options(parser)
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Run the estimator, print its errors, write table and picture."""
    from workbench.design.estimation_errors import judge_estimate, over_truth
    from workbench.estimation.estimators import find_estimator
    from workbench.estimation.run import imu_gaps, run_estimator
    from workbench.logs.record import read_log
    from workbench.logs.replay import logged_estimator
    from workbench.logs.sensor_samples import logged_sensors

    with Outputs() as outputs:
        table = outputs.add(args.output / f"{args.log.stem}-estimate.csv")
        picture = outputs.picture(args, f"{args.log.stem}-estimate.png")
        with progress_bar(f"reading {args.log.name}"):
            record = read_log(args.log)
        if record.remark:
            print_message(f"{args.log}: {record.remark}")
        flown_on = args.estimator or logged_estimator(record)
        if not args.estimator and flown_on == TRUTH:
            flown_on = EKF
        estimator = find_estimator(flown_on)
        if estimator is None:
            raise unknown_name("estimator", args.estimator, _ESTIMATOR_NAMES)
        name = estimator.name
        settings = _settings(estimator, record, dict(args.set))
        sensors = logged_sensors(record)
        missing = [kind for kind in AIDING_SENSORS if getattr(sensors.samples, kind) is None]
        silent = imu_gaps(sensors.samples.imu)
        _print_missing_sensors(args.log, missing, silent)
        with progress_bar(f"estimating {args.log.name}") as progress:
            history = run_estimator(
                estimator,
                sensors.samples,
                list(settings.values()),
                sensors.mounting,
                sensors.begin(estimator),
                progress,
            )
        found = over_truth(history, sensors.state_time, sensors.states, sensors.mounting.p_BI)
        report = judge_estimate(found)
        assert report
        _write(found, table)
        title = f"{record.vehicle}: {args.log.name}, {name}"
        if picture:
            from workbench.design.plots import write_png
            from workbench.design.plots_estimate import plot_estimate

            write_png(plot_estimate(found, title), picture)
    begin, end = found.time[0], found.time[-1]
    result = {
        "log": args.log,
        "remark": record.remark,
        "estimator": name,
        "settings": settings,
        "begin": begin,
        "end": end,
        "missing": missing,
        "gaps": [each._asdict() for each in silent],
        "estimate": report,
    }
    said = f"{title}, {begin:.2f} .. {end:.2f} s"
    print_result(args, result, print_estimate, report, said, files=outputs.files)
    return ExitCode.DONE


def _settings(
    estimator: "Estimator", record: "LogRecord", given: dict[str, float]
) -> dict[str, float]:
    """Return the settings of the estimator in order: its own, of the flight, and given ones.

    Raises:
        WorkbenchError: if a given one is unknown to the estimator, or out of its limits.
    """
    from workbench.control.controller_file import load_controller, with_estimator
    from workbench.parameters.parameter_table import flight_table

    own = estimator if estimator.file else None
    table = with_estimator(load_controller(), own).table
    names = estimator.settings._fields
    for name in given:
        if name in names:
            continue
        for other in ESTIMATORS:
            if any(row.name == name for row in flight_table().of(other)):
                raise WorkbenchError(
                    f"{name} is a setting of {other}, but {estimator.name} runs: add `--estimator "
                    f"{other}`, or leave it out"
                )
        raise unknown_name(f"setting of {estimator.name}", name, names)
    values: dict[str, float] = estimator.settings()._asdict()
    values |= {name: value for name, value in record.settings.items() if name in names}
    return values | table.checked(given)


def _print_missing_sensors(log: Path, missing: list[str], silent: "tuple[ImuGap, ...]") -> None:
    """Print the sensors that are missing."""
    if missing:
        *others, last = (kind.replace("_", " ") for kind in missing)
        kinds = f"{', '.join(others)} and {last}" if others else last
        print_message(f"{log}: has no samples of {kinds}: the estimate does not use them")
    if silent:
        longest = max(silent, key=lambda each: each.length)
        times = "once" if len(silent) == 1 else f"{len(silent)} times"
        print_message(
            f"{log}: the IMU is silent {times}, longest for {longest.length:.3f} s from "
            f"{longest.begin:.3f} s on: the gaps are interpolated linearly, which is a guess"
        )


def _write(found: "EstimateOverTruth", path: Path) -> None:
    """Write truth, estimate and standard deviations, with a row for each update."""
    import numpy as np

    from workbench.common.series import Series
    from workbench.logs.table_file import write_columns
    from workbench.session.recording import estimate_columns

    groups = (
        ("q_WB", "wxyz", "1", found.q_WB),
        ("p_W", "xyz", "m", found.p_WB),
        ("v_W", "xyz", "m/s", found.v_WB),
        ("w_W", "xyz", "rad/s", found.w_WB),
    )
    columns: dict[str, np.ndarray] = {"t [s]": found.time}
    for name, axes, unit, values in groups:
        for index, axis in enumerate(axes):
            columns[f"{name}.{axis} [{unit}]"] = values[:, index]
    columns |= estimate_columns(found.estimate, found.deviations)
    for name, unit, values in (
        ("gyro_bias", "rad/s", found.biases[:, 0:3]),
        ("accel_bias", "m/s^2", found.biases[:, 3:6]),
    ):
        for index, axis in enumerate("xyz"):
            columns[f"estimate.{name}.{axis} [{unit}]"] = values[:, index]
    # the names have their units already
    write_columns(
        {name: Series(name, "", found.time, each) for name, each in columns.items()}, path
    )


def print_estimate(report: "EstimateReport", title: str = "") -> None:
    """Print RMS and worst error of every state, NEES, and the innovations of each channel."""
    if title:
        print(title)
    rows = [("estimate", "RMS error", "worst", "")]
    for state in report.states:
        unit, factor = _DISPLAY_UNITS.get(state.unit, (state.unit, 1.0))
        rows.append((state.name, f"{factor * state.rms:.3f}", f"{factor * state.worst:.3f}", unit))
    print_table(rows, left=(0, 3))
    nees = report.nees
    if nees is None:
        return
    print(
        f"NEES of attitude, position and velocity: mean {nees.mean:.2f} of {nees.states} states, "
        f"{100.0 * nees.within:.1f} % of the time within {nees.lower:.2f} .. {nees.upper:.2f} "
        "(95 %)"
    )
    if not report.innovations:
        return
    print()
    told = [("innovations", "number", "in 95 % bounds")]
    told += [
        (each.channel, f"{each.count}", f"{100.0 * each.within:.1f} %")
        for each in report.innovations
    ]
    print_table(told, left=(0,))
    for sentence in underestimated_settings(report.innovations):
        print(sentence)


def underestimated_settings(innovations: "Sequence[Innovations]") -> list[str]:
    """Return a sentence for each setting of the estimator that is too small for the sensor."""
    found: dict[str, list[Innovations]] = {}
    for each in innovations:
        if each.surprises:
            found.setdefault(each.setting, []).append(each)
    return [
        f"{', '.join(each.channel for each in channels)}: up to "
        f"{max(each.scale for each in channels):.2g} times as far from the estimate as it assumes: "
        f"raise {setting} about as much (--set), or look for a fault of the sensor"
        for setting, channels in found.items()
    ]
