"""The lease and its ladder, with times by hand; see docs/protocol.md."""

import math
import struct

import pytest

from workbench.link.authority import Authority, CommandLimits, DeniedError, SilenceEffect
from workbench.link.backplane import VelocityCommand
from workbench.link.messages import ControlOwner, LinkLossStage

LIMITS = CommandLimits(8.0, 6.0, 0.4)


def ulp(value: float, steps: int) -> float:
    """Return the float of 32 bits so many steps away."""
    (bits,) = struct.unpack("<i", struct.pack("<f", value))
    return struct.unpack("<f", struct.pack("<i", bits + steps))[0]


@pytest.fixture
def authority() -> Authority:
    numbers = iter(range(101, 200))
    return Authority(LIMITS, lambda: next(numbers))


def command(lease, velocity=(0.0, 0.0, 0.0), yaw_rate=0.0, *, at=0.0, axes=15, peer=1):
    return VelocityCommand(peer, 1, round(at * 1e9), lease, axes, velocity, yaw_rate)


def flying(authority, now=0.0, peer=1) -> int:
    """Let a client hold the lease and have begun from neutral; return the lease."""
    lease = authority.request(peer, f"client {peer}", now)
    authority.effect_due(now)
    authority.command(command(lease, at=now, peer=peer), now)
    return lease


def code_of(call) -> str:
    with pytest.raises(DeniedError) as caught:
        call()
    assert str(caught.value)
    return caught.value.code


def test_at_first_nobody_flies(authority):
    state = authority.state(3.0)
    assert (state.hand, state.peer, state.stage) == (ControlOwner.NOBODY, 0, LinkLossStage.LIVE)
    assert authority.effect_due(100.0) is None
    assert code_of(lambda: authority.command(command(101), 3.0)) == "not_holder"


def test_a_grant_holds_first_and_is_for_one(authority):
    assert authority.request(1, "one", 2.0) == 101
    assert authority.effect_due(2.0) is SilenceEffect.HOLD
    assert authority.effect_due(2.0) is None
    assert code_of(lambda: authority.request(2, "two", 2.1)) == "held"
    assert code_of(lambda: authority.request(1, "one", 2.1)) == "held"
    state = authority.state(2.25)
    assert (state.hand, state.peer, state.name, state.age) == (ControlOwner.CLIENT, 1, "one", 0.25)


@pytest.mark.parametrize(
    ("peer", "lease"), [(1, 0), (1, 102), (2, 101), (2, 0)], ids=["0", "another", "peer", "both"]
)
def test_only_the_holder_with_its_lease_commands(authority, peer, lease):
    flying(authority)
    assert code_of(lambda: authority.command(command(lease, peer=peer), 0.1)) == "not_holder"
    assert code_of(lambda: authority.check(peer, lease, 0.1)) == "not_holder"


def test_the_first_command_must_be_neutral(authority):
    lease = authority.request(1, "", 0.0)
    fast = command(lease, (1.0, 0.0, 0.0))
    assert code_of(lambda: authority.command(fast, 0.1)) == "neutral_first"
    authority.command(command(lease), 0.1)
    assert authority.command(fast, 0.2).velocity == (1.0, 0.0, 0.0)


def test_unused_axes_are_flown_as_zero(authority):
    lease = flying(authority)
    flown = authority.command(command(lease, (1.0, 2.0, 3.0), 0.3, axes=0b0101), 0.1)
    assert flown.velocity == (1.0, 0.0, 3.0)
    assert flown.yaw_rate == 0.0


def test_the_ladder(authority):
    """Last command at 1 s: HOLD at 1.5, anybody may ask at 3, LAND at 6."""
    lease = flying(authority, 1.0)
    assert authority.effect_due(1.499) is None
    assert authority.effect_due(1.5) is SilenceEffect.HOLD
    assert authority.effect_due(1.6) is None
    assert code_of(lambda: authority.command(command(lease, at=1.6), 1.6)) == "not_holder"
    assert code_of(lambda: authority.request(2, "two", 2.999)) == "held"
    assert authority.state(2.999).hand is ControlOwner.CLIENT
    assert authority.effect_due(3.0) is None
    assert (authority.state(3.0).hand, authority.state(3.0).stage) == (
        ControlOwner.NOBODY,
        LinkLossStage.LOST,
    )
    assert authority.effect_due(5.999) is None
    assert authority.effect_due(6.0) is SilenceEffect.LAND
    assert authority.effect_due(7.0) is None
    assert authority.state(7.0).stage is LinkLossStage.LAND


