"""`workbench monitor`: a served flight in a terminal, and flying it by keys."""

import argparse
import sys
import time
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.link_options import add_link_options, link_options, parse_rate
from workbench.commands.options import add_command
from workbench.commands.printing import say
from workbench.common.errors import WorkbenchError

if TYPE_CHECKING:
    from workbench.gateways.monitor.picture import Camera
    from workbench.link import Client

PERIOD = 0.5
"""Between two lines, where the output is no terminal [s]."""
PATIENCE = 5.0
SELDOM = 1.0
"""How long a first state is waited for, and what comes more seldom [s]."""


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "monitor",
        "Show a served flight in the terminal, and fly it by keys.",
        "workbench monitor 127.0.0.1:7733 --fly",
        run,
    )
    add_link_options(parser)
    parser.add_argument(
        "--fly", action="store_true", help="take control at the start; ? lists the keys"
    )
    parser.add_argument(
        "--json", action="store_true", help="print an object a line, twice a second"
    )
    parser.add_argument("--once", action="store_true", help="print the present once and stop")
    parser.add_argument(
        "--rate",
        type=parse_rate,
        metavar="N",
        help="at most so many samples a second of each topic (default: all there are)",
    )


def run(args: argparse.Namespace) -> int:
    """Show the flight until Q or Ctrl-C."""
    from workbench.gateways.monitor.picture import Camera
    from workbench.link import Client
    from workbench.link.messages import Role

    full = _is_full(args)
    if args.fly and not full:
        raise WorkbenchError(
            "--fly needs a terminal with a full screen for its keys: leave out --json and --once"
        )
    link = link_options(args, flies=args.fly)
    role = Role.COMMAND if args.fly or not args.token_file else Role.VIEW
    client = Client(
        link.address, name="monitor", token=link.token, role=role, tls=link.tls, rate=args.rate
    )
    with client:
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
        except KeyboardInterrupt:  # a usual end, beside Q
            pass
    return ExitCode.DONE


def _is_full(args: argparse.Namespace) -> bool:
    """Return whether there is a terminal that can show a full screen, and one is wanted."""
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
    """Wait until a first state is there, and a while for what comes more seldom."""
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
