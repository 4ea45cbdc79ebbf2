"""`workbench compare`: compare controllers and gains in the same flights."""

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.chosen_vehicle import with_model
from workbench.commands.options import (
    Subcommands,
    add_command,
    add_flier_options,
    add_json_option,
    add_model_options,
    add_output_options,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import pick, print_result, print_table
from workbench.commands.progress import progress_bar
from workbench.common.html_page import html_page, html_table
from workbench.common.plain_text import html_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from workbench.design.comparison import ControllerComparison
    from workbench.scenario.scenario import Scenario


def add_parser(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "compare",
        "Compare controllers and gain files in steps, along a path, after a push, from upside "
        "down, in wind, with other vehicles, and by margins and noise. A controller without a gain "
        "file flies with its gains for the vehicle.",
        "workbench compare pd pid lqi geometric indi\n"
        "  workbench compare pd soft.yaml hard.yaml\n"
        "  workbench compare pd my_law.py --parts steps,margins --html compare.html\n"
        '  workbench compare pd pid --tune "level.rise_time<=0.5" "tilt.phase_margin>=45deg"',
        run,
    )
    parser.add_argument(
        "controllers",
        nargs="+",
        metavar="NAME|FILE|GAINS",
        help="shipped control law (`workbench controllers` lists them), a .py file of your own, or "
        "a gain file (.yaml) of a shipped law; mine.py=soft.yaml flies your file with gains",
    )
    parser.add_argument(
        "--scenario",
        metavar="FILE",
        help="shipped scenario, or a .yaml file, whose vehicle, world, rates and figure of eight "
        "are used",
    )
    parser.add_argument(
        "--parts",
        default="",
        metavar="A[,B]",
        help="of steps, path, push, upside_down, wind, vehicles, margins (default: all)",
    )
    parser.add_argument(
        "--tune",
        nargs="*",
        metavar="WISH|FILE",
        help="tune each controller for the same wishes first, see `workbench tune`; without a "
        "wish, use those that follow from the vehicle",
    )
    parser.add_argument("--html", type=Path, metavar="FILE", help="table and picture as one page")
    add_output_options(parser)
    group = parser.add_argument_group("vehicle")
    add_model_options(group)
    add_json_option(parser)
    add_flier_options(parser)


def run(args: argparse.Namespace) -> int:
    """Compare, print the table, write the picture."""
    from workbench.design.compare import (
        chosen_parts,
        compare_controllers,
        find_candidates,
        wishes_of,
    )

    parts = chosen_parts([name.strip() for name in args.parts.split(",") if name.strip()])
    candidates = find_candidates(args.controllers)
    for each in candidates:
        wishes_of(args.tune or (), each.law)
    scenario = _scenario(args, candidates[0].reference)
    with Outputs() as outputs:
        picture = outputs.picture(args, "compare.png")
        page = outputs.add(args.html) if args.html else None
        with progress_bar("comparing controllers") as progress:
            found = compare_controllers(
                args.controllers, scenario, parts=parts, wishes=args.tune, progress=progress
            )
        if picture or page:
            from workbench.design.plots import write_png
            from workbench.design.plots_compare import plot_comparison

            figure = plot_comparison(found)
            if picture:
                write_png(figure, picture)
            if page:
                page.write_text(_page(found, figure), encoding="utf-8")
    print_result(args, _result(found), _print, found, files=outputs.files)
    return ExitCode.DONE


def _scenario(args: argparse.Namespace, controller: str) -> "Scenario":
    """Return the scenario with the vehicle; errors are reported before Drake loads."""
    from workbench.common.resources import find_scenario
    from workbench.scenario.scenario import Scenario
    from workbench.scenario.scenario_file import load_scenario

    scenario = Scenario()
    if args.scenario:
        scenario = load_scenario(find_scenario(args.scenario), controller)
    return with_model(scenario, args)


def _result(found: "ControllerComparison") -> dict[str, Any]:
    """Return a comparison for JSON."""
    return {
        "vehicle": found.vehicle,
        "rows": [pick(each, "name unit part help") for each in found.rows],
        "controllers": [pick(each, "name numbers remarks gains") for each in found.controllers],
    }


def _texts(found: "ControllerComparison") -> list[list[str]]:
    """Return the table, with a row for each number and a column for each controller."""
    rows = [["", "unit", *(each.name for each in found.controllers), ""]]
    for row in found.rows:
        values = [each.numbers.get(row.name, math.nan) for each in found.controllers]
        unit = "" if row.unit == "1" else row.unit
        rows.append([row.name, unit, *map(_text, values), row.help])
    return rows


def _text(value: float) -> str:
    """Return a number as text, or a dash; below a millionth it is a rounding error."""
    if not math.isfinite(value):
        return "-"
    return f"{value:.3g}" if abs(value) >= 1e-6 else "0"


def _remarks(found: "ControllerComparison") -> list[str]:
    """Return remarks on single numbers, each as one sentence for all numbers concerned."""
    names: dict[tuple[str, str], list[str]] = {}
    for row in found.rows:
        for each in found.controllers:
            if row.name in each.remarks:
                names.setdefault((each.name, each.remarks[row.name]), []).append(row.name)
    return [f"{law}, {', '.join(rows)}: {remark}" for (law, remark), rows in names.items()]


def _print(found: "ControllerComparison") -> None:
    """Print the table, and remarks on single numbers."""
    tuned = any(each.gains for each in found.controllers)
    whose = "the gains found for the wishes" if tuned else "its gains for it, or of its file"
    print(f"{found.vehicle}, each controller with {whose}\n")
    texts = _texts(found)
    print_table(texts, left=(0, 1, len(texts[0]) - 1))
    if remarks := _remarks(found):
        print()
        print("\n".join(remarks))


def _page(found: "ControllerComparison", figure: "Figure") -> str:
    """Return the page."""
    from workbench.design.plots import inline_svg

    head, *rows = _texts(found)
    title = f"{found.vehicle}: {', '.join(each.name for each in found.controllers)}"
    remarks = "".join(f"<li>{html_text(remark)}</li>\n" for remark in _remarks(found))
    last = len(head) - 1
    table = html_table(head, rows, kinds=dict.fromkeys(range(2, last), "number") | {last: "note"})
    body = f"{inline_svg(figure)}\n{table}\n<ul>\n{remarks}</ul>"
    return html_page(title, body, wide=True)
