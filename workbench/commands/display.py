"""Whether there is a screen to draw on, and what draws there: asked before Qt is, which ends the
process without.
"""

import socket
from collections.abc import Mapping
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.common.system_libraries import missing_libraries, platform_plugins, remedy

REMEDY = (
    "run it on a desktop, log in with `ssh -X`, or set QT_QPA_PLATFORM=offscreen to run it unseen"
)
PATIENCE = 2.0
"""Time that a display has to answer [s]."""
FIRST_PORT = 6000
"""Of an X server that listens on the network."""


def check_display(environment: Mapping[str, str]) -> None:
    """Refuse to go on where no window can be shown.

    Raises:
        WorkbenchError: saying what to set.
    """
    if environment.get("QT_QPA_PLATFORM"):
        return
    display, wayland = environment.get("DISPLAY", ""), environment.get("WAYLAND_DISPLAY", "")
    if not display and not wayland:
        raise WorkbenchError(f"there is no display (DISPLAY is not set): {REMEDY}")
    folder = Path(environment.get("XDG_RUNTIME_DIR", ""))
    if wayland and (folder / wayland).exists():
        return
    if not display or not answers(display):
        raise WorkbenchError(f"the display '{display or wayland}' does not answer: {REMEDY}")


def check_libraries(environment: Mapping[str, str]) -> None:
    """Refuse to go on where Qt would end the process for want of a library of the system.

    Raises:
        WorkbenchError: naming the libraries and their packages.
    """
    missing = missing_libraries(platform_plugins(environment))
    if missing:
        raise WorkbenchError(
            f"no window can be opened without the system's {', '.join(sorted(missing))}: "
            f"{remedy(missing)}; or set QT_QPA_PLATFORM=offscreen to run it unseen"
        )


def answers(display: str) -> bool:
    """Return whether an X server listens at a display, as :0 or localhost:10.0."""
    host, colon, rest = display.rpartition(":")
    number = rest.split(".")[0]
    if not colon or not number.isdecimal():
        return False
    try:
        if host in ("", "unix"):
            return _reaches(f"/tmp/.X11-unix/X{number}") or _reaches(f"\0/tmp/.X11-unix/X{number}")
        socket.create_connection((host, FIRST_PORT + int(number)), PATIENCE).close()
    except OSError:
        return False
    return True


def _reaches(path: str) -> bool:
    """Return whether somebody listens at a local socket."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as end:
        end.settimeout(PATIENCE)
        return end.connect_ex(path) == 0
