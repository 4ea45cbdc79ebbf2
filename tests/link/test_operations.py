"""Operations are records with checked fields; what is wrong is said with the request's number."""

import json

import pytest

from workbench.link.codes import DeniedError, NackCode
from workbench.link.json_fields import read_json
from workbench.link.message_json import read_operation, write_operation
from workbench.link.messages import (
    Bye,
    FlightOperation,
    GetParameters,
    Login,
    Ping,
    ReleaseControl,
    RequestControl,
    Role,
    SetParameters,
    Subscribe,
)


def refused(**values):
    with pytest.raises(DeniedError) as error:
        read_operation(json.dumps(values).encode())
    return error.value


def test_what_is_written_is_read(case):
    for operation in [
        Login(),
        Login(1, "Zoë's phone", Role.VIEW, "t" * 1024),
        Login(1, "older", Role.VIEW, nonce="0f" * 16, proof="a5" * 32),
        Subscribe(),
        Subscribe(2, ("/dh_drone/imu",), 12.5),
        Subscribe(2, ()),
        RequestControl(),
        RequestControl(3, "joystick"),
        ReleaseControl(4, 2**32 - 1),
        FlightOperation(5, "take_off", 2.0, 7),
        FlightOperation(5, "stop", 1.5, 7),
        GetParameters(),
        GetParameters(6, ("kp_velocity_x",)),
        SetParameters(7, {"kp_velocity_x": 0.0}, 7),
        Ping(2**32 - 1),
        Bye(9),
    ]:
        with case(operation):
            assert read_operation(write_operation(operation)) == operation


def test_what_is_empty_is_not_written():
    assert read_json(write_operation(Login(name="a"))) == {"op": "login", "name": "a"}
    assert read_json(write_operation(Ping())) == {"op": "ping"}


def test_unknown_keys_are_ignored_and_unknown_operations_are_not():
    assert read_operation(b'{"op":"ping","id":3,"from":"the future"}') == Ping(3)
    error = refused(op="dance", id=12)
    assert (error.code, error.id) == (NackCode.UNKNOWN_OP, 12)
    assert "'dance' is unknown: known are login, subscribe, request_control" in error.said


def test_null_is_as_good_as_nothing():
    assert read_operation(b'{"op":"login","role":null,"name":null}') == Login()


def test_a_take_off_that_names_no_height_goes_to_a_metre_and_a_half():
    assert read_operation(b'{"op":"flight","what":"take_off","lease":1}').height == 1.5


def test_what_is_refused_and_why(case):
    for values, said in [
        ({"op": "subscribe", "topics": "all"}, 'subscribe: "topics" must be a list of at most 256'),
        ({"op": "subscribe", "topics": ["x" * 65]}, '"topics" must be a list'),
        (
            {"op": "subscribe", "topics": [], "rate": 0.05},
            '"rate" must be a number within 0.1 .. 10000',
        ),
        ({"op": "login", "name": "ü" * 25}, 'login: "name" must be a printable text of at most 48'),
        ({"op": "login", "role": True}, '"role" must be one of view, command'),
        ({"op": "login", "token": 7}, '"token" must be a printable text of at most 1024'),
        ({"op": "login", "token": "ü" * 513}, '"token" must be a printable text'),
        ({"op": "login", "proof": "0"}, '"proof" must be 64 hexadecimal digits'),
        ({"op": "login", "nonce": "٣" * 32}, '"nonce" must be 32 hexadecimal digits'),
        (
            {"op": "release_control", "lease": True},
            '"lease" must be an integer within 1 .. 4294967295',
        ),
        ({"op": "release_control", "lease": 2**32}, '"lease" must be an integer within'),
        ({"op": "flight", "what": "fly", "lease": 1}, "one of arm, take_off, land, stop"),
        ({"op": "flight", "what": "take_off", "lease": 1, "height": 0}, "above the ground"),
        ({"op": "parameters"}, 'parameters: give either "get" or "set"'),
        ({"op": "parameters", "set": {}, "lease": 1}, '"set" names no parameter'),
        ({"op": "parameters", "set": {"a\n": 1}, "lease": 1}, "a number for each name"),
        (
            {"op": "parameters", "set": {str(i): i for i in range(257)}, "lease": 1},
            "an object of at most 256 numbers",
        ),
    ]:
        with case(values, said):
            error = refused(**values, id=44)
            assert said in error.said
            assert (error.code, error.id) == (NackCode.BAD_VALUE, 44)


@pytest.mark.parametrize("number", [-1, 2**32, 1.5, "1", True, [], {}])
def test_a_false_id_is_not_echoed(number):
    error = refused(op="ping", id=number)
    assert error.id == 0
    assert error.said == '"id" must be an integer within 0 .. 4294967295'


def test_an_operation_of_another_type_is_refused():
    assert refused(op=5, id=3).said == '"op" must be a printable text of at most 48 bytes'
    assert refused(id=3).id == 3


def test_numbers_are_read_as_numbers():
    found = read_operation(b'{"op":"parameters","set":{"a":3},"lease":7.0}')
    assert found == SetParameters(0, {"a": 3.0}, 7)
    assert type(found.set["a"]) is float
    assert type(found.lease) is int
