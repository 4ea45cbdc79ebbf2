"""Run tasks on a Dask cluster of any number of machines, some of which may fail.

Workers and the scheduler load this file too, by the names in it, so it loads nothing heavy itself;
tasks and files are bytes to the scheduler.
"""

import asyncio
import functools
import hashlib
import importlib.util
import logging
import pickle
import platform
import socket
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self
from urllib.parse import urlsplit

from workbench.common.errors import WorkbenchError
from workbench.common.optional_package import has_package
from workbench.common.resources import models_dir
from workbench.design.executor.executor import Result, Stop, Task

if TYPE_CHECKING:
    from workbench.scenario.scenario import Scenario

SCHEDULER_TIMEOUT_S = 2.0
"""Time limit for a connection, and again for the answer of a scheduler [s]."""
EXAMPLE_SCHEDULER = "tcp://localhost:8786"
_SCHEMES = ("tcp", "tls")
CLUSTER_POLL_PERIOD_S = 0.05
"""Period between checks for results, and for a stop [s]."""
WORKER_INSTALL_HINT = "install there what is installed here, with one constraints.txt for all"


@functools.cache
def process_versions() -> dict[str, str]:
    """Return the versions in this process that determine a flight.

    That of the workbench is a digest of its source and of the shipped models; the processor is
    x86_64 and so on.
    """
    package = Path(__file__).parents[2]
    digest = hashlib.sha256()
    for folder, pattern in ((package, "*.py"), (models_dir(), "*")):
        for path in sorted(folder.rglob(pattern)):
            if path.is_file() and path.suffix != ".pyc":
                digest.update(path.relative_to(folder).as_posix().encode() + b"\0")
                digest.update(path.read_bytes())
    packages = {name: metadata.version(name) for name in ("drake", "numpy")}
    packages["numba"] = metadata.version("numba") if has_package("numba") else "none"
    return {"workbench": digest.hexdigest()[:12], **packages, "processor": platform.machine()}


def check_versions(worker: str, there: Mapping[str, str], here: Mapping[str, str]) -> None:
    """Check that flights by a worker would be the same.

    Raises:
        WorkbenchError: with the first version that differs.
    """
    for name, own in here.items():
        other = there[name]
        if other != own and name == "workbench":
            raise WorkbenchError(
                f"the worker {worker} has another version of the workbench's source than this "
                f"machine: {WORKER_INSTALL_HINT}"
            )
        if other != own:
            what = "a processor of kind" if name == "processor" else name
            raise WorkbenchError(
                f"the worker {worker} has {what} {other}, but here it is {own}: "
                f"{WORKER_INSTALL_HINT}"
            )


def run_there(task: bytes, files: bytes | None, here: Mapping[str, str]) -> Any:
    """Run a task on a worker of a cluster.

    Args:
        task: a pickled `Task`; its scenario has absolute paths.
        files: those that it reads, pickled, see `shipment`; None if all are shipped.
        here: versions of the caller; a worker may have joined since they were compared.

    Raises:
        WorkbenchError: as the task raises it, with the paths of the caller.
    """
    from distributed import get_worker

    check_versions(get_worker().address, process_versions(), here)
    work = pickle.loads(task)
    if files is None:
        return work.run()
    from workbench.design.executor.shipment import moved_below, unpack_shipment

    root = unpack_shipment(files, Path(get_worker().local_directory))
    try:
        return work.with_scenario(moved_below(root, work.scenario)).run()
    except WorkbenchError as error:
        raise type(error)(str(error).replace(str(root), "")) from None


def cluster_files(files: bytes) -> bytes:
    """Return files as a result of the cluster, which computes it again if it is lost."""
    return files


def check_address(address: str) -> tuple[str, int]:
    """Return host and port of an address like tcp://HOST:PORT or tls://HOST:PORT.

    Raises:
        WorkbenchError: if it is not an address, or the package that it needs is not installed.
    """
    if importlib.util.find_spec("distributed") is None:
        raise WorkbenchError(
            "a Dask cluster needs the package distributed: `pip install distributed`"
        )
    try:
        parts = urlsplit(address)
        if parts.scheme not in _SCHEMES or not parts.hostname or not parts.port or parts.path:
            raise ValueError
    except ValueError:
        raise WorkbenchError(
            f"'{address}' is not the address of a scheduler: write tcp://HOST:PORT, as "
            f"{EXAMPLE_SCHEDULER}"
        ) from None
    return parts.hostname, parts.port


