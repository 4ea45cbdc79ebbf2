"""Trajectories of joints that move servos: by hand, and under the lease of a scripted server."""

import asyncio
import dataclasses
import math
from types import SimpleNamespace

import pytest

pytest.importorskip("cyclonedds", reason="install the extra `ros2` to try it")

from tests.extras.gateways.conftest import until
from workbench.common.errors import WorkbenchError
from workbench.extras.gateways.ros2_orders import OrderExecutor
from workbench.extras.gateways.ros2_servos import ServoMover
from workbench.extras.gateways.ros2_trajectory import TrajectoryOrder, servo_trajectory
from workbench.link import AsyncClient
from workbench.link.drone_topics import drone_topics
from workbench.link.hello import ParameterRow
from workbench.link.messages import ReleaseControl, RequestControl, SetParameters
from workbench.link.signal import TopicOptions

ROWS = (
    ParameterRow("kp_pitch", "1/s^2", 0.0, 1000.0, 100.0, "gain"),
    ParameterRow("servo_tilt_front", "rad", -0.8, 1.6, 0.0, "setpoint"),
    ParameterRow("servo_winch", "m/s", -1.0, 1.0, 0.0, "setpoint"),
)
PRESENT = {"kp_pitch": 100.0, "servo_tilt_front": 0.2, "servo_winch": 0.0}


def point(seconds, positions=(), velocities=(), effort=()):
    whole, rest = divmod(round(seconds * 1e9), 1_000_000_000)
    duration = SimpleNamespace(sec=whole, nanosec=rest)
    return SimpleNamespace(
        positions=positions, velocities=velocities, effort=effort, time_from_start=duration
    )


def order(joints, *points, start=0.0):
    return TrajectoryOrder(tuple(joints), points, start)


def test_setpoints_are_linear_between_points_and_begin_where_the_servo_is():
    """The winch takes velocities; its joint and that of the tilt have other names in ROS."""
    wanted = order(
        ["tilt-front", "winch"],
        point(1.0, (1.2, 9.0), (9.0, 0.5)),
        point(3.0, (0.2, 9.0), (9.0, -0.5)),
    )
    found = servo_trajectory(wanted, ROWS, PRESENT, now=10.0)
    for time, tilt, winch in [
        (10.0, 0.2, 0.0),
        (10.5, 0.7, 0.25),
        (11.0, 1.2, 0.5),
        (12.0, 0.7, 0.0),
        (13.0, 0.2, -0.5),
        (99.0, 0.2, -0.5),
    ]:
        setpoints = {"servo_tilt_front": tilt, "servo_winch": winch}
        assert found.at(time) == pytest.approx(setpoints), time
    at_once = servo_trajectory(order(["winch"], point(0.0, (), (0.5,))), ROWS, PRESENT, 10.0)
    assert at_once.at(10.0) == {"servo_winch": 0.5}
    stamped = servo_trajectory(
        order(["winch"], point(1.0, (), (0.5,)), start=9.5), ROWS, PRESENT, 10.0
    )
    assert stamped.at(10.0) == {"servo_winch": 0.25}


@pytest.mark.parametrize(
    ("wanted", "said"),
    [
        (order(["yaw"], point(1.0, (0.1,))), "no servo .* 'yaw': name tilt_front, winch"),
        (order([], point(1.0)), "names each of its joints once"),
        (order(["winch", "winch"], point(1.0, (), (0.1, 0.1))), "names each of its joints once"),
        (order(["winch"], point(1.0, (0.1,))), "a point has 0 velocities: .* servo_winch in m/s"),
        (order(["winch"], point(1.0, (), (math.nan,))), "not finite"),
        (order(["winch"], point(1.0, (), (0.1,)), point(1.0, (), (0.2,))), "has to increase"),
        (order(["winch"], point(1.0, (), (0.1,)), start=1.7e9), "let the node use_sim_time"),
        (order(["winch"], point(1.0, (), (0.1,)), start=-1e5), "let the node use_sim_time"),
    ],
    ids=lambda each: each if isinstance(each, str) else "",
)
def test_what_is_no_trajectory_is_refused_with_the_reason(wanted, said):
    with pytest.raises(WorkbenchError, match=said):
        servo_trajectory(wanted, ROWS, PRESENT, now=10.0)


def test_a_drone_without_servos_says_so():
    with pytest.raises(WorkbenchError, match="this drone has none"):
        servo_trajectory(order(["tilt"], point(1.0, (0.1,))), ROWS[:1], PRESENT, now=10.0)


