"""Clients of a served flight: `workbench gateway` for other programs, `monitor` for people."""

import argparse
import sys
import time
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.options import add_command, add_json_option, add_option
from workbench.commands.outputs import Outputs
from workbench.commands.printing import print_json_line, say, say_written
from workbench.common.errors import WorkbenchError

if TYPE_CHECKING:
    from workbench.gateways.foxglove import Foxglove
    from workbench.gateways.monitor.picture import Camera
    from workbench.gateways.plotjuggler import PlotJuggler
    from workbench.gateways.running import LinkOptions
    from workbench.link import Client


TO_PLOTJUGGLER = "127.0.0.1:9870"
FOR_FOXGLOVE = "127.0.0.1:8765"
FOR_STATION = "127.0.0.1:14550"
SYSTEM = "system"
PERIOD = 0.5
"""Period between lines if the output is not a terminal [s]."""
PATIENCE = 5.0
SELDOM = 1.0
"""Time limits for a first state, and for less frequent topics [s]."""


def add_parser(commands: Any) -> None:
    """Add the command, and a command of its own for each kind of gateway."""
    from workbench.gateways.ros2_options import add_ros2_options

    parser = add_command(
        commands,
        "gateway",
        "Pass a served flight on to Foxglove, PlotJuggler, ROS 2 or a MAVLink ground station.",
        "workbench gateway plotjuggler 127.0.0.1:7733",
        _run_none,
    )
    kinds = parser.add_subparsers(title="kinds", metavar="KIND")

    foxglove = add_command(
        kinds,
        "foxglove",
        "Serve the topics to the Foxglove app, which opens ws://127.0.0.1:8765; watch only.",
        "workbench gateway foxglove 127.0.0.1:7733",
        _run_foxglove,
    )
    _add_common(foxglove)
    add_option(foxglove, "--listen", "HOST:PORT", "where Foxglove connects to", FOR_FOXGLOVE)
    foxglove.add_argument(
        "--anybody",
        action="store_true",
        help="let it listen on other addresses than this computer's own: anybody who reaches it "
        "may watch, because Foxglove's server has no login and checks no origin",
    )

    plotjuggler = add_command(
        kinds,
        "plotjuggler",
        "Send the topics as JSON over UDP to PlotJuggler's UDP server; watch only.",
        "workbench gateway plotjuggler 127.0.0.1:7733 --topics velocity_data,rotors",
        _run_plotjuggler,
    )
    _add_common(plotjuggler)
    add_option(plotjuggler, "--to", "HOST:PORT", "of PlotJuggler's UDP server", TO_PLOTJUGGLER)

    ros2 = add_command(
        kinds,
        "ros2",
        "Publish the topics to ROS 2, without an installed ROS, and let ROS 2 fly if that is "
        "allowed.",
        "workbench gateway ros2 127.0.0.1:7733 --allow-commands",
        _run_ros2,
    )
    add_link_options(ros2)
    _add_rate(ros2)
    add_ros2_options(ros2)

    mavlink = add_command(
        kinds,
        "mavlink",
        "Show the drone to QGroundControl or another ground station, which may set its gains.",
        "workbench gateway mavlink 127.0.0.1:7733 --allow-commands",
        _run_mavlink,
    )
    add_link_options(mavlink)
    _add_rate(mavlink)
    add_option(
        mavlink, "--to", "HOST:PORT", "where the ground station listens, by UDP", FOR_STATION
    )
    mavlink.add_argument(
        "--allow-commands",
        action="store_true",
        help="let the ground station set parameters, arm, take off, hold and land",
    )


def _add_common(parser: argparse.ArgumentParser) -> None:
    add_link_options(parser)
    parser.add_argument(
        "--topics",
        default="*",
        metavar="NAME[,NAME]",
        help="topics to pass on (default: all)",
    )
    _add_rate(parser)


def _add_rate(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--rate",
        type=parse_rate,
        metavar="N",
        help="at most this many samples a second of each topic (default: all)",
    )
    add_json_option(parser, "print where the topics go as JSON, on one line")


def _run_none(args: argparse.Namespace) -> int:
    raise WorkbenchError(
        "no kind of gateway is named: write foxglove, plotjuggler, ros2 or mavlink, as in "
        "`workbench gateway foxglove`"
    )


