"""Orders of ROS 2 under the link's lease, against a scripted server."""

import asyncio
import math
import time
from types import SimpleNamespace

import pytest

pytest.importorskip("cyclonedds", reason="install the extra `ros2` to try it")

from tests.extras.gateways.conftest import until
from workbench.extras.gateways import ros2, ros2_orders
from workbench.extras.gateways.ros2_orders import (
    OperationOrder,
    OrderExecutor,
    VelocityOrder,
)
from workbench.link import AsyncClient
from workbench.link.messages import (
    ControlOwner,
    ControlState,
    FlightOperation,
    LinkLossStage,
    Nack,
    ReleaseControl,
    RequestControl,
)
from workbench.link.wire import WireFrame

ONE, OTHER = 1, 2
NORTH = (0.0, 0.0, 1.0, 0.0, 0.0, math.pi / 2, 0.0, 0.0, 0.0)


def forward(speed, publisher=ONE):
    return VelocityOrder(publisher, (speed, 0.0, 0.0), 0.0, levelled=True)


def rest(publisher=ONE):
    return forward(0.0, publisher)


@pytest.fixture(autouse=True)
def patience(monkeypatch):
    """Let no order be too late because the machine is slow."""
    monkeypatch.setattr(ros2_orders, "MAX_ORDER_AGE_S", 3600.0)


class Flying:
    """A `OrderExecutor` at a scripted server, and what it said."""

    def __init__(self, server, client):
        self.server, self.client = server, client
        self.said = []
        self.commanding = OrderExecutor(client, self.said.append)

    async def execute(self, *orders, waited=0.0):
        since = asyncio.get_running_loop().time() - waited
        for order in orders:
            await self.commanding.execute(order, since)

    async def commands(self, count):
        """Return the velocities that arrived, as soon as there are so many."""
        await until(lambda: len(self.server.commands) >= count)
        return [values[2:] for _, values in self.server.commands]

    def asked(self, kind):
        return [each for each in self.server.operations if isinstance(each, kind)]

    async def lose(self):
        """Let the server's ladder take control."""
        lost = ControlState(
            ControlOwner.CLIENT, 1, "ros2", LinkLossStage.HOLD, 0.5, "ros2 was silent"
        )
        self.server.say(lost)
        await until(lambda: self.client.control_state == lost)
        await self.commanding.look()


def run(server, test):
    async def inner():
        async with AsyncClient(server.address, name="ros2") as client:
            await until(lambda: server.peers and server.peers[-1].topics)
            server.publish(6_000_000_000, position_data=NORTH)
            await until(lambda: client.latest("position_data"))
            flying = Flying(server, client)
            try:
                await test(flying)
            finally:
                await flying.commanding.release()

    asyncio.run(inner())


def test_a_velocity_of_zero_asks_for_control(server):
    async def test(flying):
        assert not flying.asked(RequestControl)
        await flying.execute(rest(), forward(1.5))
        *neutral, flown = await flying.commands(3)
        assert set(neutral) == {(0.0, 0.0, 0.0, 0.0)}
        assert flown == pytest.approx((0.0, 1.5, 0.0, 0.0), abs=1e-6)
        assert flying.said == ["control was granted: a ROS 2 program flies"]

    run(server, test)


def test_nobody_takes_over_with_a_stick_pushed(server):
    async def test(flying):
        await flying.execute(
            forward(1.0), forward(1.0), VelocityOrder(ONE, (0.0, 0.0, 0.0), 0.1, False)
        )
        assert not flying.asked(RequestControl)
        assert set(flying.said) == {
            "nobody takes over in full flight: begin with a velocity of zero"
        }
        await flying.execute(OperationOrder(OTHER, "take_off"), forward(1.0))  # another has control
        await flying.execute(rest(), forward(2.0))
        assert [each[1] for each in await flying.commands(3)] == pytest.approx([0.0, 0.0, 2.0])

    run(server, test)


def test_nothing_is_repeated_so_that_silence_reaches_the_drone(server):
    async def test(flying):
        await flying.execute(rest(), forward(2.0))
        await flying.commands(3)
        for step in range(1, 11):  # time goes on, states and answers come
            server.publish(6_000_000_000 + step * 200_000_000, position_data=NORTH)
            await flying.client.ping()
        await asyncio.sleep(0.2)  # several times the period at which controls are repeated
        assert len(await flying.commands(3)) == 3
        assert not flying.asked(ReleaseControl)

    run(server, test)


