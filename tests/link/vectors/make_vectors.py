"""Writes the golden vectors beside it: `python make_vectors.py`.

It knows the protocol from docs/protocol.md and imports nothing of the workbench, so that a mistake
in ours cannot hide in the vectors. HMAC is written out for the same reason.
"""

import hashlib
import json
import re
import struct
from pathlib import Path

HERE = Path(__file__).resolve().parent
HEADER = "<2sBBHHIIq"
TOKEN = "a-token-for-the-golden-vectors"
SERVER_NONCE = "000102030405060708090a0b0c0d0e0f"
CLIENT_NONCE = "f0f1f2f3f4f5f6f7f8f9fafbfcfdfeff"


def hmac_sha256(key, text):
    """Return HMAC-SHA256 as RFC 2104 defines it, of keys up to 64 bytes."""
    block = key.ljust(64, b"\0")
    inner = hashlib.sha256(bytes(byte ^ 0x36 for byte in block) + text).digest()
    return hashlib.sha256(bytes(byte ^ 0x5C for byte in block) + inner).digest()


def frame(kind=0, topic=0, flags=0, seq=1, t_ns=0, payload=b"", length=None, **other):
    """Return a frame's bytes; `length`, `magic` and `version` may be wrong on purpose."""
    magic, version = other.get("magic", b"DH"), other.get("version", 1)
    size = len(payload) if length is None else length
    return struct.pack(HEADER, magic, version, kind, topic, flags, seq, size, t_ns) + payload


def seen(kind=0, topic=0, flags=0, seq=1, t_ns=0, payload=b""):
    """Return what a decoder is to make of a frame."""
    return {
        "kind": kind,
        "topic": topic,
        "flags": flags,
        "seq": seq,
        "t_ns": t_ns,
        "payload": payload.hex(),
    }


def good(name, **values):
    """Return the vector of one frame that is to be decoded as it was made."""
    return {"name": name, "hex": frame(**values).hex(), "frames": [seen(**values)], "error": None}


def older(name, proof, payload=b"", flags=0, **values):
    """Return the vector of one frame of an older client, whose proof is dropped."""
    data = frame(payload=payload + proof, flags=flags | 1, **values)
    values |= {"payload": payload, "flags": flags}
    return {"name": name, "hex": data.hex(), "frames": [seen(**values)], "error": None}


def bad(name, data, error, frames=(), largest=65536):
    """Return the vector of a stream that ends with an error."""
    return {
        "name": name,
        "hex": data.hex(),
        "frames": list(frames),
        "error": error,
        "largest": largest,
    }


