"""Record what users, clients and files see of the workbench, and compare it with the recording.

`python tools/outside.py` runs the cases of tests/outside/cases.yaml and says what differs from the
recording in tests/outside/recorded. Names choose cases: `python tools/outside.py step judge-pitch`.
`--write` records anew what differs, and says what that is; with `--words` only sentences are taken
over, so that numbers, keys and options stay as they were recorded.

A case is a few command lines in a folder of its own, which holds a copy of tests/outside/given:
files that earlier versions wrote. Of each line the exit code, stdout (JSON where it is JSON) and
stderr are recorded, and of each case the files that it wrote. Long arrays are kept as a SHA-256 and
some of their values.

A difference is one of four kinds. `added`: a key, option, row or file that the recording does not
have; this never fails. `reworded`: other words in a text. `changed`: another value. `removed`.
Numbers are compared exactly where Drake, Python, NumPy and the processor are those of the
recording. Elsewhere rounding differs: a case's `tolerance` is the relative difference allowed then,
texts are compared without their numbers, and arrays by the values kept of them.

Exit code 0: all is as recorded. 1: something differs. 2: a name is not a case, or nothing is
recorded.
"""

import argparse
import contextlib
import csv
import difflib
import enum
import functools
import hashlib
import importlib.metadata
import inspect
import io
import json
import logging
import math
import os
import platform
import re
import shlex
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import numpy as np
import yaml

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "tests" / "outside"
GIVEN = FOLDER / "given"
RECORDED = FOLDER / "recorded"
TABLE = FOLDER / "cases.yaml"
VECTORS = ROOT / "tests" / "link" / "vectors"

LONG = 24
"""An array of more numbers is kept as a checksum and some of them."""
VIEW = 12
"""So many."""
CLOSE = 1e-9
"""Relative difference that another Drake or processor may make."""
TINY = 1e-12
"""Absolute difference that they may make, of numbers about zero."""
PATIENCE = 120.0
"""No process of a case takes so long [s]."""
HEADER = struct.Struct("<2sBBHHIIq")
"""Of a frame of the link, as docs/protocol.md has it."""


class OutsideError(Exception):
    """A case cannot be run or compared."""


@dataclass(frozen=True)
class Case:
    """Some command lines, and what is recorded besides their words.

    Attributes:
        name: of the file of the recording.
        lines: as typed into a shell; the first word is one of `PROGRAMS`.
        files: patterns of written files whose contents are recorded; of others the names are.
        ignored: patterns of paths in the recording that may differ, as times do.
        served: options of the `workbench serve` that is to run meanwhile; {address} in a line is
            where. Of what comes from a live flight only the kinds of values are recorded.
        tolerance: relative difference allowed where another machine or another Drake computes.
        near_zero: absolute difference allowed there.
        elsewhere: patterns of paths that are not compared there.
        why: more is allowed there than usual.
    """

    name: str
    lines: tuple[str, ...] = ()
    files: tuple[str, ...] = ()
    ignored: tuple[str, ...] = ()
    served: str | None = None
    tolerance: float = CLOSE
    near_zero: float = TINY
    elsewhere: tuple[str, ...] = ()
    why: str = ""


@dataclass(frozen=True)
class Difference:
    """What is not as recorded: the kind, where, and in words."""

    kind: str
    where: str
    said: str

    def __str__(self) -> str:
        return f"{self.kind}: {self.where}: {self.said}"


@dataclass(frozen=True)
class Rules:
    """How exactly two recordings are compared: `exact` means to the last digit."""

    exact: bool
    tolerance: float
    near_zero: float
    ignored: tuple[str, ...]


# ---- the table ------------------------------------------------------------------------------


@functools.cache
def cases() -> dict[str, Case]:
    """Return the cases by name."""
    rows = yaml.safe_load(TABLE.read_text(encoding="utf-8"))
    return {
        name: Case(name, **{k: tuple(v) if isinstance(v, list) else v for k, v in row.items()})
        for name, row in rows.items()
    }


# ---- recording ------------------------------------------------------------------------------


