"""Logs that are small to send and large to read; `bombs.py` reads them with its own."""

import gzip
import io
import struct
from collections.abc import Sequence

import zstandard
from bombs import ALIASES, MERGES, Bomb, Files
from mcap.opcode import Opcode
from mcap.well_known import MessageEncoding, Profile, SchemaEncoding
from mcap.writer import MCAP0_MAGIC, CompressionType, Writer

LOG, REPLAY = ("log",), ("replay",)
CDR = b"\0\1\0\0"
STATE = "float64[4] q_wb\nfloat64[3] p_wb\nfloat64[3] w_wb\nfloat64[3] v_wb\n"
ATTACHMENTS = {"scenario.yaml": "", "gains.yaml": "gains: {}"}
METADATA = {
    "flight": {"vehicle": "a", "physics_step": "0.001", "begun_ns": "0"},
    "versions": {},
    "settings": {},
}
MAPPING = (
    "time: {column: t, unit: s}\ncolumns:\n  g: {signal: imu.angular_velocity.x, unit: deg/s}\n"
)
POINT_CLOUD = "sensor_msgs/msg/PointCloud2"
CLOUD = (
    "uint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool is_bigendian\n"
    "uint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n"
    f"{'=' * 80}\nMSG: sensor_msgs/PointField\nstring name\nuint32 offset\nuint8 datatype\n"
    "uint32 count\n"
)
BLACKBOX = (
    b"H Product:Blackbox flight data recorder by Nicholas Sherlock\nH Data version:2\n"
    b"H I interval:1\nH P interval:1/1\nH Field I name:loopIteration,time,gyroADC[0]\n"
    b"H Field I signed:0,0,1\nH Field I predictor:0,0,0\nH Field I encoding:1,1,0\n"
    b"H Field P predictor:0,0,0\nH Field P encoding:0,0,0\n"
)
ULOG = b"ULog\x01\x12\x35\x01" + bytes(8)
FMT = struct.Struct("<BBBBB4s16s64s")
DATAFLASH = FMT.pack(0xA3, 0x95, 128, 128, 89, b"FMT", b"BBnNZ", b"Type,Length,Name,Format,Columns")


def mcap(
    schema: str = "uint8 x\n",
    messages: Sequence[bytes] = (),
    *,
    kind: str = "a/msg/B",
    attachments: dict[str, str] | None = None,
    after: bytes = b"",
    topic: str = "/t",
    channels: int = 1,
) -> Files:
    """Return a log of the workbench with a topic, in chunks of zstd, and records at its end."""
    buffer = io.BytesIO()
    writer = Writer(buffer, 60_000_000, CompressionType.ZSTD)
    writer.start(Profile.ROS2, "bomb")
    for name, table in METADATA.items():
        writer.add_metadata(name, table)
    for name, text in (ATTACHMENTS | (attachments or {})).items():
        writer.add_attachment(0, 0, name, "", text.encode())
    number = writer.register_schema(kind, SchemaEncoding.ROS2, schema.encode())
    topics = [
        writer.register_channel(f"{topic}{i}" if i else topic, MessageEncoding.CDR, number)
        for i in range(channels)
    ]
    for i, message in enumerate(messages):
        writer.add_message(topics[i % channels], i, message, i)
    writer.finish()
    data = buffer.getvalue()
    return {"a.mcap": data[: len(MCAP0_MAGIC)] + after + data[len(MCAP0_MAGIC) :]}


def chunk(plain: bytes, size: int | None = None, frame: int | None = None) -> bytes:
    """Return a chunk; its head and its frame may state other sizes."""
    packed = zstandard.ZstdCompressor().compress(plain)
    if frame is not None:  # RFC 8878: eight bytes for the size, in one segment
        parameters = zstandard.ZstdCompressionParameters(write_content_size=False)
        packed = zstandard.ZstdCompressor(compression_params=parameters).compress(plain)
        packed = packed[:4] + b"\xe0" + struct.pack("<Q", frame) + packed[6:]
    size = len(plain) if size is None else size
    body = struct.pack("<QQQII", 0, 0, size, 0, 4) + b"zstd" + struct.pack("<Q", len(packed))
    return struct.pack("<BQ", Opcode.CHUNK, len(body) + len(packed)) + body + packed


def numbers(count: int) -> bytes:
    """Return a message with numbers of a byte."""
    return CDR + struct.pack("<I", count) + bytes(count)


def texts(count: int) -> bytes:
    """Return a message with empty texts, each with its terminating zero and padding."""
    return CDR + struct.pack("<I", count) + struct.pack("<IB3x", 1, 0) * count


