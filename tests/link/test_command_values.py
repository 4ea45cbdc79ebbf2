"""Every field of a command with every kind of number, in real frames through the real server.

What must come of each stands in docs/protocol.md; the limits are those of hello.
"""

import importlib.util
import math
import struct
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from workbench.scenario.scenario import Rates, Scenario, ScenarioStart

CONTROL = Rates().control_period
FIELDS = ("v_x", "v_y", "v_z", "yaw_rate")
LARGEST = struct.unpack("<f", b"\xff\xff\x7f\x7f")[0]
DENORMAL = struct.unpack("<f", b"\x01\0\0\0")[0]


def _load():
    spec = importlib.util.spec_from_file_location("served", Path(__file__).with_name("served.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.load()


rig = _load()


@pytest.fixture(scope="module")
def served():
    with pytest.MonkeyPatch.context() as patch:
        served = rig.Served(
            patch, rig.build(Scenario(start=ScenarioStart(position=[0.0, 0.0, 9.0])))
        )
        served.fly(1.5)
        yield served
        served.flying._network.close()


@pytest.fixture
def holder(served):
    """A client that holds the lease, and is not silent."""
    holder = rig.Client(served, "Ada")
    holder.begin()
    served.fly(CONTROL)
    yield holder
    snapshot = served.session.snapshot()
    for vector in (snapshot.p_WB, snapshot.v_WB, snapshot.q_WB, snapshot.w_WB):
        assert np.isfinite(vector).all()
    holder.go()
    served.fly(CONTROL)


def limits(holder) -> tuple[float, ...]:
    """Return the limit of each field, as a float of 32 bits has it."""
    found = holder.said[0]["limits"]
    level, climb, turn = (found[each] for each in ("level_speed", "climb_rate", "yaw_rate"))
    return tuple(float(np.float32(each)) for each in (level, level, climb, turn))


def ulp(value: float, steps: int) -> float:
    """Return the float of 32 bits so many steps away."""
    (bits,) = struct.unpack("<i", struct.pack("<f", value))
    return struct.unpack("<f", struct.pack("<i", bits + steps))[0]


VALUES = {
    "NaN": (lambda limit: math.nan, "not_finite"),
    "infinite": (lambda limit: math.inf, "not_finite"),
    "largest": (lambda limit: LARGEST, "too_fast"),
    "1e30": (lambda limit: 1e30, "too_fast"),
    "denormal": (lambda limit: DENORMAL, ""),
    "zero": (lambda limit: 0.0, ""),
    "below the limit": (lambda limit: ulp(limit, -1), ""),
    "limit": (lambda limit: limit, ""),
    "above the limit": (lambda limit: ulp(limit, 1), "scaled"),
    "twice the limit": (lambda limit: 2.0 * limit, "scaled"),
    "above twice": (lambda limit: ulp(2.0 * limit, 1), "too_fast"),
}


def test_a_number_is_refused_scaled_or_flown(served, holder, case):
    for field, name, sign in product(range(4), VALUES, (1.0, -1.0)):
        with case(FIELDS[field], name, sign):
            make, code = VALUES[name]
            limit = limits(holder)[field]
            before = served.session.snapshot().reference[:4]
            age, done = served.age(), len(served.script)
            numbers = [0.0] * 4
            numbers[field] = sign * make(limit)
            seq = holder.command(*numbers[:3], yaw_rate=numbers[3])
            served.fly(CONTROL)
            assert holder.nacks(seq) == ([code] if code else [])
            flown = served.session.snapshot().reference[:4]
            if code in ("", "scaled"):
                expected = list(numbers)
                if code:
                    expected[field] = math.copysign(limit, sign)
                assert list(flown) == pytest.approx(expected, rel=1e-12, abs=0.0)
                # it came into force with the update that began the period
                assert served.age() == CONTROL
            else:
                assert flown == before
                assert served.age() == age + CONTROL
                assert len(served.script) == done


def test_an_axis_that_is_not_used_must_be_finite_too(served, holder, case):
    for field, name in product(range(4), ("NaN", "infinite")):
        with case(FIELDS[field], name):
            numbers = [0.0] * 4
            numbers[field] = VALUES[name][0](0.0)
            seq = holder.command(*numbers[:3], yaw_rate=numbers[3], axes=15 & ~(1 << field))
            served.fly(CONTROL)
            assert holder.nacks(seq) == ["not_finite"]


def test_an_axis_that_is_not_used_may_be_large(served, holder, case):
    for field, name in product(range(4), ("largest", "1e30", "above twice")):
        with case(FIELDS[field], name):
            numbers = [0.0] * 4
            numbers[field] = VALUES[name][0](limits(holder)[field])
            seq = holder.command(*numbers[:3], yaw_rate=numbers[3], axes=15 & ~(1 << field))
            served.fly(CONTROL)
            assert holder.nacks(seq) == []
            assert served.session.snapshot().reference[:4] == (0.0, 0.0, 0.0, 0.0)


def test_a_vector_over_the_limit_keeps_its_direction(served, holder):
    """3, 4, 5: one and a half times the limit, with climb and turn below theirs."""
    level, _, climb, turn = limits(holder)
    asked = (0.9 * level, 1.2 * level, -0.5 * climb)
    seq = holder.command(*asked, yaw_rate=0.5 * turn)
    served.fly(CONTROL)
    assert holder.nacks(seq) == ["scaled"]
    flown = served.session.snapshot().reference[:4]
    expected = (0.6 * level, 0.8 * level, -0.5 * climb, 0.5 * turn)
    assert flown == pytest.approx(expected, rel=1e-6)


def test_axes_that_are_none_are_refused(served, holder, case):
    for axes in (0, 16, 31, 2**31, 2**32 - 1):
        with case(axes):
            age = served.age()
            seq = holder.command(1.0, 0.0, 0.0, axes=axes)
            served.fly(CONTROL)
            assert holder.nacks(seq) == ["no_axes"]
            assert served.age() == age + CONTROL


def test_axes_that_are_not_set_are_flown_as_zero(served, holder, case):
    for axes in range(1, 16):
        with case(axes):
            numbers = (0.5, -0.25, 0.125, 0.0625)
            holder.command(*numbers[:3], yaw_rate=numbers[3], axes=axes)
            served.fly(CONTROL)
            expected = tuple(number * (axes >> bit & 1) for bit, number in enumerate(numbers))
            assert served.session.snapshot().reference[:4] == expected


def test_only_the_lease_itself_commands(served, holder, case):
    """0, its neighbours, and one in which a bit is another one."""
    for change in (None, 1, -1, 2**31):
        with case(change):
            lease = 0 if change is None else (holder.lease + change) % 2**32
            age, done = served.age(), len(served.script)
            seq = holder.command(1.0, 0.0, 0.0, lease=lease)
            served.fly(CONTROL)
            assert holder.nacks(seq) == ["not_holder"]
            assert (served.age(), len(served.script)) == (age + CONTROL, done)


def test_the_lease_of_another_connection_is_of_no_use(served, holder):
    other = rig.Client(served, "Bob")
    seq = other.command(1.0, 0.0, 0.0, lease=holder.lease)
    served.fly(CONTROL)
    assert other.nacks(seq) == ["not_holder"]
    assert holder.nacks() == []
    other.go()


@pytest.mark.parametrize(
    ("age_ns", "code"),
    [
        (0, ""),
        (999_999_000, ""),
        (1_000_001_000, "stale"),
        (-500, ""),
        (-2_000, "stale"),
        (-(10**9), "stale"),
        (10**15, "stale"),
    ],
)
def test_a_command_acts_on_a_state_of_the_last_second(served, holder, age_ns, code):
    """The age counts at the control update that is due."""
    update_ns = round(served.time * 1e9)
    seq = holder.command(0.5, 0.0, 0.0, t_ns=update_ns - age_ns)
    served.fly(CONTROL)
    assert holder.nacks(seq) == ([code] if code else [])
    assert served.session.snapshot().reference[0] == (0.0 if code else 0.5)


def test_a_time_that_is_none_is_stale(served, holder, case):
    for t_ns in (-1, 0, -(2**63), 2**63 - 1):
        with case(t_ns):
            age = served.age()
            seq = holder.command(0.5, 0.0, 0.0, t_ns=t_ns)
            served.fly(CONTROL)
            assert holder.nacks(seq) == ["stale"]
            assert served.age() == age + CONTROL


@pytest.mark.parametrize("value", [-0.0, 0.0])
def test_both_zeros_are_neutral_and_a_denormal_is_not(served, value):
    holder = rig.Client(served, "Ada")
    assert holder.request()
    seq = holder.command(DENORMAL, 0.0, 0.0)
    served.fly(CONTROL)
    assert holder.nacks(seq) == ["neutral_first"]
    holder.command(value, value, value, yaw_rate=value)
    seq = holder.command(0.5, 0.0, 0.0)
    served.fly(CONTROL)
    assert holder.nacks(seq) == []
    assert served.session.snapshot().reference[0] == 0.5
    holder.go()
    served.fly(CONTROL)