def frames():
    """Return streams of bytes, and what a decoder makes of them."""
    ping = b'{"op":"ping"}'
    command = struct.pack("<IIffff", 7, 15, 1.0, 0.0, 0.0, 0.0)
    first = frame(seq=1, payload=ping)
    return [
        # By hand, byte for byte: DH, 1, kind 0, topic 0, flags 0, seq 1, length 13, t_ns 0.
        {
            "name": "ping, typed by hand",
            "hex": "4448 01 00 0000 0000 01000000 0d000000 0000000000000000"
            " 7b 226f70 22 3a 22 70696e67 22 7d",
            "frames": [seen(payload=ping)],
            "error": None,
        },
        # kind 2, topic 0, flags 0, seq 0x01020304, length 0, t_ns 0.
        {
            "name": "acknowledgement, typed by hand",
            "hex": "4448 01 02 0000 0000 04030201 00000000 0000000000000000",
            "frames": [seen(kind=2, seq=16909060)],
            "error": None,
        },
        good("control, empty payload", payload=b""),
        good("data", kind=1, topic=8, seq=3, t_ns=123456789, payload=command),
        good("acknowledgement", kind=2, seq=77),
        good("acknowledgement with a payload, which is ignored", kind=2, seq=77, payload=b"xy"),
        good("last of a batch", kind=1, topic=3, flags=2, payload=bytes(24)),
        good("flags that are not known yet", kind=1, topic=3, flags=0x8000 | 2, payload=b"1"),
        good("largest topic", kind=1, topic=65535, payload=b"1"),
        good("largest seq", kind=1, topic=1, seq=2**32 - 1),
        good("negative time", kind=1, topic=1, t_ns=-1),
        good("least time", kind=1, topic=1, t_ns=-(2**63)),
        good("largest time", kind=1, topic=1, t_ns=2**63 - 1),
        good("skippable kind 128", kind=128, payload=b"whatever"),
        good("skippable kind 255", kind=255, topic=9, seq=4, payload=b""),
        good("longest frame", kind=1, topic=12, payload=b"z" * 65536),
        {
            "name": "longest frame before login",
            "hex": frame(payload=b"z" * 4096).hex(),
            "frames": [seen(payload=b"z" * 4096)],
            "error": None,
            "largest": 4096,
        },
        {
            "name": "three frames in a row",
            "hex": (first + frame(kind=2, seq=9) + frame(seq=2, payload=ping)).hex(),
            "frames": [seen(payload=ping), seen(kind=2, seq=9), seen(seq=2, payload=ping)],
            "error": None,
        },
        {"name": "nothing", "hex": "", "frames": [], "error": None},
        {"name": "half a header", "hex": first[:11].hex(), "frames": [], "error": None},
        {"name": "a header alone", "hex": first[:24].hex(), "frames": [], "error": None},
        {
            "name": "all but the last byte",
            "hex": (first + first[:-1]).hex(),
            "frames": [seen(payload=ping)],
            "error": None,
        },
        {
            "name": "a payload that looks like a header",
            "hex": frame(payload=first).hex(),
            "frames": [seen(payload=first)],
            "error": None,
        },
        bad("a web browser", b"GET / HTTP/1.1\r\nHost: drone\r\n\r\n", "magic"),
        bad("one wrong byte", b"X", "magic"),
        bad("small letters", frame(magic=b"dh", payload=ping), "magic"),
        bad("bytes swapped", frame(magic=b"HD", payload=ping), "magic"),
        bad("second byte wrong", b"DX", "magic"),
        bad("a byte too many between", first + b"\n" + first, "magic", [seen(payload=ping)]),
        bad("version 0", frame(version=0, payload=ping), "version"),
        bad("version 2", frame(version=2, payload=ping), "version"),
        bad("version 255", frame(version=255, payload=ping), "version"),
        bad("kind 3", frame(kind=3, payload=ping), "kind"),
        bad("kind 127", frame(kind=127), "kind"),
        bad("one byte too long", frame(kind=1, length=65537), "length"),
        bad("longest length there is", frame(kind=1, length=2**32 - 1), "length"),
        bad("too long before login", frame(length=4097), "length", largest=4096),
        bad("a kind to skip, too long", frame(kind=200, length=65537), "length"),
        bad(
            "a good frame, then a bad one",
            first + frame(version=9),
            "version",
            [seen(payload=ping)],
        ),
    ]


def number(value):
    """Return a number as JSON can have it."""
    if value != value:
        return "nan"
    return {float("inf"): "inf", float("-inf"): "-inf"}.get(value, value)


def topic(id, name, form, flat, values):
    """Return the vector of a topic's payload."""
    return {
        "id": id,
        "name": name,
        "struct": form,
        "hex": struct.pack(form, *flat).hex(),
        "values": values,
    }


def numbers(id, name, form, names, values):
    """Return the vector of a topic with a number for each field."""
    shown = [number(value) for value in values]
    return topic(id, name, form, values, dict(zip(names.split(), shown, strict=True)))


