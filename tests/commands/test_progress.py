"""Progress goes to a terminal and nowhere else."""

import io
import sys

from workbench.commands.progress import progress_bar


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
