"""YAML files with the line of every key, for errors with file and line.

PyYAML takes a tenth of Drake's time to load, and most commands read no such file.
"""

import copy
import dataclasses
import re
import types
import typing
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.common.errors import MAX_ECHO_CHARS, WorkbenchError, unknown_name
from workbench.common.plain_files import read_plain_text
from workbench.common.plain_text import plain_name

if TYPE_CHECKING:
    import yaml


Keys = tuple[str | int, ...]
"""The path to a value: keys of mappings and indices in lists, from the top."""
Schema = type | types.GenericAlias | types.UnionType | str | None
"""A dataclass, or the type of one of its fields."""

MAX_YAML_BYTES = 1_000_000
MAX_YAML_DEPTH = 20
MAX_YAML_TOKENS = 200_000
"""Limit of the number of keys, values, brackets, colons and commas; they take a second."""
MAX_YAML_NUMBER_CHARS = 400
"""Limit of the characters of a number; YAML's digits in base 60 take the square of their number."""
_YAML_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
_YAML_NUMERIC_START = re.compile(r"[-+.]?\d\S*")


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
    lines: dict[Keys, int]

    def where(self, *keys: str | int) -> str:
        """Return "file:line: " of a key, for the beginning of a message."""
        while keys and keys not in self.lines:
            keys = keys[:-1]
        return f"{self.path}:{self.lines.get(keys, 1)}: "


def fast_loader() -> "type[yaml.SafeLoader]":
    """Return PyYAML's loader with libyaml if available, twenty times as fast."""
    import yaml

    return getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def read_yaml(path: Path, loader: "type[yaml.SafeLoader] | None" = None) -> YamlFile:
    """Read a YAML file whose top level is a mapping.

    Args:
        path: the file.
        loader: of PyYAML, for additional tags; None for the fast one.

    Raises:
        WorkbenchError: if it cannot be read, or is not a YAML mapping.
    """
    return parse_yaml(path, read_plain_text(path, MAX_YAML_BYTES), loader)


def parse_yaml(source: Path, text: str, loader: "type[yaml.SafeLoader] | None" = None) -> YamlFile:
    """Return a YAML text whose top level is a mapping.

    Args:
        source: where the text is from, for messages.
        text: the YAML.
        loader: of PyYAML, for additional tags; None for the fast one.

    Raises:
        WorkbenchError: if it is not a YAML mapping, or costly to read.
    """
    found = _parsed(source, text, loader or fast_loader())
    return dataclasses.replace(found, data=copy.deepcopy(found.data))


@lru_cache(maxsize=16)
def _parsed(path: Path, text: str, loader: "type[yaml.SafeLoader]") -> YamlFile:
    """Return the file for a text; cached, as the gains of a vehicle are read repeatedly."""
    import yaml

    try:
        reject_costly_yaml(path, text)
        parser = loader(text)
        try:
            node = parser.get_single_node()
            data = None if node is None else parser.construct_document(node)
        finally:
            parser.dispose()
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        line = min(line, 1 + text.count("\n"))  # libyaml has a file's end on a line of its own
        raise WorkbenchError(f"{path}:{line}: not YAML: {error.problem}") from error
    except yaml.YAMLError as error:
        raise WorkbenchError(f"{path}: not YAML: {' '.join(str(error).split())}") from error
    except ValueError as error:  # an invalid date, a number with a thousand digits
        raise WorkbenchError(f"{path}: not YAML: {error}") from error
    if not isinstance(data, dict):
        raise WorkbenchError(f"{path}:1: expected 'key: value' lines, found {type(data).__name__}")
    lines: dict[Keys, int] = {}
    _collect_lines(path, node, (), lines)
    return YamlFile(path, text, data, lines)


