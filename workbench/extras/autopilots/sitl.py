"""`workbench sitl`: an autopilot's own software flies the drone, in lockstep."""

import argparse
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.commands import ExitCode
from workbench.commands.chosen_vehicle import with_model
from workbench.commands.options import (
    Subcommands,
    add_command,
    add_description_options,
    add_json_option,
    add_option,
    add_rotors_option,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import print_message, print_result, print_table
from workbench.common.errors import FlightBrokenError, WorkbenchError

if TYPE_CHECKING:
    from workbench.extras.autopilots.programs.motion import Autopilot
    from workbench.extras.autopilots.sitl_flight import AutopilotFlight

DEFAULT_SITL_HOST = "127.0.0.1"
PX4_PORT = 4560
ARDUPILOT_PORT = 9002
SITL_PROGRESS_PERIOD_S = 10.0
"""Period between lines of progress [s]."""


def add_parser(commands: Subcommands) -> None:
    """Add the command, with a subcommand for each autopilot."""
    parser = add_command(
        commands,
        "sitl",
        "Let PX4's or ArduPilot's own software (SITL) fly the drone, in lockstep.",
        "workbench sitl px4 --model dh_drone",
        _run_none,
    )
    kinds = parser.add_subparsers(title="autopilots", metavar="AUTOPILOT")
    px4 = add_command(
        kinds,
        "px4",
        "Serve PX4 the sensors of its MAVLink simulator interface, and fly its motor outputs.",
        "workbench sitl px4 --model dh_drone --duration 60",
        _run_px4,
    )
    _add_common(px4, PX4_PORT, "TCP; 4560 and the number of the instance", 256.0)
    ardupilot = add_command(
        kinds,
        "ardupilot",
        "Answer ArduPilot's JSON interface, `--model JSON` there, and fly its servo outputs.",
        "workbench sitl ardupilot --model dh_drone --duration 60",
        _run_ardupilot,
    )
    _add_common(ardupilot, ARDUPILOT_PORT, "UDP", 1024.0)
    ardupilot.add_argument(
        "--pulses",
        type=parse_pulses,
        default=(1000.0, 2000.0),
        metavar="LEAST,MOST",
        help="at standstill and at full signal [us] (default: 1000,2000)",
    )


def _add_common(parser: argparse.ArgumentParser, port: int, what: str, rate: float) -> None:
    parser.add_argument("--model", metavar="NAME|PATH", help="as for fly (default: dh_drone)")
    parser.add_argument(
        "--scenario",
        metavar="NAME|PATH",
        help="vehicle, world, start, rates and time (default: on the ground, rotors off); its "
        "script and controller are not used",
    )
    parser.add_argument("--world", metavar="NAME|PATH", help="shipped world, or a file")
    parser.add_argument(
        "--duration", type=float, metavar="T", help="fly this long [s] (default: until Ctrl-C)"
    )
    parser.add_argument("--csv", type=Path, metavar="FILE", help="log of the states")
    parser.add_argument(
        "--host", default=DEFAULT_SITL_HOST, help=f"where to listen (default: {DEFAULT_SITL_HOST})"
    )
    add_option(parser, "--port", "N", what, port)
    add_option(
        parser,
        "--rate",
        "HZ",
        "of steps in lockstep; whole physics steps, so 1024/n by default",
        rate,
    )
    parser.add_argument(
        "--order",
        type=parse_order,
        default=(),
        metavar="N,N,...",
        help="the drone's rotor of each output, counted from 1 (default: front right, rear left, "
        "front left, rear right)",
    )
    add_option(parser, "--patience", "T", "end after this long without an answer [s]", 5.0)
    parser.add_argument(
        "--fast", action="store_true", help="as fast as the autopilot answers, not in real time"
    )
    parser.add_argument("--no-noise", action="store_true", help="let sensors be exact")
    add_description_options(parser)
    add_rotors_option(parser)
    add_json_option(parser)


def parse_order(text: str) -> tuple[int, ...]:
    """Return rotors counted from 0."""
    try:
        return tuple(int(part) - 1 for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a list of rotors, as 1,2,3,4") from None


def parse_pulses(text: str) -> tuple[float, float]:
    """Return two pulses [us]."""
    try:
        least, most = (float(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"'{text}' is not a pair of pulses, as 1000,2000"
        ) from None
    if not 0.0 <= least < most <= 65535.0:
        raise argparse.ArgumentTypeError(f"'{text}': the first must be the lower one")
    return least, most


def _run_none(args: argparse.Namespace) -> int:
    raise WorkbenchError("no autopilot is named: write `workbench sitl px4` or `... ardupilot`")


def _run_px4(args: argparse.Namespace) -> int:
    from workbench.extras.autopilots.programs.px4 import Px4

    _check(args)
    flight = _built(args)
    peer = Px4(args.host, args.port, args.patience)
    return _served(args, flight, peer, f"TCP {args.host}:{args.port}")


def _run_ardupilot(args: argparse.Namespace) -> int:
    from workbench.extras.autopilots.programs.ardupilot import ArduPilot

    _check(args)
    flight = _built(args)
    peer = ArduPilot(args.host, args.port, args.patience, args.pulses)
    return _served(args, flight, peer, f"UDP {args.host}:{args.port}")


def _check(args: argparse.Namespace) -> None:
    """Check the numbers, before anything is built."""
    if not 0 < args.port < 65536:
        raise WorkbenchError(f"--port {args.port}: give it a number from 1 to 65535")
    for name, value in (("patience", args.patience), ("rate", args.rate)):
        if not 0.0 < value < 1e6:
            raise WorkbenchError(f"--{name} {value:g}: give it a positive number")
    if args.duration is not None and not 0.0 < args.duration < 1e6:
        raise WorkbenchError(f"--duration {args.duration:g}: give it a positive time in seconds")


def _built(args: argparse.Namespace) -> "AutopilotFlight":
    """Build the flight."""
    from workbench.common.resources import find_scenario, find_world
    from workbench.extras.autopilots.sitl_flight import AutopilotFlight
    from workbench.scenario.scenario import Scenario, ScenarioStart
    from workbench.scenario.scenario_file import load_scenario

    scenario = Scenario(start=ScenarioStart(mode="off"))
    if args.scenario:
        scenario = load_scenario(find_scenario(args.scenario))
        args.duration = args.duration or scenario.duration
    with_model(scenario, args)
    scenario.world = args.world or scenario.world
    find_world(scenario.world)
    return AutopilotFlight(scenario, args.rate, args.order, noise=not args.no_noise)


def _served(
    args: argparse.Namespace, flight: "AutopilotFlight", peer: "Autopilot", where: str
) -> int:
    """Fly until the end, Ctrl-C, or a failure of the autopilot; return the summary."""
    broken = ""
    with Outputs() as outputs:
        log = outputs.add(args.csv) if args.csv else None
        try:
            print_message(f"waiting for {peer.name} at {where}; Ctrl-C ends it")
            peer.connect()
            print_message(
                f"{peer.name} is connected; {flight.vehicle.name} steps at {args.rate:g} Hz"
            )
            _fly(args, flight, peer)
        except FlightBrokenError as error:
            broken = str(error)
            flight.stop()
        except KeyboardInterrupt:
            if flight.time == 0.0:
                raise
        finally:
            peer.close()
        recording = flight.recording()
        if log:
            recording.write_csv(log)
    end, highest = recording.p_WB[-1].tolist(), float(recording.p_WB[:, 2].max())
    summary = {
        "autopilot": peer.name,
        "vehicle": flight.vehicle.name,
        "duration": flight.time,
        "max_height": highest,
        "end": end,
        "armed": peer.armed,
        "exchange": peer.report(),
        "broken": broken,
    }
    rows = [
        ("duration", f"{flight.time:.3f}", "s"),
        ("max height", f"{highest:.2f}", "m"),
        ("end", " ".join(f"{number:z.2f}" for number in end), "m"),
        *((name, f"{count:.0f}", "") for name, count in peer.report().items()),
    ]
    print_result(args, summary, partial(print_table, rows, left=(0, 2)), files=outputs.files)
    if broken:
        print_message(broken)
        return ExitCode.NOT_AS_DEMANDED
    return ExitCode.DONE


def _fly(args: argparse.Namespace, flight: "AutopilotFlight", peer: "Autopilot") -> None:
    """Exchange motion and outputs, and fly with these, in real time or as fast as possible."""
    from workbench.extras.autopilots.programs.motion import RestartedError

    began, said, armed = time.monotonic(), time.monotonic(), False
    while args.duration is None or flight.time < args.duration:
        outputs: Sequence[float]
        try:
            outputs = peer.exchange(flight.motion())
        except RestartedError:
            print_message(
                f"{peer.name} restarted at {flight.time:.3f} s: the vehicle is reset, too"
            )
            flight.reset()
            began, armed = time.monotonic(), False
            continue
        flight.fly(outputs)
        now = time.monotonic()
        if peer.armed != armed:
            armed = peer.armed
            print_message(
                f"{peer.name} has {'armed' if armed else 'disarmed'} at {flight.time:.3f} s"
            )
        if now > said + SITL_PROGRESS_PERIOD_S:
            said = now
            print_message(
                f"flying: {flight.time:.1f} s, height {-flight.motion().position[2]:.2f} m"
            )
        # without lockstep yet, or in real time, the flight follows the clock of the machine
        ahead = began + flight.time - now
        if ahead > 0.0 and not (args.fast and peer.locked):
            time.sleep(ahead)
        elif ahead < -0.25 or (args.fast and peer.locked):
            began = now - flight.time
