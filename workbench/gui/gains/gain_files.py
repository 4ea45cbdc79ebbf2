"""Gain files and texts of the clipboard, loaded and saved in the background."""

import tempfile
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from pathlib import Path

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller
from workbench.control.controller_file import load_controller
from workbench.control.schedule import split_label
from workbench.gains.gains import GainFile, flown_by, gain_file_text, load_gains, save_gains
from workbench.gui.errands import BackgroundTasks, FutureCallbacks
from workbench.gui.gains.autopilot_file import (
    compare_autopilot_file,
    load_autopilot_gains,
    write_autopilot_file,
)
from workbench.gui.gains.gain_editor import GainEditor
from workbench.gui.gains.gain_file_diff import GainFileDiff, GainFileValues, compare_gain_file
from workbench.gui.notices import Notices
from workbench.live.view import LiveView
from workbench.plant.vehicle import Vehicle

MODEL_GAIN_FILE = "gains.yaml"
"""File name of a model's own gains, beside its description."""
CLIPBOARD_NAME = "clipboard"
FLIGHT_START_NAME = "Start of the flight"


class GainFiles(QObject):
    """Loads and saves gain files of the gains that are edited, in the background.

    Args:
        editor: the editor of the gains.
        notices: takes refusals.
        parent: the Qt parent.

    Attributes:
        name: name of the gain file that was loaded or saved last.
        diff: changes of a loaded gain file; None if none waits for a choice.
        file: the gain file that was loaded or saved last; None before the first one.
        note: the user's note on the gains, which is saved with them.
    """

    diff_changed = pyqtSignal(object)
    """`diff` changed."""
    named = pyqtSignal(str)
    """Name of the gain file that flies now."""

    def __init__(self, editor: GainEditor, notices: Notices, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._editor, self._notices = editor, notices
        self._errands = BackgroundTasks()
        self._answers = FutureCallbacks(lambda said: notices.warn(said), self)
        self._vehicle: Vehicle | None = None
        self._start: GainFileValues = {}
        self._scripted: frozenset[tuple[str, float]] = frozenset()
        self._values: GainFileValues = {}
        self.name = ""
        self.diff: GainFileDiff | None = None
        self.file: GainFile | None = None
        self.note = ""
        self._waiting: tuple[str, GainFile] | None = None  # for the schedule of its gains
        editor.begun.connect(self._begin)

    @property
    def controller(self) -> Controller:
        """The controller whose gains these are."""
        return self._editor.controller

    def words(self, name: str) -> str:
        """Return the name of a parameter of the flight, in words."""
        return self._editor.words(name)

    @property
    def is_changed(self) -> bool:
        """Whether the flight's values differ from the gain file that was loaded or saved last."""
        return not self._has(self._editor.flown)

    def load(self, path: Path) -> None:
        """Compare with a gain file; its sets of gains are scheduled."""
        self._read(path.stem, partial(_with_schedule, path, self.controller))

    def load_autopilot(self, path: Path) -> None:
        """Compare with an autopilot's file of parameters."""
        self._read(
            path.name,
            partial(load_autopilot_gains, path, self.controller, dict(self._editor.flown)),
        )

    def export(self, path: Path) -> None:
        """Compare the flown gains with an autopilot's file, or with its defaults for a new one."""
        law, flown = self.controller, dict(self._editor.flown)  # the flight continues meanwhile
        self._answers.expect(
            self._errands.run(partial(compare_autopilot_file, path, law, flown)), done=self._offer
        )

    def load_own(self) -> None:
        """Compare with the model's own gains, or with those of the start if it has none."""
        if self._vehicle is None:
            self._notices.warn("nothing flies: open a scenario first")
            return
        own, law = self._vehicle.source.parent / MODEL_GAIN_FILE, self.controller
        start = GainFile(
            self._vehicle.name, "as the flight began", self._start, controller=law.name
        )
        self._read(
            f"{self._vehicle.name}'s own", lambda: load_gains(own, law) if own.is_file() else start
        )

    def paste(self, text: str) -> None:
        """Compare with a text of the clipboard."""
        self._read(f"the {CLIPBOARD_NAME}", lambda: read_gain_text(text, self.controller))

    def take(self, names: Iterable[str]) -> None:
        """Fly the lines of the loaded gain file with these parameters, or write them.

        Lines that would not fly are refused once; the same lines again are written.
        """
        if self.diff is None:
            return
        diff, taken = self.diff, frozenset(names)
        self.dismiss()
        if diff.target is not None:
            self._write(diff, taken)
            return
        self._set_name(diff.name, diff.values)
        self._editor.adopt({n: v for n, v in diff.values.items() if n in taken}, diff.name)

    def dismiss(self) -> None:
        """Dismiss the loaded gain file."""
        self.diff = None
        self.diff_changed.emit(None)

    def save(self, path: Path) -> None:
        """Write the flown gains to a gain file, which keeps its history."""
        self._save(path, self._editor.ordered_gains)

    def unsaved(self) -> str:
        """Return which gains would be lost with the flight, as a sentence; "" for none.

        Flown or kept gains are lost if they equal neither those of the flight's start nor those of
        the gain file that was loaded or saved last. Values that the scenario's script sets do not
        count: the scenario has them.
        """
        flown_values, kept_values = self._editor.ordered_gains, self._editor.kept
        flown, kept = self._is_lost(flown_values), self._is_lost(kept_values)
        if not flown and not kept:
            return ""
        which = "The gains that fly" if flown else "The gains that you kept"
        said = f"{which} are in no file: they were tuned since the flight began."
        if flown and kept and kept_values != flown_values:
            return f"{said} Others are kept; Revert flies these again, so that you can save them."
        return said

    def save_unsaved(self, path: Path, saved: Callable[[], object]) -> None:
        """Write the gains that `unsaved` names to a gain file, and call back when it is written."""
        flown = self._editor.ordered_gains
        values = flown if self._is_lost(flown) else self._editor.kept
        self._save(path, values, saved)

    def as_yaml(self) -> str:
        """Return the flown gains as a gain file's text, without a history."""
        law, gains = self.controller, self._editor.ordered_gains
        file = GainFile(self._vehicle_name, "copied while flying", gains, controller=law.name)
        return gain_file_text(file, law)

    def close(self) -> None:
        """Wait for files that are being read or written; must be the last call."""
        self._answers.close()
        self._errands.close()

    @property
    def _vehicle_name(self) -> str:
        return self._vehicle.name if self._vehicle else ""

    def _begin(self, view: LiveView) -> None:
        """Start with the gains of a new flight's start."""
        self._vehicle = view.vehicle
        self._start = dict(self._editor.kept)
        script = view.scenario.script if view.scenario is not None else ()
        self._scripted = frozenset(each for action in script for each in action.set.items())
        self.file = None
        self._set_name(FLIGHT_START_NAME, self._start)
        self.dismiss()
        waiting, self._waiting = self._waiting, None
        if waiting is not None and waiting[1].controller == self.controller.name:
            self._compare(*waiting)

    def _has(self, values: GainFileValues) -> bool:
        """Return whether the gain file that was loaded or saved last has these values."""
        return all(values.get(name) == value for name, value in self._values.items())

    def _is_lost(self, values: GainFileValues) -> bool:
        """Return whether values for a gain file are stored nowhere else."""
        own = dict(values.items() - self._scripted)
        return not own.items() <= self._start.items() and not self._has({**self._values, **own})

    def _read(self, name: str, read: Callable[[], GainFile]) -> None:
        self._answers.expect(self._errands.run(read), done=lambda file: self._compare(name, file))

    def _compare(self, name: str, file: GainFile) -> None:
        if file.controller not in (self.controller.name, self.controller.unscheduled):
            self._waiting = (name, file)
            self._editor.schedule_gains(split_label(file.controller)[1])
            return
        self.file = file
        diff = compare_gain_file(
            name, file, self._vehicle_name, self._editor.flown, self.controller
        )
        if diff.changes:
            self.diff = diff
            self.diff_changed.emit(diff)
            return
        self._set_name(name, diff.values)
        self._notices.inform(f"Nothing differs: the flight already has the gains of {name}.")

    def _offer(self, diff: GainFileDiff) -> None:
        """Show how an autopilot's file would change."""
        if diff.changes:
            self.diff = diff
            self.diff_changed.emit(diff)
        else:
            self._write(diff, frozenset())

    def _write(self, diff: GainFileDiff, taken: frozenset[str]) -> None:
        """Write the accepted gains to an autopilot's file, if it would fly or the user insists."""
        assert diff.target is not None
        left = {each.name: each.a for each in diff.changes if each.name not in taken}
        insists = diff.refused == taken
        write = partial(
            write_autopilot_file, diff.target, self.controller, {**diff.values, **left}, insists
        )

        def tell(refusal: str) -> None:
            if refusal:
                self._notices.warn(f"{diff.target}: {refusal}", "Change them, or write it anyway.")
                if diff.changes:
                    self._offer(replace(diff, refused=taken))
                return
            self._notices.inform(
                f"Wrote {len(taken)} gains to {diff.target}; all else in it is unchanged."
            )

        self._answers.expect(self._errands.run(write), done=tell)

    def _save(
        self, path: Path, values: GainFileValues, saved: Callable[[], object] = lambda: None
    ) -> None:
        origin = "; ".join(filter(None, (self.note, f"tuned in flight, from {self.name}")))
        law = self.controller
        file = GainFile(self._vehicle_name, origin, dict(values), controller=law.name)

        def tell(written: GainFile) -> None:
            self.file = written
            self._set_name(path.stem, written.gains)
            self._notices.inform(f"Saved {len(written.gains)} values to {path}.")
            saved()

        self._answers.expect(self._errands.run(lambda: save_gains(path, file, law)), done=tell)

    def _set_name(self, name: str, values: GainFileValues) -> None:
        self.name, self._values = name, dict(values)
        self.named.emit(name)


def _with_schedule(path: Path, law: Controller) -> GainFile:
    """Return a gain file, of the flying controller or of its version with another schedule."""
    file, _ = split_label(law.reference)
    wanted = load_controller(flown_by(file, str(path)))
    return load_gains(path, wanted if wanted.schedule else law)


def read_gain_text(text: str, controller: Controller | None = None) -> GainFile:
    """Return a gain file from text: a whole one, or just its NAME: VALUE lines.

    Raises:
        WorkbenchError: names the line of an error.
    """
    if not text.strip():
        raise WorkbenchError("the clipboard has no text: copy the text of a gain file first")
    lines = text.splitlines()
    if not any(line.startswith("gains:") for line in lines):
        text = "\n".join(["gains:", *(f"  {line.strip()}" for line in lines)])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / CLIPBOARD_NAME
        path.write_text(text, encoding="utf-8")
        try:
            return load_gains(path, controller)
        except WorkbenchError as error:
            raise WorkbenchError(str(error).replace(str(path), f"the {CLIPBOARD_NAME}")) from None
