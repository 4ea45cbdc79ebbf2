"""Progress goes to a terminal and nowhere else."""

import io
import logging
import sys
import time

from workbench.commands import progress
from workbench.commands.progress import above_bars, progress_bar
from workbench.commands.remark_sentences import _is_new
from workbench.common.cache import PROGRESS_LOGGER


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_terminal_sees_a_bar(monkeypatch, capsys):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with progress_bar("flying") as show:
        for share in (0.25, 0.5, 1.0):
            show(share)
        show(1.0, "landed")
    assert "flying" in terminal.getvalue() and "left, landed" in terminal.getvalue()
    assert capsys.readouterr().out == ""


def test_a_file_or_a_pipe_sees_nothing(capsys):
    with progress_bar("flying") as show:
        show(0.5)
    assert capsys.readouterr() == ("", "")


def test_what_takes_long_is_said_in_lines(capsys, monkeypatch):
    monkeypatch.setattr(progress, "FIRST_DELAY_S", 0.3)
    with progress_bar("flying") as show:
        show(0.25, "climbing")
        time.sleep(0.5)
        show(1.0)
    assert capsys.readouterr().err == "workbench: flying: 25 %, climbing\n"


def test_what_takes_long_is_said_though_no_share_is_known(capsys, monkeypatch):
    monkeypatch.setattr(progress, "FIRST_DELAY_S", 0.3)
    with progress_bar("reading"):
        time.sleep(0.5)
    assert capsys.readouterr().err == "workbench: reading: 0 %\n"


def test_a_sentence_stands_above_the_bar(monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with progress_bar("flying") as show:
        show(0.5)
        shown = len(terminal.getvalue())
        with above_bars():
            print("compiling", file=sys.stderr)
    cleared, _, again = terminal.getvalue()[shown:].partition("compiling\n")
    assert cleared.replace("\r", "").strip() == ""
    assert "flying" in again


def test_long_work_in_a_pipe_is_said_ever_less_often():
    """Five minutes took 75 lines."""
    at, pause, lines = 1.0, 1.0, 0
    while at < 300.0:
        lines += 1
        pause = progress.next_delay(pause)
        at += pause
    assert 8 <= lines <= 14
    assert progress.next_delay(1e9) == progress.MAX_REPEAT_DELAY_S


def logged(messages, terminal):
    """Return what is printed of messages about progress at times [s]."""
    said, printed = {}, []
    for time_of, message, repeated in messages:
        record = logging.makeLogRecord({"name": PROGRESS_LOGGER, "msg": message})
        record.created = time_of
        if repeated:
            record.repeated = True
        if _is_new(record, said, terminal):
            printed.append(message)
    return printed


def test_a_minute_of_compiling_is_said_ever_less_often_in_a_pipe():
    messages = [(3.0 * n, f"compiling a law: {n} %, {3 * n} s", True) for n in range(1, 21)]
    messages.append((61.0, "compiled a law in 61 s", False))
    assert logged(messages, terminal=True) == [message for _, message, _ in messages]
    piped = logged(messages, terminal=False)
    assert 5 <= len(piped) <= 8
    assert (piped[0], piped[-1]) == (messages[0][1], messages[-1][1])


def test_other_processes_that_wait_for_the_same_are_told_once():
    waiting = [
        (t, "waiting for another process, which compiles a law", True) for t in (0.0, 0.1, 3.0)
    ]
    assert len(logged(waiting, terminal=True)) == 2
    assert len(logged(waiting[:2], terminal=False)) == 1
