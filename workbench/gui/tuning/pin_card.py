"""The card that pins the present flight as a regression."""

import re
import shlex
from pathlib import Path

from PyQt6.QtWidgets import (
    QCheckBox,
    QLineEdit,
)

from workbench.analysis.questions import Pin, Question
from workbench.gui.file_dialogs import choose_folder, clipboard
from workbench.gui.labels import set_tip
from workbench.gui.layout import buddy, button, fill, grid, hbox, named, tool_button
from workbench.gui.style import set_class
from workbench.gui.tuning.card import SPACING, Card, Sentence, wrapped
from workbench.gui.tuning.trial import Trial
from workbench.gui.units import unit_for
from workbench.gui.workspace import Workspace
from workbench.scenario.loads import find_excited

Pinned = tuple[Path, Path, str]
"""Paths of a spec and its baseline, and a sentence about their content."""
SUFFIX = ".spec.yaml"
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 ._-]*")
FOLDER = "tuning/pin_folder"
"""Settings key of the last folder."""


def spec_path(folder: str, name: str) -> Path:
    """Return the path of a spec with a name."""
    stem = name.strip().removesuffix(SUFFIX).replace(" ", "-")
    return Path(folder or ".").expanduser() / f"{stem}{SUFFIX}"


def name_fault(name: str) -> str:
    """Return what is wrong with a name, as a sentence; "" if it is valid."""
    if not name.strip():
        return "Give it a name."
    if not _NAME.fullmatch(name.strip()):
        return "Use letters, digits, spaces, dots, dashes and underscores."
    return ""


def regress_command(path: Path) -> str:
    """Return the shell command that flies a pinned regression."""
    return f"workbench regress {shlex.quote(str(path))}"


class PinCard(Card):
    """Writes a spec and its baseline that `workbench regress` flies.

    Args:
        workspace: analysis, preferences and colours.
        trial: the gains that are being tried; the flown ones are pinned.
    """

    def __init__(self, workspace: Workspace, trial: Trial) -> None:
        super().__init__("Pin as regression")
        self._analysis, self._trial = workspace.analysis, trial
        self._preferences = workspace.preferences
        self._asked: Pin | None = None
        self._sure: Path | None = None
        self.name = QLineEdit("my-step")
        kept = str(workspace.preferences.store.value(FOLDER, "") or Path.cwd())
        self.folder = QLineEdit(kept)
        self.browse = named(tool_button("…", self._browse), "Choose a folder")
        self.margins = QCheckBox("Pin the &margins of all loops, too")
        self.margins.setChecked(True)
        self.what = wrapped()
        self.button = button("Write", self.write)
        self.fault = wrapped("bad")
        self.paths = Sentence()
        self.command = QLineEdit()
        self.command.setReadOnly(True)
        self.copy = button("&Copy", self._copy, help="Copy the command")
        self._lay_out()
        self.name.textChanged.connect(self._show_state)
        self.folder.textChanged.connect(self._show_state)
        trial.changed.connect(self._show_state)
        self._analysis.answered.connect(self._hear)
        self._analysis.refused.connect(self._hear_refusal)
        self._show_state()
        self._show_result(None)

    @property
    def path(self) -> Path:
        """Path of the spec."""
        return spec_path(self.folder.text(), self.name.text()).absolute()

    def begin(self) -> None:
        """Clear the question about another vehicle."""
        self._asked = None
        self._show_state()

    def write(self) -> None:
        """Write the regression; ask first if one exists already."""
        step, path = self._trial.excited, self.path
        if step is None or not self.button.isEnabled():
            return
        sure = self._sure == path
        if path.exists() and not sure:
            self._sure = path
            self.said.say(f"{path.name} exists: press again to overwrite it.", "warning")
            self._label_button()
            return
        self._sure = None
        self._preferences.store.setValue(FOLDER, self.folder.text())
        self._asked = Pin(path, self._trial.flown, step, self.margins.isChecked(), sure)
        self.said.say("Flying the baseline …")
        self._show_result(None)
        self._analysis.ask(self._asked)
        self._show_state()

    def _hear(self, question: Question, pinned: Pinned) -> None:
        if not isinstance(question, Pin):
            return
        self._asked = None
        self.said.say("Written.", "good")
        self._show_result(pinned)
        self._show_state()

    def _hear_refusal(self, question: Question, said: str) -> None:
        if isinstance(question, Pin) and self._asked is not None:
            self._asked = None
            self.said.say(said, "bad")
            self._show_state()

    def _show_result(self, pinned: Pinned | None) -> None:
        for widget in (self.paths, self.command, self.copy, self._command_label):
            widget.setVisible(pinned is not None)
        if pinned is not None:
            spec, baseline, said = pinned
            self.paths.say(f"{spec.name} and {baseline.name} in {spec.parent}")
            set_tip(self.paths, f"{said}\n{spec}\n{baseline}")
            self.command.setText(regress_command(spec))
            self.command.setCursorPosition(0)

    def _show_state(self) -> None:
        if self._sure is not None and self._sure != self.path:
            self._sure = None
            self.said.say("")
        fault, step = name_fault(self.name.text()), self._trial.excited
        set_class(self.name, "bad" if fault else "")
        if step is None:
            fault = fault or "A chirp cannot be pinned: choose a step."
        self.fault.setText(f"✕ {fault}" if fault else "")
        self.fault.setVisible(bool(fault))
        if step is not None:
            row = find_excited(step.axis)
            unit = unit_for(row.unit, self._preferences)
            what = row.label if step.is_load else f"along {step.axis}"
            self.what.setText(
                f"Pins the gains that fly with a step of {unit.text(step.amplitude)} {what} for "
                f"{step.duration:g} s, flown from hover with heading 0: its numbers as limits, "
                "its curve as a band."
            )
        busy = self._asked is not None
        self.button.setEnabled(not fault and bool(self._trial.flown) and not busy)
        self._label_button()

    def _label_button(self) -> None:
        self.button.setText("Over&write it" if self._sure is not None else "&Write")
        set_class(self.button, "danger" if self._sure is not None else "primary")

    def _browse(self) -> None:
        title, folder = "Folder for the regression", self.folder
        choose_folder(self, title, folder.setText, folder.text())

    def _copy(self) -> None:
        clipboard().setText(self.command.text())

    def _lay_out(self) -> None:
        fields = grid(
            (buddy("&Name", self.name), self.name),
            (buddy("&Folder", self.folder), hbox((self.folder, 1), self.browse, spacing=SPACING)),
            spacing=(SPACING, SPACING),
        )
        self._command_label = buddy("Command that &runs it", self.command)
        fill(
            self.body,
            self.what,
            fields,
            self.fault,
            self.margins,
            hbox(1, self.button),
            self.paths,
            self._command_label,
            hbox((self.command, 1), self.copy),
            1,
        )