def cloud(fields: int, points: int) -> bytes:
    """Return a cloud whose fields are all the same byte."""
    each = [
        struct.pack("<I", len(name) + 1) + name + b"\0" * (4 - len(name) % 4)
        + struct.pack("<IB3xI", 0, 2, 1)
        for name in (b"f%07d" % i for i in range(fields))
    ]  # fmt: skip
    head = CDR + struct.pack("<III", 1, points, fields) + b"".join(each)
    return head + struct.pack("<B3xIII", 0, 1, points, points) + bytes(points) + b"\1"


def nested(depth: int, width: int) -> str:
    """Return a definition of types, each of which has several of the next."""
    parts = [f"a/T1[{width}] x\n"]
    parts += [f"MSG: a/T{i}\na/T{i + 1}[{width}] x\n" for i in range(1, depth)]
    return f"{'=' * 80}\n".join([*parts, f"MSG: a/T{depth}\nuint8[0] x\n"])


def ulog(*messages: tuple[bytes, bytes]) -> bytes:
    """Return a ULog with messages, each a kind and its content."""
    return ULOG + b"".join(
        struct.pack("<H", len(content)) + kind + content for kind, content in messages
    )


def of_topic(fields: bytes, messages: Sequence[bytes]) -> bytes:
    """Return a ULog with a topic of some fields."""
    added = (b"A", struct.pack("<BH", 0, 0) + b"a")
    return ulog((b"F", b"a:" + fields), added, *((b"D", bytes(2) + each) for each in messages))


def formats(depth: int, width: int) -> bytes:
    """Return a ULog of formats, each of which has several of the next."""
    rows = [(b"F", b"t%d:t%d[%d] x;uint64_t timestamp;" % (i, i + 1, width)) for i in range(depth)]
    last = (b"F", b"t%d:uint8_t x;" % depth)
    return ulog(*rows, last, (b"A", struct.pack("<BH", 0, 0) + b"t0"), (b"D", bytes(1000)))


def dataflash(*rows: tuple[int, int, bytes, bytes, bytes]) -> bytes:
    """Return the head of a DataFlash log with formats: type, length, name, format, columns."""
    return DATAFLASH + b"".join(FMT.pack(0xA3, 0x95, 128, *row) for row in rows)


def usd(events: int, variables: int, samples: bytes) -> bytes:
    """Return a log of a Crazyflie."""
    names = b"".join(b"v%d(B)\0" % i for i in range(variables))
    each = [
        struct.pack("<H", i) + b"e\0" + struct.pack("<H", variables) + names for i in range(events)
    ]
    return struct.pack("<BHH", 0xBC, 2, events) + b"".join(each) + samples


def packed(name: str, head: bytes, block: bytes = bytes(1_000_000), times: int = 1000) -> Files:
    """Return a gzip file of many equal blocks, as a member each."""
    return {name: gzip.compress(head) + gzip.compress(block) * times}


def table(data: str | bytes, mapping: str = MAPPING) -> Files:
    """Return a CSV file with its mapping."""
    return {"a.csv": data, "a.mapping.yaml": mapping}


def columns(count: int) -> str:
    """Return a mapping with many columns."""
    return "time: {column: t, unit: s}\ncolumns:\n" + "".join(
        f"  c{i}: {{signal: a.c{i}}}\n" for i in range(count)
    )


ROWS = "t,g\n" + "".join(f"{i},1\n" for i in range(9))
HEADS = "t" + "".join(f",c{i}" for i in range(20_000))
MESSAGE = b"\xa3\x95\x82"
"""Head of a message of type 130 in a DataFlash log."""
MILLION = 1_000_000

