"""`workbench gui`: the app."""

import argparse
import os
import struct
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.commands.options import (
    MODEL_HELP,
    NO_SENSORS,
    Subcommands,
    add_command,
    add_description_options,
    add_estimator_option,
)
from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.optional_package import require_package
from workbench.common.system_libraries import (
    known_platforms,
    library_advice,
    missing_libraries,
    platform_names,
    platform_plugins,
)
from workbench.gui.first_flight import DEFAULT_APP_SCENARIO

if TYPE_CHECKING:
    from workbench.live.choice import Choice

NO_DISPLAY_ADVICE = (
    "run it on a desktop, log in with `ssh -X`, or set QT_QPA_PLATFORM=offscreen to run it unseen"
)
DISPLAY_TIMEOUT_S = 2.0
"""Time limit for the answer of a display [s]."""
X11_BASE_PORT = 6000
"""First port of X servers on the network."""
X11, WAYLAND = "xcb", "wayland"
"""Platforms of Qt that need somebody to answer."""
FIRST_DISPLAY, FIRST_COMPOSITOR = ":0", "wayland-0"
"""Displays of X11 and Wayland unless DISPLAY or WAYLAND_DISPLAY name others."""
WAYLAND_SYNC = struct.pack("=III", 1, 12 << 16, 2)
"""Wayland's request `wl_display.sync`: object, length and opcode, number of the answer."""


def add_parser(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "gui",
        "Open the app: fly, watch, and tune while it flies.",
        "workbench gui --scenario windy --sensors imu,gps --screen tuning",
        run,
    )
    parser.add_argument(
        "--scenario",
        metavar="NAME|PATH",
        help="scenario to fly first (default: the last one set up in Settings, or "
        f"{DEFAULT_APP_SCENARIO}, a drone on the ground between obstacles with IMU, GPS and lidar)",
    )
    parser.add_argument(
        "--model",
        default="",
        metavar="NAME|PATH",
        help=MODEL_HELP,
    )
    add_description_options(parser)
    parser.add_argument(
        "--world", default="", metavar="NAME|PATH", help="shipped world, or its file"
    )
    parser.add_argument(
        "--sensors",
        metavar="NAME[,NAME]",
        help=f"sensors that measure, by name or kind, all, or {NO_SENSORS} (default: the "
        "scenario's)",
    )
    parser.add_argument(
        "--controller",
        default="",
        metavar="NAME|FILE",
        help="shipped control law, or a .py file of your own (default: the scenario's, or pd)",
    )
    add_estimator_option(parser)
    parser.add_argument("--gains", default="", metavar="FILE", help="gain file (YAML)")
    parser.add_argument(
        "--demo",
        action="store_true",
        help="fly a round between obstacles with sensors on, again and again, until somebody else "
        "flies",
    )
    parser.add_argument(
        "--screen",
        default="",
        metavar="NAME",
        help="first screen: start, home, server, joystick, visualization, tuning or settings "
        "(default: the last one shown)",
    )
    parser.add_argument("--no-3d", action="store_true", help="do not draw flights in 3-D")


def run(args: argparse.Namespace) -> int:
    """Check the arguments, then open the window."""
    require_package("PyQt6", "the app's windows")
    from workbench.gui.screen_table import find_screen

    named = (
        args.scenario,
        args.model,
        args.world,
        args.gains,
        args.sensors,
        args.controller,
        args.estimator,
    )
    described = args.arg or args.package
    choice = (
        _choice(args)
        if described or args.demo or any(each not in (None, "") for each in named)
        else None
    )
    if choice:
        choice.check()
    if args.screen:
        find_screen(args.screen)
    check_display(os.environ)
    check_libraries(os.environ)

    from workbench.gui.app import run as run_app

    return run_app(choice, screen=args.screen, view3d=not args.no_3d, demo=args.demo)


