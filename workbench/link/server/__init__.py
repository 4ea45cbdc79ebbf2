"""The server of a flight: a separate process with asyncio in one thread."""
