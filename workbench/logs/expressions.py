"""Signals computed from others by a short expression, such as sqrt(v_x**2 + v_y**2)."""

import ast
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.series import TimedValues
from workbench.logs.spectrum import MIN_SPECTRUM_SAMPLES, even_samples

SampleReader = Callable[[str, float], TimedValues]
"""Function that returns the samples of a signal by its name, from a time on [s]."""

MAX_EXPRESSION_CHARS = 300
"""Largest number of characters."""
PREFERRED_TOPICS = ("position_data", "velocity_data", "acceleration_data", "force_torque_data")
"""Topics that take precedence where several have a field with the same name: the true motion."""
_LEAD_TIME_S = 1.0
"""Time before the first sample for which other signals are read, for interpolation [s]."""
_DOTTED_NAME_PATTERN = re.compile(r"[A-Za-z_]\w*(?:\.\w+)+")


@dataclass(frozen=True)
class ExpressionFunction:
    """A function of an expression.

    Attributes:
        of: returns values from times [s] and arguments.
        arguments: their number.
        before: returns from the numeric arguments how much earlier samples are needed [s].
        help: its description.
    """

    of: Callable[..., np.ndarray]
    arguments: int
    help: str
    before: Callable[..., float] = lambda *_: 0.0


def _pointwise_function(
    of: Callable[..., np.ndarray], arguments: int, help: str
) -> ExpressionFunction:
    """Return a function that depends on values only."""
    return ExpressionFunction(lambda _, *values: of(*values), arguments, help)


def _difference_of_samples(_: np.ndarray, values: np.ndarray) -> np.ndarray:
    return np.diff(values, prepend=np.nan)


