"""`workbench frames`: the tree of all frames, and the transform from one to another."""

import argparse
import math
from typing import TYPE_CHECKING

from workbench.commands import ExitCode
from workbench.commands.chosen_vehicle import chosen_scenario
from workbench.commands.options import (
    Subcommands,
    add_command,
    add_json_option,
    add_vehicle_options,
)
from workbench.commands.printing import print_result, print_table
from workbench.commands.progress import progress_bar
from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import plain_name

if TYPE_CHECKING:
    from collections.abc import Iterable

    from pydrake.math import RigidTransform

    from workbench.plant.frame_tree import FrameTree
    from workbench.setup import Setup


def add_parser(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "frames",
        "Print the tree of all frames, or the pose of frame B in frame A: with the drone standing "
        "at the origin, or at a time of a flight.",
        "workbench frames world camera_optical --scenario square --at-time 5",
        run,
    )
    parser.usage = "%(prog)s [A B] [options]"  # options with several values would swallow them
    parser.add_argument("frames", nargs="*", metavar="A B", help="pose of B in A; none: the tree")
    parser.add_argument(
        "--scenario", metavar="NAME|PATH", help="fly this scenario, shipped or a .yaml file"
    )
    parser.add_argument("--at-time", type=float, metavar="T", help="to this time of it [s]")
    add_vehicle_options(parser)
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Print the tree or a transform."""
    from pydrake.math import RigidTransform

    from workbench.common.resources import find_scenario
    from workbench.plant.frame_tree import frames_in_world
    from workbench.scenario.configured import log_held_joints, log_world_remarks
    from workbench.scenario.scenario import Scenario
    from workbench.scenario.scenario_file import load_scenario
    from workbench.setup import make_setup

    if len(args.frames) not in (0, 2):
        raise WorkbenchError(
            f"{len(args.frames)} frames are named: name two, A and B, or none for the whole tree"
        )
    if (args.scenario is None) != (args.at_time is None):
        raise WorkbenchError("--scenario and --at-time go together: give both")
    flown = args.scenario is not None
    scenario = Scenario()
    if flown:
        scenario = load_scenario(find_scenario(args.scenario), args.controller, args.estimator)
    scenario = chosen_scenario(args, scenario)
    setup = make_setup(scenario, dict(args.set))
    tree = frames_in_world(setup.vehicle, setup.description.model, setup.world)
    for name in args.frames:
        tree.check(name)
    X_WB, time = RigidTransform([0.0, 0.0, setup.vehicle.ground_clearance]), 0.0
    if flown:  # which reports the world itself
        X_WB, time = _flown_to(args.at_time, setup, args)
    else:
        log_held_joints(setup.description)
        log_world_remarks(setup.world)
    if args.frames:
        a, b = args.frames
        _print_transform(a, b, tree.X(a, b, X_WB, time), time, args)
    else:
        _print_tree(tree, X_WB, time, args)
    return ExitCode.DONE


def _flown_to(
    at: float, setup: "Setup", args: argparse.Namespace
) -> tuple["RigidTransform", float]:
    """Return the pose of the base link and the time [s] after a flight to a time [s]."""
    from pydrake.common.eigen_geometry import Quaternion
    from pydrake.math import RigidTransform

    from workbench.session.session import Session

    duration = setup.scenario.duration
    if not 0.0 <= at <= duration:
        raise WorkbenchError(
            f"--at-time is {at:g} s: {args.scenario} lasts from 0 to {duration:g} s"
        )
    session = Session(setup)
    with progress_bar(f"flying {args.scenario}") as progress:
        slices = math.ceil(4.0 * at)
        for index in range(slices):
            session.tick(at / slices)
            progress((index + 1) / slices)
    now = session.snapshot()
    return RigidTransform(Quaternion(now.q_WB), now.p_WB), now.time


def _print_tree(
    tree: "FrameTree", X_WB: "RigidTransform", time: float, args: argparse.Namespace
) -> None:
    """Print all frames."""
    head = "frames, each with its origin in the one above in m, and roll, pitch, yaw in degrees"
    result = {"time": time, "transforms": tree.transforms(X_WB, time)}
    print_result(args, result, print, "\n".join([head, *tree.lines(X_WB, time)]))


def _print_transform(
    a: str, b: str, X_AB: "RigidTransform", time: float, args: argparse.Namespace
) -> None:
    """Print one pose."""
    from workbench.plant.frame_tree import roll_pitch_yaw, transform

    found = transform(a, b, X_AB)
    angles = roll_pitch_yaw(X_AB)
    result = {"time": time, "frame": b, "in": a, "position": found.p, "quaternion": found.q}
    result |= {"roll_pitch_yaw": angles}
    degrees = [math.degrees(angle) for angle in angles]
    rows = [
        ("x y z", *_texts(found.p), "", "m"),
        ("roll pitch yaw", *_texts(degrees), "", "deg"),
        ("quaternion w x y z", *_texts(found.q), ""),
    ]

    def show() -> None:
        when = f"at {time:g} s of {args.scenario}" if args.scenario else "with the drone standing"
        print(f"{plain_name(b)} in {plain_name(a)}, {when}")
        print_table(rows, left=(0, 5))

    print_result(args, result, show)


def _texts(values: "Iterable[float]") -> list[str]:
    return [f"{value + 0.0:.6f}" for value in values]
