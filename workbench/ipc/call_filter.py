"""Limit the system calls of a process by a seccomp filter."""

import ctypes
import errno
import os
import struct

from workbench.ipc.system_call import (
    Architecture,
    SyscallNumbers,
    checked_call,
    own_architecture,
    system_call,
)

_X32_BIT = 0x40000000
"""Bit of the numbers of the x32 ABI."""
_ALLOWED_CALLS: dict[str, SyscallNumbers] = {
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
_WRITE_CALLS: dict[str, SyscallNumbers] = {
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
_OPEN_CALLS: dict[str, SyscallNumbers] = {"open": (2, None), "openat": (257, 56)}
_FILTERED_CALLS: dict[str, SyscallNumbers] = {
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
_SECCOMP: SyscallNumbers = (317, 277)
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
_BPF_LOAD = 0x20
_BPF_EQUAL = 0x15
_BPF_AT_LEAST = 0x35
_BPF_ANY_BIT = 0x45
_BPF_AND = 0x54
_BPF_RETURN = 0x06
_SECCOMP_ALLOW = 0x7FFF0000
_SECCOMP_KILL = 0x80000000
_SECCOMP_ERRNO = 0x00050000
_SET_MODE_FILTER = 1
_GET_ACTION_AVAILABLE = 2
_ALL_THREADS = 1


def has_seccomp() -> bool:
    """Return whether filters can be installed."""
    architecture = own_architecture()
    if architecture is None:
        return False
    number = _SECCOMP[architecture.column]
    action = ctypes.byref(ctypes.c_uint32(_SECCOMP_KILL))
    return system_call(number or 0, _GET_ACTION_AVAILABLE, 0, action) == 0


def restrict_calls(*, may_write: bool) -> None:
    """Deny system calls, see `confine`."""
    architecture = own_architecture()
    assert architecture
    code = _filter(architecture, os.getpid(), may_write=may_write)
    instructions = ctypes.create_string_buffer(code, len(code))
    program = struct.pack("=H6xQ", len(code) // 8, ctypes.addressof(instructions))
    number = _SECCOMP[architecture.column] or 0
    checked_call(system_call(number, _SET_MODE_FILTER, _ALL_THREADS, program), "seccomp")


def _filter(architecture: Architecture, pid: int, *, may_write: bool) -> bytes:
    """Return the instructions of the filter."""

    def low(argument: int) -> bytes:
        """Load the lower half of an argument."""
        return _op(_BPF_LOAD, 16 + 8 * argument)

    def high(argument: int) -> bytes:
        return _op(_BPF_LOAD, 20 + 8 * argument)

    def when(table: dict[str, SyscallNumbers], name: str, *rest: bytes) -> bytes:
        """Decide about a system call by further instructions."""
        number = table[name][architecture.column]
        body = b"".join(rest)
        return b"" if number is None else _op(_BPF_EQUAL, number, 0, len(body) // 8) + body

    def one_of(*values: int) -> bytes:
        """Allow some values of what was loaded."""
        return b"".join(_op(_BPF_EQUAL, value, 0, 1) + allow for value in values) + refuse

    allow, refuse = _op(_BPF_RETURN, _SECCOMP_ALLOW), _op(_BPF_RETURN, _SECCOMP_ERRNO | errno.EPERM)
    unknown = _op(_BPF_RETURN, _SECCOMP_ERRNO | errno.ENOSYS)
    named = _ALLOWED_CALLS | (_WRITE_CALLS if may_write else {})
    to_write = _op(_BPF_ANY_BIT, _OPENS_TO_WRITE, 0, 1) + _op(
        _BPF_RETURN, _SECCOMP_ERRNO | errno.EACCES
    )
    opened = {
        name: allow if may_write else low(flags) + to_write + allow
        for name, flags in (("open", 1), ("openat", 2))
    }
    return b"".join(
        [
            _op(_BPF_LOAD, 4),
            _op(_BPF_EQUAL, architecture.audit, 1, 0),
            _op(_BPF_RETURN, _SECCOMP_KILL),
            _op(_BPF_LOAD, 0),
            _op(_BPF_AT_LEAST, _X32_BIT, 0, 1),
            _op(_BPF_RETURN, _SECCOMP_KILL),
            _op(_BPF_AT_LEAST, architecture.newest + 1, 0, 1),
            unknown,
            *(when(named, name, allow) for name in named),
            *(when(_OPEN_CALLS, name, how) for name, how in opened.items()),
            when(_FILTERED_CALLS, "clone3", unknown),
            when(_FILTERED_CALLS, "openat2", unknown),
            when(
                _FILTERED_CALLS,
                "clone",
                low(0) + _op(_BPF_AND, _THREAD | _NAMESPACES) + one_of(_THREAD),
            ),
            when(_FILTERED_CALLS, "kill", low(0) + one_of(pid)),
            when(_FILTERED_CALLS, "tgkill", low(0) + one_of(pid)),
            when(_FILTERED_CALLS, "prctl", low(0) + one_of(*_PRCTL)),
            when(_FILTERED_CALLS, "ioctl", low(1) + one_of(*_IOCTL)),
            when(_FILTERED_CALLS, "fcntl", low(1) + one_of(*_FCNTL)),
            when(  # reading the limits of itself
                _FILTERED_CALLS,
                "prlimit64",
                low(0) + _op(_BPF_EQUAL, 0, 1, 0) + refuse,
                low(2) + _op(_BPF_EQUAL, 0, 1, 0) + refuse,
                high(2) + one_of(0),
            ),
            refuse,
        ]
    )


def _op(code: int, value: int, if_true: int = 0, if_false: int = 0) -> bytes:
    """Return an instruction; jumps count the instructions that are passed over."""
    return struct.pack("=HBBI", code, if_true, if_false, value)