def topics():
    """Return payloads; all floats among them are exact in 32 bits, so that == holds."""
    command = "lease axes v_x v_y v_z yaw_rate"
    nan, inf = float("nan"), float("inf")
    least = 2.0**-149  # the smallest denormal of 32 bits
    return [
        numbers(
            1, "time_data", "<iIq", "seconds nanoseconds wall_ns", [3, 999999999, 1700 * 10**15]
        ),
        numbers(
            2,
            "position_data",
            "<fffffffff",
            "x y z roll pitch yaw displacement_x displacement_y displacement_z",
            [1.5, -2.25, 3.0, 0.125, -0.25, 3.140625, 0.5, 0.0, -0.5],
        ),
        numbers(
            3,
            "velocity_data",
            "<ffffff",
            "v_x v_y v_z w_x w_y w_z",
            [1.0, -1.0, 0.5, 0.25, 0, -2.0],
        ),
        numbers(
            4,
            "acceleration_data",
            "<ffffff",
            "vdot_x vdot_y vdot_z wdot_x wdot_y wdot_z",
            [0.0, -0.0, 9.75, 1e10, -1e10, 2.0**-126],
        ),
        numbers(
            5,
            "force_torque_data",
            "<ffffff",
            "force_x force_y force_z torque_x torque_y torque_z",
            [0.0, 0.0, 19.625, 0.015625, -0.03125, 0.0],
        ),
        topic(
            6,
            "drone_state",
            "<i16sff",
            [3, b"hovering", 0.5, 1.25],
            {"mode": 3, "condition": "hovering", "charge": 0.5, "clearance": 1.25},
        ),
        numbers(7, "on_off_state", "<i", "on", [1]),
        numbers(8, "command_velocity", "<IIffff", command, [305419896, 15, 1.0, -0.5, 0.25, 0.125]),
        numbers(8, "command_velocity", "<IIffff", command, [0, 0, 0.0, 0.0, 0.0, 0.0]),
        numbers(8, "command_velocity", "<IIffff", command, [1, 15, nan, 0.0, 0.0, 0.0]),
        numbers(8, "command_velocity", "<IIffff", command, [1, 15, inf, -inf, 0.0, 0.0]),
        numbers(8, "command_velocity", "<IIffff", command, [1, 15, least, -least, 0.0, -0.0]),
        numbers(
            8,
            "command_velocity",
            "<IIffff",
            command,
            [2**32 - 1, 2**32 - 1, (2 - 2.0**-23) * 2.0**127, 0.0, 0.0, 0.0],
        ),
        topic(
            9,
            "imu",
            "<q3f3f4f",
            [5 * 10**9, 0.0, 0.0, 9.75, 0.5, 0.0, -0.5, 1.0, 0.0, 0.0, 0.0],
            {
                "stamp": 5 * 10**9,
                "specific_force": [0.0, 0.0, 9.75],
                "angular_velocity": [0.5, 0.0, -0.5],
                "q_WS": [1.0, 0.0, 0.0, 0.0],
            },
        ),
        topic(
            10,
            "gps",
            "<qddd3f",
            [1, 0.8412345678901234, 0.2, 520.1, 1.0, 2.0, -0.5],
            {
                "stamp": 1,
                "latitude": 0.8412345678901234,
                "longitude": 0.2,
                "altitude": 520.1,
                "velocity": [1.0, 2.0, -0.5],
            },
        ),
        topic(
            11,
            "lidar",
            "<qIIf3f",
            [2, 3, 4, 0.75, 1.0, 0.0, 0.0],
            {"stamp": 2, "returns": 3, "rays": 4, "nearest": 0.75, "direction": [1.0, 0.0, 0.0]},
        ),
        topic(
            12,
            "lidar_cloud",
            "<q4f",
            [2, 0.75, float("inf"), 2.5, 0.0],
            {"stamp": 2, "ranges": [0.75, "inf", 2.5, 0.0]},
        ),
        topic(
            13,
            "frames",
            "<7f",
            [1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0],
            {"poses": [1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0]},
        ),
        topic(
            14,
            "rotors",
            "<4f4f",
            [500.0, 501.0, 502.0, 503.0, 4.5, 4.75, 5.0, 5.25],
            {"speed": [500.0, 501.0, 502.0, 503.0], "thrust": [4.5, 4.75, 5.0, 5.25]},
        ),
        topic(15, "wind", "<3f", [3.0, -1.0, 0.5], {"wind": [3.0, -1.0, 0.5]}),
        numbers(
            20,
            "battery",
            "<ffff",
            "voltage current charge capacity",
            [15.5, 21.25, 0.75, 18000.0],
        ),
        topic(
            16,
            "parameters",
            "<48sd",
            [b"kp_velocity_x", 6.1],
            {"name": "kp_velocity_x", "value": 6.1},
        ),
        topic(
            17,
            "events",
            "<i240s",
            [1, "Böe: 12 m/s".encode()],
            {"severity": 1, "said": "Böe: 12 m/s"},
        ),
        topic(17, "events", "<i240s", [0, b""], {"severity": 0, "said": ""}),
        topic(17, "events", "<i240s", [2, b"x" * 240], {"severity": 2, "said": "x" * 240}),
        topic(
            17,
            "events",
            "<i240s",
            [2, b"\xff\xfe"],
            {"severity": 2, "said": "\ufffd\ufffd"},
        ),
    ]


