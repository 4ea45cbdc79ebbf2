"""The held process of `mutated_files.py`: it mutates files, reads them, and notes the outcomes.

What a command hands to a held process of its own (logs, xacro, meshes) is computed here.
"""

import contextlib
import ctypes
import io
import json
import os
import random
import resource
import runpy
import shutil
import tempfile
import threading
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

from mutated_bytes import (
    Mutate,
    mutated_bytes,
    mutated_gzip,
    mutated_mcap,
    mutated_text,
    mutated_xml,
)

from workbench.common.errors import WorkbenchError
from workbench.ipc import limited
from workbench.ipc.limited import LimitedError, one_line_message, serve_one_request

ROOT = Path(__file__).resolve().parent.parent
SLOWEST = 60.0
"""Limit of processor time for a file [s]; what a held process reads has limits of its own."""
LONGEST = 5000
"""Largest number of characters of a sentence."""
NOTES = "notes"
"""File with a line when a file is begun, and another one with what became of it."""
Command = str | Callable[[Path], object]
"""A command line with {} for the file and {folder} for its folder, or a function."""


class TooLongError(BaseException):
    """The processor time for a file, or for a part of it, is over."""


class Kind(NamedTuple):
    """A kind of file.

    Attributes:
        files: its originals.
        mutate: makes a copy.
        commands: the command lines that read it, {} for the file; or functions.
        beside: whether the files beside it are copied with it.
    """

    files: Sequence[Path]
    mutate: Mutate
    commands: Sequence[Command]
    beside: bool = False


class Watch:
    """Ends what takes too much processor time, by an exception in the main thread."""

    def __init__(self) -> None:
        self._main = ctypes.c_ulong(threading.get_ident())
        self._until: list[float] = []
        threading.Thread(target=self._look, daemon=True).start()

    @contextlib.contextmanager
    def limit(self, seconds: float) -> Iterator[None]:
        """Raise TooLongError in the block if it takes longer."""
        self._until.append(time.process_time() + seconds)
        try:
            yield
        finally:
            self._until.pop()

    def _look(self) -> None:
        while True:
            time.sleep(0.1)
            if self._until and time.process_time() > min(self._until):
                self._until[:] = [time.process_time() + 5.0] * len(self._until)
                error = ctypes.py_object(TooLongError)
                ctypes.pythonapi.PyThreadState_SetAsyncExc(self._main, error)


@cache
def _served(module: str) -> Callable[[Any], Any]:
    """Return the function that a module of a held process serves."""
    found: list[Callable[[Any], Any]] = []
    before = limited.serve_one_request
    limited.serve_one_request = found.append  # type: ignore[assignment]
    try:
        runpy.run_module(module, run_name="__main__")
    finally:
        limited.serve_one_request = before
    return found[0]


def _answer_here(
    watch: Watch, clauses: Counter[str], module: str, request: object, **limits: Any
) -> Any:
    """Answer as a held process would."""
    function = _served(module)
    try:
        with watch.limit(limits["seconds"]):
            return json.loads(json.dumps(function(json.loads(json.dumps(request)))))
    except WorkbenchError:
        raise
    except TooLongError as error:
        raise LimitedError(f"it took more than {limits['seconds']:g} s") from error
    except (MemoryError, RecursionError) as error:
        raise LimitedError(f"it took too much: {type(error).__name__}") from error
    except Exception as error:
        where = traceback.extract_tb(error.__traceback__)[-1]
        name = f"{type(error).__name__} in {Path(where.filename).name}:{where.lineno}"
        clauses[f"{module.rpartition('.')[2]}: {name}"] += 1
        raise LimitedError(one_line_message(error)) from error


def read_all(request: dict[str, Any]) -> None:
    """Mutate and read files, and note what becomes of each."""
    folder, originals = Path(request["folder"]), Path(request["originals"])
    os.environ["XDG_CACHE_HOME"] = str(folder / "cache")
    tempfile.tempdir = str(folder)
    os.replace = _moved  # type: ignore[assignment]
    watch, clauses = Watch(), Counter[str]()
    answer = partial(_answer_here, watch, clauses)
    from workbench.logs import log_process
    from workbench.plant import drawable
    from workbench.plant.formats import xacro

    for module in (log_process, drawable, xacro):
        for name in ("run_limited", "run_trusted"):
            if hasattr(module, name):
                setattr(module, name, answer)
    kinds = _kinds(originals)
    names = [name for name in kinds if not request["kinds"] or name in request["kinds"]]
    with (folder / NOTES).open("a", encoding="utf-8") as notes:
        for number in range(*request["numbers"]):
            chance = random.Random(f"{request['seed']}-{number}")
            name = chance.choice(names)
            path, command = _mutate(kinds[name], folder / "file", chance)
            note = {"number": number, "kind": name}
            print(json.dumps(note), file=notes, flush=True)
            begun = time.process_time()
            outcome = outcome_of(command, path, watch)
            note |= {
                "outcome": outcome,
                "seconds": time.process_time() - begun,
                "megabytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000.0,
                "clauses": clauses,
            }
            print(json.dumps(note), file=notes, flush=True)
            clauses.clear()


