"""Files of the vehicle for ground stations: MAVLink's file transfer, read only, and metadata.

Source: mavlink.io/en/services/ftp.html and component_information.html. The session of an open file
is its place in the list of files, so nothing has to be closed.
"""

import json
import struct
import zlib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from workbench.link.hello import ParameterRow

FTP_HEADER = struct.Struct("<HBBBBBxI")
"""Sequence, session, opcode, size, requested opcode, end of burst, padding, offset."""
FTP_PAYLOAD_BYTES = 251
MAX_FTP_DATA_BYTES = FTP_PAYLOAD_BYTES - FTP_HEADER.size
MAX_BURST_REPLIES = 24
"""Largest number of replies to one request for a burst."""
METADATA_MESSAGE_ID = 397
PARAMETER_METADATA_TYPE = 1
GENERAL_FILE, PARAMETER_FILE = "general.json", "parameter.json"


def file_replies(files: Mapping[str, bytes], request: bytes) -> Iterator[bytes]:
    """Yield the payloads of the replies to the payload of a request for files.

    Args:
        files: contents by name.
        request: of MAVLink's file transfer.
    """
    names = sorted(files)
    if len(request) < FTP_HEADER.size:
        return
    seq, session, opcode, size, _, _, offset = FTP_HEADER.unpack_from(request)
    data = request[FTP_HEADER.size : FTP_HEADER.size + size]

    def reply(
        content: bytes,
        at: int = offset,
        number: int = 1,
        end: int = 0,
        kind: int = mavlink.MAV_FTP_OPCODE_ACK,
    ) -> bytes:
        head = FTP_HEADER.pack(
            (seq + number) & 0xFFFF, session, kind, len(content), opcode, end, at
        )
        return (head + content).ljust(FTP_PAYLOAD_BYTES, b"\0")

    def refusal(error: int) -> bytes:
        return reply(bytes([error]), kind=mavlink.MAV_FTP_OPCODE_NAK)

    if opcode in (mavlink.MAV_FTP_OPCODE_TERMINATESESSION, mavlink.MAV_FTP_OPCODE_RESETSESSION):
        yield reply(b"")
    elif opcode == mavlink.MAV_FTP_OPCODE_LISTDIRECTORY:
        lines = [f"F{name}\t{len(files[name])}\0".encode() for name in names[offset:]]
        yield reply(b"".join(lines)) if lines else refusal(mavlink.MAV_FTP_ERR_EOF)
    elif opcode in (mavlink.MAV_FTP_OPCODE_OPENFILERO, mavlink.MAV_FTP_OPCODE_CALCFILECRC):
        name = data.split(b"\0")[0].decode("ascii", "replace").lstrip("/")
        if name not in files:
            yield refusal(mavlink.MAV_FTP_ERR_FILENOTFOUND)
            return
        content = files[name]
        session = names.index(name)
        number = len(content) if opcode == mavlink.MAV_FTP_OPCODE_OPENFILERO else file_crc(content)
        yield reply(struct.pack("<I", number))
    elif opcode not in (mavlink.MAV_FTP_OPCODE_READFILE, mavlink.MAV_FTP_OPCODE_BURSTREADFILE):
        yield refusal(mavlink.MAV_FTP_ERR_UNKNOWNCOMMAND)
    elif session >= len(names):
        yield refusal(mavlink.MAV_FTP_ERR_INVALIDSESSION)
    else:
        content = files[names[session]]
        step = min(size or MAX_FTP_DATA_BYTES, MAX_FTP_DATA_BYTES)
        count = MAX_BURST_REPLIES if opcode == mavlink.MAV_FTP_OPCODE_BURSTREADFILE else 1
        places = range(offset, len(content), step)[:count]
        for number, at in enumerate(places, start=1):
            end = int(opcode == mavlink.MAV_FTP_OPCODE_BURSTREADFILE and number == len(places))
            yield reply(content[at : at + step], at, number, end)
        if not places:
            yield refusal(mavlink.MAV_FTP_ERR_EOF)


def file_crc(content: bytes) -> int:
    """Return MAVLink's CRC32 of a file: that of zlib without the inversions."""
    return zlib.crc32(content, 0xFFFFFFFF) ^ 0xFFFFFFFF


def metadata_files(rows: Sequence[ParameterRow], ids: Mapping[str, str]) -> dict[str, bytes]:
    """Return the files that tell a station units, ranges and meanings of parameters.

    Args:
        rows: the live parameters.
        ids: MAVLink id of each, by its name.
    """
    parameters = [
        {
            "name": ids[row.name],
            "type": "Float",
            "group": row.name.partition("_")[0],
            "shortDesc": row.name,
            "longDesc": row.help,
            "units": "" if row.unit == "1" else row.unit,
            "min": row.low,
            "max": row.high,
            "default": row.default,
            "decimalPlaces": 4,
        }
        for row in rows
        if row.name in ids
    ]
    about = _json_bytes({"version": 1, "parameters": parameters})
    general = {
        "version": 1,
        "metadataTypes": [
            {
                "type": PARAMETER_METADATA_TYPE,
                "uri": f"mftp:///{PARAMETER_FILE}",
                "fileCrc": file_crc(about),
            }
        ],
    }
    return {GENERAL_FILE: _json_bytes(general), PARAMETER_FILE: about}


def _json_bytes(value: object) -> bytes:
    return json.dumps(value, allow_nan=False, separators=(",", ":")).encode()


class ComponentMetadata(mavlink.MAVLink_message):
    """COMPONENT_METADATA, which pymavlink's dialects lack: where the general metadata is.

    Source: MAVLink's common.xml, message 397: uint32 time_boot_ms, uint32 file_crc, char[100] uri.

    Args:
        time_ms: since the start [ms].
        crc: of the file.
        uri: of the file.
    """

    crc_extra = 182
    unpacker = struct.Struct("<II100s")

    def __init__(self, time_ms: int, crc: int, uri: str) -> None:
        super().__init__(METADATA_MESSAGE_ID, "COMPONENT_METADATA")
        self._values = (time_ms, crc, uri.encode())

    def pack(self, mav: Any, force_mavlink1: bool = False) -> bytes:
        """Return the bytes of the message."""
        return self._pack(mav, self.crc_extra, self.unpacker.pack(*self._values), force_mavlink1)
