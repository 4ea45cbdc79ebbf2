"""Flights of the paper: `workbench reproduce` for its four steps, `lidar-trial` for its lidar."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands.chosen_vehicle import chosen_scenario
from workbench.commands.options import Subcommands, add_command, add_flight_options
from workbench.commands.outputs import Outputs
from workbench.commands.printing import (
    pick,
    print_result,
    print_table,
    report_unmet,
    to_json,
)
from workbench.commands.progress import progress_bar

if TYPE_CHECKING:
    from workbench.design.reproduce import PaperCheck, ReproducedRow

_FIGURES = (8, 9, 10, 11)


def add_parser(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "reproduce",
        "Fly the paper's four steps and set acceleration, force and rise beside its figures 8-11.",
        "workbench reproduce --output out",
        run,
    )
    add_flight_options(parser)


def run(args: argparse.Namespace) -> int:
    """Fly, print the table, write figures and logs; 1 if the demands are not met."""
    from workbench.design.reproduce import reproduce, unmet_demands

    scenario = chosen_scenario(args)
    with Outputs() as outputs:
        summary = outputs.add(args.output / "reproduce.json")
        logs = [outputs.add(args.output / f"figure{number}.csv") for number in _FIGURES]
        plots = (
            []
            if args.no_plots
            else [outputs.add(args.output / f"figure{number}.png") for number in _FIGURES]
        )
        with progress_bar("flying four steps") as progress:
            rows = reproduce(scenario=scenario, settings=dict(args.set), progress=progress)
        _write(rows, logs, plots)
        result = _result(rows, outputs.files)
        summary.write_text(to_json(result) + "\n", encoding="utf-8")
    print_result(args, result, _print, rows, files=outputs.files)
    return report_unmet(unmet_demands(rows))


def _write(rows: "list[ReproducedRow]", logs: list[Path], plots: list[Path]) -> None:
    """Write a log and, unless disabled, a figure for each step."""
    for row, log in zip(rows, logs, strict=True):
        row.flight.recording.write_csv(log)
    if plots:
        from workbench.design.plots import write_png
        from workbench.design.plots_step import plot_reproduced

        for row, plot in zip(rows, plots, strict=True):
            write_png(plot_reproduced(row), plot)


def _result(rows: "list[ReproducedRow]", files: list[Path]) -> dict[str, Any]:
    """Return the results for JSON."""
    from workbench.design.reproduce import (
        AVERAGING_WINDOW_TEXT,
        implied_t90,
        paper_checks,
        unmet_demands,
    )

    return {
        "window": AVERAGING_WINDOW_TEXT,
        "rows": [
            {
                **pick(row.paper, "axis command"),
                **pick(row, "t90 mean_acceleration mean_force"),
                **pick(row.flight.metrics, "overshoot steady_state_error"),
                **pick(row.flight, "coupling peak_rotor_use"),
                "met": all(check.met for check in paper_checks(row)),
                "paper": {
                    "figure": row.paper.number,
                    "t90": implied_t90(row),
                    **pick(row.paper, "mean_acceleration mean_force remark"),
                },
            }
            for row in rows
        ],
        "violations": unmet_demands(rows),
        "files": files,
    }


def _print(rows: "list[ReproducedRow]") -> None:
    """Print the table with its window and remarks."""
    from workbench.design.reproduce import AVERAGING_WINDOW_TEXT, paper_checks, paper_step_name

    table = [["", "paper", "ours", "difference", "demanded", ""]]
    for row in rows:
        table.append([paper_step_name(row), "", "", "", "", ""])
        table += [_line(check) for check in paper_checks(row)]
    print_table(table, left=(0, 4, 5))
    print(
        f"\nwindow: {AVERAGING_WINDOW_TEXT}; the paper's t90 is what its mean acceleration over "
        "it implies."
    )
    for row in rows:
        if row.paper.remark:
            print(f"{row.paper.axis}: {row.paper.remark}.")


def _line(check: "PaperCheck") -> list[str]:
    """Return one line of the table."""
    return [
        f"  {check.quantity} [{check.unit}]",
        "-" if check.paper is None else f"{check.paper:.3f}",
        f"{check.ours:.3f}",
        "-" if check.difference is None else f"{check.difference:+z.1f} %",
        check.demand or "-",
        "" if check.met else "<- missed",
    ]
