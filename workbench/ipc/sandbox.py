"""The kernel's limits for a process that reads untrusted data: Landlock and seccomp.

Landlock bounds the files that the process can open, seccomp its system calls. Neither can be undone
by the process, and neither needs a privilege. A fault in a parser, even one that runs machine
code, can then only compute, read the named files, and write its answer.

The filter of seccomp lists what is allowed, as new kernels add system calls. A call outside the
list fails with EPERM, so Python raises PermissionError. Calls that are newer than the list, and
those whose arguments are in memory that a filter cannot read, fail with ENOSYS: the C library then
uses an older one. A call of another architecture or of the x32 ABI ends the process.
"""

import ctypes
import errno
import os
import struct
import sys
import sysconfig
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from workbench.ipc.call_filter import has_seccomp, restrict_calls
from workbench.ipc.system_call import SandboxError, checked_call, own_architecture, system_call

MIN_LANDLOCK_ABI = 3
"""ABI of Linux 6.2, the first that also holds back truncation."""


_CREATE_RULESET = 444
_ADD_RULE = 445
_RESTRICT_SELF = 446
"""System calls of Landlock, on all architectures."""


_SET_NO_NEW_PRIVILEGES = 38

# linux/landlock.h
_READ_FILE = 1 << 2
_READ_DIR = 1 << 3
_WRITE_FILE = 1 << 1
_TRUNCATE = 1 << 14
_CHANGE_FOLDER = 1 << 4 | 1 << 5 | 1 << 7 | 1 << 8
"""Remove folders and files, make folders and plain files."""
_RIGHTS = {1: 13, 2: 14, 3: 15, 4: 15, 5: 16}
"""Number of rights to files by ABI; those that are not granted are denied."""
_ALL_NETWORK = 3
_ALL_SCOPES = 3
_PATH_BENEATH = 1

_SYSTEM_PATHS = (
    "/lib",
    "/lib64",
    "/usr/lib",
    "/usr/lib64",
    "/usr/local/lib",
    "/usr/share/zoneinfo",
    "/etc/ld.so.cache",
    "/etc/localtime",
    "/etc/mime.types",
    "/proc/cpuinfo",
    "/proc/meminfo",
    "/proc/stat",
    "/proc/self/maps",
    "/sys/devices/system/cpu",
    "/dev/null",
    "/dev/urandom",
    "/dev/zero",
)
"""What the C library and numerical libraries read."""


def missing_protections() -> tuple[str, ...]:
    """Return which of seccomp and Landlock this kernel lacks, or has in too old a version."""
    found = []
    if not has_seccomp():
        found.append("seccomp filters")
    if _landlock_version() < MIN_LANDLOCK_ABI:
        found.append(f"Landlock of ABI {MIN_LANDLOCK_ABI} (Linux 6.2)")
    return tuple(found)


def confine(reads: Iterable[str], writes: Sequence[str]) -> None:
    """Bound what this process can do from now on, as far as the kernel can.

    It starts no program and no other process, has no network, sends no signal to others, and opens
    only files that are named here or needed by Python. It keeps the files that are open.

    Args:
        reads: files, and folders with all that is below them; missing ones are ignored.
        writes: folders in which it may also make, change and delete files.

    Raises:
        SandboxError: if the kernel refuses, or if a second thread runs, which Landlock would not
            bind.
    """
    version = _landlock_version()
    if not version and not has_seccomp():
        return
    if _threads() > 1:
        raise SandboxError(errno.EBUSY, "a second thread runs already")
    libc = ctypes.CDLL(None, use_errno=True)
    checked_call(libc.prctl(_SET_NO_NEW_PRIVILEGES, *map(ctypes.c_ulong, (1, 0, 0, 0))), "prctl")
    if version:
        _restrict_files(version, [*_python_paths(), *reads], writes)
    if has_seccomp():
        restrict_calls(may_write=bool(writes))


def _landlock_version() -> int:
    """Return the ABI of Landlock, 0 if the kernel has none or has it switched off."""
    if own_architecture() is None:
        return 0
    return max(0, system_call(_CREATE_RULESET, None, 0, 1))


def _threads() -> int:
    try:
        return len(list(Path("/proc/self/task").iterdir()))
    except OSError:  # no /proc, or another system
        return 1


def _python_paths() -> Iterator[str]:
    """Yield what Python and its packages read while they run."""
    home = Path(os.path.expanduser("~"))  # noqa: PTH111 - raises nothing without a home
    packages = [*sys.path, *(sysconfig.get_path(name) for name in ("stdlib", "platstdlib"))]
    for folder in dict.fromkeys(packages):
        if folder and not home.is_relative_to(folder):  # a path to code, not to all of a user
            yield folder
    yield str(Path(sys.base_prefix) / "lib")
    yield from _SYSTEM_PATHS


def _restrict_files(version: int, reads: Iterable[str], writes: Iterable[str]) -> None:
    """Deny all access to files but that to some paths, see `confine`."""
    rights = (1 << _RIGHTS.get(version, _RIGHTS[max(_RIGHTS)])) - 1
    fields = [rights]
    fields += [_ALL_NETWORK] if version >= 4 else []
    fields += [_ALL_SCOPES] if version >= 6 else []
    attributes = struct.pack(f"={len(fields)}Q", *fields)
    ruleset = checked_call(system_call(_CREATE_RULESET, attributes, len(attributes), 0), "Landlock")
    try:
        of_files = _READ_FILE | _WRITE_FILE | _TRUNCATE
        for granted, paths in (
            (_READ_FILE | _READ_DIR, reads),
            (of_files | _READ_DIR | _CHANGE_FOLDER, writes),
        ):
            for path in paths:
                _grant(ruleset, path, granted & rights, of_files)
        checked_call(system_call(_RESTRICT_SELF, ruleset, 0), "Landlock")
    finally:
        os.close(ruleset)


def _grant(ruleset: int, path: str, rights: int, of_files: int) -> None:
    try:
        handle = os.open(path, os.O_PATH | os.O_CLOEXEC)
    except (OSError, ValueError):  # missing, or no path at all
        return
    try:
        allowed = rights if os.path.isdir(handle) else rights & of_files  # noqa: PTH112 - a handle
        rule = struct.pack("=Qi", allowed, handle)
        checked_call(system_call(_ADD_RULE, ruleset, _PATH_BENEATH, rule, 0), f"Landlock: {path}")
    finally:
        os.close(handle)
