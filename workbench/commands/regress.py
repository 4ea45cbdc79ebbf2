"""Regression specs: `workbench regress` to run them and `pin` to write them."""

import argparse
import dataclasses
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.chosen_vehicle import chosen_executor, chosen_scenario
from workbench.commands.options import (
    LOG_HELP,
    Subcommands,
    add_command,
    add_controller_option,
    add_flier_options,
    add_json_option,
    add_log_options,
    add_option,
    add_order_option,
    add_repeated,
    add_scheduler_option,
    add_vehicle_options,
    parse_argument,
    parse_variation,
)
from workbench.commands.outputs import Outputs, check_writable
from workbench.commands.printing import pick, print_result
from workbench.commands.progress import progress_bar
from workbench.commands.step import LOAD_CHOICES
from workbench.common.errors import WorkbenchError
from workbench.parameters.parameter_table import split_setting

if TYPE_CHECKING:
    from workbench.design.regress.flight import Changes
    from workbench.design.regress.verdict import CaseResult

DEFAULT_PIN_AXIS = "x"
"""Default axis of a step."""


def add_parser(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "regress",
        "Fly the cases of specs, and check metrics, margins and curves against limits and "
        "baselines.",
        "workbench regress --set kp_velocity_z=3 --html out/regress.html",
        run,
    )
    parser.add_argument(
        "specs",
        nargs="*",
        metavar="SPEC",
        help="spec file, folder of *.workbench.yaml, or name of a shipped spec (default: all "
        "shipped)",
    )
    change = parser.add_argument_group("changes to the specs")
    add_repeated(
        change, "--set", "NAME=VALUE", split_setting, "value of a live parameter; may be repeated"
    )
    add_repeated(
        change,
        "--vary",
        "NAME=VALUE",
        parse_variation,
        "let what flies differ from what the controller knows, as mass=1.05, or rotor_lag, "
        "inertia, control_delay, sensing_delay, command_delay; may be repeated",
    )
    add_repeated(
        change,
        "--arg",
        "NAME:=VALUE",
        parse_argument,
        "argument of the xacro file, as mass:=2.1; may be repeated",
    )
    add_controller_option(change, "spec")
    change.add_argument("--seed", type=int, metavar="N", help="of noise and turbulence")
    change.add_argument("--physics-step", type=float, metavar="S", help="of the integration [s]")
    parser.add_argument("--update", action="store_true", help="record the baselines again")
    parser.add_argument("--junit", type=Path, metavar="FILE", help="write JUnit XML")
    parser.add_argument("--html", type=Path, metavar="FILE", help="write a page with all curves")
    parser.add_argument(
        "-j", "--jobs", type=int, default=2, metavar="N", help="processes that fly (default: 2)"
    )
    add_scheduler_option(parser)
    add_json_option(parser)
    add_flier_options(parser)


def run(args: argparse.Namespace) -> int:
    """Fly, judge, print and write; return 1 if a demand is not met."""
    from workbench.design.regress.baseline import conditions_file
    from workbench.design.regress.flight import Changes
    from workbench.design.regress.running import local_executor, record, regress
    from workbench.design.regress.spec_names import find_specs
    from workbench.logs.judged_log import read_case

    if args.jobs < 1:
        raise WorkbenchError(f"--jobs is {args.jobs}: give it 1 or more")
    changes = Changes(dict(args.set), dict(args.arg), dict(args.vary), args.seed, args.physics_step)
    if args.update and changes.any:
        raise WorkbenchError(
            "a baseline belongs to the spec as it is written: leave out --update, or write the "
            "change into the spec or the gain file"
        )
    changes = dataclasses.replace(changes, controller=args.controller)
    specs = find_specs(args.specs)
    with (
        Outputs() as outputs,
        chosen_executor(args.scheduler, local_executor(args.jobs)) as executor,
    ):
        junit = outputs.add(args.junit) if args.junit else None
        html = outputs.add(args.html) if args.html else None
        for spec in specs if args.update else ():
            check_writable(conditions_file(Path(spec)))
        with progress_bar("judging the cases") as progress:
            if args.update:
                results, files = record(
                    specs,
                    controller=args.controller,
                    executor=executor,
                    progress=progress,
                    read_log=read_case,
                )
                for path, text in files.items():
                    outputs.add(path).write_text(text, encoding="utf-8")
            else:
                results = regress(
                    specs, changes, executor=executor, progress=progress, read_log=read_case
                )
        title = ", ".join(args.specs) or "the shipped specs"
        _write(results, junit, html, f"Regression of {title}")
    print_result(args, _result(results, changes), _print, results, files=outputs.files)
    return ExitCode.DONE if all(result.passed for result in results) else ExitCode.NOT_AS_DEMANDED