def test_the_end_gives_control_back(server):
    async def test(flying):
        await flying.execute(rest())
        await flying.commanding.release()
        assert len(flying.asked(ReleaseControl)) == 1

    run(server, test)


def test_who_lost_control_begins_with_zero(server):
    async def test(flying):
        await flying.execute(rest(), forward(1.0))
        await flying.commands(3)
        await flying.lose()
        assert flying.said[-1] == "control was lost: ros2 was silent; to continue, begin with zero"
        await flying.execute(forward(1.0), forward(1.0))
        assert len(flying.asked(RequestControl)) == 1
        assert flying.said[-1].endswith("begin with a velocity of zero")
        await flying.execute(rest(), forward(1.0))
        assert len(flying.asked(RequestControl)) == 2
        assert (await flying.commands(6))[-1][1] == pytest.approx(1.0)
        assert not flying.asked(ReleaseControl)  # the ladder was not stopped

    run(server, test)


def test_another_program_does_not_fly_between(server):
    async def test(flying):
        await flying.execute(rest(), forward(1.0), forward(2.0, OTHER), rest(OTHER), forward(3.0))
        speeds = [command[1] for command in await flying.commands(4)]
        assert speeds == pytest.approx([0.0, 0.0, 1.0, 3.0], abs=1e-6)
        assert "another ROS 2 program flies already: one at a time" in flying.said
        await flying.lose()
        await flying.execute(forward(2.0, OTHER))  # it was refused: it may not just go on
        assert len(flying.asked(RequestControl)) == 1

    run(server, test)


def test_a_refusal_is_said_and_control_is_not_asked_for_by_who_goes_on(server, monkeypatch):
    monkeypatch.setattr(ros2_orders, "CONTROL_RETRY_S", 0.0)

    async def test(flying):
        server.refuse(RequestControl, "held", "the operator at the screen flies")
        await flying.execute(rest())
        assert flying.said == ["refused: the operator at the screen flies"]
        server.answer = lambda peer, operation: None
        await flying.execute(forward(1.0), forward(1.0))
        assert len(flying.asked(RequestControl)) == 1
        await flying.execute(rest())
        assert len(flying.asked(RequestControl)) == 2

    run(server, test)


def test_control_is_not_asked_for_with_every_message(server):
    async def test(flying):
        server.refuse(RequestControl, "held", "the operator at the screen flies")
        await flying.execute(*[rest()] * 20)
        assert len(flying.asked(RequestControl)) == 1
        await flying.execute(OperationOrder(ONE, "land"))  # which is no stream
        assert len(flying.asked(RequestControl)) == 2

    run(server, test)


@pytest.mark.parametrize("speed", [math.nan, math.inf, 1e39])
def test_what_is_no_velocity_is_not_sent(server, speed):
    async def test(flying):
        await flying.execute(rest(), forward(speed))
        assert "all must be finite numbers" in flying.said[-1]
        await flying.execute(rest())
        assert all(map(math.isfinite, sum(await flying.commands(3), ())))

    run(server, test)


def test_a_refused_velocity_is_said_in_the_flights_words(server):
    async def test(flying):
        await flying.execute(rest())
        await flying.commands(2)
        server.answer = lambda peer, sent: (
            Nack("too_fast", "the level speed is 99 m/s", seq=sent.seq)
            if isinstance(sent, WireFrame)
            else None
        )
        await flying.execute(forward(99.0))
        await flying.commands(3)
        server.answer = lambda peer, sent: None
        await flying.client.ping()
        await flying.execute(forward(1.0))
        assert "the level speed is 99 m/s" in flying.said[-1]

    run(server, test)


def test_flight_operations_are_carried_out(server):
    async def test(flying):
        await flying.execute(OperationOrder(ONE, "take_off", 2.5), OperationOrder(ONE, "land"))
        done = [(each.what, each.height) for each in flying.asked(FlightOperation)]
        assert done[0] == ("take_off", 2.5)
        assert done[1][0] == "land"
        assert flying.said[-2:] == ["take_off has started", "land has started"]

    run(server, test)


