"""Where a command's flights are flown: here, or on the cluster that it was given."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from workbench.commands.printing import say

if TYPE_CHECKING:
    from workbench.design.executor.executor import Executor


@contextmanager
def chosen_executor(scheduler: str, here: "Executor") -> Iterator["Executor"]:
    """Yield what flies: the cluster of a scheduler, whose size is said, or else what flies here.

    Raises:
        WorkbenchError: if the scheduler cannot be reached, or its workers cannot fly as is flown
            here.
    """
    if not scheduler:
        yield here
        return
    from workbench.design.executor.cluster import DaskCluster

    with DaskCluster(scheduler) as cluster:
        say(f"flying on {cluster.workers} workers of {scheduler}")
        yield cluster
