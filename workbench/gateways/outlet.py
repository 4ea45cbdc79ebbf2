"""Where a gateway passes samples on to, and the loop that does."""

from collections.abc import Sequence
from typing import Protocol

from workbench.link import Client
from workbench.link.sample import Sample
from workbench.link.topics import Topic


class Outlet(Protocol):
    """Where samples go to; nothing here waits for whoever reads them."""

    def announce(self, topics: Sequence[Topic]) -> None:
        """Get ready for topics."""

    def deliver(self, sample: Sample) -> None:
        """Pass a sample on."""

    def close(self) -> None:
        """End."""


def pass_on(client: Client, outlet: Outlet) -> None:
    """Pass all samples on, until Ctrl-C or the end of the client.

    Raises:
        WorkbenchError: if the client ends by itself.
    """
    try:
        outlet.announce(client.hello.topics)
        for sample in client:
            outlet.deliver(sample)
    except KeyboardInterrupt:  # the usual end of a gateway
        return
    finally:
        outlet.close()