def _run_foxglove(args: argparse.Namespace) -> int:
    """Serve Foxglove until Ctrl-C."""
    from workbench.gateways.foxglove import PORT, Foxglove, check_reach
    from workbench.link.address import parse_address

    listen = parse_address(args.listen, port=PORT)
    check_reach(listen, args.anybody)  # before any wait
    with link_options(args, "foxglove").client() as client:
        outlet = Foxglove(client.hello.vehicle, listen, args.anybody)
        say(
            f"{client.hello.vehicle}: open ws://{outlet.address} in Foxglove, as a Foxglove "
            "WebSocket; Ctrl-C ends it"
        )
        if args.json:
            print_json_line({"vehicle": client.hello.vehicle, "address": f"ws://{outlet.address}"})
        _pass_on(client, outlet)
    return ExitCode.DONE


def _run_plotjuggler(args: argparse.Namespace) -> int:
    """Send datagrams until Ctrl-C."""
    from workbench.gateways.plotjuggler import PORT, PlotJuggler
    from workbench.link.address import parse_address

    to = parse_address(args.to, port=PORT)
    with link_options(args, "plotjuggler").client() as client:
        outlet = PlotJuggler(to, say)
        say(
            f"{client.hello.vehicle}: sending to {to}; in PlotJuggler start the UDP server there, "
            "protocol JSON, with its timestamp field; Ctrl-C ends it"
        )
        if args.json:
            print_json_line({"vehicle": client.hello.vehicle, "address": str(to)})
        _pass_on(client, outlet)
    return ExitCode.DONE


def _pass_on(client: "Client", outlet: "Foxglove | PlotJuggler") -> None:
    """Pass all samples on, until Ctrl-C or the end of the client.

    Raises:
        WorkbenchError: if the client ends by itself.
    """
    try:
        outlet.announce(client.hello.topics)
        for sample in client:
            outlet.deliver(sample)
    except KeyboardInterrupt:  # the usual end of a gateway
        return
    finally:
        outlet.close()


def _run_ros2(args: argparse.Namespace) -> int:
    """Publish to ROS 2 until Ctrl-C, or write the package of messages."""
    if args.write_messages is not None:
        from workbench.gateways.ros_messages.library import package_files

        with Outputs() as outputs:
            for path, text in package_files(args.write_messages).items():
                outputs.add(path).write_text(text, encoding="utf-8")
        if args.json:
            print_json_line({"files": outputs.files})
        say_written(outputs.files)
        return ExitCode.DONE
    from workbench.gateways.ros2 import run_ros2
    from workbench.gateways.ros2_options import ros2_options

    link = link_options(args, "ros2", flies=args.allow_commands)
    if args.json:
        print_json_line({"address": link.address})
    run_ros2(link, ros2_options(args), say)
    return ExitCode.DONE


def _run_mavlink(args: argparse.Namespace) -> int:
    """Speak MAVLink until Ctrl-C."""
    from workbench.gateways.mavlink import PORT, run_mavlink
    from workbench.link.address import parse_address

    to = parse_address(args.to, port=PORT)
    link = link_options(args, "mavlink", flies=args.allow_commands)

    def tell(vehicle: str, ids: dict[str, str]) -> None:
        if args.json:
            print_json_line({"vehicle": vehicle, "to": str(to), "parameters": ids})
        short = {name: each for name, each in ids.items() if name != each}
        if short:
            say("names of more than 16 characters are shorter in MAVLink: ")
            for name, each in short.items():
                say(f"  {each:16} {name}")

    run_mavlink(link, to, say, tell)
    return ExitCode.DONE


def add_link_options(parser: argparse.ArgumentParser) -> None:
    """Add options for the address of the server and its trust."""
    parser.add_argument(
        "address",
        nargs="?",
        default="127.0.0.1:7733",
        metavar="HOST:PORT",
        help="of the server (default: 127.0.0.1:7733)",
    )
    parser.add_argument(
        "--token-file",
        default="",
        metavar="FILE",
        help="the server's token file, or its line `view: TOKEN` or `command: TOKEN`; mode 0600",
    )
    parser.add_argument(
        "--tls",
        default="",
        metavar="system|FILE|sha256:HEX",
        help="connect by TLS, and trust the system's authorities, those in a file (PEM), or the "
        "one certificate with this fingerprint",
    )


