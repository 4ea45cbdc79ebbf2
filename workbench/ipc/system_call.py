"""Make system calls, which fail as errors of the sandbox."""

import ctypes
import os
import platform
import sys
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Architecture:
    """Numbers of an architecture (linux/audit.h, asm/unistd.h).

    Attributes:
        audit: its identifier in a filter.
        column: its column in the tables of system calls.
        newest: highest number of a system call in Linux 6.0; newer ones are unknown here.
    """

    audit: int
    column: int
    newest: int = 450


_ARCHITECTURES = {"x86_64": Architecture(0xC000003E, 0), "aarch64": Architecture(0xC00000B7, 1)}
SyscallNumbers = tuple[int | None, int | None]
"""Numbers of a system call on x86_64 and aarch64, None where there is none."""


class SandboxError(OSError):
    """The kernel offers its limits, and did not apply them."""


def system_call(number: int, *arguments: Any) -> int:
    """Make a system call; return -1 on failure."""
    libc = ctypes.CDLL(None, use_errno=True)
    libc.syscall.restype = ctypes.c_long
    given = (ctypes.c_long(each) if isinstance(each, int) else each for each in arguments)
    return int(libc.syscall(ctypes.c_long(number), *given))


def checked_call(result: int, what: str) -> int:
    """Return the result of a system call; `what` names it in the error if it failed."""
    if result < 0:
        number = ctypes.get_errno()
        raise SandboxError(number, f"{what}: {os.strerror(number)}")
    return result


def own_architecture() -> Architecture | None:
    """Return that of this process, None if it is unknown here."""
    known = sys.platform == "linux" and sys.maxsize > 2**32 and sys.byteorder == "little"
    return _ARCHITECTURES.get(platform.machine()) if known else None
