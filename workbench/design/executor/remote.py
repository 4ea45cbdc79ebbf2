"""What a worker does with a task: it compares versions, lays out the files, and does it.

A scheduler loads this file too, to pass on what names it, so it loads nothing heavy itself; tasks
and files are bytes to it.
"""

import pickle
from typing import Any

from workbench.common.errors import WorkbenchError
from workbench.design.executor.versions import Versions, check_versions, versions


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

    root = pickle.loads(files).unpacked()
    try:
        return work.with_scenario(moved_below(root, work.scenario)).run()
    except WorkbenchError as error:
        raise type(error)(str(error).replace(str(root), "")) from None


def passed_on(files: bytes) -> bytes:
    """Return files as a result of the cluster's own, which it makes again when it is lost."""
    return files
