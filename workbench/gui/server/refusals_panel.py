"""The panel of the commands that the server has refused."""

from collections.abc import Mapping

from PyQt6.QtCore import QTime
from PyQt6.QtWidgets import QPlainTextEdit, QWidget

from workbench.common.plain_text import MAX_SHOWN_TEXT_CHARS, plain_name
from workbench.gui.labels import WrappedLabel
from workbench.gui.layout import NO_MARGINS, buddy, hbox, named, vbox
from workbench.gui.style import with_class
from workbench.link.backplane import ServerStatus

MAX_REFUSAL_LINES = 300
"""Number of kept lines."""
REFUSAL_CODE_TEXTS = {"magic": "other protocol", "tls": "TLS", "json": "JSON"}
"""How codes are shown that are no words of their own."""


def refusal_counts_text(counts: Mapping[str, int]) -> str:
    """Return the number of refusals, as a sentence."""
    if not counts:
        return "Nothing was refused."
    often = sorted(counts.items(), key=lambda pair: -pair[1])
    texts = [(REFUSAL_CODE_TEXTS.get(code, code.replace("_", " ")), n) for code, n in often]
    said = ", ".join(f"{text} {count}×" for text, count in texts)
    return f"Refused since the server's start: {said}."


class RefusalsPanel(QWidget):
    """A line with counts, and a list of limited length.

    Attributes:
        counts: the line.
        list: the last refusals, newest below.
    """

    def __init__(self) -> None:
        super().__init__()
        self._total: int | None = None  # refusals of the present server that are in the list
        self.counts = with_class(WrappedLabel(refusal_counts_text({}), lines=2), "muted")
        self.list = named(with_class(QPlainTextEdit(), "lines"), "Refusals, newest last")
        self.list.setReadOnly(True)
        self.list.setMaximumBlockCount(MAX_REFUSAL_LINES)
        self.list.setLineWrapMode(QPlainTextEdit.LineWrapMode.WidgetWidth)
        self.list.setTabChangesFocus(True)
        heading = buddy("Refusals", self.list, kind="heading")
        top = hbox(heading, (self.counts, 1), spacing=16)
        vbox(top, (self.list, 1), of=self, margins=NO_MARGINS, spacing=6)

    def show_server(self, server: ServerStatus | None) -> None:
        """Show a server's report; lines of earlier servers stay in the list."""
        if server is None:
            self._total = None
            return
        total = sum(server.refusals.values())
        fresh, self._total = total - (self._total or 0), total
        clock = QTime.currentTime().toString("HH:mm:ss")
        if fresh > len(server.log):
            more = f"… {fresh - len(server.log)} more, too many to list"
            self.list.appendPlainText(f"{clock}  {more}")
        for said in server.log[-fresh:] if fresh > 0 else ():
            self.list.appendPlainText(f"{clock}  {plain_name(said, MAX_SHOWN_TEXT_CHARS)}")
        self.counts.setText(refusal_counts_text(server.refusals))
