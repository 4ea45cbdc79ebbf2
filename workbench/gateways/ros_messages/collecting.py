"""The values of a message in a row, as `struct` wants them.

A definition is turned into functions once, as thousands of messages a second are encoded: fields
that follow each other and are one number each are read by a single `itemgetter`.
"""

from collections.abc import Callable, Mapping, Sequence
from itertools import groupby
from operator import itemgetter
from typing import Any

from workbench.gateways.ros_messages.definitions import (
    NUMBERS,
    TEXT,
    Arity,
    Definition,
    MessageField,
)
from workbench.gateways.ros_messages.layout import BYTES

Collect = Callable[[Any, list[Any], list[int]], None]
"""Adds the values of a message to a row, and the lengths of its texts and sequences to another."""


def make_collector(definitions: Mapping[str, Definition], name: str) -> Collect:
    """Return what collects the values of a message of a type."""
    steps: list[Collect] = []
    for plain, group in groupby(definitions[name].fields, key=_is_number):
        fields = list(group)
        if plain:
            steps.append(_numbers([field.name for field in fields]))
        else:
            steps += [_field(definitions, field) for field in fields]

    def collect(values: Any, flat: list[Any], shape: list[int]) -> None:
        for step in steps:
            step(values, flat, shape)

    return collect


def _is_number(field: MessageField) -> bool:
    return field.type in NUMBERS and field.arity is Arity.ONE


def _numbers(names: Sequence[str]) -> Collect:
    if len(names) == 1:
        name = names[0]
        return lambda values, flat, shape: flat.append(values[name])
    get = itemgetter(*names)
    return lambda values, flat, shape: flat.extend(get(values))


def _field(definitions: Mapping[str, Definition], field: MessageField) -> Collect:
    """Return what collects a field that is not just one number."""
    name = field.name
    several = _several(definitions, field)
    if field.arity is Arity.SEQUENCE:

        def sequence(values: Any, flat: list[Any], shape: list[int]) -> None:
            value = values[name]
            shape.append(len(value))
            flat.append(len(value))
            several(value, flat, shape)

        return sequence
    if field.arity is Arity.FIXED:

        def fixed(values: Any, flat: list[Any], shape: list[int]) -> None:
            value = values[name]
            if len(value) != field.count:
                raise ValueError(f"{name} has {len(value)} values: {field.count} are needed")
            several(value, flat, shape)

        return fixed
    one = _one(definitions, field)
    return lambda values, flat, shape: one(values[name], flat, shape)


def _several(definitions: Mapping[str, Definition], field: MessageField) -> Collect:
    """Return what collects the values of an array."""
    if field.type in BYTES:
        return lambda value, flat, shape: flat.append(bytes(value))
    if field.type in NUMBERS:
        return lambda value, flat, shape: flat.extend(value)
    one = _one(definitions, field)

    def each(value: Any, flat: list[Any], shape: list[int]) -> None:
        for item in value:
            one(item, flat, shape)

    return each


def _one(definitions: Mapping[str, Definition], field: MessageField) -> Collect:
    """Return what collects one text or message."""
    return _text if field.type == TEXT else make_collector(definitions, field.type)


def _text(value: str, flat: list[Any], shape: list[int]) -> None:
    data = value.encode()
    shape.append(len(data))
    flat += (len(data) + 1, data)