def check_scheduler(address: str, within: float = SCHEDULER_TIMEOUT_S) -> None:
    """Check that a Dask scheduler answers at an address.

    Dask's own client retries a closed port without end, and waits without limit for an answer from
    a program that is not a scheduler.

    Args:
        address: tcp://HOST:PORT or tls://HOST:PORT.
        within: time for a connection to be made, and once more for an answer [s].

    Raises:
        WorkbenchError: if none does.
    """
    try:
        socket.create_connection(check_address(address), timeout=within).close()
    except OSError as error:
        reason = "it does not answer" if isinstance(error, TimeoutError) else error.strerror
        raise _unreachable(address, reason or str(error)) from error
    with ThreadPoolExecutor(1) as pool:  # a notebook has an event loop of its own in this thread
        try:
            who = pool.submit(asyncio.run, _identity(address, within)).result()
        except TimeoutError as error:
            raise _unreachable(
                address, "the program at that address does not answer like one"
            ) from error
        except Exception as error:  # another protocol's answer is read as Dask's: anything follows
            reason = (
                "the program at that address is not a Dask scheduler, or uses TLS "
                f"differently ({error})"
            )
            raise _unreachable(address, reason) from error
    if who.get("type") != "Scheduler":
        raise _unreachable(address, f"the program at that address is a Dask {who.get('type', '?')}")


async def _identity(address: str, within: float) -> dict[str, Any]:
    """Return what a scheduler says of itself."""
    from distributed.core import rpc
    from distributed.security import Security

    async def ask() -> dict[str, Any]:
        arguments = Security().get_connection_args("client")
        async with rpc(address, connection_args=arguments) as scheduler:
            answer: dict[str, Any] = await scheduler.identity()
            return answer

    return await asyncio.wait_for(ask(), within)


def _unreachable(address: str, reason: str) -> WorkbenchError:
    return WorkbenchError(
        f"no scheduler can be reached at {address} ({reason}): start one with `dask scheduler`, "
        "and give the address that it prints"
    )