def test_one_program_may_land_what_another_flies(server):
    async def test(flying):
        await flying.execute(rest(), OperationOrder(OTHER, "land"), forward(2.0))
        assert [each.what for each in flying.asked(FlightOperation)] == ["land"]
        assert len(flying.asked(RequestControl)) == 1
        assert (await flying.commands(3))[-1][1] == pytest.approx(2.0)

    run(server, test)


def test_one_program_may_fly_on_when_another_has_taken_off(server):
    async def test(flying):
        await flying.execute(OperationOrder(ONE, "take_off"), rest(OTHER), forward(1.0, OTHER))
        assert (await flying.commands(3))[-1][1] == pytest.approx(1.0)
        await flying.execute(forward(2.0, ONE))
        assert flying.said[-1].startswith("another ROS 2 program flies already")
        assert len(flying.asked(RequestControl)) == 1

    run(server, test)


@pytest.mark.parametrize("order", [forward(1.0), rest(), OperationOrder(ONE, "take_off")])
def test_an_order_that_waited_behind_others_is_not_carried_out(server, order):
    async def test(flying):
        await flying.execute(rest())
        await flying.commands(2)
        await flying.execute(order, waited=4000.0)
        assert flying.said[-1].startswith("an order was not carried out: it waited up to 4000")
        await flying.client.ping()
        assert len(server.commands) == 2
        assert not flying.asked(FlightOperation)

    run(server, test)


def test_an_old_order_does_not_ask_for_control(server):
    async def test(flying):
        await flying.execute(rest(), OperationOrder(ONE, "take_off"), waited=4000.0)
        assert not flying.asked(RequestControl)

    run(server, test)


def test_an_order_that_waited_for_control_is_not_carried_out(server):
    async def test(flying):
        ask = flying.commanding._ask

        async def ask_long():
            control = await ask()
            ros2_orders.MAX_ORDER_AGE_S = -1.0  # it took too long; `patience` puts it right again
            return control

        flying.commanding._ask = ask_long
        await flying.execute(OperationOrder(ONE, "take_off"))
        assert flying.said[-1].startswith("an order was not carried out")
        assert len(flying.asked(RequestControl)) == 1
        assert not flying.asked(FlightOperation)

    run(server, test)


def test_what_came_while_an_operation_was_answered_is_old(server, monkeypatch):
    """The age counts from the last look at what has come, not from when its turn is."""
    monkeypatch.setattr(ros2_orders, "MAX_ORDER_AGE_S", 0.2)
    looks = iter([[OperationOrder(ONE, "land")], [rest()]])
    server.answer = lambda peer, sent: (
        time.sleep(0.5) if isinstance(sent, FlightOperation) else None
    )

    async def nothing():
        pass

    async def test(flying):
        node, servos = SimpleNamespace(serve=nothing), SimpleNamespace(look=nothing)
        taking = asyncio.create_task(
            ros2._take_orders(flying.commanding, lambda: next(looks, []), node, servos)
        )
        await until(lambda: len(flying.said) == 3)
        taking.cancel()
        assert flying.said[1] == "land has started"
        assert flying.said[2].startswith("an order was not carried out: it waited up to")
        await asyncio.gather(taking, return_exceptions=True)

    run(server, test)


@pytest.mark.parametrize("what", ["land", "stop"])
def test_what_ends_a_flight_is_never_too_late(server, what):
    async def test(flying):
        await flying.execute(OperationOrder(ONE, what), waited=4000.0)
        assert [each.what for each in flying.asked(FlightOperation)] == [what]

    run(server, test)


def test_what_is_unclear_is_said(server):
    async def test(flying):
        await flying.execute("that is no order")
        assert flying.said == ["that is no order"]
        assert not flying.asked(RequestControl)

    run(server, test)


def test_without_a_heading_nothing_is_flown(server):
    async def test():
        async with AsyncClient(server.address) as client:
            flying = Flying(server, client)
            await flying.execute(rest())
            assert "heading is not known yet" in flying.said[-1]
            assert await flying.commands(1) == [(0.0, 0.0, 0.0, 0.0)]
            await flying.commanding.release()

    asyncio.run(test())
