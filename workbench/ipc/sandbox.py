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
import platform
import struct
import sys
import sysconfig
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

OLDEST_LANDLOCK = 3
"""ABI of Linux 6.2, the first that also holds back truncation."""


@dataclass(frozen=True)
class _Architecture:
    """Numbers of an architecture (linux/audit.h, asm/unistd.h).

    Attributes:
        audit: its identifier in a filter.
        column: its column in the tables of system calls.
        newest: highest number of a system call in Linux 6.0; newer ones are unknown here.
    """

    audit: int
    column: int
    newest: int = 450


_ARCHITECTURES = {"x86_64": _Architecture(0xC000003E, 0), "aarch64": _Architecture(0xC00000B7, 1)}
_X32 = 0x40000000
"""Bit of the numbers of the x32 ABI."""

Numbers = tuple[int | None, int | None]
"""Numbers of a system call on x86_64 and aarch64, None where there is none."""

_ALLOWED: dict[str, Numbers] = {
    # open files and folders
    "read": (0, 63),
    "write": (1, 64),
    "readv": (19, 65),
    "writev": (20, 66),
    "pread64": (17, 67),
    "pwrite64": (18, 68),
    "preadv": (295, 69),
    "pwritev": (296, 70),
    "lseek": (8, 62),
    "close": (3, 57),
    "close_range": (436, 436),
    "fstat": (5, 80),
    "getdents": (78, None),
    "getdents64": (217, 61),
    "dup": (32, 23),
    "dup2": (33, None),
    "dup3": (292, 24),
    "pipe": (22, None),
    "pipe2": (293, 59),
    "poll": (7, None),
    "ppoll": (271, 73),
    "select": (23, None),
    "pselect6": (270, 72),
    "sendfile": (40, 71),
    "copy_file_range": (326, 285),
    "ftruncate": (77, 46),
    "fallocate": (285, 47),
    "fsync": (74, 82),
    "fdatasync": (75, 83),
    "fadvise64": (221, 223),
    "flock": (73, 32),
    "fstatfs": (138, 44),
    # names of files; Landlock lets them be seen, and not opened
    "newfstatat": (262, 79),
    "stat": (4, None),
    "lstat": (6, None),
    "statx": (332, 291),
    "statfs": (137, 43),
    "access": (21, None),
    "faccessat": (269, 48),
    "faccessat2": (439, 439),
    "readlink": (89, None),
    "readlinkat": (267, 78),
    "getcwd": (79, 17),
    "chdir": (80, 49),
    "fchdir": (81, 50),
    "umask": (95, 166),
    # memory
    "mmap": (9, 222),
    "munmap": (11, 215),
    "mremap": (25, 216),
    "mprotect": (10, 226),
    "madvise": (28, 233),
    "brk": (12, 214),
    "msync": (26, 227),
    "mincore": (27, 232),
    "membarrier": (324, 283),
    "get_mempolicy": (239, 236),
    # threads, and the process itself
    "futex": (202, 98),
    "set_robust_list": (273, 99),
    "get_robust_list": (274, 100),
    "rseq": (334, 293),
    "set_tid_address": (218, 96),
    "arch_prctl": (158, None),
    "gettid": (186, 178),
    "getpid": (39, 172),
    "getppid": (110, 173),
    "getpgrp": (111, None),
    "getpgid": (121, 155),
    "getsid": (124, 156),
    "getuid": (102, 174),
    "geteuid": (107, 175),
    "getgid": (104, 176),
    "getegid": (108, 177),
    "getresuid": (118, 148),
    "getresgid": (120, 150),
    "getgroups": (115, 158),
    "sched_yield": (24, 124),
    "sched_getaffinity": (204, 123),
    "sched_getparam": (143, 121),
    "sched_getscheduler": (145, 120),
    "sched_get_priority_max": (146, 125),
    "sched_get_priority_min": (147, 126),
    "getcpu": (309, 168),
    "getrlimit": (97, 163),
    "getrusage": (98, 165),
    "rt_sigaction": (13, 134),
    "rt_sigprocmask": (14, 135),
    "rt_sigreturn": (15, 139),
    "sigaltstack": (131, 132),
    "restart_syscall": (219, 128),
    "exit": (60, 93),
    "exit_group": (231, 94),
    # time and the machine
    "clock_gettime": (228, 113),
    "clock_getres": (229, 114),
    "clock_nanosleep": (230, 115),
    "nanosleep": (35, 101),
    "gettimeofday": (96, 169),
    "time": (201, None),
    "times": (100, 153),
    "sysinfo": (99, 179),
    "uname": (63, 160),
    "getrandom": (318, 278),
}
_WRITING: dict[str, Numbers] = {
    "mkdir": (83, None),
    "mkdirat": (258, 34),
    "rmdir": (84, None),
    "unlink": (87, None),
    "unlinkat": (263, 35),
    "rename": (82, None),
    "renameat": (264, 38),
    "renameat2": (316, 276),
}
"""Allowed as well if a folder may be written to."""
_OPENING: dict[str, Numbers] = {"open": (2, None), "openat": (257, 56)}
_OTHERS: dict[str, Numbers] = {
    "clone": (56, 220),
    "kill": (62, 129),
    "tgkill": (234, 131),
    "prctl": (157, 167),
    "ioctl": (16, 29),
    "fcntl": (72, 25),
    "prlimit64": (302, 261),
    # their arguments are in memory
    "clone3": (435, 435),
    "openat2": (437, 437),
}
"""Allowed with some arguments, see `_filter`, or not known to the process."""
_SECCOMP: Numbers = (317, 277)
_CREATE_RULESET = 444
_ADD_RULE = 445
_RESTRICT_SELF = 446
"""System calls of Landlock, on all architectures."""