def test_a_grant_waits_for_a_round_trip(authority):
    """Only the first sign of life, be it an operation, may take that long."""
    lease = authority.request(1, "far", 1.0)
    assert authority.effect_due(1.0) is SilenceEffect.HOLD
    authority.check(1, lease, 2.499)
    assert authority.effect_due(2.499) is None
    assert authority.effect_due(2.5) is SilenceEffect.HOLD
    lease = authority.request(1, "far", 2.9)
    authority.effect_due(2.9)
    authority.renew(4.3)
    assert authority.effect_due(4.799) is None
    assert authority.effect_due(4.8) is SilenceEffect.HOLD
    assert "0.5 s" in authority.state(4.8).reason


def test_a_leap_of_time_misses_no_rung(authority):
    flying(authority, 1.0)
    assert authority.effect_due(60.0) is SilenceEffect.HOLD
    assert authority.effect_due(60.0) is SilenceEffect.LAND
    assert authority.effect_due(60.0) is None


def test_a_rung_that_a_refusal_climbs_is_still_told(authority):
    lease = flying(authority, 1.0)
    code_of(lambda: authority.command(command(lease, at=60.0), 60.0))
    assert authority.effect_due(60.0) is SilenceEffect.HOLD
    assert authority.effect_due(60.0) is SilenceEffect.LAND


def test_the_silent_holder_may_ask_again_and_begins_from_neutral(authority):
    old = flying(authority, 1.0)
    authority.effect_due(1.5)
    lease = authority.request(1, "one", 1.9)
    assert lease != old
    assert authority.effect_due(1.9) is SilenceEffect.HOLD
    fast = command(lease, (1.0, 0.0, 0.0), at=1.9)
    assert code_of(lambda: authority.command(fast, 1.95)) == "neutral_first"
    assert code_of(lambda: authority.command(command(old, at=1.9), 1.95)) == "not_holder"


def test_no_lease_is_none_that_a_silent_holder_has(authority):
    """While it is silent the holder has no lease, which the wire writes as 0."""
    for now in (1.6, 3.1, 6.1):  # it holds, is lost, lands
        flying(authority, 1.0)
        assert code_of(lambda now=now: authority.check(1, 0, now)) == "not_holder"
        assert code_of(lambda now=now: authority.command(command(0, at=now), now)) == "not_holder"
        assert authority.state(now).age == pytest.approx(now - 1.0)
        authority.begin(1.0, "given back")


def test_another_takes_over_what_is_lost_and_nothing_lands(authority):
    flying(authority, 1.0)
    authority.effect_due(3.0)
    lease = authority.request(2, "two", 4.0)
    authority.command(command(lease, at=4.0, peer=2), 4.25)
    authority.effect_due(4.3)
    assert authority.effect_due(4.7) is None
    authority.command(command(lease, at=4.7, peer=2), 4.7)
    assert authority.effect_due(6.0) is SilenceEffect.HOLD  # its own silence, since 4.7
    assert authority.effect_due(6.5) is None


def test_a_connection_that_ends_frees_the_lease_and_lands_later(authority):
    flying(authority, 1.0)
    authority.gone(2)
    assert authority.state(1.1).hand is ControlOwner.CLIENT
    authority.gone(1)
    assert authority.effect_due(1.125) is SilenceEffect.HOLD
    assert authority.state(1.125).hand is ControlOwner.NOBODY
    assert authority.effect_due(5.9) is None
    assert authority.effect_due(6.0) is SilenceEffect.LAND


def test_who_has_let_go_is_not_landed(authority):
    lease = flying(authority, 1.0)
    assert code_of(lambda: authority.check(2, lease, 1.1)) == "not_holder"
    authority.release(1.1)
    assert authority.effect_due(1.125) is SilenceEffect.HOLD
    assert authority.effect_due(100.0) is None
    assert authority.request(2, "two", 1.2)


def test_the_operator_wins_and_gives_back(authority):
    lease = flying(authority, 1.0)
    authority.take_over(1.1)
    assert authority.state(1.1).hand is ControlOwner.OPERATOR
    assert code_of(lambda: authority.command(command(lease, at=1.1), 1.1)) == "not_holder"
    assert code_of(lambda: authority.request(2, "two", 50.0)) == "held"
    assert authority.effect_due(50.0) is None
    authority.begin(51.0, "given back")
    assert authority.request(2, "two", 51.0)