LOG_BOMBS: dict[str, Bomb] = {
    "mcap chunks": Bomb(lambda: mcap(after=chunk(bytes(64 * MILLION)) * 48), LOG, quick=True),
    "mcap frame": Bomb(lambda: mcap(after=chunk(bytes(999), frame=3 * 10**9)), LOG),
    "mcap stated size": Bomb(lambda: mcap(after=chunk(bytes(999), size=2**62)), LOG),
    "mcap empty messages": Bomb(
        lambda: mcap(after=chunk((struct.pack("<BQHIQQ", 5, 22, 1, 0, 0, 0)) * 1_900_000)), LOG
    ),
    "mcap layouts": Bomb(
        lambda: mcap(
            "uint8[] x\nuint8[] y\nstring z\n",
            [
                CDR + struct.pack("<I", i % 997) + bytes(i % 997 + -i % 997 % 4) + bytes(999)
                for i in range(30_000)
            ],
        ),
        LOG,
    ),
    "mcap texts": Bomb(lambda: mcap("string[] x\n", [texts(5 * MILLION)]), LOG),
    "mcap numbers": Bomb(lambda: mcap("int8[] x\n", [numbers(50 * MILLION)]), LOG),
    "mcap empty types": Bomb(
        lambda: mcap(f"a/C[4000000000] x\n{'=' * 80}\nMSG: a/C\n", [CDR + bytes(8)]), LOG
    ),
    "mcap nested types": Bomb(lambda: mcap(nested(12, 10), [CDR + bytes(8)]), LOG),
    "mcap fields": Bomb(
        lambda: mcap("".join(f"uint8 f{i}\n" for i in range(MILLION)), [CDR + bytes(MILLION)]), LOG
    ),
    "mcap channels": Bomb(lambda: mcap(messages=[CDR + b"\0"] * 60_000, channels=60_000), LOG),
    "mcap cloud": Bomb(lambda: mcap(CLOUD, [cloud(3000, MILLION)] * 9, kind=POINT_CLOUD), LOG),
    "mcap gains": Bomb(lambda: mcap(attachments={"gains.yaml": ALIASES}), LOG),
    "mcap gains, depth": Bomb(lambda: mcap(attachments={"gains.yaml": "[" * MILLION}), LOG),
    "mcap gains, rows": Bomb(
        lambda: mcap(attachments={"gains.yaml": "gains: {" + "a: 1," * 9 * MILLION}), LOG
    ),
    "mcap scenario": Bomb(
        lambda: mcap(
            STATE,
            [CDR + bytes(104)],
            topic="/dh_drone/exact_state",
            attachments={"scenario.yaml": MERGES},
        ),
        REPLAY,
        quick=True,
    ),
    "mcap imported": Bomb(
        lambda: mcap(attachments={"flight_record.json": '{"signals": ' + "[" * MILLION}), LOG
    ),
    "mcap imported, rows": Bomb(
        lambda: mcap(attachments={"flight_record.json": f'{{"signals": [{"0," * 9 * MILLION}0]}}'}),
        LOG,
    ),
    "gz, mcap": Bomb(lambda: packed("a.mcap.gz", MCAP0_MAGIC), LOG),
    "gz, ulog": Bomb(lambda: packed("a.ulg.gz", ULOG), LOG),
    "gz, dataflash": Bomb(lambda: packed("a.bin.gz", DATAFLASH), LOG),
    "gz, blackbox": Bomb(lambda: packed("a.bbl.gz", BLACKBOX), LOG),
    "gz, usd": Bomb(lambda: packed("a.gz", usd(1, 1, b"")), LOG),
    "gz, rows": Bomb(
        lambda: packed("a.csv.gz", b"t,g\n", b"1,2\n" * 250_000) | {"a.mapping.yaml": MAPPING}, LOG
    ),
    "gz, line": Bomb(
        lambda: packed("a.csv.gz", b"t,g\n") | {"a.mapping.yaml": MAPPING}, LOG, quick=True
    ),
    "gz, members": Bomb(lambda: {"a.csv.gz": gzip.compress(b"") * 500_000}, LOG),
    "gz, ratio of a log": Bomb(lambda: packed("a.ulg.gz", ULOG, times=60), LOG),
    "csv line": Bomb(lambda: table("t,g\n" + "1" * 100 * MILLION), LOG),
    "csv columns": Bomb(lambda: table(",".join(["t", "g", *["x"] * MILLION])), LOG, quick=True),
    "csv commas": Bomb(lambda: table("t,g" + "," * 900_000 + "\n"), LOG),
    "csv quote": Bomb(lambda: table('t,g\n1,"' + "2\n" * 20 * MILLION), LOG),
    "csv zeros": Bomb(lambda: table(bytes(50 * MILLION)), LOG),
    "csv digits": Bomb(lambda: table("t,g\n" + f"{'9' * 99_000},{'9' * 99_000}\n" * 100), LOG),
    "csv rows": Bomb(lambda: table("t,g\n" + "1,2\n" * 500_000), LOG),
    "mapping aliases": Bomb(lambda: table(ROWS, ALIASES), LOG),
    "mapping merges": Bomb(lambda: table(ROWS, MERGES), LOG),
    "mapping depth": Bomb(lambda: table(ROWS, "time: " + "[" * 900_000), LOG),
    "mapping rows": Bomb(lambda: table(HEADS, columns(20_000)), LOG),
    "mapping names": Bomb(lambda: table(ROWS, columns(20_000)), LOG),
    "metadata aliases": Bomb(
        lambda: {
            "a.csv": "t,px,py,pz,qx,qy,qz,qw,roll,pitch,yaw,x\n"
            + "".join(f"{i}.5{',1' * 11}\n" for i in range(9)),
            "a_metadata.yaml": ALIASES,
        },
        LOG,
    ),
    "ulog array": Bomb(lambda: {"a.ulg": of_topic(b"float[2000000000] x;", [bytes(99)])}, LOG),
    "ulog formats": Bomb(lambda: {"a.ulg": formats(12, 30)}, LOG),
    "ulog format of itself": Bomb(lambda: {"a.ulg": formats(1, 1).replace(b"t1 x", b"t0 x")}, LOG),
    "ulog fields": Bomb(
        lambda: {
            "a.ulg": ulog(
                (b"F", b"a:" + b"".join(b"uint8_t f%d;" % i for i in range(4000))),
                *((b"A", struct.pack("<BH", i % 256, i) + b"a") for i in range(300)),
                *((b"D", struct.pack("<H", i) + bytes(4000)) for i in range(300)),
            )
        },
        LOG,
    ),
    "ulog parameters": Bomb(
        lambda: {"a.ulg": ulog(*[(b"P", b"\x0bint32_t abc" + bytes(4))] * 20_000)}, LOG
    ),
    "ulog zeros": Bomb(lambda: {"a.ulg": ULOG + bytes(MILLION)}, LOG),
    "dataflash no length": Bomb(
        lambda: {"a.bin": dataflash((130, 0, b"AAAA", b"Q", b"TimeUS")) + MESSAGE * 30_000}, LOG
    ),
    "dataflash short": Bomb(
        lambda: {"a.bin": dataflash((130, 3, b"AAAA", b"", b"")) + MESSAGE * 100_000}, LOG
    ),
    "dataflash long": Bomb(
        lambda: {
            "a.bin": dataflash((130, 255, b"AAAA", b"a" * 16, b"TimeUS,A,B,C"))
            + (MESSAGE + bytes(252)) * 400
        },
        LOG,
    ),
    "dataflash formats": Bomb(
        lambda: {"a.bin": dataflash(*[(130, 11, b"AAAA", b"Q", b"TimeUS")] * 2000)}, LOG
    ),
    "dataflash zeros": Bomb(lambda: {"a.bin": DATAFLASH + bytes(MILLION)}, LOG),
    "dataflash heads": Bomb(lambda: {"a.bin": DATAFLASH + b"\xa3\x95" * 100_000}, LOG),
    "blackbox logs": Bomb(lambda: {"a.bbl": BLACKBOX * 300}, LOG),
    "blackbox names": Bomb(
        lambda: {"a.bbl": BLACKBOX.replace(b"gyroADC[0]", b",".join([b"f"] * 10_000))}, LOG
    ),
    "blackbox interval": Bomb(
        lambda: {
            "a.bbl": BLACKBOX.replace(b"interval:1", b"interval:0") + b"I\0\0\0P\0\0\0" * 20_000
        },
        LOG,
    ),
    "blackbox header": Bomb(lambda: {"a.bbl": BLACKBOX + b"H x:" + b"9" * MILLION + b"\n"}, LOG),
    "blackbox headers": Bomb(
        lambda: {"a.bbl": BLACKBOX + b"".join(b"H x%d:%d\n" % (i, i) for i in range(100_000))}, LOG
    ),
    "blackbox zeros": Bomb(lambda: {"a.bbl": BLACKBOX + bytes(200_000)}, LOG),
    "blackbox frames": Bomb(lambda: {"a.bbl": BLACKBOX + b"I\0\0\0" * 100_000}, LOG),
    "blackbox varint": Bomb(lambda: {"a.bbl": BLACKBOX + b"I" + b"\xff" * 200_000}, LOG),
    "usd variables": Bomb(lambda: {"a": usd(65535, 1, b"")}, LOG),
    "usd events": Bomb(lambda: {"a": usd(65535, 0, bytes(MILLION))}, LOG),
    "usd bytes": Bomb(lambda: {"a": usd(1, 500, bytes(2 * MILLION))}, LOG),
    "usd name": Bomb(lambda: {"a": b"\xbc\2\0\1\0\0\0" + b"a" * MILLION}, LOG),
}
"""By name."""
