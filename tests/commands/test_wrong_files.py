"""Whatever is named where a file belongs, every command ends with a sentence, and soon."""

import argparse
import os
import re

import pytest

from workbench.commands.cli import OTHER_NAMES, _parser
from workbench.gains.formats import gain_format_names

NEEDED = {
    "new": "drone --mass 1kg --diagonal 450mm --propeller 10x4.5 --max-thrust 850g",
    "inspect": "dh_drone",
    "frequency-response": "roll",
    "compare": "pd pid",
    "record": "new.workbench.yaml",
    "sweep": "kp_roll=10..20:2",
    "fly": "hover",
    "tokens": "new.tokens",
    "log": "flight.mcap",
    "identify": "flight.mcap --model dh_drone",
    "import": "table.csv --mapping table.mapping.yaml",
    "replay": "flight.mcap",
    "plot": "flight.mcap state.p_WB",
    "export": "flight.mcap",
    "estimate": "flight.mcap",
    "predict": "flight.mcap --model dh_drone",
    "what-if": "flight.mcap --model dh_drone",
    "gains show": "flown.yaml",
    "gains diff": "flown.yaml flown.yaml",
    "gains save": "new.yaml",
    "gains history": "flown.yaml",
    "gains restore": "flown.yaml 1",
    "gains import": "vehicle.params",
    "gains export": "vehicle.params --for px4",
    "controllers": "pd",
    "frames --scenario": "--at-time 0",
    "record --mapping": "--from-log table.csv",
    "serve --tls-cert": "--tls-key flown.yaml",
    "serve --tls-key": "--tls-cert flown.yaml",
    "serve --model": "--sensors imu",
    "log --model": "--html page.html",
}
"""What a command needs besides an argument, and what an option of it needs."""
ENDINGS = {
    "controller": [".py"],
    "controllers": [".py"],
    "estimator": [".py"],
    "flown": [".py"],
    "model": [".urdf", ".xacro"],
    "log": [".mcap", ".ulg", ".bin", ".bbl", ".csv"],
    "logs": [".mcap", ".ulg", ".bin", ".bbl", ".csv"],
    "over": [".mcap", ".csv"],
    "new file": [".urdf.xacro"],
}
"""Endings that decide how the file of an argument is read."""
WRITTEN = frozenset(
    ["output", "write", "html", "junit", "table", "save", "sidecar", "csv", "write_messages"]
    + ["new file", "tokens file", "gains save file", "gains export file", "record spec"]
    + ["fly --log", "serve --log"]
)
"""Arguments whose file is written, by their name, or that and the command's."""
UNNAMED = {"sitl"}
"""Commands that wait for a program."""
NO_FORMATS = set() if gain_format_names() else {("gains", "import"), ("gains", "export")}
"""Commands that have nothing to read with, without a package of formats."""
UNREAD = {"gains show --model", "gains show --rotors"}
"""Options without effect where the file of the command is named."""
OPENED = {("gui --model", "folder")}
"""What opens the app, which says in its window what is wrong with a folder."""
OTHERWISE = {
    "identify --sidecar": "has no motor commands",
    "identify --output": "has no motor commands",
    "predict --controller": "has no setpoint of the position",
}
"""What is said of another argument, as it is read first, or does not go with this one."""


def commands(parser, words=()):
    """Yield the words and the parser of each command, by its first name."""
    inner = [each for each in parser._actions if isinstance(each, argparse._SubParsersAction)]
    for each in inner:
        for name, below in each.choices.items():
            if name not in OTHER_NAMES:
                yield from commands(below, (*words, name))
    if words and not inner and words[0] not in UNNAMED and words not in NO_FORMATS:
        yield words, parser


def names_a_file(action):
    """Return whether an argument's metavar says that it is a file."""
    shown = re.split(r"[^A-Za-z]+", str(action.metavar))
    return action.nargs != 0 and bool(
        {*shown} & {"FILE", "PATH", "LOG", "SPEC", "SCENARIO", "MAPPING", "GAINS"}
        or action.metavar in ("A", "B")
        or action.dest in WRITTEN
    )