def _moved(source: Path, target: Path) -> None:
    """Move a file as the kernel lets this process: not from one folder to another."""
    Path(target).write_bytes(Path(source).read_bytes())
    Path(source).unlink()


def _mutate(kind: Kind, folder: Path, chance: random.Random) -> tuple[Path, Command]:
    """Write a mutated copy of a file, and return it with the command that is to read it."""
    shutil.rmtree(folder, ignore_errors=True)
    original = chance.choice(kind.files)
    folder.mkdir()
    for file in original.parent.rglob("*") if kind.beside else ():
        copy = folder / file.relative_to(original.parent)
        copy.mkdir() if file.is_dir() else copy.write_bytes(file.read_bytes())
    path = folder / original.name
    path.write_bytes(kind.mutate(original.read_bytes(), chance))
    return path, chance.choice(kind.commands)


def outcome_of(command: Command, path: Path, watch: Watch) -> int | str:
    """Read a file; return the exit code, or what is wrong."""
    from workbench.commands.cli import main as workbench

    said, printed = io.StringIO(), io.StringIO()
    try:
        with (
            watch.limit(SLOWEST),
            contextlib.redirect_stderr(said),
            contextlib.redirect_stdout(printed),
        ):
            if isinstance(command, str):
                code = workbench(
                    [word.format(path, folder=path.parent) for word in command.split()]
                )
            else:
                code = _called(command, path)
    except TooLongError:
        return f"{command}: took more than {SLOWEST:g} s"
    except BaseException as error:  # whatever it is, it is a fault
        tail = traceback.format_exception(error)[-3:]
        return f"{command}: {' '.join(' '.join(tail).split())[-600:]}"
    text = said.getvalue()
    if code not in (0, 2):
        return f"{command}: exit code {code}: {text[-300:]}"
    sentence = text.rstrip("\n").rpartition("\n")[2]
    if code == 2 and (not sentence.startswith("workbench: ") or len(sentence) > LONGEST):
        return f"{command}: no sentence: {text[-300:]}"
    if "Traceback" in text:
        return f"{command}: {text[-600:]}"
    return code


def _called(function: Callable[[Path], object], path: Path) -> int:
    """Call a function as a command would."""
    from workbench.commands.printing import print_message

    try:
        function(path)
    except WorkbenchError as error:
        print_message(" ".join(str(error).split()))
        return 2
    return 0


def _kinds(originals: Path) -> dict[str, Kind]:
    """Return all kinds of files, by name."""
    found = {}
    for folder in sorted(originals.iterdir()):
        part, mutate, commands, beside = KINDS[folder.name]
        files = [each for each in sorted(folder.rglob("*")) if each.is_file() and part in each.name]
        found[folder.name] = Kind(files, mutate, commands, beside)
    return found


def _tables(path: Path) -> None:
    """Export a log."""
    from workbench.logs.flight_reader import log_topics
    from workbench.logs.table_file import topic_tables, write_columns

    topics, _ = log_topics(path)
    for topic in topics:
        for name, columns in topic_tables(topic).items():
            write_columns(columns, path.with_name(f"{name}.csv"))


def _as_own(path: Path) -> None:
    """Import a log."""
    from workbench.extras.flightdata.importing import write_flight
    from workbench.logs.flight_reader import read_flight

    write_flight(read_flight(path), path.with_name("imported.mcap"))
    _tables(path.with_name("imported.mcap"))


def _replayed(path: Path) -> None:
    """Read what a replay reads."""
    from workbench.logs.record import read_log
    from workbench.logs.replay import replay_scenario

    replay_scenario(read_log(path), "", path.parent)


def _drawn(path: Path) -> None:
    """Draw the overview of a log."""
    from workbench.logs.flight_reader import open_log
    from workbench.logs.plots import plot_overview

    plot_overview(open_log(path))


def _scenario(path: Path) -> None:
    """Read a scenario with what it names."""
    from workbench.scenario.configured import configured_vehicle, read_configured_world
    from workbench.scenario.scenario_file import load_scenario

    scenario = load_scenario(path)
    configured_vehicle(scenario.vehicle)
    read_configured_world(scenario)


def _built(path: Path) -> None:
    """Build the flight of a scenario."""
    from workbench.scenario.scenario_file import load_scenario
    from workbench.session.session import Session

    Session(load_scenario(path))


