"""What users, clients and files see is as tools/outside.py has recorded it."""

import importlib
import json
import re
from pathlib import Path

import pytest

TOOLS = Path(__file__).resolve().parent.parent / "tools"


@pytest.fixture
def outside(monkeypatch):
    monkeypatch.syspath_prepend(TOOLS)
    return importlib.import_module("outside")


@pytest.mark.slow
def test_what_is_seen_from_outside_is_as_recorded(outside):
    found = [(case, outside.check(case)) for case in outside.cases().values()]
    wrong = [
        outside.sentence(case, differences)
        for case, differences in found
        if any(each.kind != "added" for each in differences)
    ]
    assert not wrong, "\n".join(["", *wrong])


def test_each_command_is_recorded(outside, capsys):
    """By its first name, or by the one that it had first."""
    from workbench.commands.cli import OTHER_NAMES, main

    older = {name: old for old, name in OTHER_NAMES.items()}
    with pytest.raises(SystemExit):
        main(["--help"])
    listed = re.findall(r"^    ([a-z-]+) ", capsys.readouterr().out, re.MULTILINE)
    assert len(listed) > 20
    lines = [line for case in outside.cases().values() for line in case.lines]
    for command in listed:
        names = tuple(f"workbench {name} " for name in (command, older.get(command, command)))
        called = [line for line in lines if line.startswith(names)]
        assert {"--help"} < {word for line in called for word in line.split()}, command
    recorded = sum(path.stat().st_size for path in outside.RECORDED.iterdir())
    assert recorded < 1_500_000
    for case in outside.cases().values():
        done = json.dumps(outside.recorded(case)["lines"])
        assert "Traceback" not in done, case.name


def test_differences_are_named_by_their_kind(outside, case):
    text = {"text": ["one gain", "of two"]}
    numbers = [0.1 * k for k in range(100)]
    other = [*numbers[:-1], 9.91]
    nearly = [each * (1 + 1e-12) for each in numbers]
    rows = [{"name": "a", "value": 1.0}, {"name": "b", "value": 2.0}]
    table = [
        # was, now, kind on the recording's machine, kind on another
        ({"a": 1}, {"a": 1}, None, None),
        ({"a": 1}, {"a": 1, "b": 2}, "added", "added"),
        ({"a": 1, "b": 2}, {"a": 1}, "removed", "removed"),
        ({"a": 1.0}, {"a": 1.0 + 1e-12}, "changed", None),
        ({"a": 1.0}, {"a": 1.0 + 1e-6}, "changed", "changed"),
        ({"a": True}, {"a": 1}, "changed", "changed"),
        ({"a": [1.0, 2.0]}, {"a": [1.0]}, "changed", "changed"),
        (rows, [rows[0], {"name": "c", "value": 3.0}, rows[1]], "added", "added"),
        (rows, rows[1:], "removed", "removed"),
        (["--json", "--set"], ["--json", "--new", "--set"], "added", "added"),
        (["--json", "--set"], ["--set"], "removed", "removed"),
        (numbers, numbers, None, None),
        (numbers, nearly, "changed", None),
        (numbers, other, "changed", "changed"),
        (numbers, numbers[1:], "changed", "changed"),
        (text, {"text": ["one gain of", "two"]}, None, None),
        (text, {"text": ["one gain", "a new line", "of two"]}, "added", "added"),
        (text, {"text": ["one gain", "of three"]}, "reworded", "reworded"),
        ({"text": ["in 1.25 s"]}, {"text": ["in 1.26 s"]}, "reworded", None),
    ]
    here, there = {"drake": "1"}, {"drake": "2"}
    for was, now, on_same, on_other in table:
        before, after = (
            {
                "host": here,
                "lines": [{"line": "x", "code": 0, "out": outside._short(each)}],
            }
            for each in (was, now)
        )
        one = outside.Case("one")
        with case(was, now):
            found = outside.compare(one, before, after)
            assert [each.kind for each in found] == [on_same] * (on_same is not None)
            found = outside.compare(one, before, after | {"host": there})
            assert [each.kind for each in found] == [on_other] * (on_other is not None)


def test_new_words_are_taken_over_without_new_numbers(outside):
    was = {"out": {"a": 1.0}, "err": {"text": ["wrote a file"]}, "options": ["--json"]}
    now = {"out": {"a": 2.0}, "err": {"text": ["The file is written."]}, "options": []}
    assert outside.with_words(was, now) == was | {"err": now["err"]}


def test_what_may_differ_is_left_out(outside, tmp_path):
    text = f"workbench: wrote {tmp_path}/a.csv at 2026-01-02T03:04:05Z\nworkbench: sweep: 12 %\n"
    assert outside._plain(text, tmp_path) == "workbench: wrote HERE/a.csv at TIME\n"