class DaskCluster:
    """Runs tasks on the workers of a Dask scheduler; use it in a `with` statement.

    Another worker repeats the task of a lost one; workers may join at any time. The files read by
    tasks are sent along.

    Args:
        address: of the scheduler, as tcp://HOST:PORT.

    Raises:
        WorkbenchError: if no scheduler answers there, it has no workers, or a worker cannot do what
            is done here.
    """

    def __init__(self, address: str) -> None:
        check_scheduler(address)
        from distributed import Client

        self._address = address
        # it logs many lines about a lost scheduler, which are replaced by one sentence
        self._log = logging.getLogger("distributed.client")
        self._loudness = self._log.level
        self._log.setLevel(logging.CRITICAL)
        self._client = Client(address, set_as_default=False, name="workbench")
        try:
            self.workers = self._checked_workers()
        except BaseException as error:
            self._close()
            if isinstance(error, OSError):  # as Dask has what is lost
                raise WorkbenchError(
                    f"the scheduler at {address} or a worker was lost at the start: run this again"
                ) from error
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._close()

    def _close(self) -> None:
        self._client.close()
        self._log.setLevel(self._loudness)

    def run(
        self, tasks: Sequence[Task[Result]], stop: Stop | None = None
    ) -> Iterator[tuple[int, Result]]:
        """See `Executor.run`; flights in progress when it is stopped are abandoned.

        Raises:
            WorkbenchError: as a task raised it, or if the scheduler is lost, or several workers one
                after the other with the same task.
        """
        from distributed import as_completed

        futures = self._begin(tasks)
        places = {future.key: index for index, future in enumerate(futures)}
        arriving = as_completed(futures, loop=self._client.loop)
        try:
            while places:
                done = arriving.next_batch(block=False)
                for future in done:
                    index = places.pop(future.key)
                    yield index, self._result(future)
                if stop and stop():
                    break
                if not done:
                    time.sleep(CLUSTER_POLL_PERIOD_S)
            for future in arriving.next_batch(block=False):
                yield places.pop(future.key), self._result(future)
        finally:
            if self._client.status == "running":
                left = [future for future in futures if future.key in places]
                self._client.cancel(left, force=True)

    def _begin(self, tasks: Sequence[Task[Result]]) -> list[Any]:
        """Return a future for each task."""
        import dask

        from workbench.design.executor.shipment import shipment, with_absolute_paths

        files: dict[str, Any] = {}
        moved, needed = [], []
        given: Scenario | None = None
        with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1GB"}):
            for task in tasks:
                if (own := task.scenario) is not given:  # a sweep's tasks share one
                    given, scenario = own, with_absolute_paths(own)
                    key = _named_files(scenario)
                if key not in files:
                    found = shipment(scenario)
                    files[key] = found and self._client.submit(
                        cluster_files, pickle.dumps(found), pure=False
                    )
                moved.append(pickle.dumps(task.with_scenario(scenario)))
                needed.append(files[key])
            futures: list[Any] = self._client.map(
                run_there, moved, needed, here=process_versions(), pure=False
            )
        return futures

    def _result(self, future: Any) -> Any:
        """Return a future's result, and let the cluster forget it."""
        from concurrent.futures import CancelledError

        from distributed import KilledWorker
        from distributed.comm import CommClosedError

        try:
            return future.result()
        except KilledWorker as error:
            raise WorkbenchError(
                f"{error.allowed_failures + 1} workers were lost one after the other while they "
                "did the same task, perhaps because memory ran out: see their logs"
            ) from error
        except (CancelledError, CommClosedError) as error:
            raise WorkbenchError(
                f"the scheduler at {self._address} was lost with its tasks: start it again, and "
                "fly again"
            ) from error
        except (ImportError, pickle.UnpicklingError) as error:
            raise WorkbenchError(
                f"a worker cannot do this task ({error}): {WORKER_INSTALL_HINT}"
            ) from error
        finally:
            future.release()

    def _checked_workers(self) -> int:
        """Return the number of workers, all of them able to fly as is flown here.

        Raises:
            WorkbenchError: if there are none, or one of them or the scheduler is not able.
        """
        info: Any = self._client.get_versions()
        pythons = {
            f"the worker {at}": _python_version(each) for at, each in info["workers"].items()
        }
        if not pythons:
            raise WorkbenchError(
                f"the scheduler at {self._address} has no workers: start some with `dask worker "
                f"{self._address} --nthreads 1`"
            )
        own = _python_version(info["client"])
        for who, python in (
            {"the scheduler": _python_version(info["scheduler"])} | pythons
        ).items():
            if python != own:
                raise WorkbenchError(
                    f"{who} runs Python {python}, but this machine runs {own}: "
                    f"{WORKER_INSTALL_HINT}"
                )
        tell = _versions_there()
        if self._client.run_on_scheduler(tell) is None:
            raise WorkbenchError(
                f"the scheduler lacks drake-drone-workbench: {WORKER_INSTALL_HINT}"
            )
        for address, there in self._client.run(tell).items():
            if there is None:
                raise WorkbenchError(
                    f"the worker {address} lacks drake-drone-workbench: {WORKER_INSTALL_HINT}"
                )
            check_versions(address, there, process_versions())
        return len(pythons)


def _versions_there() -> Any:
    """Return a function that tells a worker's versions, None where it has no workbench.

    A function within a function is sent as it is. What it names must not be sent with it, as the
    other end may have no workbench: so it imports that itself.
    """

    def tell() -> dict[str, str] | None:
        try:
            from workbench.design.executor import cluster

            return cluster.process_versions()
        except ImportError:  # of the workbench, or of what it needs
            return None

    return tell


def _named_files(scenario: "Scenario") -> str:
    """Return a text that is the same for scenarios that are read from the same files."""
    return repr(
        (
            scenario.vehicle.model,
            sorted(scenario.vehicle.args.items()),
            scenario.world,
            sorted(scenario.vehicle.packages.items()),
            scenario.vehicle.rotors,
            scenario.vehicle.gains,
        )
    )


def _python_version(info: Mapping[str, Any]) -> str:
    """Return 3.11 of what Dask says of a process that runs 3.11.2."""
    return ".".join(info["host"]["python"].split(".")[:2])
