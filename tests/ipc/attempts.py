"""What hostile code may try in a held process, with Python and with system calls of its own.

Run as a child of `run_limited` and `run_trusted`. Each attempt is harmless where it succeeds.
"""

import ctypes
import errno
import os
import signal
import socket
import sqlite3
import subprocess
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from workbench.ipc.limited import serve_one_request

NUMBERS = {
    # name: (x86_64, aarch64)
    "fork": (57, None),
    "vfork": (58, None),
    "execve": (59, 221),
    "execveat": (322, 281),
    "memfd_create": (319, 279),
    "socket": (41, 198),
    "socketpair": (53, 199),
    "ptrace": (101, 117),
    "process_vm_writev": (311, 271),
    "pidfd_open": (434, 434),
    "pidfd_send_signal": (424, 424),
    "rt_sigqueueinfo": (129, 138),
    "tkill": (200, 130),
    "open_by_handle_at": (304, 265),
    "name_to_handle_at": (303, 264),
    "mount": (165, 40),
    "open_tree": (428, 428),
    "fsopen": (430, 430),
    "chroot": (161, 51),
    "unshare": (272, 97),
    "setns": (308, 268),
    "bpf": (321, 280),
    "perf_event_open": (298, 241),
    "userfaultfd": (323, 282),
    "io_uring_setup": (425, 425),
    "keyctl": (250, 219),
    "add_key": (248, 217),
    "init_module": (175, 105),
    "kexec_load": (246, 104),
    "shmget": (29, 194),
    "mq_open": (240, 180),
    "fanotify_init": (300, 262),
    "inotify_init1": (294, 26),
    "mknodat": (259, 33),
    "linkat": (265, 37),
    "symlinkat": (266, 36),
    "fchmodat": (268, 53),
    "fchownat": (260, 54),
    "utimensat": (280, 88),
    "setxattr": (188, 5),
    "truncate": (76, 45),
    "seccomp": (317, 277),
    "landlock_create_ruleset": (444, 444),
    "setuid": (105, 146),
    "setpriority": (141, 140),
    "clone3": (435, 435),
    "openat2": (437, 437),
}


def system_call(name: str) -> Callable[[Any], int]:
    """Return an attempt at a system call whose arguments are all invalid."""

    def attempt(_: Any) -> int:
        libc = ctypes.CDLL(None, use_errno=True)
        number = NUMBERS[name][os.uname().machine == "aarch64"]
        if number is None:
            raise PermissionError(errno.ENOSYS, "this processor has none")
        arguments = [ctypes.c_long(-1)] * 6
        if libc.syscall(ctypes.c_long(number), *arguments) < 0:
            raise OSError(ctypes.get_errno(), name)
        if name in ("fork", "vfork"):
            os._exit(0)
        return 0

    return attempt


def clone(flags: int) -> Callable[[Any], int]:
    def attempt(_: Any) -> int:
        libc = ctypes.CDLL(None, use_errno=True)
        number = 220 if os.uname().machine == "aarch64" else 56
        made = libc.syscall(ctypes.c_long(number), ctypes.c_long(flags), *[ctypes.c_long(0)] * 4)
        if made < 0:
            raise OSError(ctypes.get_errno(), "clone")
        if made == 0:
            os._exit(0)
        return 0

    return attempt


def starts(_: Any) -> None:
    subprocess.run(["true"], check=True)


def fork_exec(_: Any) -> None:
    subprocess._USE_POSIX_SPAWN = False
    subprocess.run(["true"], check=True, close_fds=False)


def spawns(_: Any) -> None:
    os.waitpid(os.posix_spawn("/bin/true", ["true"], {}), 0)


def shell(_: Any) -> None:
    if os.system("true"):
        raise PermissionError(errno.EPERM, "system")


def forks(_: Any) -> None:
    if os.fork() == 0:
        os._exit(0)
    os.wait()


def executes(_: Any) -> None:
    os.execv("/no/such/program", ["x"])


def opens_a_socket(_: Any) -> None:
    socket.socket(socket.AF_INET, socket.SOCK_STREAM).close()


def opens_a_unix_socket(_: Any) -> None:
    socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM).close()


def opens_netlink(_: Any) -> None:
    socket.socket(socket.AF_NETLINK, socket.SOCK_RAW).close()


def reads_the_passwords(_: Any) -> None:
    Path("/etc/passwd").read_bytes()


def reads_a_secret(asked: Any) -> None:
    Path(asked["secret"]).read_bytes()


