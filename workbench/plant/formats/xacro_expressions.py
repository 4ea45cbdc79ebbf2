"""The values of xacro's expressions, by an interpreter of their syntax tree.

xacro evaluates `${...}` and `$(eval ...)` as Python, which gives a file all that Python can do.
This interpreter has Python's expressions and xacro's names. Its values are numbers, texts, lists,
mappings and the functions that xacro offers; no other object can be reached from them. Time and
memory are bounded for the whole process, see `ipc.limited`.
"""

import ast
import operator
import string
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

from xacro import NameSpace, XacroException, YamlDictWrapper, YamlListWrapper

_MAX_POWER_BITS = 100_000
"""Of a whole number that is a power: far beyond those of any description."""


def _bounded_power(one: Any, other: Any) -> Any:
    """Return a power.

    Python computes one of whole numbers to the last digit, and cannot be interrupted meanwhile.
    """
    whole = isinstance(one, int) and isinstance(other, int)
    if whole and one.bit_length() * other > _MAX_POWER_BITS:
        raise OverflowError(f"a power of more than {_MAX_POWER_BITS:,} bits is too large")
    return one**other


_OPERATORS: Mapping[type[ast.AST], Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: _bounded_power,
    ast.LShift: operator.lshift,
    ast.RShift: operator.rshift,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.BitXor: operator.xor,
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
    ast.Invert: operator.invert,
    ast.Not: operator.not_,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
    ast.In: lambda one, many: one in many,
    ast.NotIn: lambda one, many: one not in many,
}
_CONVERSIONS: Mapping[int, Callable[[Any], Any]] = {
    -1: lambda value: value,
    ord("s"): str,
    ord("r"): repr,
    ord("a"): ascii,
}
_DATA_TYPES = (
    *(bool, int, float, complex, str, bytes),
    *(list, tuple, dict, set, frozenset, range, slice, type(None)),
    *(YamlListWrapper, YamlDictWrapper),
)
"""Types of data: all that their public attributes return is data, too."""


class _Scope(dict[str, Any]):
    """The names of a comprehension or a lambda, and those around it."""

    def __init__(self, around: Mapping[str, Any], own: Mapping[str, Any] | None = None) -> None:
        super().__init__(own or {})
        self._around = around

    def __missing__(self, name: str) -> Any:
        return self._around[name]


class _Formatter(string.Formatter):
    """Formats as `str.format` does, with the attributes of an expression only."""

    def get_field(self, field_name: str, args: Any, kwargs: Any) -> Any:
        # the base class calls getattr, which reaches every attribute
        first, _, rest = field_name.partition(".")
        value, used = super().get_field(first, args, kwargs)
        for name in rest.split(".") if rest else ():
            key, *indices = name.replace("]", "").split("[")
            value = public_attribute(value, key)
            for index in indices:
                value = value[int(index) if index.isdecimal() else index]
        return value, used


def evaluate(text: str, symbols: Mapping[str, Any], _: object = None) -> Any:
    """Return the value of an expression; replaces `xacro.safe_eval`.

    Args:
        text: the expression.
        symbols: values by name.

    Raises:
        Exception: whatever Python raises for such an expression, as SyntaxError or NameError.
    """
    return _node_value(ast.parse(text.strip(), "<expression>", "eval").body, symbols)


def public_attribute(value: Any, name: str) -> Any:
    """Return an attribute of a value, or an item of a namespace or a YAML mapping.

    Raises:
        AttributeError: if there is none, or expressions cannot use it.
    """
    if isinstance(value, NameSpace) and not name.startswith("__"):
        return _symbol_value(name, value)
    if isinstance(value, YamlDictWrapper) and name.startswith("_") and name in value:
        return value[name]
    kind = value if isinstance(value, type) else type(value)
    if (
        kind not in _DATA_TYPES
        or name.startswith("_")
        or (kind is value and name not in dir(value))
    ):
        raise AttributeError(f"an expression cannot use '{name}' of a {kind.__name__}")
    if kind is str and name in ("format", "format_map"):
        how = _formatted if name == "format" else _format_map
        return how if kind is value else partial(how, value)
    return getattr(value, name)


def type_of(value: Any) -> type:
    """Return the type of a value; replaces `type`, which can also make one.

    Raises:
        TypeError: for a value that is not data.
    """
    if type(value) not in _DATA_TYPES:
        raise TypeError(f"an expression cannot use the type {type(value).__name__}")
    return type(value)


def _formatted(text: str, /, *args: Any, **kwargs: Any) -> str:
    return _Formatter().vformat(text, args, kwargs)


def _format_map(text: str, values: Mapping[str, Any]) -> str:
    return _Formatter().vformat(text, (), values)