@pytest.fixture
def server(fakes, monkeypatch):
    """A scripted server of a drone with two servos."""
    topics = drone_topics(TopicOptions(4, 200.0, 10.0, joints=("tilt-front", "winch")))
    by_name = {topic.name.rsplit("/", 1)[1]: topic for topic in topics}
    monkeypatch.setattr(fakes, "BY_NAME", fakes.BY_NAME | by_name)
    server = fakes.FakeServer()
    hello = server.hello
    server.hello = lambda peer: dataclasses.replace(hello(peer), topics=topics, parameters=ROWS)
    yield server
    server.close()


def move(server, test):
    """Run a test with a mover of servos at 10 s of the flight, and the sentences for its user."""

    async def inner():
        async with AsyncClient(server.address, name="ros2") as client:
            said = []
            executor = OrderExecutor(client, said.append)
            mover = ServoMover(client, executor, said.append)

            async def pass_time(seconds):
                t_ns = round(seconds * 1e9)
                await until(lambda: server.peers and server.peers[-1].topics)
                server.publish(t_ns, joint_states=((0.0, 0.0), (0.0, 0.0)), on_off_state=(0,))
                await until(lambda: (found := client.latest("joint_states")) and found.t_ns == t_ns)
                await mover.look()

            await pass_time(10.0)
            try:
                await test(mover, executor, pass_time, said)
            finally:
                await executor.release()

    asyncio.run(inner())


def test_a_trajectory_is_flown_in_simulated_time_under_the_lease(server):
    async def test(mover, executor, pass_time, said):
        await mover.start(order(["winch"], point(0.0, (), (0.0,)), point(1.0, (), (0.5,))))
        for time in (10.0, 10.05, 10.2, 10.21, 10.6, 10.95, 11.0):
            await pass_time(time)
        sent = [each.set["servo_winch"] for each in server.heard(SetParameters)]
        # at most ten a second, and the end at its time
        assert sent == pytest.approx([0.0, 0.1, 0.3, 0.475, 0.5])
        assert len(server.heard(RequestControl)) == 1 and not server.heard(ReleaseControl)
        assert said == ["control was granted: a ROS 2 program flies", "joint_trajectory is done"]
        server.publish(12_500_000_000, on_off_state=(0,))
        await until(lambda: executor._client.latest("on_off_state").t_ns == 12_500_000_000)
        await executor.look()
        assert len(server.heard(ReleaseControl)) == 1  # a second after the last setpoint

    move(server, test)


def test_a_refused_setpoint_and_lost_control_end_a_trajectory(server):
    async def test(mover, executor, pass_time, said):
        wanted = order(["winch"], point(0.0, (), (0.0,)), point(9.0, (), (9.0,)))
        server.refuse(SetParameters, "out_of_range", "servo_winch is at most 1")
        await mover.start(wanted)
        await pass_time(10.1)
        await pass_time(10.3)
        assert len(server.heard(SetParameters)) == 1
        assert said[-1] == "joint_trajectory has ended: refused: servo_winch is at most 1"
        server.answer = lambda peer, asked: None
        await mover.start(wanted)
        await executor.release()
        await pass_time(10.5)
        assert said[-1].startswith("joint_trajectory has ended: this gateway has no control")
        server.refuse(RequestControl, "held", "the operator at the screen flies")
        await mover.start(wanted)
        assert said[-1] == "joint_trajectory: refused: the operator at the screen flies"
        await pass_time(10.7)
        assert len(server.heard(SetParameters)) == 1

    move(server, test)


def test_a_newer_trajectory_replaces_one_and_one_without_points_ends_it(server):
    async def test(mover, executor, pass_time, said):
        long = order(["winch"], point(0.0, (), (0.0,)), point(9.0, (), (0.9,)))
        await mover.start(long)
        await pass_time(11.0)
        await mover.start(order(["tilt-front"], point(0.0, (1.0,))))
        await pass_time(11.1)
        assert said[-1] == "joint_trajectory is done"
        await mover.start(long)
        await mover.start(order([]))
        await pass_time(12.0)
        sets = [dict(each.set) for each in server.heard(SetParameters)]
        assert sets == [{"servo_winch": pytest.approx(0.1)}, {"servo_tilt_front": 1.0}]

    move(server, test)


def test_a_service_meanwhile_leaves_a_trajectory_its_control(server):
    """A second after it the rotors still stand still, as during the whole trajectory."""

    async def test(mover, executor, pass_time, said):
        await mover.start(order(["winch"], point(0.0, (), (0.0,)), point(9.0, (), (0.9,))))
        await executor.operate("stop")
        for time in (10.5, 11.5, 13.0):
            await pass_time(time)
            await executor.look()
        assert not server.heard(ReleaseControl)
        assert server.heard(SetParameters)[-1].set["servo_winch"] == pytest.approx(0.3)

    move(server, test)
