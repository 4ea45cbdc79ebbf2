"""Files and metadata for ground stations, read by pymavlink's client of the file transfer."""

import json
import math
import struct

import pytest

pytest.importorskip("pymavlink", reason="install the extra `mavlink` to try it")

from pymavlink.dialects.v20 import common as mavlink
from pymavlink.generator.mavcrc import x25crc
from pymavlink.mavftp import MAVFTP
from pymavlink.mavftp_op import FTP_OP, OP_CalcFileCRC32

from workbench.extras.gateways.mavlink_files import (
    ComponentMetadata,
    file_crc,
    file_replies,
    metadata_files,
)
from workbench.link.hello import ParameterRow

ROWS = (
    ParameterRow("kp_pitch", "1/s^2", 0.0, 2500.0, 120.0, "gain of the pitch angle"),
    ParameterRow("spin_up_feedforward", "1", 0.0, 1.0, 0.0, "share of the torque"),
)
IDS = {"kp_pitch": "kp_pitch", "spin_up_feedforward": "spin_up_fedfrwrd"}


class Wire:
    """A connection of pymavlink to the file server, without a network."""

    source_system, source_component, target_system, target_component = 255, 190, 1, 1

    def __init__(self, files):
        self.files, self.waiting, self.mav = files, [], self

    def file_transfer_protocol_send(self, network, system, component, payload):
        for reply in file_replies(self.files, bytes(payload)):
            message = mavlink.MAVLink_file_transfer_protocol_message(0, 255, 190, list(reply))
            message._header = mavlink.MAVLink_header(110, srcSystem=1, srcComponent=1)
            self.waiting.append(message)

    def recv_match(self, **_):
        return self.waiting.pop(0) if self.waiting else None


def read(files, name, folder):
    """Return a file as pymavlink reads it."""
    target = folder / name
    ftp = MAVFTP(Wire(files), 1, 1)
    ftp.cmd_get([f"/{name}", str(target)])
    ftp.process_ftp_reply("OpenFileRO", timeout=30)
    return target.read_bytes()


@pytest.mark.parametrize("size", [0, 1, 239, 240, 20_000])
def test_pymavlink_reads_a_file(size, tmp_path):
    content = bytes(i * 7 % 251 for i in range(size))
    assert read({"a.bin": content, "b": b"x"}, "a.bin", tmp_path) == content


def test_a_read_has_one_answer_and_a_burst_has_many_of_which_the_last_says_so():
    """Codes of the protocol's description: 5 reads, 15 reads in a burst, 128 acknowledges."""
    files = {"a": bytes(600)}
    answers = {}
    for opcode in (5, 15):
        request = FTP_OP(0, 0, opcode, 239, 0, 0, 0).pack()
        answers[opcode] = [(reply[3], reply[4], reply[6]) for reply in file_replies(files, request)]
    assert answers == {5: [(128, 239, 0)], 15: [(128, 239, 0), (128, 239, 0), (128, 122, 1)]}


def test_the_checksum_is_that_of_mavlink():
    """CRC32 with the polynomial of zlib, from 0 and without an inversion, bit by bit."""
    content, crc = b"parameters", 0
    for byte in content:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xEDB88320 if crc & 1 else 0)
    assert file_crc(content) == crc
    request = FTP_OP(0, 0, OP_CalcFileCRC32, 2, 0, 0, 0, bytearray(b"/a")).pack()
    [reply] = file_replies({"a": content}, bytes(request))
    assert struct.unpack_from("<I", reply, 12) == (crc,)


def test_what_is_no_request_has_no_answer_and_unknown_files_are_refused():
    files = {"a": b"x"}
    assert list(file_replies(files, b"short")) == []
    for opcode, data, error in ((4, b"../etc/passwd", 10), (7, b"a", 7), (5, b"", 6)):
        request = FTP_OP(1, 0, opcode, len(data), 0, 0, 99, bytearray(data)).pack()
        [reply] = file_replies(files, bytes(request))
        assert (reply[3], reply[12]) == (129, error), opcode
    request = FTP_OP(1, 9, 5, 9, 0, 0, 0).pack()
    [reply] = file_replies(files, bytes(request))
    assert (reply[3], reply[12]) == (129, 4)


def test_metadata_has_units_and_ranges_by_the_ids_of_mavlink():
    files = metadata_files(ROWS, IDS)
    general = json.loads(files["general.json"])
    [kind] = general["metadataTypes"]
    assert (kind["type"], kind["uri"]) == (1, "mftp:///parameter.json")
    assert kind["fileCrc"] == file_crc(files["parameter.json"])
    first, second = json.loads(files["parameter.json"])["parameters"]
    assert (first["name"], first["units"], first["min"], first["max"], first["default"]) == (
        *("kp_pitch", "1/s^2"),
        *(0.0, 2500.0, 120.0),
    )
    assert (second["name"], second["shortDesc"]) == ("spin_up_fedfrwrd", "spin_up_feedforward")
    assert "units" in second and second["units"] == ""
    assert all(math.isfinite(each["max"]) for each in (first, second))


def test_the_message_that_tells_of_metadata_is_that_of_mavlink():
    """Its checksum byte covers names and types of the fields in common.xml, as mavgen makes it."""
    crc = x25crc()
    crc.accumulate_str("COMPONENT_METADATA ")
    for text in ("uint32_t time_boot_ms ", "uint32_t file_crc ", "char uri "):
        crc.accumulate_str(text)
    crc.accumulate([100])
    assert ComponentMetadata.crc_extra == (crc.crc & 0xFF) ^ (crc.crc >> 8)
    data = ComponentMetadata(1, 2, "mftp:///general.json").pack(mavlink.MAVLink(None, 1, 1))
    assert data[7:10] == (397).to_bytes(3, "little")
    assert struct.unpack_from("<II20s", data, 10) == (1, 2, b"mftp:///general.json")
