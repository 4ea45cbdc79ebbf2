"""The client with asyncio against a scripted server; test_client.py has the details of both."""

import asyncio

import pytest

from workbench.common.errors import WorkbenchError
from workbench.link import AsyncClient
from workbench.link.control import AsyncControl
from workbench.link.messages import Bye, ReleaseControl, RequestControl

VELOCITY = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)


def test_samples_come_and_control_is_taken(server, fakes):
    async def fly():
        async with AsyncClient(server.address, name="me") as client:
            server.publish(6_000_000_000, velocity_data=VELOCITY, on_off_state=(1,))
            samples = [await anext(client), await anext(client)]
            async with client.control() as c:
                c.velocity(1.0, 0.0, 0.0)
                while len(server.commands) < 4:
                    await asyncio.sleep(0.01)
                begun = await c.take_off(1.0)
                values = await c.set(a=2.0)
            return samples, begun, values, await client.parameters(), await client.ping()

    samples, *answers = asyncio.run(fly())
    assert [sample.topic for sample in samples] == [
        "/dh_drone/velocity_data",
        "/dh_drone/on_off_state",
    ]
    assert answers == [6.0, {"a": 2.0}, {"take_off_speed": 0.5}, 6.0]
    assert server.commands[0][1] == (fakes.LEASE, 15, 0.0, 0.0, 0.0, 0.0)
    kinds = [type(each) for each in server.operations]
    assert kinds.index(RequestControl) < kinds.index(ReleaseControl)


def test_the_loop_ends_when_the_client_is_closed(server):
    async def read(client):
        return [sample async for sample in client]

    async def close_beside_it():
        async with AsyncClient(server.address) as client:
            reader = asyncio.create_task(read(client))
            await asyncio.sleep(0)
        return await reader

    assert asyncio.run(close_beside_it()) == []


def test_the_loop_raises_what_ended_the_connection(server):
    async def read():
        async with AsyncClient(server.address, reconnect=False) as client:
            server.say(Bye(said="enough"))
            async for _ in client:
                pass

    with pytest.raises(WorkbenchError, match="said goodbye: enough"):
        asyncio.run(read())


def test_a_cancelled_block_gives_control_back(server, fakes):
    async def fly():
        async with AsyncClient(server.address) as client, client.control():
            await asyncio.sleep(3600.0)

    async def cancel_it():
        task = asyncio.create_task(fly())
        while not server.commands:
            await asyncio.sleep(0.01)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task

    asyncio.run(cancel_it())
    fakes.wait_until(lambda: any(isinstance(each, ReleaseControl) for each in server.operations))


@pytest.mark.parametrize("make", [AsyncClient.control, AsyncClient.direct_control])
def test_a_cancellation_at_the_end_of_a_block_is_not_swallowed(server, fakes, make):
    usual = server.usual
    server.usual = lambda peer, operation: (
        None if isinstance(operation, ReleaseControl) else usual(peer, operation)
    )
    left = []

    async def fly():
        async with AsyncClient(server.address) as client:
            async with make(client):
                asyncio.current_task().cancel()  # it arrives where the block ends
            left.append("the block was left as if nothing were")

    async def see():
        with pytest.raises(asyncio.CancelledError):
            await asyncio.create_task(fly())

    asyncio.run(see())
    assert left == []
    fakes.wait_until(lambda: any(isinstance(each, ReleaseControl) for each in server.operations))


def test_a_cancellation_while_the_client_closes_is_not_swallowed(server):
    left = []

    async def watch():
        async with AsyncClient(server.address):
            asyncio.current_task().cancel()
        left.append("the block was left as if nothing were")

    async def see():
        with pytest.raises(asyncio.CancelledError):
            await asyncio.create_task(watch())

    asyncio.run(see())
    assert left == []


def test_a_fault_of_the_repetition_is_lost_control(server, monkeypatch):
    async def fail(self):
        raise ZeroDivisionError("a fault")

    monkeypatch.setattr(AsyncControl, "_repeat", fail)

    async def fly():
        async with AsyncClient(server.address) as client, client.control() as c:
            while not c.lost:
                await asyncio.sleep(0)
            with pytest.raises(WorkbenchError, match="the client failed: ZeroDivisionError"):
                c.velocity(1.0, 0.0, 0.0)

    asyncio.run(fly())