def reject_costly_yaml(path: Path, text: str) -> None:
    """Reject files that take long or much memory: aliases, depth, many values, long numbers."""
    import yaml

    opening = (
        yaml.BlockMappingStartToken,
        yaml.BlockSequenceStartToken,
        yaml.FlowMappingStartToken,
        yaml.FlowSequenceStartToken,
    )
    closing = (yaml.BlockEndToken, yaml.FlowMappingEndToken, yaml.FlowSequenceEndToken)
    depth = 0
    for count, token in enumerate(yaml.scan(text, Loader=fast_loader())):
        if count > MAX_YAML_TOKENS:
            line = token.start_mark.line + 1
            raise WorkbenchError(
                f"{path}:{line}: here are more than {MAX_YAML_TOKENS} keys, values and signs: "
                "leave "
                "some out"
            )
        word = token.value if isinstance(token, yaml.ScalarToken) and token.plain else ""
        if len(word) > MAX_YAML_NUMBER_CHARS and _YAML_NUMERIC_START.fullmatch(word):
            line = token.start_mark.line + 1
            raise WorkbenchError(
                f"{path}:{line}: a number has more than {MAX_YAML_NUMBER_CHARS} characters: "
                "shorten it"
            )
        depth += isinstance(token, opening) - isinstance(token, closing)
        if depth > MAX_YAML_DEPTH:
            line = token.start_mark.line + 1
            raise WorkbenchError(f"{path}:{line}: is nested more than {MAX_YAML_DEPTH} deep")
        if isinstance(token, yaml.AliasToken):
            line = token.start_mark.line + 1
            raise WorkbenchError(f"{path}:{line}: has an alias: write it out")


def with_numbers(file: YamlFile, schema: type) -> YamlFile:
    """Return a file with numbers converted that YAML 1.1 reads as texts or integers: 1e-3, 1e9, 2.

    Arguments are those of `check_schema`; values that do not fit the schema stay unchanged.
    """
    return dataclasses.replace(file, data=_numbered(file.data, schema))


def _numbered(data: Any, schema: Schema) -> Any:
    origin, parts = typing.get_origin(schema) or schema, typing.get_args(schema)
    if origin in (typing.Union, types.UnionType):
        return _numbered(data, next(part for part in parts if part is not type(None)))
    if dataclasses.is_dataclass(origin) and isinstance(data, dict):
        fields = {field.name: field.type for field in dataclasses.fields(origin)}
        return {key: _numbered(value, fields.get(key)) for key, value in data.items()}
    if origin in (list, tuple) and isinstance(data, list):
        return [_numbered(item, parts[0]) for item in data]
    if origin is dict and isinstance(data, dict):
        return {key: _numbered(value, parts[1]) for key, value in data.items()}
    written = isinstance(data, str) and _YAML_NUMBER.fullmatch(data)
    if origin is float and (written or type(data) is int):
        with suppress(OverflowError):  # an integer beyond all floats
            return float(data)
    return data


def check_schema(file: YamlFile, schema: type) -> None:
    """Check the content of a file against a dataclass.

    Args:
        file: its content is checked.
        schema: a dataclass of numbers, texts, dataclasses, and lists, tuples and dictionaries of
            them.

    Raises:
        WorkbenchError: for the first unknown key, or the first value of a wrong type.
    """
    _check(file, file.data, schema, ())


def _check(file: YamlFile, data: object, schema: Schema, keys: Keys) -> None:
    origin, parts = typing.get_origin(schema) or schema, typing.get_args(schema)
    if origin in (typing.Union, types.UnionType):
        if data is not None:
            _check(file, data, next(part for part in parts if part is not type(None)), keys)
        return
    if dataclasses.is_dataclass(origin):
        fields = {field.name: field.type for field in dataclasses.fields(origin)}
        for key, value in _expect(file, data, dict, "'key: value' lines", keys).items():
            if key not in fields:
                where = file.where(*keys, key)
                raise WorkbenchError(f"{where}{unknown_name('key', str(key), fields)}")
            _check(file, value, fields[key], (*keys, key))
    elif origin in (list, tuple):
        for index, item in enumerate(_expect(file, data, list, "a list", keys)):
            _check(file, item, parts[0], (*keys, index))
    elif origin is dict:
        for key, value in _expect(file, data, dict, "'key: value' lines", keys).items():
            if not isinstance(key, parts[0]):
                shown = plain_name(repr(key), MAX_ECHO_CHARS)
                raise WorkbenchError(
                    f"{file.where(*keys, key)}the key {shown} should be text: put it in quotes"
                )
            _check(file, value, parts[1], (*keys, key))
    elif origin is str:
        _expect(file, data, str, "text: put it in quotes", keys)
    elif origin is bool:
        if not isinstance(data, bool):
            raise WorkbenchError(
                f"{file.where(*keys)}{dotted(keys)} is {data!r}, and should be true or false"
            )
    else:
        expected: Any = (int, float) if origin is float else (origin,)
        _expect(file, data, expected, "a number" if origin is float else "a whole number", keys)