def title(words, action):
    """Return the command and the name of one of its arguments."""
    return " ".join([*words, *(action.option_strings[:1] or [action.dest])])


def is_written(words, action):
    return bool({action.dest, title(words, action)} & WRITTEN)


def line_with(words, parser, action, name):
    """Return the command with a name for one of its arguments, and with what it needs besides."""
    needed = NEEDED.get(" ".join(words), "").split()
    if action.option_strings:
        more = NEEDED.get(title(words, action), "").split()
        return [*words, *needed, *more, action.option_strings[0], name]
    places = [each for each in parser._actions if not each.option_strings]
    place = places.index(action)
    return [*words, *needed[:place], name, *needed[place + 1 :]]


FILES = [
    pytest.param(words, parser, action, id=title(words, action))
    for words, parser in commands(_parser())
    for action in parser._actions
    if names_a_file(action) and title(words, action) not in UNREAD
]


def test_the_options_that_name_files_are_found():
    """A file whose metavar hides it would be left out of all that follows."""
    known = {each.id for each in FILES}
    assert len(known) > 200
    assert {
        "new --thrust-curve",
        "step --controller",
        "step --estimator",
        "compare --tune",
        "serve --tls-key",
        "gains import file",
        "regress specs",
    } <= known


@pytest.fixture(scope="module")
def folder(log, tmp_path_factory):
    """A folder with what is no plain file under every ending, and with good files besides."""
    made = tmp_path_factory.mktemp("files")
    for ending in ("", *sorted({each for endings in ENDINGS.values() for each in endings})):
        os.mkfifo(made / f"pipe{ending}")
        (made / f"zero{ending}").symlink_to("/dev/zero")
        (made / f"folder{ending}").mkdir()
    (made / "flight.mcap").symlink_to(log)
    for name, text in GOOD.items():
        (made / name).write_text(text, encoding="utf-8")
    return made


@pytest.fixture
def fifos(folder, monkeypatch):
    monkeypatch.chdir(folder)
    return folder


GOOD = {
    "flown.yaml": "gains:\n  kp_roll: 200\n",
    "vehicle.params": "1\t1\tMC_ROLL_P\t6.5\t9\n",
    "table.csv": "t,x\n0,0\n1,0\n",
    "table.mapping.yaml": "time: {column: t, unit: s}\ncolumns:\n"
    "  x: {signal: imu.angular_velocity.x, unit: deg/s}\n",
}


@pytest.mark.parametrize(("words", "parser", "action"), FILES)
def test_what_is_no_file_is_refused(words, parser, action, refused, fifos, case):
    """A pipe that nobody writes to would be waited for, and a device read without end."""
    before = sorted(fifos.iterdir())
    written, said_otherwise = is_written(words, action), OTHERWISE.get(title(words, action))
    names = ["x" * 5000] + ([] if written else ["no\0name", "~nobodyhere/x"])
    for ending in ENDINGS.get(title(words, action), ENDINGS.get(action.dest, [""])):
        names += [f"{name}{ending}" for name in ("pipe", "zero")]
        names += [] if written else [f"folder{ending}", f"gone{ending}"]
    names = [name for name in names if (title(words, action), name.split(".")[0]) not in OPENED]
    for name in names:
        with case(name[:20]):
            said = refused(*line_with(words, parser, action, name))
            assert "Errno" not in said
            assert (said_otherwise or name[:20].partition("\0")[0]) in said
    assert sorted(fifos.iterdir()) == before


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (["inspect", ""], "the text after 'inspect' is empty"),
        (["step", "--gains", ""], "the text after '--gains' is empty"),
        (["step", "--gains="], "'--gains=' has no value"),
        (["replay", " "], "the text after 'replay' is empty"),
    ],
)
def test_an_unset_variable_of_the_shell_is_noticed(command, said, refused):
    assert said in refused(*command)


def test_a_log_larger_than_memory_is_refused(refused, tmp_path):
    path = tmp_path / "huge.mcap"
    with path.open("wb") as file:
        file.write(b"\x89MCAP0\r\n")
        file.truncate(1 << 40)  # a sparse file: it takes no room
    for command in ("replay", "plot", "export", "estimate"):
        assert "is larger than" in refused(command, path)
