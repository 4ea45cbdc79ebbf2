"""What is the same for all clients."""

import json

import pytest

from workbench.link.authentication import Tokens
from workbench.link.hello import Hello, ServerLimits
from workbench.link.messages import Login, Role
from workbench.link.server import policy as module
from workbench.link.server.policy import Policy


@pytest.mark.parametrize("tokens", [None, Tokens("v" * 16, "c" * 16)])
def test_hello_says_what_is_each_clients_own_and_what_is_all_clients(parts, tokens):
    flight = parts.make_flight()
    policy = Policy(flight, tokens, clients=9, server="s", session="5e")
    for peer, nonce, places in ((1, "00" * 16, 4), (2**40, "ff" * 16, 12)):
        level, climb, turn = flight.limits
        limits = ServerLimits(level, climb, turn, clients=9, clients_an_address=places)
        hello = Hello(
            "s",
            "5e",
            peer,
            "x500",
            nonce,
            tokens is not None,
            limits,
            flight.topics,
            flight.parameters,
        )
        said = json.loads(policy.hello(peer, nonce, places))
        assert said == {"op": "hello"} | json.loads(json.dumps(hello.values()))


def test_a_login_gets_no_more_than_it_asks_for_and_the_server_grants(parts, case):
    """Nobody has a role that commands on a server that takes no commands."""
    tokens = Tokens("v" * 16, "c" * 16)
    for known in (None, tokens):
        for allows in (True, False):
            policy = Policy(parts.make_flight(), known, allow_commands=allows)
            for asked in (Role.VIEW, Role.COMMAND, None):
                if known and asked is None:
                    continue  # refused
                login = Login(1, "a", asked, known.of(asked) if known else "")
                grants = allows and asked is not Role.VIEW
                with case(known is not None, allows, asked):
                    assert policy.role_of(login, "") is (Role.COMMAND if grants else Role.VIEW)


def test_what_all_clients_are_told_is_written_once(parts, monkeypatch):
    policy = Policy(parts.make_flight())
    policy.hello(1, "00" * 16, 4)
    written = []
    write = module.write_json

    def note(value):
        written.append(write(value))
        return written[-1]

    monkeypatch.setattr(module, "write_json", note)
    assert len(policy.hello(2, "11" * 16, 4)) > 2000
    assert sum(map(len, written)) < 1000