def record(case: Case) -> dict[str, Any]:
    """Run a case in a folder of its own, and return what was seen."""
    with tempfile.TemporaryDirectory(prefix="outside-") as name:
        folder = Path(name).resolve() / "here"
        shutil.copytree(GIVEN, folder)
        before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
        with contextlib.chdir(folder), _quiet(), _serving(case) as address:
            lines = [_seen(line, folder, address) for line in case.lines]
        found: dict[str, Any] = {"host": host(), "lines": lines}
        written = {
            path.relative_to(folder).as_posix(): path
            for path in sorted(folder.rglob("*"))
            if path.is_file() and before.get(path) != path.read_bytes()
            if "__pycache__" not in path.parts
        }
        if written:
            found["files"] = {
                name: _content(path, folder)
                if any(fnmatch(name, p) or fnmatch(path.name, p) for p in case.files)
                else "written"
                for name, path in written.items()
            }
        return json.loads(json.dumps(found))


@functools.cache
def host() -> dict[str, str]:
    """Return what decides how numbers are rounded."""
    versions = {name: importlib.metadata.version(name) for name in ("drake", "numpy", "scipy")}
    # libraries choose their code by the processor's flags
    flags = re.findall(r"(?m)^(?:flags|Features)\s*: (.*)", Path("/proc/cpuinfo").read_text())
    chosen = hashlib.sha256(" ".join(flags[:1]).encode()).hexdigest()[:12]
    return versions | {
        "python": ".".join(platform.python_version_tuple()[:2]),
        "processor": f"{platform.machine()} {chosen}",
    }


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Leave out what depends on how fast the machine is, and on its terminal."""
    wanted = {
        "COLUMNS": "100",
        "MPLBACKEND": "Agg",
        "NO_COLOR": "1",
        "PYTHONPATH": str(ROOT),
        "QT_QPA_PLATFORM": "offscreen",
        "WORKBENCH_FLY_ON": "diagram",  # whatever machine code is kept here
    }
    # with CI or BUILD_NUMBER set, pytest prints long lines in full
    unwanted = [
        name
        for name in os.environ
        if name in ("CI", "BUILD_NUMBER") or name.startswith(("PYTEST_", "ROS_", "LINK_"))
    ]
    before = dict(os.environ)
    progress = logging.getLogger("workbench.progress")
    os.environ.update(wanted)
    for name in unwanted:
        del os.environ[name]
    progress.disabled = True
    stdin, sys.stdin = sys.stdin, io.StringIO()  # no command asks anything
    try:
        yield
    finally:
        sys.stdin = stdin
        progress.disabled = False
        os.environ.clear()
        os.environ.update(before)


@contextlib.contextmanager
def _serving(case: Case) -> Iterator[str]:
    """Run `workbench serve` where a case asks for it, and yield its address."""
    if case.served is None:
        yield ""
        return
    words = [sys.executable, "-m", "workbench", "serve", "--port", "0", "--json"]
    process = subprocess.Popen(
        [*words, *shlex.split(case.served)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout
    try:
        said = process.stdout.readline()
        if not said:
            raise OutsideError(f"workbench serve ended: {process.communicate()[1]}")
        yield json.loads(said)["address"]
    finally:
        process.send_signal(signal.SIGTERM)
        try:
            process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()


def _seen(line: str, folder: Path, address: str) -> dict[str, Any]:
    """Run one line, and return its exit code and what it said."""
    program, *words = shlex.split(line.replace("{address}", address))
    code, out, err = PROGRAMS[program](words)
    said = {
        name: _said(_plain(text, folder), bool(address) and program != "hello")
        for name, text in (("out", out), ("err", err))
    }
    if "--help" in words:
        said["options"] = sorted(set(re.findall(r"(?<![\w-])--[a-z][\w-]*", out)))
    return {"line": line, "code": code} | said


def _workbench(words: list[str]) -> tuple[int, str, str]:
    """Run a command in this process, as loading Drake takes longer than most commands."""
    from workbench.commands import cli

    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = cli.main(words)
        except SystemExit as end:  # --help and --version
            code = int(end.code or 0)
    return code, out.getvalue(), err.getvalue()


def _pytest(words: list[str]) -> tuple[int, str, str]:
    """Run pytest with the plugin, also where it is not installed with its entry point."""
    points = importlib.metadata.entry_points(group="pytest11")
    if not any(point.name == "workbench" for point in points):
        words = ["-p", "workbench.pytest_plugin", *words]
    return _python(["-m", "pytest", "--no-header", "-p", "no:cacheprovider", *words])


def _python(words: list[str]) -> tuple[int, str, str]:
    done = subprocess.run(
        [sys.executable, *words], capture_output=True, text=True, timeout=PATIENCE
    )
    return done.returncode, done.stdout, done.stderr


def _hello(words: list[str]) -> tuple[int, str, str]:
    """Return what a server of the link says first, as a client reads it by docs/protocol.md."""
    name, _, port = words[0].rpartition(":")
    with socket.create_connection((name, int(port)), timeout=PATIENCE) as stream:
        incoming = stream.makefile("rb")
        *_, length, _ = HEADER.unpack(incoming.read(HEADER.size))
        return 0, incoming.read(length).decode(), ""


def _public_names(_: list[str]) -> tuple[int, str, str]:
    """Return the names that `workbench` promises, with parameters and public attributes."""
    import workbench

    found: dict[str, Any] = {}
    for name in workbench.__all__:
        each = getattr(workbench, name)
        found[name] = {"parameters": _parameters(each)} if callable(each) else type(each).__name__
        if inspect.isclass(each):
            found[name]["attributes"] = sorted(n for n in dir(each) if not n.startswith("_"))
    return 0, json.dumps(found), ""


def _parameters(each: Any) -> dict[str, str]:
    # parameters of these are Python's; in which versions they have a signature differs
    if inspect.isclass(each) and issubclass(each, enum.Enum | Exception):
        return {}
    signature = inspect.signature(each)
    return {
        name: "" if parameter.default is parameter.empty else _default(parameter.default)
        for name, parameter in signature.parameters.items()
    }


def _default(value: Any) -> str:
    """Return a default value's text, without addresses of memory."""
    return re.sub(r" at 0x[0-9a-f]+", "", repr(value))


