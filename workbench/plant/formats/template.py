"""Recognize a file that is a template of a description, not a description."""

import re
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import read_plain
from workbench.plant.formats.values import shortened_text
from workbench.plant.formats.xml import MAX_XML_BYTES

_TEMPLATE_PATTERN = re.compile(rb"\{\{[^\n]*?\}\}|\{%|<%")


def refuse_template(path: Path) -> None:
    """Reject a jinja or erb template; comments are ignored.

    Raises:
        WorkbenchError: naming file and line of the first template mark.
    """
    data = read_plain(path, MAX_XML_BYTES)
    line = 1
    for index, part in enumerate(data.split(b"<!--")):
        comment, _, text = part.partition(b"-->") if index else (b"", b"", part)
        line += comment.count(b"\n")
        match = _TEMPLATE_PATTERN.search(text)
        if match:
            line += text[: match.start()].count(b"\n")
            raise WorkbenchError(
                f"{path}:{line}: '{shortened_text(match[0].decode(errors='replace'))}' makes this "
                "a "
                "template: render it first (jinja or erb) and give the result"
            )
        line += text.count(b"\n")
