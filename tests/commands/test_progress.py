"""Progress goes to a terminal and nowhere else."""

import io
import sys
import time

from workbench.commands import progress
from workbench.commands.progress import above_bars, progress_bar


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_terminal_sees_a_bar(monkeypatch, capsys):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with progress_bar("flying") as show:
        for share in (0.25, 0.5, 1.0):
            show(share)
    assert "flying" in terminal.getvalue()
    assert capsys.readouterr().out == ""


def test_a_file_or_a_pipe_sees_nothing(capsys):
    with progress_bar("flying") as show:
        show(0.5)
    assert capsys.readouterr() == ("", "")


def test_what_takes_long_is_said_in_lines(capsys, monkeypatch):
    monkeypatch.setattr(progress, "SOON", 0.3)
    with progress_bar("flying") as show:
        show(0.25)
        time.sleep(0.5)
        show(1.0)
    assert capsys.readouterr().err == "workbench: flying: 25 %\n"


def test_what_takes_long_is_said_though_no_share_is_known(capsys, monkeypatch):
    monkeypatch.setattr(progress, "SOON", 0.3)
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