def _node_value(node: ast.expr | None, names: Mapping[str, Any]) -> Any:
    """Return the value of a node."""
    match node:
        case ast.Constant(value=value):
            return value
        case ast.Name(id=name):
            return _symbol_value(name, names)
        case ast.Attribute(value=of, attr=name):
            return public_attribute(_node_value(of, names), name)
        case ast.Subscript(value=of, slice=index):
            return _node_value(of, names)[_node_value(index, names)]
        case ast.Slice(lower=lower, upper=upper, step=step):
            return slice(*(each and _node_value(each, names) for each in (lower, upper, step)))
        case ast.UnaryOp(op=op, operand=operand):
            return _OPERATORS[type(op)](_node_value(operand, names))
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATORS:
            return _OPERATORS[type(op)](_node_value(left, names), _node_value(right, names))
        case ast.BoolOp() | ast.Compare() | ast.IfExp():
            return _logic(node, names)
        case ast.Call(func=function, args=args, keywords=keywords):
            called = _node_value(function, names)
            return called(*_item_values(args, names), **_named_arguments(keywords, names))
        case ast.Lambda():
            return _function(node, names)
        case ast.List(elts=items):
            return list(_item_values(items, names))
        case ast.Tuple(elts=items):
            return tuple(_item_values(items, names))
        case ast.Set(elts=items):
            return set(_item_values(items, names))
        case ast.Dict(keys=keys, values=values):
            return _mapping_value(keys, values, names)
        case ast.ListComp(elt=item, generators=loops):
            return [_node_value(item, each) for each in _loop_scopes(loops, _Scope(names))]
        case ast.SetComp(elt=item, generators=loops):
            return {_node_value(item, each) for each in _loop_scopes(loops, _Scope(names))}
        case ast.GeneratorExp(elt=item, generators=loops):
            return (_node_value(item, each) for each in _loop_scopes(loops, _Scope(names)))
        case ast.DictComp(key=key, value=value, generators=loops):
            scopes = _loop_scopes(loops, _Scope(names))
            return {_node_value(key, each): _node_value(value, each) for each in scopes}
        case ast.JoinedStr(values=parts):
            return "".join(str(_node_value(part, names)) for part in parts)
        case ast.FormattedValue(value=of, conversion=conversion, format_spec=spec):
            found = _CONVERSIONS[conversion](_node_value(of, names))
            return format(found, _node_value(spec, names) if spec else "")
    raise SyntaxError(f"an expression cannot have a {type(node).__name__}")


def _symbol_value(name: str, names: Mapping[str, Any]) -> Any:
    if name.startswith("__"):
        raise XacroException("Use of invalid name(s): ", name)
    try:
        return names[name]
    except KeyError:
        raise NameError(f"name '{name}' is not defined") from None


def _logic(node: ast.BoolOp | ast.Compare | ast.IfExp, names: Mapping[str, Any]) -> Any:
    """Return the value of an expression that may leave out a part of itself."""
    match node:
        case ast.IfExp(test=test, body=body, orelse=other):
            return _node_value(body if _node_value(test, names) else other, names)
        case ast.BoolOp(op=op, values=parts):
            found = None
            for part in parts:
                found = _node_value(part, names)
                if bool(found) == isinstance(op, ast.Or):
                    break
            return found
        case ast.Compare(left=left, ops=ops, comparators=others):
            one, found = _node_value(left, names), True
            for op, part in zip(ops, others, strict=True):
                other = _node_value(part, names)
                found = _OPERATORS[type(op)](one, other)
                if not found:
                    break
                one = other
            return found


def _item_values(nodes: list[ast.expr], names: Mapping[str, Any]) -> Iterator[Any]:
    """Yield the values of nodes; one with a star has several."""
    for node in nodes:
        if isinstance(node, ast.Starred):
            yield from _node_value(node.value, names)
        else:
            yield _node_value(node, names)


def _named_arguments(keywords: list[ast.keyword], names: Mapping[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for keyword in keywords:
        value = _node_value(keyword.value, names)
        found |= dict(value) if keyword.arg is None else {keyword.arg: value}
    return found


def _mapping_value(
    keys: list[ast.expr | None], values: list[ast.expr], names: Mapping[str, Any]
) -> dict[Any, Any]:
    found: dict[Any, Any] = {}
    for key, value in zip(keys, values, strict=True):
        if key is None:  # `**mapping`
            found |= _node_value(value, names)
        else:
            found[_node_value(key, names)] = _node_value(value, names)
    return found


def _loop_scopes(loops: list[ast.comprehension], scope: _Scope) -> Iterator[_Scope]:
    """Yield the names of each turn of the loops of a comprehension."""
    if not loops:
        yield scope
        return
    loop, *inner = loops
    for item in _node_value(loop.iter, scope):
        _assign(loop.target, item, scope)
        if all(_node_value(test, scope) for test in loop.ifs):
            yield from _loop_scopes(inner, scope)


def _assign(target: ast.expr, value: Any, scope: _Scope) -> None:
    """Give the names of a target their values."""
    match target:
        case ast.Name(id=name):
            scope[name] = value
        case ast.Tuple(elts=parts) | ast.List(elts=parts):
            values = list(value)
            if len(values) != len(parts):
                raise ValueError(f"expected {len(parts)} values to unpack, not {len(values)}")
            for part, each in zip(parts, values, strict=True):
                _assign(part, each, scope)
        case _:
            raise SyntaxError(f"an expression cannot assign to a {type(target).__name__}")


def _function(node: ast.Lambda, names: Mapping[str, Any]) -> Callable[..., Any]:
    """Return the function of a lambda, whose parameters have no stars."""
    given = node.args
    if given.vararg or given.kwarg or given.kwonlyargs or given.posonlyargs:
        raise SyntaxError("a lambda has plain parameters here")
    parameters = [each.arg for each in given.args]
    defaults = dict(
        zip(
            parameters[len(parameters) - len(given.defaults) :],
            _item_values(given.defaults, names),
            strict=True,
        )
    )

    def function(*args: Any, **kwargs: Any) -> Any:
        named = dict(zip(parameters, args, strict=False))
        values = defaults | named | kwargs
        if len(args) > len(parameters) or named.keys() & kwargs or values.keys() != set(parameters):
            raise TypeError(f"the lambda takes {', '.join(parameters) or 'no arguments'}")
        return _node_value(node.body, _Scope(names, values))

    return function