def _write(
    results: Sequence["CaseResult"], junit: Path | None, html: Path | None, title: str
) -> None:
    """Write the requested files."""
    if junit:
        from workbench.design.regress.page import junit_xml

        junit.write_text(junit_xml(results), encoding="utf-8")
    if html:
        from workbench.design.regress.page import results_page

        html.write_text(results_page(results, title), encoding="utf-8")


def _print(results: Sequence["CaseResult"]) -> None:
    """Print a sentence for each failure, and the number of passed cases."""
    from workbench.design.regress.verdict import results_summary, since_baseline

    for result in results:
        for failure in result.failures:
            print(f"{result.spec}: {result.case}: {failure}")
        for skipped in result.skips:
            print(f"{result.spec}: {result.case}: skipped: {skipped}")
    for changed in since_baseline([result for result in results if not result.passed]):
        print(changed)
    print(results_summary(results))


def _result(results: Sequence["CaseResult"], changes: "Changes") -> dict[str, Any]:
    """Return the results for JSON."""
    return {
        "passed": all(result.passed for result in results),
        "changes": changes,
        "cases": [
            {
                "spec": result.spec,
                "file": result.path,
                "skipped": result.skips,
                **pick(result, "case passed failures trouble seconds differences"),
                "checks": [
                    {
                        "metric": check.name,
                        **pick(check.limit, "min max"),
                        "beyond": check.excess,
                        "passed": check.met,
                        **pick(check, "unit value doubt skipped"),
                    }
                    for check in result.checks
                ],
                "curves": [
                    {
                        **pick(curve, "signal unit"),
                        "band_use": curve.use if curve.band else None,
                        "beyond": float(curve.excesses.max(initial=0.0)),
                        "passed": curve.met,
                    }
                    for curve in result.curves
                ],
            }
            for result in results
        ],
    }


def add_pin(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "record",
        "Fly a step, or take a log, and write a spec that later flights must fulfil.",
        "workbench record quad.workbench.yaml --model quad.urdf.xacro --gains mine.yaml --axis x",
        run_pin,
        other_name="pin",
    )
    parser.add_argument(
        "spec",
        type=Path,
        metavar="NAME.workbench.yaml",
        help="to be written, with NAME.gains.yaml and NAME.baseline beside it",
    )
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--axis", choices=("x", "y", "z", "yaw"), help="of the step (default: x)")
    what.add_argument(
        "--load",
        choices=LOAD_CHOICES,
        help="of a step of a load in hover, see `workbench step --help`",
    )
    what.add_argument("--from-log", type=Path, metavar="LOG", help=f"take a flight: {LOG_HELP}")
    add_option(
        parser,
        "--amplitude",
        "A",
        "of the step [m/s], for yaw [rad/s], of a load [N], [N·m] or [m/s]",
        1.0,
    )
    parser.add_argument(
        "--duration",
        type=float,
        metavar="T",
        help="flown after the command's edge [s] (default: until the step has settled by the "
        "linear model, at least 5; for a load 5)",
    )
    parser.add_argument(
        "--acts",
        type=float,
        metavar="T",
        help="for how long the load acts [s] (default: to the end, a gust for 1)",
    )
    parser.add_argument(
        "--no-margins", action="store_true", help="set no limits on the margins at hover"
    )
    log = parser.add_argument_group("of a log")
    log.add_argument(
        "--loop",
        default="",
        metavar="LOOP",
        help="whose response is held: roll_rate, roll, v_x, x, ... or SETPOINT:RESPONSE of any two "
        "signals",
    )
    log.add_argument(
        "--span", type=float, nargs=2, default=[], metavar=("FROM", "TO"), help="part of it [s]"
    )
    add_order_option(log)
    add_log_options(log)
    parser.add_argument("--force", action="store_true", help="replace existing files")
    add_vehicle_options(parser)
    add_json_option(parser)
    add_flier_options(parser)


