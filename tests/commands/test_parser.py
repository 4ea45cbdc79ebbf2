"""Words that no command takes, and numbers that look like options."""

import argparse

import pytest

from workbench.commands.cli import _parser
from workbench.common.errors import WorkbenchError


def commands(parser, words=()):
    """Yield the words and the parser of each command."""
    inner = [each for each in parser._actions if isinstance(each, argparse._SubParsersAction)]
    for each in inner:
        for name, below in each.choices.items():
            yield from commands(below, (*words, name))
    if words and not inner:
        yield words, parser


def test_what_is_unknown_is_named_with_what_is_near(refused, case):
    for words, said in (
        (
            "step --axs x",
            "unknown option '--axs': did you mean '--axis'? (see `workbench step --help`)",
        ),
        (
            "step --axs=x",
            "unknown option '--axs': did you mean '--axis'? (see `workbench step --help`)",
        ),
        ("gains show --modle x", "did you mean '--model'? (see `workbench gains show --help`)"),
        ("step --qqq", "unknown option '--qqq' (see `workbench step --help`)"),
        (
            "--vrsion",
            "unknown option '--vrsion': did you mean '--version'? (see `workbench --help`)",
        ),
        ("stpe", "unknown command 'stpe': did you mean 'step'? known are check, compare,"),
        ("gains shw", "unknown command 'shw': did you mean 'show'? known are diff, export,"),
        (
            "step --axis w",
            "unknown --axis 'w': known are pitch, pitch_rate, roll, roll_rate, x, y, yaw, z",
        ),
        ("fly hover twice", "'twice' is one argument too many (see `workbench fly --help`)"),
        (f"step --{'x' * 5000}", f"unknown option '--{'x' * 58}' (see `workbench step --help`)"),
    ):
        with case(words):
            assert said in refused(*words.split())


NUMERIC = [
    pytest.param(words, parser, action, id=f"{'-'.join(words)} {action.option_strings[0]}")
    for words, parser in commands(_parser())
    for action in parser._actions
    if action.option_strings and action.nargs != 0
]


@pytest.mark.parametrize("value", ["-1e-3", "-1E+3", "-.5e1", "-inf", "-20cm", "-1,2"])
def test_what_begins_as_a_negative_number_is_a_value(value):
    """Whether an option takes it is for the option to say: for a length, for example."""
    for each in NUMERIC:
        words, parser, action = each.values
        many = action.nargs if isinstance(action.nargs, int) else 1
        line = [action.option_strings[0], *[value] * many]
        try:
            parser.parse_args(line)
        except WorkbenchError as error:
            assert "expected" not in str(error), (words, line)


def test_negative_numbers_are_numbers():
    _, step = next(each for each in commands(_parser("step")))
    assert step.parse_args(["--amplitude", "-1e-3"]).amplitude == -0.001
    _, plot = next(each for each in commands(_parser("plot")))
    assert plot.parse_args(["log", "--span", "-1e-3", "2"]).span == [-0.001, 2.0]
