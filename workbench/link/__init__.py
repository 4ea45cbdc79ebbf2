"""The wire protocol, its server and its clients, without Drake or Qt."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from workbench.link.client import AsyncClient, Client

__all__ = ["AsyncClient", "Client"]


def __getattr__(name: str) -> object:
    # Loaded on demand: the server and the flight import this room without them.
    if name in __all__:
        from workbench.link import client

        return getattr(client, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