def run_pin(args: argparse.Namespace) -> int:
    """Fly or read, write and prove the spec."""
    check_writable(args.spec)
    if args.from_log:
        return _pin_log(args)
    for option in ("loop", "span", "order", "mapping"):
        if getattr(args, option):
            raise WorkbenchError(
                f"--{option} is for a log: give --from-log LOG too, or leave it out"
            )
    from workbench.design.pin import pin_step

    scenario = chosen_scenario(args)
    axis = args.axis or DEFAULT_PIN_AXIS
    with progress_bar("flying and proving a step") as progress:
        pinned = pin_step(
            args.spec,
            scenario,
            dict(args.set),
            args.load or axis,
            args.amplitude,
            duration=args.duration,
            acts=args.acts,
            margins=not args.no_margins,
            overwrite=args.force,
            progress=progress,
        )
    loops = f", margins of {pinned.loops} loops" if pinned.loops else ""
    said = [
        f"pinned to the present values: {pinned.limits} numbers and {pinned.curves} curves of a "
        f"step {args.load or f'along {axis}'}{loops}"
    ]
    if args.gains:
        said.append(f"it flies {pinned.gains.name}: pin again when {args.gains} has changed")
    files = [pinned.spec, pinned.gains, pinned.baseline]
    print_result(args, pinned, _print_pinned, args.spec, said, files=files)
    return ExitCode.DONE


def _print_pinned(spec: Path, said: Sequence[str]) -> None:
    """Print the limits, and what to do next."""
    name = shlex.quote(str(spec))
    print("\n".join([*said, "", f"next: workbench regress {name}, or pytest {name}"]))


def _pin_log(args: argparse.Namespace) -> int:
    """Write the spec of a log."""
    given = [option for option in ("set", "gains", "controller") if getattr(args, option, None)]
    if given:
        raise WorkbenchError(
            f"--{given[0]} is for a step, and a log has flown already: leave it out"
        )
    with progress_bar(f"pinning and proving {args.from_log.name}") as progress:
        from workbench.design.pin_log import pin_log
        from workbench.design.regress.running import regress
        from workbench.design.regress.spec import LogConfig
        from workbench.logs.judged_log import read_case

        vehicle = chosen_scenario(args).vehicle
        log = LogConfig(
            file=str(args.from_log),
            mapping=str(args.mapping or ""),
            number=args.log_number or 0,
            order=args.order,
            span=list(args.span),
        )
        pinned = pin_log(args.spec, vehicle, log, args.loop, read_case, overwrite=args.force)
        progress(0.5)
        results = regress([pinned.spec], read_log=read_case)
    failures = [said for each in results for said in each.failures]
    if failures:
        raise WorkbenchError(f"{pinned.spec}: what was pinned fails: {failures[0]}")
    said = [f"pinned to the present values: {pinned.limits} numbers of {args.from_log}"]
    if not args.model:
        said.append(f"the drone is taken to be a {vehicle.model}: give --model if another one flew")
    said += [f"left out: {name}: {reason}" for name, reason in pinned.left_out.items()]
    print_result(args, pinned, _print_pinned, args.spec, said, files=[pinned.spec])
    return ExitCode.DONE
