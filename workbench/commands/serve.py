"""Serve a flight for others to watch and fly: `workbench serve`, and `tokens` for access."""

import argparse
import sys
import threading
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.commands import ExitCode
from workbench.commands.chosen_vehicle import chosen_scenario, with_sensors
from workbench.commands.options import (
    Subcommands,
    add_command,
    add_json_option,
    add_sensor_options,
    add_vehicle_options,
)
from workbench.commands.outputs import make_folder_of
from workbench.commands.printing import print_json, print_json_line, print_message, terminal
from workbench.commands.stopping import stop_event_on_signal
from workbench.common.errors import WorkbenchError
from workbench.link.address import DEFAULT_PORT, LOOPBACK_HOST
from workbench.link.authority import NO_HOLDER_YET

if TYPE_CHECKING:
    from concurrent.futures import Future

    from workbench.link.server.config import ServerConfig
    from workbench.live.flight import LiveFlight
    from workbench.live.view import LiveView
    from workbench.scenario.scenario import Scenario


SERVER_SCENARIO = "network"
SERVER_START_TIMEOUT_S = 30.0
"""Time limit for the server to listen [s]."""
FLIGHT_CHECK_PERIOD_S = 0.2
"""Period between checks of the flight [s]."""


def add_parser(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "serve",
        "Fly in real time and let others watch and fly, over TCP and in a browser; Ctrl-C ends it.",
        "workbench serve --web --log flight.mcap",
        run,
    )
    parser.add_argument(
        "--scenario",
        default=SERVER_SCENARIO,
        metavar="NAME|FILE",
        help=f"scenario to fly; the flight continues after its end (default: {SERVER_SCENARIO}, "
        "a drone on the ground with IMU, GPS and lidar)",
    )
    parser.add_argument(
        "--duration", type=_positive, metavar="T", help="end after this simulated time [s]"
    )
    parser.add_argument(
        "--log", type=Path, metavar="FILE.mcap", help="record a log, see docs/logs.md"
    )
    parser.add_argument("--draw", action="store_true", help="draw the flight in Meshcat")
    group = parser.add_argument_group("network")
    group.add_argument(
        "--host",
        default=LOOPBACK_HOST,
        help=f"where to listen (default: {LOOPBACK_HOST}, this machine only; 0.0.0.0 for all "
        "networks needs --token-file, --tls-cert and --tls-key)",
    )
    group.add_argument(
        "--port",
        type=int,
        default=DEFAULT_PORT,
        help=f"of TCP; 0 takes a free one (default: {DEFAULT_PORT})",
    )
    group.add_argument(
        "--token-file",
        default="",
        metavar="FILE",
        help="tokens to watch and to command; `workbench tokens FILE` makes them",
    )
    group.add_argument("--tls-cert", default="", metavar="FILE", help="certificate (PEM) for TLS")
    group.add_argument("--tls-key", default="", metavar="FILE", help="its private key (PEM)")
    group.add_argument("--watch-only", action="store_true", help="let nobody command")
    group.add_argument("--web", action="store_true", help="serve the page for phones and browsers")
    group.add_argument(
        "--web-port", type=int, default=0, metavar="PORT", help="of the page (default: a free one)"
    )
    add_vehicle_options(parser)
    add_sensor_options(parser)
    add_json_option(parser, "print its addresses as JSON, on one line")


def run(args: argparse.Namespace) -> int:
    """Fly and serve until the end of the duration, or until the user stops it."""
    from workbench.live.flight import LiveFlight

    config = _config(args)
    config.check()
    scenario = _scenario(args)
    if args.log:
        make_folder_of(args.log)
    with (
        stop_event_on_signal() as stopped,
        LiveFlight(scenario, dict(args.set), draw=args.draw) as flight,
    ):
        view = flight.wait(progress=print_message)
        for remark in view.remarks:
            print_message(remark)
        address = _accepted_answer(flight.serve(config), "the server listens")
        if args.log:
            print_message(
                f"logging to {_accepted_answer(flight.keep_log(args.log), 'the log is begun')}"
            )
        assert view.vehicle
        if args.json:
            print_json_line(_addresses(flight, view.vehicle.name, address))
        else:
            print(f"serving {view.vehicle.name} at {address}", flush=True)
        if view.url:
            print_message(f"drawn at {view.url}")
        if config.web:
            _print_page_address(flight)
        code = _watch(flight, args.duration, stopped)
        if args.log:
            flight.stop_log().result()  # a long log takes time to finish: no time limit
            if lost := flight.latest().network.log_said:
                print_message(lost)
                return ExitCode.NOT_AS_DEMANDED
        return code


def _config(args: argparse.Namespace) -> "ServerConfig":
    from workbench.link.server.config import ServerConfig

    return ServerConfig(
        host=args.host,
        port=args.port,
        token_file=args.token_file,
        tls_cert=args.tls_cert,
        tls_key=args.tls_key,
        allow_commands=not args.watch_only,
        web=args.web,
        web_port=args.web_port,
    )