def test_taking_over_from_a_client_lets_the_drone_hold_and_from_nobody_it_flies_on(authority):
    assert authority.take_over(0.5) is False  # nobody flew
    authority.begin(1.0, "given back")
    flying(authority, 1.0)
    assert authority.take_over(1.1) is True  # else the client's last velocity flies on
    assert authority.take_over(1.2) is False  # the operator flies already


@pytest.mark.parametrize(
    ("at", "now", "right"),
    [
        (9.0, 10.0, True),
        (8.999, 10.0, False),
        (10.0, 10.0, True),
        (10.001, 10.0, False),
        (-1e9, 10.0, False),
    ],
)
def test_a_command_on_an_old_or_coming_state_is_dropped(authority, at, now, right):
    lease = flying(authority, 9.9)
    if right:
        authority.command(command(lease, at=at), now)
        assert authority.state(now).age == 0.0
    else:
        assert code_of(lambda: authority.command(command(lease, at=at), now)) == "stale"
        assert authority.state(now).age == pytest.approx(0.1)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("field", range(4))
@pytest.mark.parametrize("axes", [15, 1, 8])
def test_what_is_not_finite_refuses_the_whole_and_renews_nothing(authority, field, bad, axes):
    lease = flying(authority)
    numbers = [0.0] * 4
    numbers[field] = bad
    wrong = command(lease, tuple(numbers[:3]), numbers[3], at=0.3, axes=axes)
    assert code_of(lambda: authority.command(wrong, 0.3)) == "not_finite"
    assert authority.effect_due(0.5) is SilenceEffect.HOLD


@pytest.mark.parametrize("axes", [0, 16, 31, 2**32 - 1])
def test_axes_must_be_there(authority, axes):
    lease = flying(authority)
    assert code_of(lambda: authority.command(command(lease, axes=axes), 0.1)) == "no_axes"


@pytest.mark.parametrize(
    ("velocity", "yaw_rate", "flown", "turn"),
    [
        ((8.0, 0.0, 0.0), 0.0, (8.0, 0.0, 0.0), 0.0),
        ((0.0, -16.0, 0.0), 0.0, (0.0, -8.0, 0.0), 0.0),
        ((6.0, 8.0, 0.0), 0.0, (4.8, 6.4, 0.0), 0.0),
        ((6.0, 8.0, 3.0), 0.2, (4.8, 6.4, 3.0), 0.2),
        ((0.0, 0.0, -9.0), 0.0, (0.0, 0.0, -6.0), 0.0),
        ((1.0, 0.0, 0.0), 0.6, (1.0, 0.0, 0.0), 0.4),
    ],
)
def test_over_a_limit_the_direction_is_kept(authority, velocity, yaw_rate, flown, turn):
    lease = flying(authority)
    done = authority.command(command(lease, velocity, yaw_rate), 0.1)
    assert done.velocity == pytest.approx(flown, rel=1e-7)
    assert done.yaw_rate == pytest.approx(turn, rel=1e-7)
    assert bool(done.scaled) == (flown != velocity or turn != yaw_rate)


@pytest.mark.parametrize(("field", "limit"), [(0, 8.0), (1, 8.0), (2, 6.0), (3, 0.4)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_limits_are_those_of_the_wire(authority, field, limit, sign):
    """A float of 32 bits: the limit itself passes, the next one is scaled, twice it refused."""
    lease = flying(authority)

    def asked(value):
        numbers = [0.0] * 4
        numbers[field] = sign * value
        return command(lease, tuple(numbers[:3]), numbers[3])

    for value, scaled in ((ulp(limit, -1), False), (ulp(limit, 0), False), (ulp(limit, 1), True)):
        assert bool(authority.command(asked(value), 0.1).scaled) is scaled
    assert authority.command(asked(ulp(2.0 * limit, 0)), 0.1).scaled
    assert code_of(lambda: authority.command(asked(ulp(2.0 * limit, 1)), 0.1)) == "too_fast"


def test_a_flight_that_begins_anew_belongs_to_nobody(authority):
    lease = flying(authority, 9.0)
    authority.begin(0.0, "anew")
    assert authority.state(0.0).hand is ControlOwner.NOBODY
    assert code_of(lambda: authority.command(command(lease), 0.0)) == "not_holder"
    assert authority.effect_due(100.0) is None