def _expect(
    file: YamlFile, data: object, kind: type | tuple[type, ...], name: str, keys: Keys
) -> Any:
    """Return `data` if it is of a type; a truth value is not a number."""
    if isinstance(data, kind) and not isinstance(data, bool):
        return data
    shown = plain_name(repr(data), MAX_ECHO_CHARS)
    raise WorkbenchError(f"{file.where(*keys)}{dotted(keys)} is {shown}, and should be {name}")


def as_record(data: Any, schema: Schema) -> Any:
    """Return checked data as the dataclass of its schema, see `check_schema`."""
    origin, parts = typing.get_origin(schema) or schema, typing.get_args(schema)
    if data is not None and origin in (typing.Union, types.UnionType):
        return as_record(data, next(part for part in parts if part is not type(None)))
    if dataclasses.is_dataclass(origin):
        fields = {field.name: field.type for field in dataclasses.fields(origin)}
        made: Any = origin
        return made(**{key: as_record(value, fields.get(key)) for key, value in data.items()})
    if origin in (list, tuple):
        return [as_record(item, parts[0]) for item in data]
    if origin is dict:
        return {key: as_record(value, parts[1]) for key, value in data.items()}
    return data


def dotted(keys: Keys) -> str:
    """Return keys as one name."""
    return ".".join(map(str, keys))


def _collect_lines(path: Path, node: "yaml.Node", keys: Keys, lines: dict[Keys, int]) -> None:
    """Note the line of every key below a node."""
    import yaml

    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            line = key.start_mark.line + 1
            if (*keys, key.value) in lines:
                raise WorkbenchError(f"{path}:{line}: '{key.value}' appears a second time")
            lines[(*keys, key.value)] = line
            _collect_lines(path, value, (*keys, key.value), lines)
    elif isinstance(node, yaml.SequenceNode):
        for index, value in enumerate(node.value):
            lines[(*keys, index)] = value.start_mark.line + 1
            _collect_lines(path, value, (*keys, index), lines)


def dump_changes(record: object) -> str:
    """Return the YAML of the differences from the defaults of a dataclass."""
    import yaml

    return yaml.safe_dump(changes_of(record), sort_keys=False, allow_unicode=True)


def changes_of(record: object) -> dict[str, Any]:
    """Return the differences from the defaults of a dataclass, for YAML."""
    found: dict[str, Any] = _changes(record, type(record)())
    return found


def _changes(value: object, default: object) -> Any:
    """Return a value for YAML; for a dataclass, the differences from its default."""
    if isinstance(value, list | tuple):
        return [_changes(each, type(each)()) for each in value]
    if not dataclasses.is_dataclass(value):
        return value
    if default is None:
        default = type(value)()
    names = [each.name for each in dataclasses.fields(value)]
    pairs = ((name, getattr(value, name), getattr(default, name)) for name in names)
    return {name: _changes(new, old) for name, new, old in pairs if new != old}


@lru_cache(maxsize=1)
def tagged_loader() -> "type[yaml.SafeLoader]":
    """Return a loader that ignores tags of Drake such as `!Rpy`."""
    loader: Any = type("TaggedLoader", (fast_loader(),), {})
    loader.add_multi_constructor("!", _without_tag)
    return loader


def _without_tag(loader: "yaml.SafeLoader", _: str, node: "yaml.Node") -> object:
    import yaml

    if isinstance(node, yaml.MappingNode):
        return loader.construct_mapping(node, deep=True)
    if isinstance(node, yaml.SequenceNode):
        return loader.construct_sequence(node, deep=True)
    return loader.construct_scalar(node)
