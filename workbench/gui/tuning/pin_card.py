"""The card that pins the present flight as a regression."""

import re
import shlex
from pathlib import Path

from PyQt6.QtWidgets import (
    QCheckBox,
    QLineEdit,
)

from workbench.analysis.queries import RegressionCase
from workbench.common.resources import SPEC_SUFFIX
from workbench.design.regress.spec_names import SPEC_SUFFIXES
from workbench.gui.analysis import QueryStream
from workbench.gui.file_dialogs import choose_folder, clipboard
from workbench.gui.labels import set_tip
from workbench.gui.layout import buddy, button, fill, grid, hbox, named, tool_button
from workbench.gui.style import set_class
from workbench.gui.tuning.card import CARD_SPACING_PX, ToneLabel, TuningCard, wrapped_label
from workbench.gui.tuning.trial import TuningTrial
from workbench.gui.units import unit_for
from workbench.gui.workspace import Workspace
from workbench.scenario.loads import find_excited

PinnedPaths = tuple[Path, Path, str]
"""Paths of a spec and its baseline, and a sentence about their content."""
_SPEC_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 ._-]*")
PIN_FOLDER_KEY = "tuning/pin_folder"
"""Settings key of the last folder."""


def spec_path(folder: str, name: str) -> Path:
    """Return the path of a spec with a name."""
    stem = name.strip().replace(" ", "-")
    for suffix in SPEC_SUFFIXES:
        stem = stem.removesuffix(suffix)
    return Path(folder or ".").expanduser() / f"{stem}{SPEC_SUFFIX}"


def name_fault(name: str) -> str:
    """Return what is wrong with a name, as a sentence; "" if it is valid."""
    if not name.strip():
        return "Give it a name."
    if not _SPEC_NAME.fullmatch(name.strip()):
        return "Use letters, digits, spaces, dots, dashes and underscores."
    return ""


def regress_command(path: Path) -> str:
    """Return the shell command that flies a pinned regression."""
    return f"workbench regress {shlex.quote(str(path))}"


class PinCard(TuningCard):
    """Writes a spec and its baseline that `workbench regress` flies.

    Args:
        workspace: analysis, preferences and colours.
        trial: the gains that are being tried; the flown ones are pinned.
    """

    def __init__(self, workspace: Workspace, trial: TuningTrial) -> None:
        super().__init__("Pin as regression")
        self._trial, self._preferences = trial, workspace.preferences
        self._cases = QueryStream(workspace.analysis, self, seen=True)
        self._sure: Path | None = None
        self.name = QLineEdit("my-step")
        kept = str(workspace.preferences.store.value(PIN_FOLDER_KEY, "") or Path.cwd())
        self.folder = QLineEdit(kept)
        self.browse = named(tool_button("…", self._browse), "Choose a folder")
        self.margins = QCheckBox("Pin the &margins of all loops, too")
        self.margins.setChecked(True)
        self.what = wrapped_label()
        self.button = button("Write", self.write)
        self.fault = wrapped_label("bad")
        self.paths = ToneLabel()
        self.command = QLineEdit()
        self.command.setReadOnly(True)
        self.copy = button("&Copy", self._copy, help="Copy the command")
        self._lay_out()
        self.name.textChanged.connect(self._show_state)
        self.folder.textChanged.connect(self._show_state)
        trial.changed.connect(self._show_state)
        self._cases.answered.connect(self._show_written)
        self._cases.refused.connect(self._show_refusal)
        self._show_state()
        self._show_result(None)

    @property
    def path(self) -> Path:
        """Path of the spec."""
        return spec_path(self.folder.text(), self.name.text()).absolute()

    def begin(self) -> None:
        """Clear the question about another vehicle."""
        self._cases.forget()
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
        self._preferences.store.setValue(PIN_FOLDER_KEY, self.folder.text())
        self.said.say("Flying the baseline …")
        self._show_result(None)
        self._cases.ask(
            RegressionCase(path, self._trial.flown, step, self.margins.isChecked(), sure)
        )
        self._show_state()

    def _show_written(self, _: RegressionCase, pinned: PinnedPaths) -> None:
        self.said.say("Written.", "good")
        self._show_result(pinned)
        self._show_state()

    def _show_refusal(self, said: str) -> None:
        self.said.say(said, "bad")
        self._show_state()

    def _show_result(self, pinned: PinnedPaths | None) -> None:
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
        elif step.is_attitude:
            fault = fault or (
                "A step of attitude or rate cannot be pinned: choose one of velocity, yaw rate or "
                "a load."
            )
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
        free = not self._cases.is_waiting
        self.button.setEnabled(not fault and bool(self._trial.flown) and free)
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
            (
                buddy("F&older", self.folder),
                hbox((self.folder, 1), self.browse, spacing=CARD_SPACING_PX),
            ),
            spacing=(CARD_SPACING_PX, CARD_SPACING_PX),
        )
        self._command_label = buddy("Command that r&uns it", self.command)
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
