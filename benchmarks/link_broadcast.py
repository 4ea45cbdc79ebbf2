"""A bare broadcast of the link's frames by asyncio, for link_age.py to compare the link with.

`python benchmarks/link_broadcast.py` reads a line of JSON from standard input: the frames of eight
topics, in hexadecimal, and the period of their samples [s]. It prints its port, and sends the
frames to every client, stamped anew, until standard input ends. It has no leases,
no acknowledgements, no subscriptions and no slow clients.
"""

import asyncio
import json
import sys
import time

from link_client import HEADER, STAMP, TIME


def stamped(frames: list[bytes], seq: int, t_ns: int) -> bytes:
    """Return the frames of one sample, at a time of the flight, with the present time."""
    now, sent = time.time_ns(), []
    for frame in frames:
        magic, version, kind, topic, flags, _, length, _ = HEADER.unpack_from(frame)
        payload = frame[HEADER.size :]
        if topic == TIME:
            payload = STAMP.pack(0, 0, now) + payload[STAMP.size :]
        sent.append(HEADER.pack(magic, version, kind, topic, flags, seq, length, t_ns) + payload)
    return b"".join(sent)


async def broadcast(frames: list[bytes], period: float) -> None:
    """Send until standard input ends."""
    clients: set[asyncio.StreamWriter] = set()

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        clients.add(writer)
        try:
            while await reader.read(65536):
                pass
        except ConnectionError:  # a client that has seen enough
            writer.close()
        clients.discard(writer)

    server = await asyncio.start_server(serve, "127.0.0.1", 0)
    print(server.sockets[0].getsockname()[1], flush=True)
    loop = asyncio.get_running_loop()
    ended = loop.run_in_executor(None, sys.stdin.read)
    due, seq = loop.time(), 0
    while not ended.done():
        due, seq = due + period, seq + 1
        await asyncio.sleep(max(0.0, due - loop.time()))
        data = stamped(frames, seq, round(1e9 * seq * period))
        for writer in clients:
            if not writer.is_closing():
                writer.write(data)


if __name__ == "__main__":
    given = json.loads(sys.stdin.readline())
    asyncio.run(broadcast([bytes.fromhex(each) for each in given["frames"]], given["period"]))
