"""YAML files with the line of every key, for messages that name file and line."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from workbench.errors import WorkbenchError


@dataclass(frozen=True)
class YamlFile:
    """A parsed YAML mapping.

    Attributes:
        path: the file.
        text: its text.
        data: its content.
        lines: the line of each key, by its path of keys and list indices.
    """

    path: Path
    text: str
    data: dict[str, Any]
    lines: dict[tuple[str | int, ...], int]

    def where(self, *keys: str | int) -> str:
        """Return "file:line: " of a key, for the beginning of a message."""
        while keys and keys not in self.lines:
            keys = keys[:-1]
        return f"{self.path}:{self.lines.get(keys, 1)}: "


def read_yaml(path: Path) -> YamlFile:
    """Read a YAML file whose top level is a mapping.

    Raises:
        WorkbenchError: if it cannot be read, or is not such YAML.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise WorkbenchError(f"{path}: cannot be read: {error}") from error
    try:
        node = yaml.compose(text, Loader=yaml.SafeLoader)
        data = yaml.safe_load(text)
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        raise WorkbenchError(f"{path}:{line}: not YAML: {error.problem}") from error
    if not isinstance(data, dict):
        raise WorkbenchError(f"{path}:1: expected 'key: value' lines, found {type(data).__name__}")
    lines: dict[tuple[str | int, ...], int] = {}
    _collect_lines(node, (), lines)
    return YamlFile(path, text, data, lines)


def _collect_lines(
    node: yaml.Node, keys: tuple[str | int, ...], lines: dict[tuple[str | int, ...], int]
) -> None:
    """Note the line of every key below a node."""
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            lines[(*keys, key.value)] = key.start_mark.line + 1
            _collect_lines(value, (*keys, key.value), lines)
    elif isinstance(node, yaml.SequenceNode):
        for index, value in enumerate(node.value):
            lines[(*keys, index)] = value.start_mark.line + 1
            _collect_lines(value, (*keys, index), lines)
