"""Tasks done in this process, one after the other."""

from collections.abc import Iterator, Sequence

from workbench.design.executor.executor import Result, Stop, Task


class InThisProcess:
    """Does tasks in their order."""

    def run(
        self, tasks: Sequence[Task[Result]], stop: Stop | None = None
    ) -> Iterator[tuple[int, Result]]:
        """See `Executor.run`."""
        for index, task in enumerate(tasks):
            yield index, task.run()
            if stop and stop():
                return