_OPENS_TO_WRITE = os.O_ACCMODE | os.O_CREAT | os.O_TRUNC
_THREAD = 0x00010F00
"""CLONE_VM, CLONE_FS, CLONE_FILES, CLONE_SIGHAND and CLONE_THREAD, as for every thread."""
_NAMESPACES = 0x7E020000
"""All flags CLONE_NEW... of clone."""
_PRCTL = (15, 16, 0x53564D41)
"""Names of threads and of memory: PR_SET_NAME, PR_GET_NAME, PR_SET_VMA."""
_IOCTL = (0x5401, 0x541B, 0x5421, 0x5450, 0x5451)
"""TCGETS, FIONREAD, FIONBIO, FIONCLEX, FIOCLEX."""
_FCNTL = (0, 1, 2, 3, 4, 5, 6, 7, 36, 37, 38, 1030)
"""Descriptors, their flags, and locks; not the owner of signals."""

# linux/filter.h and linux/seccomp.h
_LOAD = 0x20
_EQUAL = 0x15
_AT_LEAST = 0x35
_ANY_BIT = 0x45
_AND = 0x54
_RETURN = 0x06
_ALLOW = 0x7FFF0000
_KILL = 0x80000000
_ERRNO = 0x00050000
_SET_MODE_FILTER = 1
_GET_ACTION_AVAILABLE = 2
_ALL_THREADS = 1
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