def link_options(
    args: argparse.Namespace, name: str, flies: bool = False, free: bool = False
) -> "LinkOptions":
    """Return the options of a connection.

    Args:
        args: with what `add_link_options` adds, and the rate.
        name: of the client.
        flies: whether to use the token to command, or that to view.
        free: whether to use the role command, too, if there is no token file.

    Raises:
        WorkbenchError: if the token file or the address is invalid.
    """
    from workbench.gateways.running import LinkOptions
    from workbench.link.address import parse_address
    from workbench.link.authentication import read_token
    from workbench.link.messages import Role

    address = parse_address(args.address)
    wanted = Role.COMMAND if flies else Role.VIEW
    topics = getattr(args, "topics", "*").split(",")
    return LinkOptions(
        address=str(address),
        name=name,
        token=read_token(args.token_file, wanted) if args.token_file else "",
        role=Role.COMMAND if flies or (free and not args.token_file) else Role.VIEW,
        tls=args.tls == SYSTEM or args.tls or None,
        topics=[topic.strip() for topic in topics if topic.strip()],
        rate=args.rate,
    )


def parse_rate(text: str) -> float:
    """Return a rate of samples [1/s].

    Raises:
        WorkbenchError: if it is invalid.
    """
    try:
        return float(text)
    except ValueError:
        raise WorkbenchError(f"the rate '{text}' is not a number of samples a second") from None


def add_monitor(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "monitor",
        "Show a served flight in the terminal, and fly it by keys.",
        "workbench monitor 127.0.0.1:7733 --fly",
        run_monitor,
    )
    add_link_options(parser)
    parser.add_argument(
        "--fly", action="store_true", help="take control at the start; ? lists the keys"
    )
    parser.add_argument(
        "--json", action="store_true", help="print an object a line, twice a second"
    )
    parser.add_argument(
        "--once", action="store_true", help="print the present values once and stop"
    )
    parser.add_argument(
        "--rate",
        type=parse_rate,
        metavar="N",
        help="at most this many samples a second of each topic (default: all)",
    )


def run_monitor(args: argparse.Namespace) -> int:
    """Show the flight until Q or Ctrl-C."""
    from workbench.gateways.monitor.picture import Camera

    full = _is_full(args)
    if args.fly and not full:
        raise WorkbenchError(
            "--fly needs a terminal with a full screen for its keys: leave out --json and --once"
        )
    link = link_options(args, "monitor", flies=args.fly, free=True)
    with link.client() as client:
        camera = Camera(client, link.address)
        try:
            if full:
                _show(client, camera, args.fly)
                return ExitCode.DONE
            _await_state(client)
            if args.once:
                _print(camera, args.json, once=True)
            else:
                _print_on(client, camera, args.json)
        except KeyboardInterrupt:  # a usual end, like Q
            pass
    return ExitCode.DONE


def _is_full(args: argparse.Namespace) -> bool:
    """Return whether a full screen is requested and the terminal supports it."""
    if args.json or args.once or not (sys.stdin.isatty() and sys.stdout.isatty()):
        return False
    try:
        from workbench.gateways.monitor.screen import is_capable
    except ImportError:  # a Python without curses
        return False
    return is_capable()


def _show(client: "Client", camera: "Camera", fly: bool) -> None:
    """Show the full screen until Q is pressed."""
    from workbench.gateways.monitor.pilot import Pilot
    from workbench.gateways.monitor.screen import show

    pilot = Pilot(client)
    if fly:
        pilot.take()
    show(camera, pilot)


def _print_on(client: "Client", camera: "Camera", as_json: bool) -> None:
    """Print a line after another."""
    while True:
        client.raise_failure()
        _print(camera, as_json, once=False)
        time.sleep(PERIOD)


def _print(camera: "Camera", as_json: bool, once: bool) -> None:
    from workbench.gateways.monitor.dashboard import dashboard, one_line
    from workbench.gateways.monitor.picture import as_json as to_json

    picture = camera.picture()
    if as_json:
        print(to_json(picture), flush=True)
    elif once:
        print("\n".join(dashboard(picture)))
    else:
        print(one_line(picture), flush=True)


def _await_state(client: "Client") -> None:
    """Wait for a first state, and for a while for less frequent topics."""
    regular = [topic.name for topic in client.hello.topics if topic.rate > 0.0]
    begin = time.monotonic()
    while True:
        client.raise_failure()
        begun = client.latest("position_data") is not None
        if begun and client.control_state and all(map(client.latest, regular)):
            return
        if time.monotonic() - begin > (SELDOM if begun else PATIENCE):
            if not begun:
                say(f"no state came within {PATIENCE:g} s: is the flight paused?")
            return
        time.sleep(0.02)
