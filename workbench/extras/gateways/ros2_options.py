"""Options of the gateway to ROS 2 from the command line, checked before it starts."""

import argparse
import os
import socket
from dataclasses import dataclass
from ipaddress import ip_address
from pathlib import Path
from urllib.parse import unquote

from workbench.common.errors import WorkbenchError
from workbench.common.resources import find_file
from workbench.link.ros_messages.namespace import ros_namespace

LOOPBACK_INTERFACE = "lo"
MAX_DDS_DOMAIN = 232
"""Largest DDS domain; higher ones have no valid ports."""


@dataclass(frozen=True)
class Ros2Options:
    """The options of the ROS 2 gateway.

    Attributes:
        domain: number of the DDS domain; None for ROS_DOMAIN_ID, or 0.
        interface: name or address of the network interface; "lo" for this computer alone.
        configuration: of Cyclone DDS, text or file:// address; replaces the interface.
        allow_commands: whether ROS 2 programs may fly.
        namespace: of the drone's topics; "" for the name of the vehicle.
    """

    domain: int | None = None
    interface: str = LOOPBACK_INTERFACE
    configuration: str = ""
    allow_commands: bool = False
    namespace: str = ""

    def check(self) -> None:
        """Check that options are valid, and that not anybody in the network can fly.

        Raises:
            WorkbenchError: if an option is invalid.
        """
        domain_number(self.domain)
        possible = "/".join(map(ros_namespace, self.namespace.split("/")))  # as fleet/drone_1
        if self.namespace and possible != self.namespace:
            raise WorkbenchError(
                f"--namespace {self.namespace[:40]!r} is not a name in ROS 2: write letters, "
                f"digits and underscores, such as {possible[:40]}"
            )
        if self.allow_commands and (self.interface != LOOPBACK_INTERFACE or self.configuration):
            raise WorkbenchError(
                "commands are taken on this computer only, as DDS has no login: leave out "
                "--interface and --config, and run this gateway on the computer that flies; it "
                "reaches a server elsewhere with --token-file and --tls"
            )
        if not _is_interface(self.interface):
            raise WorkbenchError(
                f"--interface {self.interface[:40]}: no network interface here has this name: "
                f"write one of {', '.join(interface_names())}, or an address of this computer"
            )


def interface_names() -> list[str]:
    """Return the names of the network interfaces of this machine."""
    return [name for _, name in socket.if_nameindex()]


def _is_interface(interface: str) -> bool:
    """Return whether a network interface has this name, or it is an address."""
    if interface in interface_names():
        return True
    try:
        ip_address(interface)
    except ValueError:
        return False
    return True


def domain_number(asked: int | None) -> int:
    """Return the number of the domain: the requested one, else ROS_DOMAIN_ID, else 0.

    Raises:
        WorkbenchError: if it is invalid.
    """
    text = os.environ.get("ROS_DOMAIN_ID", "").strip() or "0" if asked is None else str(asked)
    where = "ROS_DOMAIN_ID" if asked is None else "--domain"
    if not (text.isascii() and text.isdigit() and int(text[:9]) <= MAX_DDS_DOMAIN):
        raise WorkbenchError(
            f"{where} is '{text[:20]}': the number of a domain is 0 to {MAX_DDS_DOMAIN}"
        )
    return int(text)


def add_ros2_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of only this gateway."""
    parser.add_argument(
        "--domain",
        type=int,
        metavar="N",
        help="DDS domain (default: the environment's ROS_DOMAIN_ID, or 0)",
    )
    parser.add_argument(
        "--allow-commands",
        action="store_true",
        help="let ROS 2 programs on this computer fly, set parameters and call services",
    )
    parser.add_argument(
        "--namespace",
        default="",
        metavar="NAME",
        help="of the topics (default: the name of the vehicle, as /dh_drone)",
    )
    parser.add_argument(
        "--interface",
        default=LOOPBACK_INTERFACE,
        metavar="NAME|ADDRESS",
        help="publish to this network; without it to this computer alone",
    )
    parser.add_argument(
        "--config",
        default="",
        metavar="FILE|XML",
        help="configuration of Cyclone DDS instead, as its CYCLONEDDS_URI, which is not read",
    )
    parser.add_argument(
        "--write-messages",
        type=Path,
        metavar="DIR",
        help="write the package dh_drone_msgs there, to be built with colcon, and stop",
    )


def ros2_options(args: argparse.Namespace) -> Ros2Options:
    """Return the options for a command line, to which `add_ros2_options` added them.

    Raises:
        WorkbenchError: if an option is invalid.
    """
    configuration = _configuration(args.config)
    options = Ros2Options(
        args.domain,
        args.interface,
        configuration,
        args.allow_commands,
        args.namespace.strip("/"),
    )
    options.check()
    return options


def _configuration(said: str) -> str:
    """Return the configuration for Cyclone: XML unchanged, a file as its address."""
    if not said or said.lstrip().startswith("<"):
        return said
    return find_file(unquote(said.removeprefix("file://"))).as_uri()
