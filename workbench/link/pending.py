"""Requests that wait for their answers."""

import asyncio
from collections.abc import Callable
from typing import TypeVar

from workbench.common.errors import WorkbenchError
from workbench.link.line import Line
from workbench.link.operations import Operation
from workbench.link.server_messages import Nack, ServerMessage

REQUEST_LIMIT = 5.0
"""An answer that is not there by then does not come [s]."""

T = TypeVar("T")


class Pending:
    """Requests that wait for their answers, by their numbers.

    Args:
        server: its address, for people.
    """

    def __init__(self, server: str) -> None:
        self._server = server
        self._answers: dict[int, asyncio.Future[ServerMessage]] = {}

    async def ask(
        self, line: Line, make: Callable[[int], Operation], wanted: type[T], limit: float
    ) -> T:
        """Ask for something, and return the answer.

        Args:
            line: to the server.
            make: makes the operation with an id.
            wanted: type of the answer.
            limit: how long to wait [s].

        Raises:
            WorkbenchError: if it is refused, or no answer comes.
        """
        operation = make(line.conversation.new_id())
        answer: asyncio.Future[ServerMessage] = asyncio.get_running_loop().create_future()
        self._answers[operation.id] = answer
        try:
            line.ask(operation)
            async with asyncio.timeout(limit):
                said = await answer
        except TimeoutError:
            raise WorkbenchError(
                f"{self._server} gave no answer within {limit:g} s: the flight may be busy"
            ) from None
        finally:
            del self._answers[operation.id]
        if isinstance(said, Nack):
            raise WorkbenchError(f"refused: {said.said}")
        if not isinstance(said, wanted):
            raise WorkbenchError(f"{self._server} answered with something else: {said}")
        return said

    def hear(self, said: ServerMessage) -> None:
        """Hand an answer to who waits for it; the rest is nobody's."""
        answer = self._answers.get(getattr(said, "id", None) or 0)
        if answer is not None and not answer.done():
            answer.set_result(said)

    def fail(self, why: str) -> None:
        """Let all who wait know that no answer will come."""
        for answer in self._answers.values():
            if not answer.done():
                answer.set_exception(WorkbenchError(why))
