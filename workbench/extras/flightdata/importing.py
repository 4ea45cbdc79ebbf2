"""Write a flight of another program as a log of the workbench."""

from pathlib import Path

from mcap.well_known import MessageEncoding, SchemaEncoding

from workbench.common.flight import Flight
from workbench.link.ros_messages.cdr import CDR_ENCAPSULATION
from workbench.link.topics import PREFIX
from workbench.logs.contents import IMPORTED_ATTACHMENT, VERSIONS_METADATA, software_versions
from workbench.logs.imported import record_metadata, signal_topics
from workbench.logs.mcap_writer import McapWriter


def write_flight(flight: Flight, path: Path) -> None:
    """Write a flight as a log of the workbench; `imported_flight` restores the same flight.

    Raises:
        OSError: if the file cannot be written.
    """
    streams = signal_topics(flight)
    found = software_versions()
    writer = McapWriter(path, f"workbench {found['workbench']}")
    try:
        writer.add_metadata(VERSIONS_METADATA, found)
        writer.add_attachment(
            0, 0, IMPORTED_ATTACHMENT, "application/json", record_metadata(flight, streams).encode()
        )
        channels = []
        for each in streams:
            schema = each.schema.encode()
            number = writer.register_schema(each.topic.type, SchemaEncoding.ROS2, schema)
            name = f"{PREFIX}{each.ros_name}"
            channels.append(writer.register_channel(name, MessageEncoding.CDR, number))
        rows = [
            (t_ns, channel, row)
            for channel, each in zip(channels, streams, strict=True)
            for t_ns, row in zip(each.topic.t_ns.tolist(), each.table, strict=True)
        ]
        for t_ns, channel, row in sorted(rows, key=lambda row: row[:2]):
            writer.message(channel, t_ns, t_ns, CDR_ENCAPSULATION + row.tobytes())
        writer.finish()
    except BaseException:
        writer.give_up()
        raise
