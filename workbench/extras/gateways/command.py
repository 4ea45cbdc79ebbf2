"""`workbench gateway`: pass a served flight on to other programs."""

import argparse
from typing import TYPE_CHECKING

from workbench.commands import ExitCode
from workbench.commands.options import Subcommands, add_command, add_json_option, add_option
from workbench.commands.outputs import Outputs
from workbench.commands.printing import print_json_line, print_message, print_written_files
from workbench.common.errors import WorkbenchError

if TYPE_CHECKING:
    from workbench.extras.gateways.foxglove import Foxglove
    from workbench.extras.gateways.plotjuggler import PlotJuggler
    from workbench.extras.gateways.running import LinkOptions
    from workbench.link import Client


PLOTJUGGLER_ADDRESS = "127.0.0.1:9870"
FOXGLOVE_ADDRESS = "127.0.0.1:8765"
GROUND_STATION_ADDRESSES = ("127.0.0.1:14550", "127.0.0.1:14540")
"""Where ground stations listen, and programs that fly (MAVSDK), as with PX4's simulator."""
SYSTEM_CERTIFICATES = "system"


def add_parser(commands: Subcommands) -> None:
    """Add the command, and a command of its own for each kind of gateway."""
    from workbench.extras.gateways.ros2_options import add_ros2_options

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
    add_option(foxglove, "--listen", "HOST:PORT", "where Foxglove connects to", FOXGLOVE_ADDRESS)
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
    add_option(plotjuggler, "--to", "HOST:PORT", "of PlotJuggler's UDP server", PLOTJUGGLER_ADDRESS)

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
        "Show the drone to QGroundControl or another ground station, which may fly it if that is "
        "allowed.",
        "workbench gateway mavlink 127.0.0.1:7733 --allow-commands",
        _run_mavlink,
    )
    add_link_options(mavlink)
    _add_rate(mavlink)
    mavlink.add_argument(
        "--to",
        action="append",
        metavar="HOST:PORT",
        help="where a ground station listens, by UDP; may be repeated (default: "
        f"{' and '.join(GROUND_STATION_ADDRESSES)})",
    )
    mavlink.add_argument(
        "--allow-commands",
        action="store_true",
        help="let ground stations set parameters, arm, take off, hold, land and fly missions",
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
    from workbench.extras.gateways.foxglove import FOXGLOVE_PORT, Foxglove, check_reach
    from workbench.link.address import parse_address

    listen = parse_address(args.listen, port=FOXGLOVE_PORT)
    check_reach(listen, args.anybody)  # before any wait
    with link_options(args, "foxglove").client() as client:
        outlet = Foxglove(client.hello.vehicle, listen, args.anybody)
        print_message(
            f"{client.hello.vehicle}: open ws://{outlet.address} in Foxglove, as a Foxglove "
            "WebSocket; Ctrl-C ends it"
        )
        if args.json:
            print_json_line({"vehicle": client.hello.vehicle, "address": f"ws://{outlet.address}"})
        _pass_on(client, outlet)
    return ExitCode.DONE


def _run_plotjuggler(args: argparse.Namespace) -> int:
    """Send datagrams until Ctrl-C."""
    from workbench.extras.gateways.plotjuggler import PLOTJUGGLER_PORT, PlotJuggler
    from workbench.link.address import parse_address

    to = parse_address(args.to, port=PLOTJUGGLER_PORT)
    with link_options(args, "plotjuggler").client() as client:
        outlet = PlotJuggler(to, print_message)
        print_message(
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
        from workbench.link.ros_messages.library import package_files

        with Outputs() as outputs:
            for path, text in package_files(args.write_messages).items():
                outputs.add(path).write_text(text, encoding="utf-8")
        if args.json:
            print_json_line({"files": outputs.files})
        print_written_files(outputs.files)
        return ExitCode.DONE
    from workbench.extras.gateways.ros2 import run_ros2
    from workbench.extras.gateways.ros2_options import ros2_options

    link = link_options(args, "ros2", flies=args.allow_commands)
    if args.json:
        print_json_line({"address": link.address})
    run_ros2(link, ros2_options(args), print_message)
    return ExitCode.DONE


def _run_mavlink(args: argparse.Namespace) -> int:
    """Speak MAVLink until Ctrl-C."""
    from workbench.extras.gateways.mavlink import MAVLINK_PORT, run_mavlink
    from workbench.link.address import parse_address

    to = [parse_address(each, port=MAVLINK_PORT) for each in args.to or GROUND_STATION_ADDRESSES]
    link = link_options(args, "mavlink", flies=args.allow_commands)

    def tell(vehicle: str, ids: dict[str, str]) -> None:
        if args.json:
            addresses = {"to": str(to[0]), "stations": [str(each) for each in to]}
            print_json_line({"vehicle": vehicle, **addresses, "parameters": ids})
        short = {name: each for name, each in ids.items() if name != each}
        if short:
            print_message("names of more than 16 characters are shorter in MAVLink: ")
            for name, each in short.items():
                print_message(f"  {each:16} {name}")

    run_mavlink(link, to, print_message, tell)
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


def link_options(args: argparse.Namespace, name: str, flies: bool = False) -> "LinkOptions":
    """Return the options of a connection.

    Args:
        args: with what `add_link_options` adds, and the rate.
        name: of the client.
        flies: whether to use the token to command, or that to view.

    Raises:
        WorkbenchError: if the token file or the address is invalid.
    """
    from workbench.extras.gateways.running import LinkOptions
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
        role=wanted,
        tls=args.tls == SYSTEM_CERTIFICATES or args.tls or None,
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
