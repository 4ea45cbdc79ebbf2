"""The Crazyflie's parameters in YAML or JSON: `group.name: value`, and the firmware's version.

The firmware has no text file of its own. Read are names with a dot at the top, below `params`, or
as groups, and of a mapping its `stored_value` or `value`, as the client writes them.
"""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from workbench.common.errors import WorkbenchError
from workbench.common.yaml_files import fast_loader, reject_costly_yaml
from workbench.extras.autopilots.gain_files.parameter_file import (
    ParameterEntry,
    ParameterFile,
    number_in,
    shortest_single,
)

_VERSION_KEYS = ("firmware", "firmware_version")
_VALUE_KEYS = ("stored_value", "value")


def read_crazyflie_parameters(path: Path, text: str) -> ParameterFile:
    """Read a YAML or JSON file of parameters.

    Raises:
        WorkbenchError: if it is neither.
    """
    try:
        reject_costly_yaml(path, text)
        root = yaml.compose(text, Loader=fast_loader())
    except (yaml.YAMLError, ValueError, UnicodeError) as error:
        mark = getattr(error, "problem_mark", None)
        where = f":{mark.line + 1}" if mark else ""
        said = getattr(error, "problem", None) or "it has characters that are not allowed"
        raise WorkbenchError(f"{path}{where}: is neither YAML nor JSON: {said}") from error
    if not isinstance(root, yaml.MappingNode):
        raise WorkbenchError(f"{path}: expected lines as 'pid_rate.roll_kp: 250'")
    version = ""
    entries = []
    for name, node in _values(root, ""):
        if name in _VERSION_KEYS:
            version = node.value
            continue
        quoted = 1 if node.style in ("'", '"') else 0
        start = node.start_mark.index + quoted
        end = node.end_mark.index - quoted
        written, line = text[start:end], node.start_mark.line + 1
        entries.append(ParameterEntry(name, number_in(written), written, start, line))
    return ParameterFile(path, text, tuple(entries), version)


def _values(node: Any, group: str) -> Iterator[tuple[str, Any]]:
    """Yield name and node of every value; groups stand before their names, with a dot."""
    for key, value in node.value:
        if not isinstance(key, yaml.ScalarNode):
            continue
        name = f"{group}.{key.value}" if group else key.value
        if isinstance(value, yaml.ScalarNode):
            yield name, value
        elif isinstance(value, yaml.MappingNode):
            inner = {k.value: v for k, v in value.value if isinstance(k, yaml.ScalarNode)}
            stored = [inner[each] for each in _VALUE_KEYS if each in inner]
            if "." in name and stored and isinstance(stored[0], yaml.ScalarNode):
                yield name, stored[0]
            elif "." not in name:
                yield from _values(value, "" if name in ("params", "parameters") else name)


def crazyflie_value(entry: ParameterEntry, value: float) -> str:
    """Return the text of a value in its line."""
    if "." not in entry.text and "e" not in entry.text.lower() and value.is_integer():
        return str(int(value))
    text = shortest_single(value)
    return text if "." in text or "e" in text else f"{text}.0"


def new_crazyflie_file(values: Mapping[str, float], version: str) -> str:
    """Return the text of a YAML file."""
    lines = [f"firmware: {json.dumps(version)}\n", "params:\n"]
    return "".join([*lines, *(f"  {name}: {shortest_single(values[name])}\n" for name in values)])
