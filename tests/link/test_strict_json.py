"""JSON that two readers could take differently is refused, without a fuss."""

import json
import math

import pytest

from workbench.link.json_fields import MAX_JSON_DEPTH, read_json, write_json
from workbench.link.wire import WireError


def refusal(payload):
    with pytest.raises(WireError) as error:
        read_json(payload)
    assert error.value.code == "json"
    return str(error.value)


@pytest.mark.parametrize(
    "value",
    [
        {},
        {"a": [1, -2.5, True, None, "ü€𝄞", {"b": {}}]},
        {"t": 2**63 - 1, "u": -(2**63), "least": 5e-324, "largest": 1.7976931348623157e308},
        {"brackets in a text": "[[[[[[[[[[[[[[{{{{{{{{{{", "quote": '"\\"[[[[[[[[[[['},
    ],
)
def test_what_is_written_is_read(value):
    assert read_json(write_json(value)) == value


def test_what_is_refused_and_why(case):
    for payload, said in [
        (b'{"a":1,"a":2}', "'a' comes twice"),
        (b'{"x":[{"a":1,"a":1}]}', "'a' comes twice"),
        (b'{"a":NaN}', "NaN is not a number"),
        (b'{"a":Infinity}', "Infinity is not a number"),
        (b'{"a":1e400}', "1e400 is too large"),
        (b'{"a":' + b"9" * 5000 + b"}", "is too long"),
        (b'{"a":' + b"9" * 5000 + b".0}", "is too large"),
        (b'{"a":"\\uD834"}', "half of a surrogate pair"),
        (b'{"\\udd1e":1}', "half of a surrogate pair"),
        (b'{"a":"\xc3"}', "byte 6 is not UTF-8"),
        (b'{"a":"\xed\xa0\x80"}', "is not UTF-8"),
        (b"[1]", "an operation is an object"),
        (b"1", "an operation is an object"),
        (b"", "not strict JSON"),
        (b"{} {}", "not strict JSON"),
        (b'{"a":"\t"}', "not strict JSON"),
        (b'{"a":' * 100_000, "within each other"),
        (b"[" * 100_000, "within each other"),
    ]:
        with case(payload, said):
            assert said in refusal(payload)


def test_a_surrogate_pair_is_a_character():
    assert read_json(b'{"a":"\\ud834\\udd1e"}') == {"a": "𝄞"}


def test_depth_counts_brackets_outside_texts_only():
    def nested(depth):
        return b'{"x":' + b"[" * (depth - 1) + b"]" * (depth - 1) + b"}"

    assert read_json(nested(MAX_JSON_DEPTH))
    assert "within each other" in refusal(nested(MAX_JSON_DEPTH + 1))
    assert read_json(b'{"x":"' + b"[" * 1000 + b'"}')
    assert "within each other" in refusal(b'{"x":"\\\\",' + b'"y":' + b"[" * 9 + b"]" * 9 + b"}")
    assert read_json(b'{"x":"\\"' + b"[" * 1000 + b'"}')


@pytest.mark.parametrize("unit", [b'"\\', b'\\"', b'"', b'"\\"', b'{"', b'":'])
def test_no_payload_costs_the_square_of_its_length(unit):
    """2 MiB would take hours if the search for texts began anew at each quote."""
    refusal(unit * (2**21 // len(unit)))


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_not_written(value):
    with pytest.raises(ValueError):
        write_json({"a": [value]})


def test_half_of_a_surrogate_pair_is_not_sent_on():
    assert json.loads(write_json({"a": "x\ud800"})) == {"a": "x?"}
