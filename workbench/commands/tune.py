"""`workbench tune`: from wishes to gains, with the proof on the full diagram."""

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.chosen_vehicle import chosen_setup
from workbench.commands.options import (
    Subcommands,
    add_command,
    add_flight_options,
    add_option,
    add_repeated,
)
from workbench.commands.outputs import Outputs, check_writable, make_folder_of
from workbench.commands.printing import pick, print_message, print_result, print_table
from workbench.commands.progress import progress_bar
from workbench.commands.stopping import StopFlag, stop_on_interrupt
from workbench.common.errors import WorkbenchError

if TYPE_CHECKING:
    from workbench.control.controller import Controller
    from workbench.design.tune.tuner import Tuner
    from workbench.design.tune.tuning import Tuning, TuningProgress, WishResult
    from workbench.design.tune.wish import Wishes


def add_parser(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "tune",
        "Find gains that meet wishes on the vehicle and on vehicles near it, and verify them in "
        "flight.",
        'workbench tune --wish "level.rise_time<=0.4" --wish "tilt.phase_margin>=45deg"',
        run,
    )
    group = parser.add_argument_group("wishes")
    add_repeated(
        group,
        "--wish",
        "WISH",
        str,
        "SUBJECT.METRIC<=VALUE or >=; may be repeated. Steps of the axes x, y, z, yaw, or level "
        "for x and y: rise_time, settling_time, overshoot, steady_state_error, peak_rotor_use. "
        "Steps of the angles roll, pitch, or tilt for both: the first three. Loops, such as roll, "
        "yaw_rate, velocity_x, position_z, or tilt for roll and pitch, and loop points, such as "
        "pitch_error: phase_margin, gain_margin, delay_margin, disk_margin, peak_sensitivity, "
        "bandwidth. rotors: noise_amplification, command_noise. Examples: level.rise_time<=0.4, "
        "pitch.rise_time<=80ms, roll.bandwidth>=12rad/s, yaw_rate.phase_margin>=60deg; see "
        "docs/tuning.md",
    )
    group.add_argument(
        "--wishes", type=Path, metavar="FILE", help="file of wishes (YAML), see docs/tuning.md"
    )
    group.add_argument(
        "--no-defaults", action="store_true", help="add no wishes that follow from the vehicle"
    )
    add_option(
        group,
        "--at",
        "POINT",
        "steady flight to tune for, hover or as vx=5,vz=-1: loops are judged there and steps "
        "begin from it; of scheduled gains those of the set that flies there change",
        "hover",
    )
    group = parser.add_argument_group("search")
    group.add_argument(
        "--separate",
        action="store_true",
        help="let x and y, roll and pitch differ on a symmetric vehicle",
    )
    group.add_argument(
        "--evaluations",
        type=_positive(int),
        default=600,
        metavar="N",
        help="candidates to evaluate, at most (default: 600)",
    )
    group.add_argument(
        "--budget",
        type=_positive(float),
        default=float("inf"),
        metavar="SECONDS",
        help="time to search, at most [s] (default: until all candidates are flown)",
    )
    group.add_argument(
        "--seed", type=int, default=0, metavar="N", help="of the random starts (default: 0)"
    )
    parser.add_argument(
        "--save",
        type=Path,
        metavar="FILE",
        help="gain file to write, with a history if it is there (default: tuned.yaml in --output)",
    )
    add_flight_options(parser)