def reads_it_through_a_link(asked: Any) -> None:
    Path(asked["link"]).read_bytes()


def reads_it_through_proc(asked: Any) -> None:
    Path(f"/proc/self/root{asked['secret']}").read_bytes()


def lists_a_folder(asked: Any) -> None:
    list(Path(asked["secret"]).parent.iterdir())


def reads_the_parent(_: Any) -> None:
    Path(f"/proc/{os.getppid()}/environ").read_bytes()


def writes(asked: Any) -> None:
    Path(asked["target"]).write_bytes(b"x")


def appends(asked: Any) -> None:
    with Path(asked["secret"]).open("ab") as file:
        file.write(b"x")


def truncates(asked: Any) -> None:
    os.truncate(asked["secret"], 1)


def writes_a_database(asked: Any) -> None:
    with sqlite3.connect(asked["target"]) as base:
        base.execute("create table t (a)")


def writes_shared_memory(_: Any) -> None:
    os.close(os.open("/dev/shm/workbench-attempt", os.O_CREAT | os.O_RDWR))
    Path("/dev/shm/workbench-attempt").unlink()


def writes_its_own_memory(_: Any) -> None:
    os.close(os.open("/proc/self/mem", os.O_RDWR))


def makes_a_folder(asked: Any) -> None:
    Path(asked["target"]).mkdir()


def removes(asked: Any) -> None:
    Path(asked["doomed"]).unlink()


def renames(asked: Any) -> None:
    Path(asked["secret"]).rename(f"{asked['secret']}2")


def changes_the_mode(asked: Any) -> None:
    Path(asked["secret"]).chmod(0o777)


def signals_its_parent(_: Any) -> None:
    os.kill(os.getppid(), 0)


def signals_its_group(_: Any) -> None:
    os.kill(0, 0)


def owns_signals(_: Any) -> None:
    import fcntl

    fcntl.fcntl(0, fcntl.F_SETOWN, os.getppid())


def raises_its_limits(_: Any) -> None:
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    try:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
    except ValueError as error:
        raise PermissionError(errno.EPERM, "setrlimit") from error


ATTEMPTS: dict[str, Callable[[Any], object]] = {
    **{each.__name__: each for each in (
        starts, fork_exec, spawns, shell, forks, executes,
        opens_a_socket, opens_a_unix_socket, opens_netlink,
        reads_the_passwords, reads_a_secret, reads_it_through_a_link, reads_it_through_proc,
        lists_a_folder, reads_the_parent,
        writes, appends, truncates, writes_a_database, writes_shared_memory,
        writes_its_own_memory, makes_a_folder, removes, renames, changes_the_mode,
        signals_its_parent, signals_its_group, owns_signals, raises_its_limits,
    )},
    "clone": clone(signal.SIGCHLD),
    "clone with its memory": clone(signal.SIGCHLD | 0x100 | 0x4000),
    **{name: system_call(name) for name in NUMBERS},
}  # fmt: skip


def outcome(name: str, asked: Any) -> str:
    """Return "done", or the name of the error."""
    if asked["again"]:
        for file in ("secret", "doomed"):
            Path(asked[file]).write_bytes(b"private")
        target = Path(asked["target"])
        target.rmdir() if target.is_dir() else target.unlink(missing_ok=True)
    try:
        ATTEMPTS[name](asked)
    except sqlite3.OperationalError:
        return "EACCES"
    except OSError as error:
        return errno.errorcode.get(error.errno or 0, str(error))
    return "done"


def run(asked: Any) -> Any:
    """Return the outcome of every attempt, or of one made by another architecture's call."""
    if asked.get("kill") == "x32":
        ctypes.CDLL(None).syscall(ctypes.c_long(0x40000000 | 39))
    done: list[int] = []
    thread = threading.Thread(target=done.append, args=(1,))
    thread.start()
    thread.join()
    assert done == [1]
    if asked.get("kill"):
        return "lives"
    allowed = {"read": len(Path(asked["own"]).read_bytes()), "signal": os.kill(os.getpid(), 0)}
    if asked["folder"]:
        place = Path(asked["folder"]) / "made"
        place.write_bytes(b"abc")
        place.rename(place.with_name("renamed"))
        allowed["written"] = [each.name for each in Path(asked["folder"]).iterdir()]
    return {"allowed": allowed, **{name: outcome(name, asked) for name in asked["attempts"]}}


if __name__ == "__main__":
    serve_one_request(run)