_SYSTEM = (
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


class SandboxError(OSError):
    """The kernel offers its limits, and did not apply them."""


def lacking() -> tuple[str, ...]:
    """Return which of seccomp and Landlock this kernel lacks, or has in too old a version."""
    found = []
    if not _has_seccomp():
        found.append("seccomp filters")
    if _landlock_version() < OLDEST_LANDLOCK:
        found.append(f"Landlock of ABI {OLDEST_LANDLOCK} (Linux 6.2)")
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
    if not version and not _has_seccomp():
        return
    if _threads() > 1:
        raise SandboxError(errno.EBUSY, "a second thread runs already")
    libc = ctypes.CDLL(None, use_errno=True)
    _checked(libc.prctl(_SET_NO_NEW_PRIVILEGES, *map(ctypes.c_ulong, (1, 0, 0, 0))), "prctl")
    if version:
        _restrict_files(version, [*_needed(), *reads], writes)
    if _has_seccomp():
        _restrict_calls(may_write=bool(writes))


def _call(number: int, *arguments: Any) -> int:
    """Make a system call; return -1 on failure."""
    libc = ctypes.CDLL(None, use_errno=True)
    libc.syscall.restype = ctypes.c_long
    given = (ctypes.c_long(each) if isinstance(each, int) else each for each in arguments)
    return int(libc.syscall(ctypes.c_long(number), *given))


def _checked(result: int, what: str) -> int:
    if result < 0:
        number = ctypes.get_errno()
        raise SandboxError(number, f"{what}: {os.strerror(number)}")
    return result


def _architecture() -> _Architecture | None:
    """Return that of this process, None if it is unknown here."""
    known = sys.platform == "linux" and sys.maxsize > 2**32 and sys.byteorder == "little"
    return _ARCHITECTURES.get(platform.machine()) if known else None


def _has_seccomp() -> bool:
    """Return whether filters can be installed."""
    architecture = _architecture()
    if architecture is None:
        return False
    number = _SECCOMP[architecture.column]
    action = ctypes.byref(ctypes.c_uint32(_KILL))
    return _call(number or 0, _GET_ACTION_AVAILABLE, 0, action) == 0


def _landlock_version() -> int:
    """Return the ABI of Landlock, 0 if the kernel has none or has it switched off."""
    if _architecture() is None:
        return 0
    return max(0, _call(_CREATE_RULESET, None, 0, 1))


def _threads() -> int:
    try:
        return len(list(Path("/proc/self/task").iterdir()))
    except OSError:  # no /proc, or another system
        return 1


def _needed() -> Iterator[str]:
    """Yield what Python and its packages read while they run."""
    home = Path(os.path.expanduser("~"))  # noqa: PTH111 - raises nothing without a home
    packages = [*sys.path, *(sysconfig.get_path(name) for name in ("stdlib", "platstdlib"))]
    for folder in dict.fromkeys(packages):
        if folder and not home.is_relative_to(folder):  # a path to code, not to all of a user
            yield folder
    yield str(Path(sys.base_prefix) / "lib")
    yield from _SYSTEM


def _restrict_files(version: int, reads: Iterable[str], writes: Iterable[str]) -> None:
    """Deny all access to files but that to some paths, see `confine`."""
    rights = (1 << _RIGHTS.get(version, _RIGHTS[max(_RIGHTS)])) - 1
    fields = [rights]
    fields += [_ALL_NETWORK] if version >= 4 else []
    fields += [_ALL_SCOPES] if version >= 6 else []
    attributes = struct.pack(f"={len(fields)}Q", *fields)
    ruleset = _checked(_call(_CREATE_RULESET, attributes, len(attributes), 0), "Landlock")
    try:
        of_files = _READ_FILE | _WRITE_FILE | _TRUNCATE
        for granted, paths in (
            (_READ_FILE | _READ_DIR, reads),
            (of_files | _READ_DIR | _CHANGE_FOLDER, writes),
        ):
            for path in paths:
                _grant(ruleset, path, granted & rights, of_files)
        _checked(_call(_RESTRICT_SELF, ruleset, 0), "Landlock")
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
        _checked(_call(_ADD_RULE, ruleset, _PATH_BENEATH, rule, 0), f"Landlock: {path}")
    finally:
        os.close(handle)


def _restrict_calls(*, may_write: bool) -> None:
    """Deny system calls, see `confine`."""
    architecture = _architecture()
    assert architecture
    code = _filter(architecture, os.getpid(), may_write=may_write)
    instructions = ctypes.create_string_buffer(code, len(code))
    program = struct.pack("=H6xQ", len(code) // 8, ctypes.addressof(instructions))
    number = _SECCOMP[architecture.column] or 0
    _checked(_call(number, _SET_MODE_FILTER, _ALL_THREADS, program), "seccomp")


def _filter(architecture: _Architecture, pid: int, *, may_write: bool) -> bytes:
    """Return the instructions of the filter."""

    def low(argument: int) -> bytes:
        """Load the lower half of an argument."""
        return _op(_LOAD, 16 + 8 * argument)

    def high(argument: int) -> bytes:
        return _op(_LOAD, 20 + 8 * argument)

    def when(table: dict[str, Numbers], name: str, *rest: bytes) -> bytes:
        """Decide about a system call by further instructions."""
        number = table[name][architecture.column]
        body = b"".join(rest)
        return b"" if number is None else _op(_EQUAL, number, 0, len(body) // 8) + body

    def one_of(*values: int) -> bytes:
        """Allow some values of what was loaded."""
        return b"".join(_op(_EQUAL, value, 0, 1) + allow for value in values) + refuse

    allow, refuse = _op(_RETURN, _ALLOW), _op(_RETURN, _ERRNO | errno.EPERM)
    unknown = _op(_RETURN, _ERRNO | errno.ENOSYS)
    named = _ALLOWED | (_WRITING if may_write else {})
    to_write = _op(_ANY_BIT, _OPENS_TO_WRITE, 0, 1) + _op(_RETURN, _ERRNO | errno.EACCES)
    opened = {
        name: allow if may_write else low(flags) + to_write + allow
        for name, flags in (("open", 1), ("openat", 2))
    }
    return b"".join(
        [
            _op(_LOAD, 4),
            _op(_EQUAL, architecture.audit, 1, 0),
            _op(_RETURN, _KILL),
            _op(_LOAD, 0),
            _op(_AT_LEAST, _X32, 0, 1),
            _op(_RETURN, _KILL),
            _op(_AT_LEAST, architecture.newest + 1, 0, 1),
            unknown,
            *(when(named, name, allow) for name in named),
            *(when(_OPENING, name, how) for name, how in opened.items()),
            when(_OTHERS, "clone3", unknown),
            when(_OTHERS, "openat2", unknown),
            when(
                _OTHERS,
                "clone",
                low(0) + _op(_AND, _THREAD | _NAMESPACES) + one_of(_THREAD),
            ),
            when(_OTHERS, "kill", low(0) + one_of(pid)),
            when(_OTHERS, "tgkill", low(0) + one_of(pid)),
            when(_OTHERS, "prctl", low(0) + one_of(*_PRCTL)),
            when(_OTHERS, "ioctl", low(1) + one_of(*_IOCTL)),
            when(_OTHERS, "fcntl", low(1) + one_of(*_FCNTL)),
            when(  # reading the limits of itself
                _OTHERS,
                "prlimit64",
                low(0) + _op(_EQUAL, 0, 1, 0) + refuse,
                low(2) + _op(_EQUAL, 0, 1, 0) + refuse,
                high(2) + one_of(0),
            ),
            refuse,
        ]
    )


def _op(code: int, value: int, if_true: int = 0, if_false: int = 0) -> bytes:
    """Return an instruction; jumps count the instructions that are passed over."""
    return struct.pack("=HBBI", code, if_true, if_false, value)
