"""What flies many flights: the interface, and what a flight must be to go anywhere."""

from collections.abc import Callable, Iterator, Sequence
from typing import Protocol, Self, TypeVar

from workbench.scenario.scenario import Scenario

Result = TypeVar("Result")
Result_co = TypeVar("Result_co", covariant=True)

Stop = Callable[[], bool]
"""Asked from time to time; True ends the work with what is done."""


class Task(Protocol[Result_co]):
    """Work that may be done in any process: it can be pickled, and depends on nothing but itself.

    Chance in it comes from a seed that it carries, so that it gives the same wherever it is done,
    and however often.
    """

    @property
    def scenario(self) -> Scenario:
        """What names the files that are read for it."""
        ...

    def with_scenario(self, scenario: Scenario) -> Self:
        """Return the same task with the files of that scenario: copies that lie elsewhere."""
        ...

    def run(self) -> Result_co:
        """Do it.

        Raises:
            WorkbenchError: where it cannot be done; it arrives where the work was asked for.
        """
        ...


class Executor(Protocol):
    """Does tasks somewhere."""

    def run(
        self, tasks: Sequence[Task[Result]], stop: Stop | None = None
    ) -> Iterator[tuple[int, Result]]:
        """Yield the place of each task and its result, as they get done.

        What is not begun when the iterator is closed, or fails, is given up.

        Args:
            tasks: what is to be done.
            stop: True ends it: what is done by then is still yielded.

        Raises:
            WorkbenchError: as a task raised it, or if what does the tasks is lost for good.
        """
        ...


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