def run(args: argparse.Namespace) -> int:
    """Tune, print the table, write gains, report and figure; return 1 if wishes cannot be met."""
    from workbench.design.linear.operating_point import steady_velocity
    from workbench.design.tune.tuner import Tuner

    setup = chosen_setup(args)
    law = setup.controller
    tuner = Tuner(
        setup,
        _wishes(args, law, setup.scenario.vehicle.rotors),
        separate=args.separate,
        evaluations=args.evaluations,
        seconds=args.budget,
        seed=args.seed,
        velocity=steady_velocity(args.at),
    )
    gain_file = args.save or args.output / "tuned.yaml"
    _check_gain_file(gain_file, tuner.vehicle, law)
    with Outputs() as outputs:
        report = outputs.add(args.output / "tuning.html")
        picture = outputs.picture(args, "tuning.png")
        found, stopped = _tuned(tuner)
        _write(found, report, picture)
    files = outputs.files
    if found.met:
        _save(found, gain_file)
        files = [gain_file, *files]
    print_result(args, tuning_json(found), print_tuning, found, files=files)
    if found.met:
        return ExitCode.DONE
    for sentence in conclusion(found):
        print_message(sentence)
    return stopped.exit_code if stopped() else ExitCode.NOT_AS_DEMANDED


def _wishes(args: argparse.Namespace, law: "Controller", rotors: str) -> "Wishes":
    """Return the wishes from file and command line; the latter take precedence.

    The uncertainty of the vehicle comes from the wishes, or else from its identification.
    """
    import dataclasses

    from workbench.common.resources import find_file
    from workbench.design.tune.case import Robustness, identified_robustness
    from workbench.design.tune.wish import Wishes, load_wishes, merged_wishes, parse_wish

    wishes = load_wishes(find_file(str(args.wishes)), law) if args.wishes else Wishes()
    said = [wish for text in args.wish for wish in parse_wish(text, law=law)]
    robustness = wishes.robustness
    if rotors and robustness == Robustness():
        robustness = identified_robustness(find_file(rotors)) or robustness
    if robustness != wishes.robustness:
        print_message(
            f"by the intervals in {rotors} the mass may differ by {robustness.mass:.1%}, inertia "
            f"by {robustness.inertia:.1%}, rotor lag by {robustness.rotor_lag:.1%}"
        )
    return dataclasses.replace(
        wishes,
        robustness=robustness,
        wishes=tuple(merged_wishes([*wishes.wishes, *said])),
        defaults=wishes.defaults and not args.no_defaults,
    )


def _tuned(tuner: "Tuner") -> "tuple[Tuning, StopFlag]":
    """Run, and show the best so far; the first Ctrl-C ends the search and keeps its results.

    Before the search there are none, so that it ends the command.
    """
    with progress_bar("tuning") as show:

        def tell(progress: "TuningProgress") -> None:
            show(progress.share, progress_line(progress))

        tuner.prepare(tell)
        with stop_on_interrupt(tuner.stop, "the best so far") as stopped:
            found = tuner.run(tell)
        return found, stopped


def _write(found: "Tuning", report: Path, picture: Path | None) -> None:
    """Write report and picture."""
    from workbench.design.plots import write_png
    from workbench.design.tune.report import plot_tuning, report_html

    figure = plot_tuning(found)
    if picture:
        write_png(figure, picture)
    report.write_text(report_html(found, figure), encoding="utf-8")


def _check_gain_file(path: Path, vehicle: str, law: "Controller") -> None:
    """Check that no file is lost, before time is spent."""
    from workbench.gains.gains import load_gains

    check_writable(path)
    owner = load_gains(path, law).vehicle if path.exists() else ""
    if owner not in ("", vehicle):
        raise WorkbenchError(
            f"{path}: has the gains of '{owner}', and '{vehicle}' is tuned: name another file"
        )


def _save(found: "Tuning", path: Path) -> None:
    """Write the gain file."""
    from workbench.gains.gains import save_gains

    make_folder_of(path)
    save_gains(path, found.profile, found.controller)


def _positive(kind: type) -> Callable[[str], float]:
    """Return a parser of numbers above 0."""

    def parse(text: str) -> float:
        try:
            value = kind(text)
        except ValueError:
            value = 0
        if not value > 0:
            raise WorkbenchError(f"'{text}' is not a number above 0")
        return value

    return parse


def progress_line(progress: "TuningProgress") -> str:
    """Return a line on the best candidate so far."""
    if progress.best is None or progress.worst is None:
        return progress.phase
    metric = progress.worst.wish.metric
    reserve = 100.0 * progress.best.reserve
    return (
        f"{progress.phase}; best so far: {progress.worst.wish.name} "
        f"{metric.text(progress.value)} ({reserve:+.0f} % to spare)"
    )