def _derivative(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    if len(time) < 2:
        return np.full(len(time), np.nan)
    return np.gradient(values, time)


def _lowpass(time: np.ndarray, values: np.ndarray, cutoff: float) -> np.ndarray:
    import scipy.signal  # slow to load, and rarely needed

    if len(time) < MIN_SPECTRUM_SAMPLES:  # the flight has just begun
        return np.full(len(time), np.nan)
    even, rate, resampled = even_samples(time, values, "a low-pass")
    if not 0.0 < cutoff < (0.5 - 1e-9) * rate:
        raise WorkbenchError(
            f"lowpass at {cutoff:g} Hz: with {rate:.4g} samples a second the cut-off is above 0 "
            f"and below {0.5 * rate:.4g} Hz"
        )
    sections = scipy.signal.butter(2, cutoff, fs=rate, output="sos")
    settled = scipy.signal.sosfilt_zi(sections) * even[0]
    smooth, _ = scipy.signal.sosfilt(sections, even, zi=settled)
    known = time[np.isfinite(values)]
    grid = np.linspace(known[0], known[-1], len(smooth)) if resampled else known
    return np.interp(time, grid, smooth, left=np.nan, right=np.nan)


EXPRESSION_FUNCTIONS: Mapping[str, ExpressionFunction] = {
    **{
        name: _pointwise_function(of, 1, help)
        for name, of, help in (
            ("sqrt", np.sqrt, "square root"),
            ("abs", np.abs, "absolute value"),
            ("sign", np.sign, "-1, 0 or 1"),
            ("exp", np.exp, "e to a power"),
            ("log", np.log, "natural logarithm"),
            ("log10", np.log10, "logarithm to 10"),
            ("sin", np.sin, "sine"),
            ("cos", np.cos, "cosine"),
            ("tan", np.tan, "tangent"),
            ("asin", np.arcsin, "inverse sine"),
            ("acos", np.arccos, "inverse cosine"),
            ("atan", np.arctan, "inverse tangent"),
            ("deg", np.rad2deg, "degrees of radians"),
            ("rad", np.deg2rad, "radians of degrees"),
        )
    },
    **{
        name: _pointwise_function(of, 2, help)
        for name, of, help in (
            ("atan2", np.arctan2, "angle of y and x"),
            ("hypot", np.hypot, "length of two components"),
            ("min", np.minimum, "the lesser of two"),
            ("max", np.maximum, "the larger of two"),
        )
    },
    "clip": _pointwise_function(np.clip, 3, "within a least and a largest value"),
    "diff": ExpressionFunction(
        _difference_of_samples, 1, "change since the sample before", lambda: _LEAD_TIME_S
    ),
    "derivative": ExpressionFunction(_derivative, 1, "slope over time", lambda: _LEAD_TIME_S),
    "unwrap": ExpressionFunction(
        lambda _, values: np.unwrap(values), 1, "an angle without jumps", lambda: np.inf
    ),
    "lowpass": ExpressionFunction(
        _lowpass,
        2,
        "second-order Butterworth low-pass, cut-off in Hz",
        lambda cutoff: 5.0 / cutoff if cutoff > 0.0 else 0.0,
    ),
}
"""Functions by their names in expressions; those of numpy if numpy has one."""
EXPRESSION_CONSTANTS = {"pi": np.pi}
_BINARY_OPERATORS: Mapping[type[ast.operator], Callable[..., np.ndarray]] = {
    ast.Add: np.add,
    ast.Sub: np.subtract,
    ast.Mult: np.multiply,
    ast.Div: np.divide,
    ast.Pow: np.power,
    ast.Mod: np.mod,
    ast.FloorDiv: np.floor_divide,
}
_COMPARISON_OPERATORS: Mapping[type[ast.cmpop], Callable[..., np.ndarray]] = {
    ast.Lt: np.less,
    ast.LtE: np.less_equal,
    ast.Gt: np.greater,
    ast.GtE: np.greater_equal,
    ast.Eq: np.equal,
    ast.NotEq: np.not_equal,
}


@dataclass(frozen=True)
class Expression:
    """An expression that was parsed.

    Attributes:
        text: as written.
        signals: the names in it, in the order of the text; its times are those of the first signal.
        before: how much earlier samples it needs than it returns [s].
    """

    text: str
    signals: tuple[str, ...]
    before: float
    _tree: ast.expr
    _named: Mapping[str, str]

    def find(self, known: Iterable[str]) -> dict[str, str]:
        """Return the full name of each of its signals.

        Raises:
            WorkbenchError: if one is unknown or ambiguous.
        """
        names = tuple(known)
        found = {each: _candidates(each, names) for each in self.signals}
        for name, full in found.items():
            if len(full) > 1:
                raise WorkbenchError(f"'{name}' may be {', '.join(full)}: write which one")
            if not full:
                raise unknown_name("signal", name, names)
        return {name: full[0] for name, full in found.items()}

    def can_find(self, known: Iterable[str]) -> bool:
        """Return whether `find` would succeed, without a search for similar names."""
        names = tuple(known)
        return all(len(_candidates(each, names)) == 1 for each in self.signals)

    def series(
        self, read: SampleReader, full: Mapping[str, str], since: float = -np.inf
    ) -> TimedValues:
        """Return its times and values, from a time on [s].

        Other signals than the first are interpolated linearly to its times. There is no value
        before their first sample; the last one is held.

        Args:
            read: returns the samples of its signals.
            full: their full names, from `find`.
            since: first time [s].

        Raises:
            WorkbenchError: if a filter is not suitable for the samples.
        """
        begin = since - self.before
        time, first = read(full[self.signals[0]], begin)
        parts = {self.signals[0]: first}
        for name in self.signals[1:]:
            own, values = read(full[name], begin - _LEAD_TIME_S)
            same = len(own) == len(time) and (own == time).all()
            parts[name] = values if same else _held_at(time, own, values)
        if len(time) == 0:
            return time, np.zeros(0)
        made = self.values(time, parts)
        seen = int(np.searchsorted(time, since))
        return time[seen:], made[seen:]

    def values(self, time: np.ndarray, parts: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return its values (N) at times [s], from the values of its signals (N) by name.

        Raises:
            WorkbenchError: if a filter is not suitable for the samples.
        """
        with np.errstate(all="ignore"):  # invalid results are gaps in the curve
            made = self._value(self._tree, time, parts)
        return np.broadcast_to(np.asarray(made, dtype=float), time.shape)

    def _value(self, node: ast.expr, time: np.ndarray, parts: Mapping[str, np.ndarray]) -> Any:
        """Return the value of a node that `parse_expression` accepted."""
        match node:
            case ast.Constant(value=float() | int() as value):
                return np.float64(value)
            case ast.Name(id=name):
                return (
                    EXPRESSION_CONSTANTS[name]
                    if name in EXPRESSION_CONSTANTS
                    else parts[self._named[name]]
                )
            case ast.UnaryOp(op=op, operand=operand):
                of = self._value(operand, time, parts)
                return np.negative(of) if isinstance(op, ast.USub) else of
            case ast.BinOp(left=left, op=op, right=right):
                sides = (self._value(each, time, parts) for each in (left, right))
                return _BINARY_OPERATORS[type(op)](*sides)
            case ast.Compare(left=left, ops=[op], comparators=[right]):
                sides = (self._value(each, time, parts) for each in (left, right))
                return _COMPARISON_OPERATORS[type(op)](*sides).astype(float)
            case ast.Call(func=ast.Name(id=name), args=args):
                return EXPRESSION_FUNCTIONS[name].of(
                    time, *(self._value(each, time, parts) for each in args)
                )
        raise AssertionError(ast.dump(node))


def _held_at(time: np.ndarray, own: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return values at other times; NaN before the first."""
    if len(own) == 0:
        return np.full(len(time), np.nan)
    return np.interp(time, own, values, left=np.nan)


def _candidates(name: str, known: tuple[str, ...]) -> list[str]:
    """Return the possible full names of a signal given as TOPIC.FIELD, or as FIELD alone.

    If several topics have the field, that of the true motion takes precedence.
    """
    if name in known:
        return [name]
    found = [each for each in known if each.partition(".")[2] == name]
    true = [each for each in found if each.partition(".")[0] in PREFERRED_TOPICS]
    return true[:1] or found


def parse_expression(text: str) -> Expression:
    """Return an expression of numbers, signals, + - * / // % **, comparisons, and
    `EXPRESSION_FUNCTIONS`.

    Signals are TOPIC.FIELD, or FIELD alone if it is in only one topic or in the true motion. No
    code is executed: `ast` parses the text, and anything not in this list is rejected.

    Raises:
        WorkbenchError: with the position of the error.
    """
    if len(text) > MAX_EXPRESSION_CHARS:
        raise WorkbenchError(
            f"an expression has at most {MAX_EXPRESSION_CHARS} characters: shorten it"
        )
    named: dict[str, str] = {}

    def stand_in(found: re.Match[str]) -> str:
        """Return a plain Python name as long as a dotted one, so that positions stay the same."""
        if re.match(r"\d", found.string[found.start() - 1 : found.start()] or " "):
            return found.group()
        known = next((key for key, name in named.items() if name == found.group()), None)
        made = known or f"_{len(named)}".ljust(len(found.group()), "_")
        named[made] = found.group()
        return made

    plain = _DOTTED_NAME_PATTERN.sub(stand_in, text.rstrip())
    try:
        tree = ast.parse(plain, mode="eval").body
    except SyntaxError as error:
        place = error.offset - 1 if error.offset else len(plain)
        raise _wrong(text, place, "no expression here") from error
    except (ValueError, RecursionError, MemoryError) as error:
        raise WorkbenchError(f"'{text[:40]}' is not an expression") from error
    signals: list[str] = []
    before = _check_node(tree, text, named, signals)
    if not signals:
        raise WorkbenchError(f"'{text}' names no signal: write one, as velocity_data.v_x")
    return Expression(text, tuple(dict.fromkeys(signals)), before, tree, named)


def _check_node(node: ast.expr, text: str, named: dict[str, str], signals: list[str]) -> float:
    """Check that a node is allowed, note signals, and return the time needed before [s]."""

    def below(*nodes: ast.expr) -> float:
        return max((_check_node(each, text, named, signals) for each in nodes), default=0.0)

    match node:
        case ast.Constant(value=float() | int() as value) if not isinstance(value, bool):
            return 0.0
        case ast.Name(id=name):
            if name in EXPRESSION_FUNCTIONS:
                raise _wrong(text, node.col_offset, f"{name} is a function: write {name}(...)")
            if name not in EXPRESSION_CONSTANTS:
                named.setdefault(name, name)
                signals.append(named[name])
            return 0.0
        case ast.UnaryOp(op=ast.USub() | ast.UAdd(), operand=operand):
            return below(operand)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _BINARY_OPERATORS:
            return below(left, right)
        case ast.Compare(left=left, ops=[op], comparators=[right]) if (
            type(op) in _COMPARISON_OPERATORS
        ):
            return below(left, right)
        case ast.Call(func=ast.Name(id=name), args=args, keywords=[]):
            if name not in EXPRESSION_FUNCTIONS:
                raise _wrong(
                    text, node.col_offset, str(unknown_name("function", name, EXPRESSION_FUNCTIONS))
                )
            function = EXPRESSION_FUNCTIONS[name]
            if len(args) != function.arguments:
                wanted = f"{name} takes {function.arguments} arguments, not {len(args)}"
                raise _wrong(text, node.col_offset, wanted)
            numbers = (
                [_number_constant(each, text, name) for each in args[1:]]
                if name == "lowpass"
                else []
            )
            return below(*args) + function.before(*numbers)
    raise _wrong(text, node.col_offset, "this is not allowed in an expression")


def _number_constant(node: ast.expr, text: str, name: str) -> float:
    match node:
        case ast.Constant(value=float() | int() as value):
            return float(value)
    raise _wrong(text, node.col_offset, f"{name} takes a number here")


def _wrong(text: str, column: int, why: str) -> WorkbenchError:
    """Return the error at a column, counted from 0."""
    text = text.rstrip()
    rest = text[column : column + 20]
    at = f"at character {column + 1}, '{rest}'" if rest else "at its end"
    return WorkbenchError(f"'{text}', {at}: {why}")