def said(text, error=None, operation=None):
    """Return the vector of a control frame's payload: its record, or the code of its refusal."""
    data = text if isinstance(text, bytes) else text.encode()
    return {"hex": data.hex(), "text": data.decode("ascii", "replace"), "error": error} | (
        {"operation": operation} if operation else {}
    )


def operations():
    """Return what clients say, and what a server makes of it."""
    nonce, proof = "0f" * 16, "a5" * 32
    lease = 4026531840

    def nested(depth):
        return '{"op":"ping","x":' + "[" * (depth - 1) + "]" * (depth - 1) + "}"

    return [
        said('{"op":"ping"}', operation=["Ping", {"id": 0}]),
        said(' {"id" : 4 ,\t"op":"ping"}\r\n', operation=["Ping", {"id": 4}]),
        said('{"op":"ping","id":4294967295}', operation=["Ping", {"id": 4294967295}]),
        said('{"op":"ping","id":3.0}', operation=["Ping", {"id": 3}]),
        said('{"op":"ping","id":null}', operation=["Ping", {"id": 0}]),
        said('{"op":"bye","id":1}', operation=["Bye", {"id": 1}]),
        said('{"op":"ping","later":[1,{"a":2}]}', operation=["Ping", {"id": 0}]),
        said(nested(8), operation=["Ping", {"id": 0}]),
        said(
            '{"op":"login","name":"Zo\\u00eb"}',
            operation=["Login", {"id": 0, "name": "Zoë", "role": None}],
        ),
        said(
            '{"op":"login","id":1,"name":"a","role":"view","token":"0123456789abcd\\u00eb"}',
            operation=[
                "Login",
                {"id": 1, "name": "a", "role": "view", "token": "0123456789abcdë"},
            ],
        ),
        said(
            f'{{"op":"login","id":1,"role":"command","nonce":"{nonce.upper()}","proof":"{proof}"}}',
            operation=[
                "Login",
                {"id": 1, "name": "", "role": "command", "nonce": nonce, "proof": proof},
            ],
        ),
        said(
            '{"op":"subscribe","topics":["*"]}',
            operation=["Subscribe", {"id": 0, "topics": ["*"], "rate": None}],
        ),
        said(
            '{"op":"subscribe","id":2,"topics":["/dh_drone/imu"],"rate":20}',
            operation=["Subscribe", {"id": 2, "topics": ["/dh_drone/imu"], "rate": 20}],
        ),
        said(
            '{"op":"subscribe","topics":[]}',
            operation=["Subscribe", {"id": 0, "topics": [], "rate": None}],
        ),
        said('{"op":"request_control"}', operation=["RequestControlOp", {"id": 0, "name": ""}]),
        said(
            f'{{"op":"release_control","lease":{lease}}}',
            operation=["ReleaseControlOp", {"id": 0, "lease": lease}],
        ),
        said(
            f'{{"op":"flight","what":"take_off","height":2.5,"lease":{lease}}}',
            operation=["FlightOp", {"id": 0, "what": "take_off", "height": 2.5, "lease": lease}],
        ),
        said(
            f'{{"op":"flight","what":"land","lease":{lease}}}',
            operation=["FlightOp", {"id": 0, "what": "land", "height": 1.5, "lease": lease}],
        ),
        said('{"op":"parameters","get":[]}', operation=["GetParametersOp", {"id": 0, "names": []}]),
        said('{"op":"description"}', operation=["DescribeVehicle", {"id": 0, "urdf": ""}]),
        said(
            '{"op":"parameters","set":{"kp_velocity_x":6},"lease":1}',
            operation=["SetParametersOp", {"id": 0, "values": {"kp_velocity_x": 6}, "lease": 1}],
        ),
        # No strict JSON: the connection ends.
        said(b"", "json"),
        said(b"ping", "json"),
        said(b"[]", "json"),
        said(b"null", "json"),
        said(b'"ping"', "json"),
        said(b"{'op':'ping'}", "json"),
        said(b'{"op":"ping",}', "json"),
        said(b'{"op":"ping"', "json"),
        said(b'{"op":"ping"}{"op":"ping"}', "json"),
        said(b'{"op":"ping"} // now', "json"),
        said(b'{"op":"ping","op":"ping"}', "json"),
        said(b'{"op":"ping","x":{"a":1,"a":1}}', "json"),
        said(b'{"op":"ping","x":NaN}', "json"),
        said(b'{"op":"ping","x":-Infinity}', "json"),
        said(b'{"op":"ping","x":1e999}', "json"),
        said(b'{"op":"ping","x":-1e999}', "json"),
        said(b'{"op":"ping","x":123456789012345678901}', "json"),
        said(b'{"op":"ping","x":01}', "json"),
        said(b'{"op":"p\xe9ng"}', "json"),
        said(b'{"op":"ping","x":"\\ud800"}', "json"),
        said(b'{"op":"ping","\\udfff":1}', "json"),
        said(b'{"op":"pi\nng"}', "json"),
        said(b'\xef\xbb\xbf{"op":"ping"}', "json"),
        said('{"op":"ping"}'.encode("utf-16"), "json"),
        said(nested(9), "json"),
        said(b"[" * 4096, "json"),
        # Strict JSON, and no operation: nack, and the connection goes on.
        said("{}", "bad_value"),
        said('{"op":1}', "bad_value"),
        said('{"op":null}', "bad_value"),
        said('{"op":["ping"]}', "bad_value"),
        said('{"op":"PING"}', "unknown_op"),
        said('{"op":"hello"}', "unknown_op"),
        said('{"op":"ping","id":-1}', "bad_value"),
        said('{"op":"ping","id":4294967296}', "bad_value"),
        said('{"op":"ping","id":1.5}', "bad_value"),
        said('{"op":"ping","id":true}', "bad_value"),
        said('{"op":"ping","id":"1"}', "bad_value"),
        said('{"op":"login","name":7}', "bad_value"),
        said('{"op":"login","name":"' + "x" * 49 + '"}', "bad_value"),
        said('{"op":"login","name":"bell\\u0007"}', "bad_value"),
        said('{"op":"login","role":"admin"}', "bad_value"),
        said('{"op":"login","role":"view","token":7}', "bad_value"),
        said('{"op":"login","role":"view","token":"' + "x" * 1025 + '"}', "bad_value"),
        said('{"op":"login","role":"view","token":"0123456789abcdef\\n"}', "bad_value"),
        said('{"op":"login","nonce":"0f"}', "bad_value"),
        said('{"op":"login","nonce":"' + "zz" * 16 + '"}', "bad_value"),
        said('{"op":"login","proof":"' + "a5" * 31 + '"}', "bad_value"),
        said('{"op":"subscribe"}', "bad_value"),
        said('{"op":"subscribe","topics":"*"}', "bad_value"),
        said('{"op":"subscribe","topics":[1]}', "bad_value"),
        said('{"op":"subscribe","topics":[' + ",".join(['"x"'] * 257) + "]}", "bad_value"),
        said('{"op":"subscribe","topics":["*"],"rate":0}', "bad_value"),
        said('{"op":"subscribe","topics":["*"],"rate":true}', "bad_value"),
        said('{"op":"subscribe","topics":["*"],"rate":-5}', "bad_value"),
        said('{"op":"release_control"}', "bad_value"),
        said('{"op":"release_control","lease":0}', "bad_value"),
        said('{"op":"flight","what":"loop","lease":1}', "bad_value"),
        said('{"op":"flight","what":"land"}', "bad_value"),
        said('{"op":"flight","what":"take_off","height":0,"lease":1}', "bad_value"),
        said('{"op":"flight","what":"take_off","height":1e300,"lease":1}', "bad_value"),
        said('{"op":"flight","what":"take_off","height":"2","lease":1}', "bad_value"),
        said('{"op":"parameters"}', "bad_value"),
        said('{"op":"parameters","get":[],"set":{"a":1},"lease":1}', "bad_value"),
        said('{"op":"parameters","set":{},"lease":1}', "bad_value"),
        said('{"op":"parameters","set":{"a":true},"lease":1}', "bad_value"),
        said('{"op":"parameters","set":{"a":"1"},"lease":1}', "bad_value"),
        said('{"op":"parameters","set":{"a":1}}', "bad_value"),
    ]


