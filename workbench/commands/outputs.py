"""Output files of a command: all are written at its end, or none."""

import argparse
import errno
import os
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import make_folder

_OUTPUT_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
"""Errors that only writing raises: the device is full, a quota is used up, it is defective."""


@dataclass
class Outputs:
    """A set of files that appear together when its `with` block ends without an exception.

    A file is added before the work begins, so that an unwritable path is rejected early. Until the
    end its content is in a temporary file next to it. If the block fails, that file and all new
    folders are removed.
    """

    _partial: dict[Path, Path] = field(default_factory=dict)
    _folders: list[Path] = field(default_factory=list)

    def add(self, target: Path) -> Path:
        """Return the temporary path for `target`, with the same suffix.

        Raises:
            WorkbenchError: if the path is not writable.
        """
        import tempfile

        if target in self._partial:
            raise WorkbenchError(f"{target}: two different files would be written there")
        try:
            if target.exists() and not target.is_file():
                what = "a folder" if target.is_dir() else "not a plain file"
                raise WorkbenchError(f"{target}: is {what}, so no file of that name can be written")
            target = target.resolve() if target.is_symlink() else target
            self._make_folder(target.parent)
            handle, name = tempfile.mkstemp(
                prefix=f".{target.stem}.", suffix=target.suffix, dir=target.parent
            )
        except (OSError, ValueError) as error:  # ValueError for a name with a NUL
            reason = getattr(error, "strerror", "") or str(error)
            raise WorkbenchError(
                f"{target}: cannot be written: {reason}; name another place"
            ) from error
        os.close(handle)
        self._partial[target] = Path(name)
        return self._partial[target]

    def picture(self, args: argparse.Namespace, name: str) -> Path | None:
        """Return the temporary path of a figure in the folder of --output; None with --no-plots.

        Raises:
            WorkbenchError: if the path is not writable.
        """
        return None if args.no_plots else self.add(args.output / name)

    @property
    def files(self) -> list[Path]:
        """The final paths."""
        return list(self._partial)

    def __enter__(self) -> "Outputs":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        try:
            if isinstance(error, OSError) and error.errno in _OUTPUT_ERRORS:
                names = ", ".join(map(str, self._partial))
                raise WorkbenchError(f"{names}: cannot be written: {error.strerror}") from error
            if isinstance(error, WorkbenchError) and self._with_targets(error) != str(error):
                raise WorkbenchError(self._with_targets(error)) from error
            if kind is None:
                for target, partial in self._partial.items():
                    partial.chmod(0o666 & ~_umask())
                    partial.replace(target)
                self._folders.clear()
        except OSError as failure:
            place = self._with_targets(failure.filename)
            raise WorkbenchError(f"{place}: cannot be written: {failure.strerror}") from failure
        finally:
            self.discard()

    def discard(self) -> None:
        """Remove temporary files, and all folders made for them."""
        for partial in self._partial.values():
            partial.unlink(missing_ok=True)
        for folder in reversed(self._folders):
            if not any(folder.iterdir()):
                folder.rmdir()

    def _with_targets(self, said: object) -> str:
        """Return a text that names final paths in place of temporary ones."""
        text = str(said)
        for target, partial in self._partial.items():
            text = text.replace(str(partial), str(target))
        return text

    def _make_folder(self, folder: Path) -> None:
        """Make a folder and its parents, and note which are new."""
        missing = [each for each in (folder, *folder.parents) if not each.exists()]
        for each in reversed(missing):
            each.mkdir()
            self._folders.append(each)


def _umask() -> int:
    """Return the umask of the process, which can only be read by setting it."""
    mask = os.umask(0)
    os.umask(mask)
    return mask


def check_writable(target: Path) -> None:
    """Check that a file written without `Outputs` is writable, before the work begins.

    Raises:
        WorkbenchError: if the path is not writable.
    """
    probe = Outputs()
    try:
        probe.add(target)
    finally:
        probe.discard()


def make_folder_of(path: Path) -> None:
    """Make the folder of a file written during the work, such as a log.

    Raises:
        WorkbenchError: if this fails, or the path is not writable.
    """
    check_writable(path)
    make_folder(path.parent)