def _spec(path: Path) -> None:
    from workbench.design.regress.loading import load_spec

    load_spec(path)


def _wishes(path: Path) -> None:
    from workbench.design.tune.wish import load_wishes

    load_wishes(path)


def _rotor_commands(path: Path) -> None:
    from workbench.systems.rotor_playback import load_rotor_commands, make_rotor_playback

    make_rotor_playback(load_rotor_commands(path, _plain_vehicle()))


def _thrust_curve(path: Path) -> None:
    from workbench.plant.thrust_curve import read_thrust_curve

    read_thrust_curve(path)


@cache
def _plain_vehicle() -> Any:
    from workbench.common.resources import find_model
    from workbench.plant.loading import load_vehicle

    return load_vehicle(find_model("dh_drone"))


def _world(path: Path) -> None:
    from workbench.plant.worlds.reading import read_world

    read_world(path, {"worlds": ROOT / "models/worlds"})


def _parsed(path: Path) -> None:
    """Let Drake parse a description, as every flight does."""
    from pydrake.systems.framework import DiagramBuilder

    from workbench.plant.description import read_description
    from workbench.plant.multibody import add_shapes

    add_shapes(DiagramBuilder(), read_description(path))


_LOG = ("log {}", "log {} --json --all", "plot {} --list", _tables, _as_own)
_DESCRIPTION = ("inspect {}", "inspect {} --json", "params --model {}", "frames --model {}")
_MESH = ("inspect {folder}/model.urdf",)
_GAINS = ("gains show {}", "params --gains {}", "gains history {}", "gains diff {} default")
_FIRMWARE = ("gains import {} --model dh_drone", "gains import {} --model dh_drone --json")
KINDS: dict[str, tuple[str, Mutate, Sequence[Command], bool]] = {
    "log-mcap": ("", mutated_mcap, (*_LOG, _replayed, _drawn), False),
    "log-mcap-imported": ("", mutated_mcap, (*_LOG, _drawn), False),
    "log-ulog": ("", mutated_bytes, _LOG, False),
    "log-dataflash": ("", mutated_bytes, _LOG, False),
    "log-blackbox": ("", mutated_bytes, _LOG, False),
    "log-blackbox-head": ("", mutated_text, _LOG, False),
    "log-usd": ("", mutated_bytes, _LOG, False),
    "log-packed": ("", mutated_gzip(mutated_bytes), _LOG, False),
    "log-table-packed": (".gz", mutated_gzip(mutated_text), _LOG, True),
    "log-table": (".csv", mutated_text, _LOG, True),
    "log-mapping": (".mapping.yaml", mutated_text, ("log {folder}/a.csv --mapping {}",), True),
    "log-metadata": ("_metadata.yaml", mutated_text, ("log {folder}/a.csv",), True),
    "xacro": (".urdf.xacro", mutated_xml, _DESCRIPTION, True),
    "xacro-parts": ("parts.xacro", mutated_xml, ("inspect {folder}/palm_quad.urdf.xacro",), True),
    "urdf": (".urdf", mutated_xml, (*_DESCRIPTION, _parsed), True),
    "sdf": (".sdf", mutated_xml, (*_DESCRIPTION, _parsed), True),
    "mjcf": (".xml", mutated_xml, (*_DESCRIPTION, _parsed), True),
    "mesh-text": ("mesh.", mutated_text, _MESH, True),
    "mesh-xml": ("mesh.", mutated_xml, _MESH, True),
    "mesh-binary": ("mesh.", mutated_bytes, _MESH, True),
    "rotors": (".rotors.yaml", mutated_text, ("inspect {folder}/plate.urdf --rotors {}",), True),
    "world": (".yaml", mutated_text, ("frames --world {}", _world), True),
    "world-sdf": ("", mutated_xml, (_world,), False),
    "scenario": (".scenario.yaml", mutated_text, (_scenario, _scenario, _built), True),
    "gains": ("", mutated_text, _GAINS, False),
    "spec": (".workbench.yaml", mutated_text, (_spec,), True),
    "wishes": ("", mutated_text, (_wishes,), False),
    "rotor-commands": ("", mutated_text, (_rotor_commands,), False),
    "thrust-curve": ("", mutated_text, (_thrust_curve,), False),
    "px4-parameters": ("", mutated_text, _FIRMWARE, False),
    "ardupilot-parameters": ("", mutated_text, _FIRMWARE, False),
    "betaflight-settings": ("", mutated_text, _FIRMWARE, False),
    "crazyflie-parameters": ("", mutated_text, _FIRMWARE, False),
}
"""For each kind: part of the names of its files, what mutates them, what reads them, and whether
the files beside it are needed."""


if __name__ == "__main__":
    serve_one_request(read_all)
