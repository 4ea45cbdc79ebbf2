"""Names from outside in a terminal, in tables and in pictures: they are seen, and do nothing."""

import csv
import io
import sys
from pathlib import Path
from types import SimpleNamespace
from xml.sax.saxutils import quoteattr

import numpy as np
import pytest

from tests.hostile_names import NAMES, acting
from workbench.commands import printing
from workbench.commands.cli import main
from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.flight import Flight
from workbench.common.series import Series
from workbench.logs import flight_reader

SAYABLE = [name for name in NAMES if "\0" not in name and "\ud800" not in name]
"""What can be a word of a command line."""
LONGEST_LINE = 12_000


def assert_plain(said):
    """No character that was printed acts, and no line is endless."""
    for text in (said.out, said.err):
        assert acting(text) == []
        assert max(map(len, text.splitlines()), default=0) < LONGEST_LINE


@pytest.fixture
def hostile_log(monkeypatch):
    """Let every log have one name in all its parts."""
    time = np.linspace(0.0, 2.0, 200)

    def read(name):
        signals = {
            each: Series(each, name, time, np.sin(time), 100.0)
            for each in (f"{name}.{name}", f"plain.{name}")
        }
        source, few = Path("a.ulg"), time[:2]
        flight = Flight(name, source, "ULog", signals, name, {name: name}, (name,), 2.0)
        texts = Series(name, name, few, np.array([name] * len(few), dtype=object))
        topic = SimpleNamespace(name=name, short=name, columns={name: texts}, points={}, time=few)
        monkeypatch.setattr(flight_reader, "read_flight", lambda *_: flight)
        monkeypatch.setattr(flight_reader, "open_log", lambda *_: flight)
        monkeypatch.setattr(flight_reader, "log_topics", lambda *_: ([topic], name))
        return flight

    return read


def test_a_log_is_listed_and_exported(run, hostile_log, tmp_path, case):
    for number, name in enumerate(NAMES):
        with case(name[:60]):
            hostile_log(name)
            for words in (("log", "a.ulg", "--all"), ("plot", "a.ulg", "--list")):
                said = run(*words)
                assert said.code == 0
                assert_plain(said)
                said = run(*words, "--json")
                assert (said.code, acting(said.out)) == (0, [])
            assert_plain(said := run("export", "a.ulg", "--output", tmp_path / str(number)))
            assert said.code == 0
            (table,) = (tmp_path / str(number)).iterdir()
            text = table.read_text(encoding="utf-8")
            assert acting(text, "\n\t\r") == []
            for cell in next(iter(csv.reader(io.StringIO(text))))[1:]:
                assert not cell.startswith(("=", "+", "-", "@"))


def test_json_has_the_name_itself(run, hostile_log):
    name = "<b>\x1b[2J\x9b\u202e"
    hostile_log(name)
    assert run("log", "a.ulg", "--json").json["name"] == name


def test_errors_repeat_a_name_as_text(run, case):
    for name in SAYABLE:
        with case(name[:60]):
            for words in (
                *(("inspect", name), ("fly", name), ("log", name), ("params", name), (name,)),
                ("fly", "hover", "--set", f"{name}=1"),
                ("gui", "--screen", name),
            ):
                said = run(*words)
                assert said.code in (1, 2)
                assert_plain(said)
                assert said.err.count("\n") == 1


def test_a_description_is_shown(run, write, vehicle_text, case):
    for number, name in enumerate(NAMES):
        if any(each < " " or 0xD800 <= ord(each) < 0xE000 or ord(each) > 0xFFFD for each in name):
            continue  # nothing that XML can have
        with case(name[:60]):
            path = write(f"{number}.urdf", vehicle_text(name))
            for words in (("inspect", path), ("frames", path)):
                said = run(*words)
                assert said.code in (0, 2)
                assert_plain(said)


@pytest.fixture
def vehicle_text(description):
    """Return a drone whose robot, links and joints have a name; one names a parent that is not."""
    base = "<link name='base_link'><inertial><mass value='1'/>{}</inertial></link>".format(
        "<inertia ixx='0.01' iyy='0.01' izz='0.02' ixy='0' ixz='0' iyz='0'/>"
    )

    def text(name):
        quoted, missing = quoteattr(name), quoteattr(f"{name} of another")
        return (
            f"<robot name={quoted}>{base}<link name={quoted}/>"
            f"<joint name={quoted} type='fixed'><parent link={missing}/><child link={quoted}/>"
            "</joint></robot>"
        )

    return text


def test_tables_and_sentences(capsys, case):
    for name in NAMES:
        with case(name[:60]), printing.plain_output():
            printing.print_table([(name, "x"), ("y", name)])
            printing.print_message(name)
            print(name[:1000])
            print(unknown_name("thing", name, [name, "other"]))
            printing.print_json_line({name: [name]})
    out, err = capsys.readouterr()
    assert acting(out) == acting(err) == []
    assert err.count("\n") == len(NAMES) + sum(name[:2000].count("\n") for name in NAMES)


def test_the_main_file_shows_what_others_print(monkeypatch, capfd):
    """Whoever prints: a library, a warning, a thread."""

    def fails(args):
        sys.stderr.write("\x1b[31m")
        print("\x9b2J", end="")
        raise WorkbenchError("\x1b]0;title\x07")

    monkeypatch.setattr("workbench.commands.controllers.run", fails)
    assert main(["controllers"]) == 2
    out, err = capfd.readouterr()
    assert (out, err) == (r"\x9b2J", r"\x1b[31mworkbench: \x1b]0;title\x07" + "\n")


def test_what_controls_a_terminal_on_purpose_still_does(capsys):
    with printing.plain_output():
        print("\x1b[1mbold\x1b[0m", file=printing.terminal(), end="")
    assert capsys.readouterr().err == "\x1b[1mbold\x1b[0m"
