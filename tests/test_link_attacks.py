"""Strangers attack for 5 s each and kill the server every 5 s: the pilot flies, the owner gets in.

`benchmarks/link_attacks.py` does the same for a minute each, with how long commands take.
"""

import importlib
import math

import pytest

pytestmark = pytest.mark.slow

SECONDS = 3.0
KILLS = 4
ATTACKS = (
    "pipelining",
    "continuations",
    "slow reads",
    "slow requests",
    "10,000 connections",
    "10,000 requests",
)


@pytest.fixture(scope="module")
def attacks():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend("benchmarks")
        yield importlib.import_module("link_attacks")


def test_all_attacks_are_tried(attacks):
    assert set(attacks.ATTACKS) == set(ATTACKS)


@pytest.mark.parametrize("name", ATTACKS)
def test_the_pilot_keeps_control_and_the_owner_of_the_token_gets_in(attacks, name):
    for row in attacks.measure(SECONDS, [name]):
        assert row.lost == 0, row
        assert row.commands > 0, row
        assert math.isfinite(row.login_worst), row
        assert row.connections >= row.clients, row


def test_a_flight_survives_the_kills_of_its_server(attacks):
    rows = attacks.measure_kills(KILLS, SECONDS)
    assert len(rows) == KILLS
    for row in rows:
        assert row.flown > 0.0, row
        assert math.isfinite(row.restart), row