def proofs():
    """Return a login of older clients, and their frames with proofs, which are dropped."""
    nonces = bytes.fromhex(SERVER_NONCE + CLIENT_NONCE)
    proof = bytes(range(16))
    command = struct.pack("<IIffff", 7, 15, 1.0, 0.0, 0.0, 0.0)
    return {
        "token": TOKEN,
        "server_nonce": SERVER_NONCE,
        "client_nonce": CLIENT_NONCE,
        "login_proof": {
            role: hmac_sha256(TOKEN.encode(), b"DH1 login" + role.encode() + nonces).hex()
            for role in ("view", "command")
        },
        "frames": [
            # kind 1, topic 8, flags 1, seq 2, length 40, t_ns 1 s; lease 1, axes 15, zeros; proof.
            {
                "name": "a command, typed by hand",
                "hex": "4448 01 01 0800 0100 02000000 28000000 00ca9a3b00000000"
                " 01000000 0f000000 00000000 00000000 00000000 00000000"
                " 000102030405060708090a0b0c0d0e0f",
                "frames": [
                    seen(
                        kind=1,
                        topic=8,
                        seq=2,
                        t_ns=1000000000,
                        payload=bytes.fromhex("010000000f000000" + "00" * 16),
                    )
                ],
                "error": None,
            },
            older("a proof alone", proof),
            older(
                "a proof and the end of a batch", proof, kind=1, topic=8, flags=2, payload=command
            ),
            older("the longest frame", proof, kind=1, payload=b"z" * 65520),
            bad("too long", frame(flags=1, length=65537), "length"),
            bad("a proof in nothing", frame(flags=1, length=0), "length"),
            bad("a proof in 15 bytes", frame(flags=1, payload=bytes(15)), "length"),
        ],
    }


def short(text):
    """Return hexadecimal digits with a long row of z as `7a*COUNT`."""
    found = re.search("(7a){64,}", text)
    if found is None:
        return text
    count = len(found[0]) // 2
    return f"{text[: found.start()]} 7a*{count} {text[found.end() :]}".strip()


def shortened(value):
    """Return a vector with its long rows made short."""
    if isinstance(value, dict):
        return {
            key: short(each) if key in ("hex", "payload") else shortened(each)
            for key, each in value.items()
        }
    return [shortened(each) for each in value] if isinstance(value, list) else value


def vectors():
    """Return the content of each file by its name."""
    made = {
        "frames": frames(),
        "topics": topics(),
        "operations": operations(),
        "proofs": proofs(),
    }
    return {
        f"{name}.json": json.dumps(shortened(content), indent=1, ensure_ascii=True) + "\n"
        for name, content in made.items()
    }


if __name__ == "__main__":
    for name, text in vectors().items():
        (HERE / name).write_text(text, encoding="utf-8")
