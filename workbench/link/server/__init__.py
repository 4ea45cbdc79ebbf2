"""The server of a flight: a process of its own, asyncio in one thread, standard library only."""