def _scenario(args: argparse.Namespace) -> "Scenario":
    """Return the scenario."""
    from workbench.common.resources import find_scenario
    from workbench.scenario.scenario_file import load_scenario, without_arrays

    scenario = load_scenario(find_scenario(args.scenario), args.controller, args.estimator)
    scenario = chosen_scenario(args, scenario)
    if args.model and args.scenario == SERVER_SCENARIO and args.sensors is None:
        scenario.sensors.use = []  # those of another drone may have other names, or not be there
        print_message("no sensor is switched on: name them, as in `--sensors imu,gps,lidar`")
    return without_arrays(with_sensors(scenario, args))  # no client gets arrays


def _accepted_answer(answer: "Future[str]", what: str) -> str:
    """Return an answer of the flight.

    Raises:
        WorkbenchError: if it is a rejection, or does not come.
    """
    try:
        return answer.result(SERVER_START_TIMEOUT_S)
    except TimeoutError as error:
        raise WorkbenchError(
            f"more than {SERVER_START_TIMEOUT_S:g} s passed before {what}: try again"
        ) from error


def _addresses(flight: "LiveFlight", vehicle: str, address: str) -> dict[str, str | None]:
    """Return the addresses of the served flight for JSON; None for those not served."""
    view = flight.latest()
    page = view.network.server.page if view.network.server else ""
    return {"vehicle": vehicle, "address": address, "page": page or None, "drawn": view.url or None}


def _print_page_address(flight: "LiveFlight") -> None:
    """Print the address of the page, on a terminal also as a QR code."""
    from workbench.link.page_address import is_page_reachable
    from workbench.link.qr import terminal_code

    server = flight.latest().network.server
    assert server
    who = "a phone in the same network can open it"
    if not is_page_reachable(server.page):
        who = (
            "only this machine can open it: for a phone, listen at 0.0.0.0 with a token file and a "
            "certificate"
        )
    print_message(f"page for phones and browsers: {server.page} ({who})")
    if sys.stderr.isatty():
        print(terminal_code(server.page), file=terminal())


def _watch(flight: "LiveFlight", duration: float | None, stopped: threading.Event) -> int:
    """Report events until the end."""
    from workbench.live.messages import Phase

    told: tuple[str, ...] = ()
    who, ended, lost, autopilot = NO_HOLDER_YET, "", "", ""
    while not stopped.wait(FLIGHT_CHECK_PERIOD_S):
        view = flight.latest()
        if view.phase is Phase.ENDED:
            raise WorkbenchError(view.said)
        network = view.network
        if network.server is None and network.said and not network.starts_again:
            raise WorkbenchError(network.said)
        if view.phase is Phase.BROKEN:
            print_message(f"{view.said}; the server stops")
            return ExitCode.NOT_AS_DEMANDED
        if view.autopilot and view.autopilot.ended != autopilot:
            autopilot = view.autopilot.ended
            print_message(autopilot)
        ended = _print_server_state(view, ended)
        if view.network.log_said != lost:
            lost = view.network.log_said
            print_message(lost)
        told = _print_refusals(view, told)
        who = _print_control(view, who)
        if duration is not None and view.snapshot and view.snapshot.time >= duration:
            break
    return ExitCode.NOT_AS_DEMANDED if autopilot else ExitCode.DONE


def _print_server_state(view: "LiveView", before: str) -> str:
    """Report that the server has ended and is restarted, or listens; return the message."""
    network = view.network
    if network.server is None:
        if network.said and network.said != before:
            print_message(network.said)
        return network.said or before
    if before:
        print_message(f"serving again at {network.server.address}")
    return ""


def _print_refusals(view: "LiveView", told: tuple[str, ...]) -> tuple[str, ...]:
    """Report rejections since the last call."""
    log = view.network.server.log if view.network.server else told
    for sentence in log:
        if sentence not in told:
            print_message(f"refused: {sentence}")
    return log


def _print_control(view: "LiveView", before: str) -> str:
    """Report changes of control."""
    reason = view.network.control.reason if view.network.control else before
    if reason != before:
        print_message(reason)
    return reason


def _positive(text: str) -> float:
    number = float(text)
    if not number > 0.0:
        raise argparse.ArgumentTypeError(f"{text} is not a positive number")
    return number


def add_tokens(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "tokens",
        "Make a file of two tokens, to watch and to command; only its owner can read it.",
        "workbench tokens tokens.txt",
        run_tokens,
    )
    parser.add_argument(
        "file", type=Path, metavar="FILE", help="file to make; an existing one is never overwritten"
    )
    add_json_option(parser)


def run_tokens(args: argparse.Namespace) -> int:
    """Write the file."""
    from workbench.link.authentication import write_tokens

    write_tokens(args.file)
    if args.json:
        print_json({"files": [args.file]})
    print_message(
        f"wrote {args.file}: give others the token of a line, and keep the file to yourself"
    )
    return ExitCode.DONE