def _choice(args: argparse.Namespace) -> "Choice":
    """Return the first scenario."""
    from workbench.live.choice import Choice

    if args.demo and args.scenario:
        raise WorkbenchError("--demo and --scenario both say what to fly: give one of them")
    scenario = args.scenario or DEFAULT_APP_SCENARIO
    sensors = None
    if args.sensors is not None:
        names = [name.strip() for name in args.sensors.split(",")]
        sensors = tuple(name for name in names if name not in ("", NO_SENSORS))
    elif args.model:
        sensors = ("all",)  # those of another drone may have other names
    return Choice(
        scenario,
        args.model,
        args.world,
        args.gains,
        sensors,
        dict(args.arg),
        dict(args.package),
        args.controller,
        args.estimator,
    )


def check_display(environment: Mapping[str, str]) -> None:
    """Check that a window can be shown; Qt would end the process.

    Raises:
        WorkbenchError: that says what to set.
    """
    if sys.platform == "darwin":  # its screen needs no name
        return
    asked = environment.get("QT_QPA_PLATFORM", "")
    display, wayland = environment.get("DISPLAY", ""), environment.get("WAYLAND_DISPLAY", "")
    if not asked and not display and not wayland:
        raise WorkbenchError(f"there is no display (DISPLAY is not set): {NO_DISPLAY_ADVICE}")
    screens = [name.partition("-")[0] for name in platform_names(environment)]
    known = known_platforms()
    for name in screens if known else ():
        if name not in known:
            raise WorkbenchError(
                f"QT_QPA_PLATFORM: {unknown_name('platform of Qt', name, known)}; "
                f"{NO_DISPLAY_ADVICE}"
            )
    for name in screens:
        if name not in (X11, WAYLAND):
            return
        if x_server_listens(display) if name == X11 else compositor_listens(environment):
            return
    where = {X11: display or FIRST_DISPLAY, WAYLAND: wayland or FIRST_COMPOSITOR}
    tried = " or ".join(f"'{where[name]}'" for name in dict.fromkeys(screens))
    raise WorkbenchError(f"the display {tried} does not answer: {NO_DISPLAY_ADVICE}")


def check_libraries(environment: Mapping[str, str]) -> None:
    """Check the system libraries without which Qt would end the process.

    Raises:
        WorkbenchError: with the missing libraries and their packages.
    """
    missing = missing_libraries(platform_plugins(environment))
    if missing:
        raise WorkbenchError(
            f"no window can be opened without the system's {', '.join(sorted(missing))}: "
            f"{library_advice(missing)}; or set QT_QPA_PLATFORM=offscreen to run it unseen"
        )


def x_server_listens(display: str) -> bool:
    """Return whether an X server listens at a display such as :0 or localhost:10.0."""
    import socket  # other commands do not need it

    host, colon, rest = display.rpartition(":")
    number = rest.split(".")[0]
    if not colon or not number.isdecimal():
        return False
    try:
        if host in ("", "unix"):
            return _reaches(f"/tmp/.X11-unix/X{number}") or _reaches(f"\0/tmp/.X11-unix/X{number}")
        socket.create_connection((host, X11_BASE_PORT + int(number)), DISPLAY_TIMEOUT_S).close()
    except OSError:
        return False
    return True


def compositor_listens(environment: Mapping[str, str]) -> bool:
    """Return whether a Wayland compositor answers."""
    import socket

    if environment.get("WAYLAND_SOCKET"):  # it has started this program
        return True
    name = environment.get("WAYLAND_DISPLAY") or FIRST_COMPOSITOR
    path = Path(environment.get("XDG_RUNTIME_DIR", "")) / name
    try:
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as end:
            end.settimeout(DISPLAY_TIMEOUT_S)
            end.connect(str(path))
            end.sendall(WAYLAND_SYNC)
            return bool(end.recv(1))
    except OSError:
        return False


def _reaches(path: str) -> bool:
    """Return whether a program listens at a local socket."""
    import socket

    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as end:
        end.settimeout(DISPLAY_TIMEOUT_S)
        return end.connect_ex(path) == 0