def _golden_vectors(_: list[str]) -> tuple[int, str, str]:
    """Return checksums of the golden vectors, which tests/link holds server and clients against."""
    sums = {
        path.name: hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(VECTORS.glob("*.json"))
    }
    return 0, json.dumps(sums), ""


PROGRAMS: dict[str, Callable[[list[str]], tuple[int, str, str]]] = {
    "workbench": _workbench,
    "pytest": _pytest,
    "python": _python,
    "hello": _hello,
    "public-names": _public_names,
    "golden-vectors": _golden_vectors,
}
"""What a line may begin with; each returns exit code, stdout and stderr."""


def _plain(text: str, folder: Path) -> str:
    """Return a text without what may differ between two runs: places, times and versions."""
    version = importlib.metadata.version("drake-drone-workbench")
    for found, said in (
        (str(folder), "HERE"),
        (str(ROOT), "PROJECT"),
        (str(Path.home()), "HOME"),
        (sys.executable, "PYTHON"),
        (f"workbench {version}", "workbench VERSION"),
    ):
        text = text.replace(found, said)
    text = re.sub(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d(:\d\d(\.\d+)?)?(Z|[+-]\d\d:\d\d)?", "TIME", text)
    text = re.sub(r"in \d+\.\d+s( \(.*?\))?", "in TIME", text)  # pytest's
    text = re.sub(r"(?m)^={3,}(.*?)={3,}$", r"===\1===", text)  # as wide as the time is long
    text = re.sub(r" at 0x[0-9a-f]+>", ">", text)  # a function's place in memory
    text = re.sub(r" (time|timestamp)=\"[^\"]*\"", r' \1="TIME"', text)  # JUnit's
    text = re.sub(r"(?m)^workbench: .*: \d+ %\n", "", text)  # of a slow machine
    # Python 3.13 no longer repeats the value's name
    return re.sub(r"(-\w) ([A-Z]\w*), (--[\w-]+) \2", r"\1, \3 \2", text)


def _said(text: str, live: bool) -> Any:
    """Return what a program said: JSON where it is JSON, else its lines."""
    if not text.strip():
        return None
    try:
        data = json.loads(text)
    except ValueError:
        lines = [line.rstrip() for line in text.splitlines() if line.strip()]
        if live:
            lines = sorted({_without_numbers(line) for line in lines})
        return {"text": lines}
    return _kinds(data) if live else _short(data)


def _without_numbers(line: str) -> str:
    return re.sub(r"-?\d+(\.\d+)?(e[+-]?\d+)?", "#", line)


def _kinds(data: Any) -> Any:
    """Return the kind of each value, of what a live flight never repeats."""
    match data:
        case dict():
            return {name: _kinds(value) for name, value in data.items()}
        case [first, *_]:
            return [_kinds(first)]
        case _:
            return "number" if isinstance(data, int | float) else type(data).__name__


def _short(data: Any) -> Any:
    """Return data with long arrays as a checksum and some of their values."""
    if isinstance(data, dict):
        return {str(name): _short(value) for name, value in data.items()}
    if isinstance(data, list | tuple):
        numbers = _numbers(data)
        if numbers is not None and numbers.size > LONG:
            return _array(numbers)
        return [_short(value) for value in data]
    if isinstance(data, float) and not math.isfinite(data):
        return repr(data)
    return data


def _numbers(data: Any) -> np.ndarray | None:
    """Return a list of numbers, or of equal lists of numbers, as an array; None stands for NaN."""
    try:
        array = np.array(data, dtype=object)
    except ValueError:
        return None
    fine = all(
        value is None or (isinstance(value, int | float) and not isinstance(value, bool))
        for value in array.flat
    )
    return array.astype(float) if fine and array.size else None


def _array(numbers: np.ndarray) -> dict[str, Any]:
    chosen = np.unique(np.linspace(0, numbers.size - 1, VIEW).round().astype(int))
    values = [None if math.isnan(v) else v for v in numbers.ravel()[chosen].tolist()]
    data = np.ascontiguousarray(numbers, dtype="<f8")
    return {
        "shape": list(numbers.shape),
        "sha256": hashlib.sha256(data.tobytes()).hexdigest(),
        "view": [repr(v) if v is not None and math.isinf(v) else v for v in values],
    }


def _content(path: Path, folder: Path) -> Any:
    """Return what a file says, by its kind."""
    match path.suffix:
        case ".mcap":
            return _short(_log(path))
        case ".npz":
            with np.load(path) as file:
                return {name: _short(file[name].tolist()) for name in file.files}
    text = _plain(path.read_text(encoding="utf-8"), folder)
    match path.suffix:
        case ".json":
            return _short(json.loads(text))
        case ".yaml":
            return _short(yaml.safe_load(text))
        case ".csv":
            return _short(_table(text))
    return {"text": [line.rstrip() for line in text.splitlines() if line.strip()]}


def _table(text: str) -> dict[str, Any]:
    """Return a table's columns; its rows by name where the first column has names."""
    head, *rows = list(csv.reader(text.splitlines()))
    values = [[_number(cell) for cell in row] for row in rows]
    first = [row[0] for row in values]
    if first and all(isinstance(each, str) for each in first) and len(set(first)) == len(first):
        return {row[0]: dict(zip(head[1:], row[1:], strict=True)) for row in values}
    columns = zip(*values, strict=True) if values else [()] * len(head)
    return dict(zip(head, map(list, columns), strict=True))


def _number(cell: str) -> Any:
    try:
        return float(cell)
    except ValueError:
        return cell


def _log(path: Path) -> dict[str, Any]:
    """Return what readers of MCAP find: topics, schemas, messages, metadata, attachments."""
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        topics: dict[str, Any] = {}
        messages: dict[str, list[tuple[int, dict[str, Any]]]] = defaultdict(list)
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            topics.setdefault(
                channel.topic,
                {
                    "encoding": channel.message_encoding,
                    "metadata": channel.metadata,
                    "schema": schema.name,
                    "schema_encoding": schema.encoding,
                    "schema_text": schema.data.decode().splitlines(),
                },
            )
            fields: dict[str, Any] = {}
            _flatten(decoded, "", fields)
            messages[channel.topic].append((message.log_time, fields))
        for topic, found in messages.items():
            topics[topic]["log_time"] = [time for time, _ in found]
            names = dict.fromkeys(name for _, fields in found for name in fields)
            topics[topic]["fields"] = {
                name: [fields.get(name) for _, fields in found] for name in names
            }
        header = reader.get_header()
        return {
            "profile": header.profile,
            "topics": topics,
            "metadata": {
                each.name: {
                    name: value.replace(str(ROOT), "PROJECT")
                    for name, value in each.metadata.items()
                }
                for each in reader.iter_metadata()
            },
            "attachments": {
                each.name: {"media_type": each.media_type, "size": len(each.data)}
                for each in reader.iter_attachments()
            },
        }


def _flatten(value: Any, name: str, found: dict[str, Any]) -> None:
    """Collect the numbers and texts of a message by their paths."""
    slots = getattr(value, "__slots__", None)
    if slots:
        for each in slots:
            _flatten(getattr(value, each), f"{name}.{each}" if name else each, found)
    elif isinstance(value, bytes | bytearray | memoryview):
        found[name] = hashlib.sha256(bytes(value)).hexdigest()
    elif isinstance(value, list | tuple) and value and hasattr(value[0], "__slots__"):
        for index, each in enumerate(value):
            _flatten(each, f"{name}.{index}", found)
    else:
        found[name] = list(value) if isinstance(value, list | tuple) else value


# ---- comparing ------------------------------------------------------------------------------


def compare(case: Case, was: dict[str, Any], now: dict[str, Any]) -> list[Difference]:
    """Return what differs of two recordings of a case."""
    exact = was["host"] == now["host"]
    ignored = case.ignored if exact else case.ignored + case.elsewhere
    rules = Rules(exact, case.tolerance, case.near_zero, ignored)
    found = list(_differences(was.get("files", {}), now.get("files", {}), "files", rules))
    before, after = ({line["line"]: line for line in each["lines"]} for each in (was, now))
    for name, line in before.items():
        if name not in after:
            found.append(Difference("removed", name, "the line is no longer in the table"))
        else:
            found += _differences(line, after[name], name, rules)
    found += [Difference("added", name, "a new line") for name in after.keys() - before.keys()]
    return found


def _differences(was: Any, now: Any, where: str, rules: Rules) -> Iterator[Difference]:
    if any(fnmatch(where, pattern) for pattern in rules.ignored):
        return
    if was is None and now is not None:
        yield Difference("added", where, _cut(now))
    elif _is_text(was) and _is_text(now):
        yield from _rewordings(was["text"], now["text"], where, rules)
    elif _is_array(was) and _is_array(now):
        yield from _array_differences(was, now, where, rules)
    elif isinstance(was, dict) and isinstance(now, dict):
        for name in was:
            there = f"{where}/{name}"
            if name in now:
                yield from _differences(was[name], now[name], there, rules)
            elif not any(fnmatch(there, pattern) for pattern in rules.ignored):
                yield Difference("removed", there, f"was {_cut(was[name])}")
        for name in now.keys() - was.keys():
            yield Difference("added", f"{where}/{name}", _cut(now[name]))
    elif isinstance(was, list) and isinstance(now, list):
        yield from _list_differences(was, now, where, rules)
    elif not _equal(was, now, 0.0, rules):
        yield Difference("changed", where, f"was {_cut(was)}, is {_cut(now)}")


def _is_text(data: Any) -> bool:
    return isinstance(data, dict) and data.keys() == {"text"}


def _is_array(data: Any) -> bool:
    return isinstance(data, dict) and data.keys() == {"shape", "sha256", "view"}


def _is_number(data: Any) -> bool:
    return isinstance(data, int | float) and not isinstance(data, bool)


def _equal(was: Any, now: Any, scale: float, rules: Rules) -> bool:
    """Return whether two values are equal; numbers of an array as large as `scale`."""
    if was == now and isinstance(was, bool) == isinstance(now, bool):
        return True
    if rules.exact or not (_is_number(was) and _is_number(now)):
        return False
    return abs(was - now) <= rules.tolerance * max(abs(was), abs(now), scale) + rules.near_zero


def _list_differences(was: list, now: list, where: str, rules: Rules) -> Iterator[Difference]:
    names = [_names(was), _names(now)]
    if names[0] and names[1]:
        yield from _differences(names[0], names[1], where, rules)
    elif all(isinstance(each, str) for each in (*was, *now)):
        yield from (Difference("removed", where, _cut(each)) for each in was if each not in now)
        yield from (Difference("added", where, _cut(each)) for each in now if each not in was)
        if [each for each in now if each in was] != [each for each in was if each in now]:
            yield Difference("changed", where, "the same words in another order")
    elif len(was) != len(now):
        yield Difference("changed", where, f"had {len(was)} values, has {len(now)}")
    elif all(_is_number(each) for each in (*was, *now)):
        scale = max(map(abs, was), default=0.0)
        for index, (a, b) in enumerate(zip(was, now, strict=True)):
            if not _equal(a, b, scale, rules):
                yield Difference("changed", f"{where}/{index}", f"was {a!r}, is {b!r}")
    else:
        for index, (a, b) in enumerate(zip(was, now, strict=True)):
            yield from _differences(a, b, f"{where}/{index}", rules)


def _names(rows: list) -> dict[str, Any] | None:
    """Return rows by their names, where each has one of its own: they may then change places."""
    for key in ("name", "topic", "case", "parameter"):
        if rows and all(isinstance(row, dict) and isinstance(row.get(key), str) for row in rows):
            found = {row[key]: row for row in rows}
            if len(found) == len(rows):
                return found
    return None


def _array_differences(was: Any, now: Any, where: str, rules: Rules) -> Iterator[Difference]:
    if was["shape"] != now["shape"]:
        yield Difference("changed", where, f"had {was['shape']} numbers, has {now['shape']}")
        return
    if was["sha256"] == now["sha256"]:
        return
    pairs = list(zip(was["view"], now["view"], strict=True))
    scale = max((abs(a) for a, _ in pairs if _is_number(a)), default=0.0)
    wrong = [(a, b) for a, b in pairs if not _equal(a, b, scale, rules)]
    if wrong:
        a, b = max(wrong, key=lambda p: abs(p[0] - p[1]) if all(map(_is_number, p)) else math.inf)
        yield Difference("changed", where, f"{len(wrong)} of {len(pairs)} shown; was {a}, is {b}")
    elif rules.exact:
        yield Difference("changed", where, f"numbers between those shown, of {was['shape']}")


def _rewordings(was: list[str], now: list[str], where: str, rules: Rules) -> Iterator[Difference]:
    """Compare texts by their words; lines that are only added are an addition."""
    # another Python breaks the lines of --help elsewhere, at hyphens too
    if _words("".join("".join(was).split()), rules) == _words("".join("".join(now).split()), rules):
        return
    before, after = ([_words(line, rules) for line in lines] for lines in (was, now))
    changes = [
        (kind, " | ".join(before[a:b]), " | ".join(after[c:d]))
        for kind, a, b, c, d in difflib.SequenceMatcher(None, before, after, False).get_opcodes()
        if kind != "equal"
    ]
    for kind, old, new in changes:
        if kind == "insert":
            yield Difference("added", where, _cut(new))
        else:
            yield Difference("reworded", where, f"was {_cut(old)}, is {_cut(new)}")


def _words(line: str, rules: Rules) -> str:
    words = " ".join(line.split())
    return words if rules.exact else _without_numbers(words)


def _cut(data: Any) -> str:
    """Return the beginning of some data, for a sentence."""
    text = data if isinstance(data, str) else json.dumps(data, ensure_ascii=False)
    return text if len(text) <= 160 else f"{text[:157]}..."


# ---- the recording's files -------------------------------------------------------------------


def recorded(case: Case) -> dict[str, Any]:
    """Return the recording of a case."""
    path = RECORDED / f"{case.name}.json"
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise OutsideError(
            f"{case.name} is not recorded yet: run `python tools/outside.py {case.name} --write`"
        ) from None


def store(case: Case, found: dict[str, Any]) -> None:
    """Write the recording of a case."""
    RECORDED.mkdir(parents=True, exist_ok=True)
    text = _layout(found, "")
    (RECORDED / f"{case.name}.json").write_text(f"{text}\n", encoding="utf-8")


def _layout(data: Any, indent: str) -> str:
    """Return JSON with what is short on one line, so that a difference of it can be read."""
    flat = json.dumps(data, ensure_ascii=False, separators=(", ", ": "))
    if len(flat) + len(indent) <= 120 or not isinstance(data, dict | list) or _is_array(data):
        return flat
    inner = indent + " "
    if isinstance(data, list):
        parts = [_layout(value, inner) for value in data]
        if all(_is_number(value) for value in data):
            return flat
        return "[\n" + ",\n".join(inner + part for part in parts) + f"\n{indent}]"
    parts = [
        f"{json.dumps(name, ensure_ascii=False)}: {_layout(value, inner)}"
        for name, value in data.items()
    ]
    return "{\n" + ",\n".join(inner + part for part in parts) + f"\n{indent}}}"


def with_words(was: Any, now: Any) -> Any:
    """Return what was recorded, with the texts of now."""
    if _is_text(was) and _is_text(now):
        return now
    if isinstance(was, dict) and isinstance(now, dict):
        return {name: with_words(value, now.get(name)) for name, value in was.items()}
    if isinstance(was, list) and isinstance(now, list) and len(was) == len(now):
        return [with_words(a, b) for a, b in zip(was, now, strict=True)]
    return was


def check(case: Case) -> list[Difference]:
    """Run a case, and return what differs from its recording."""
    return compare(case, recorded(case), record(case))


def sentence(case: Case, differences: list[Difference]) -> str:
    """Return what differs of a case, and how to see it; additions are fine, and left out."""
    wrong = [each for each in differences if each.kind != "added"]
    rest = [f"and {len(wrong) - 12} more"] if len(wrong) > 12 else []
    said = "\n  ".join([*map(str, wrong[:12]), *rest])
    return f"{case.name}: differs from its recording:\n  {said}\n  see: {command(case)}"


def command(case: Case) -> str:
    """Return what shows a case's differences."""
    return f"python tools/outside.py {case.name}"


def _do(case: Case, options: argparse.Namespace) -> bool:
    """Run a case, say what differs, and return whether it is as recorded, or is recorded now."""
    now = record(case)
    if options.write and not (RECORDED / f"{case.name}.json").exists():
        store(case, now)
        print(f"{case.name}: recorded", flush=True)
        return True
    was = recorded(case)
    differences = compare(case, was, now)
    for each in differences:
        print(f"{case.name}: {each}", flush=True)
    if options.write and differences:
        store(case, with_words(was, now) if options.words else now)
        print(f"{case.name}: recorded", flush=True)
        return True
    if not differences:
        print(f"{case.name}: as recorded", flush=True)
    return all(each.kind == "added" for each in differences)


def main() -> int:
    """Compare with the recording, or record."""
    description, _, rest = (__doc__ or "").partition("\n\n")
    parser = argparse.ArgumentParser(
        description=description,
        epilog=rest,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("cases", nargs="*", metavar="CASE", help="names of cases (default: all)")
    parser.add_argument("--list", action="store_true", help="list the cases with their lines")
    parser.add_argument("--write", action="store_true", help="record anew what differs")
    parser.add_argument("--words", action="store_true", help="with --write: only sentences")
    options = parser.parse_args()
    try:
        for name in options.cases:
            if name not in cases():
                raise OutsideError(f"{name} is not a case: known are {', '.join(cases())}")
        chosen = [cases()[name] for name in options.cases or cases()]
        if options.list:
            for case in chosen:
                print(case.name, *case.lines, sep="\n  ")
            return 0
        # each case is run, also after one that differs
        fine = [_do(case, options) for case in chosen]
    except OutsideError as error:
        print(f"outside: {error}", file=sys.stderr)
        return 2
    return 0 if all(fine) else 1


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT))
    sys.exit(main())
