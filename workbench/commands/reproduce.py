"""`workbench reproduce`: the paper's four steps, flown here and set beside its figures."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    add_command,
    add_json_option,
    add_output_options,
    add_vehicle_options,
    with_vehicle,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import print_json, print_table, say, say_written, to_json
from workbench.commands.progress import progress_bar

if TYPE_CHECKING:
    from workbench.design.reproduce import Check, Row


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "reproduce",
        "Fly the paper's four steps and set acceleration, force and rise beside its figures 8-11.",
        "workbench reproduce --output out",
        run,
    )
    add_output_options(parser)
    add_vehicle_options(parser)
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Fly, print the table, write figures and logs; 1 if the demands are not met."""
    from workbench.design.reproduce import reproduce, violations
    from workbench.scenario.scenario import Scenario

    scenario = with_vehicle(Scenario(), args)
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
    if args.json:
        print_json(result)
    else:
        _print(rows)
    say_written(outputs.files)
    missed = violations(rows)
    if missed:
        say(f"not as demanded: {'; '.join(missed)}")
        return ExitCode.NOT_AS_DEMANDED
    return ExitCode.DONE


_FIGURES = (8, 9, 10, 11)


def _write(rows: "list[Row]", logs: list[Path], plots: list[Path]) -> None:
    """Write a log and, where plots are wanted, a figure for each step."""
    for row, log in zip(rows, logs, strict=True):
        row.flight.recording.write_csv(log)
    if plots:
        from workbench.design.plots import write_png
        from workbench.design.plots_step import plot_reproduced

        for row, plot in zip(rows, plots, strict=True):
            write_png(plot_reproduced(row), plot)


def _result(rows: "list[Row]", files: list[Path]) -> dict[str, Any]:
    """Return everything as JSON has it."""
    from workbench.design.reproduce import WINDOW, checks, implied_t90, violations

    return {
        "window": WINDOW,
        "rows": [
            {
                "axis": row.paper.axis,
                "command": row.paper.command,
                "t90": row.t90,
                "mean_acceleration": row.mean_acceleration,
                "mean_force": row.mean_force,
                "overshoot": row.flight.metrics.overshoot,
                "steady_state_error": row.flight.metrics.steady_state_error,
                "coupling": row.flight.coupling,
                "peak_rotor_use": row.flight.peak_rotor_use,
                "met": all(check.met for check in checks(row)),
                "paper": {
                    "figure": row.paper.number,
                    "t90": implied_t90(row),
                    "mean_acceleration": row.paper.mean_acceleration,
                    "mean_force": row.paper.mean_force,
                    "remark": row.paper.remark,
                },
            }
            for row in rows
        ],
        "violations": violations(rows),
        "files": files,
    }


def _print(rows: "list[Row]") -> None:
    """Print the table with its window and remarks."""
    from workbench.design.reproduce import WINDOW, checks, heading

    table = [["", "paper", "ours", "difference", "demanded", ""]]
    for row in rows:
        table.append([heading(row), "", "", "", "", ""])
        table += [_line(check) for check in checks(row)]
    print_table(table, left=(0, 4, 5))
    print(f"\nwindow: {WINDOW}; the paper's t90 is what its mean acceleration over it implies.")
    for row in rows:
        if row.paper.remark:
            print(f"{row.paper.axis}: {row.paper.remark}.")


def _line(check: "Check") -> list[str]:
    """Return one line of the table."""
    return [
        f"  {check.quantity} [{check.unit}]",
        "-" if check.paper is None else f"{check.paper:.3f}",
        f"{check.ours:.3f}",
        "-" if check.difference is None else f"{check.difference:+z.1f} %",
        check.demand or "-",
        "" if check.met else "<- missed",
    ]