def print_tuning(found: "Tuning") -> None:
    """Print wishes, gains and the proof."""
    from workbench.control.installed_laws import DEFAULT_CONTROLLER
    from workbench.design.tune.report import gain_rows, proof_rows, wish_rows

    whose = "" if found.controller.name == DEFAULT_CONTROLLER else f" with {found.controller.name}"
    searched = f"{len(found.wishes)} wishes, {found.evaluations} candidates evaluated"
    print(f"{found.vehicle}{whose}: {searched}")
    for remark in (*found.shortfalls, *found.remarks):
        print(remark)
    for each in found.given_up:
        print_message(
            f"not met, and not wished: {each.required}, a default; it has "
            f"{each.required.wish.metric.text(each.after)}. --no-defaults leaves defaults "
            "out"
        )
    print()
    print_table(
        [["", "before", "after", "wished", ""], *wish_rows(found.as_described)], left=(0, 4)
    )
    if found.in_corners:
        print("\nin the worst corner of each:")
        rows = wish_rows(found.in_corners, cases=True)
        print_table([["", "before", "after", "still wished", "", ""], *rows], left=(0, 4, 5))
    if found.guarded:
        print("\nloops that no wish is about, to keep 90 % of their margins:")
        rows = wish_rows(found.guarded)
        print_table([["", "before", "after", "kept", ""], *rows], left=(0, 4))
    print()
    print_table([["", "before", "after", ""], *gain_rows(found)], left=(0, 3))
    if found.proof and found.proof.values:
        print("\nflown on the full diagram:")
        print_table([["", "flown", "wished", "", ""], *proof_rows(found)], left=(0, 3, 4))


def conclusion(found: "Tuning") -> list[str]:
    """Return the reasons why there are no gains, as sentences."""
    if found.conflicts:
        return [str(conflict) for conflict in found.conflicts]
    short = min(found.deciding, key=lambda result: result.reserve)

    value = short.required.wish.metric.text(short.after)
    nearest = f"no gains that meet all wishes were found: {short.required} is nearest with {value}"
    if found.stopped:
        return [f"ended early; so far {nearest}"]
    return [f"{nearest}; evaluate more candidates with --evaluations"]


def tuning_json(found: "Tuning") -> dict[str, Any]:
    """Return the results for JSON, in SI units but for margins, which are in degrees."""
    return {
        **pick(found, "vehicle met stopped evaluations shortfalls remarks"),
        "controller": found.controller.name,
        "wishes": [_result(result) for result in found.results if result not in found.guarded],
        "guarded": [_result(result) for result in found.guarded],
        "gains": {
            name: {"before": found.before[name], "after": value}
            for name, value in found.gains.items()
        },
        "proof": [
            {
                "wish": required.wish.file_name,
                "case": required.case,
                "bound": required.wish.metric.file_factor * required.bound,
                "flown": required.wish.metric.file_factor * value,
                "met": required.met(value),
            }
            for required, value in (found.proof.values if found.proof else ())
        ],
        "conflicts": [
            {
                "wish": conflict.wish.file_name,
                "against": [wish.file_name for wish in conflict.against],
                "bound": conflict.wish.metric.file_factor * conflict.required.bound,
                "nearest": conflict.wish.metric.file_factor * conflict.nearest,
                "sentence": str(conflict),
            }
            for conflict in found.conflicts
        ],
    }


def _result(result: "WishResult") -> dict[str, Any]:
    required, metric = result.required, result.required.wish.metric
    factor = metric.file_factor
    return {
        "wish": required.wish.file_name,
        "origin": required.wish.origin,
        "case": required.case,
        "unit": metric.file_unit,
        "at_least": required.wish.at_least,
        "bound": factor * required.bound,
        "widened_from": required.widened,
        "before": factor * result.before if math.isfinite(result.before) else None,
        "after": factor * result.after,
        "met": result.met,
    }
