"""What a worker does with a task: it compares versions, lays out the files, and does it.

A scheduler loads this file too, to pass on what names it, so it loads nothing heavy itself; tasks
and files are bytes to it.
"""

import functools
import hashlib
import pickle
import platform
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

from workbench.common.errors import WorkbenchError
from workbench.common.resources import models_dir

INSTALL = "install there what is installed here, with one constraints.txt for all"


class Versions(NamedTuple):
    """Of what a flight follows from.

    Attributes:
        workbench: a digest of its source and of the shipped models.
        drake, numpy, numba: of these packages.
        processor: x86_64 and so on.
    """

    workbench: str
    drake: str
    numpy: str
    numba: str
    processor: str


@functools.cache
def versions() -> Versions:
    """Return those of this process."""
    package = Path(__file__).parents[2]
    digest = hashlib.sha256()
    for folder, pattern in ((package, "*.py"), (models_dir(), "*")):
        for path in sorted(folder.rglob(pattern)):
            if path.is_file() and path.suffix != ".pyc":
                digest.update(path.relative_to(folder).as_posix().encode() + b"\0")
                digest.update(path.read_bytes())
    return Versions(
        workbench=digest.hexdigest()[:12],
        drake=metadata.version("drake"),
        numpy=metadata.version("numpy"),
        numba=metadata.version("numba"),
        processor=platform.machine(),
    )


def check_versions(worker: str, there: Versions, here: Versions) -> None:
    """Refuse a worker that would fly otherwise.

    Raises:
        WorkbenchError: naming the first that is not the same.
    """
    for name, other, own in zip(Versions._fields, there, here, strict=True):
        if other != own and name == "workbench":
            raise WorkbenchError(
                f"the worker {worker} has another state of the workbench's source than there is "
                f"here: {INSTALL}"
            )
        if other != own:
            what = "a processor of kind" if name == "processor" else name
            raise WorkbenchError(
                f"the worker {worker} has {what} {other}, and here it is {own}: {INSTALL}"
            )


def run_there(task: bytes, files: bytes | None, here: Versions) -> Any:
    """Do a task on a worker of a cluster.

    Args:
        task: a pickled `Task`; its scenario has absolute paths.
        files: a pickled `Shipment` of what it reads, None if only shipped files.
        here: versions of where it was asked for; a worker may have joined since they were compared.

    Raises:
        WorkbenchError: as the task raises it, with paths as they are where it was asked for.
    """
    from distributed import get_worker

    check_versions(get_worker().address, versions(), here)
    work = pickle.loads(task)
    if files is None:
        return work.run()
    from workbench.design.executor.shipment import moved_below

    root = pickle.loads(files).unpacked(Path(get_worker().local_directory))
    try:
        return work.with_scenario(moved_below(root, work.scenario)).run()
    except WorkbenchError as error:
        raise type(error)(str(error).replace(str(root), "")) from None


def passed_on(files: bytes) -> bytes:
    """Return files as a result of the cluster's own, which it makes again when it is lost."""
    return files
