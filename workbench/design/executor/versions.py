"""What must be the same here and on a worker, for a flight to be the same there."""

import functools
import hashlib
import platform
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

from workbench.common.errors import WorkbenchError
from workbench.common.resources import models_dir

INSTALL = "install there what is installed here, with one constraints.txt for all"


class Versions(NamedTuple):
    """Of what a flight follows from.

    Attributes:
        workbench: a digest of its source and of the shipped models.
        drake, numpy, numba: of these packages.
        processor: x86_64 and so on.
    """

    workbench: str
    drake: str
    numpy: str
    numba: str
    processor: str


@functools.cache
def versions() -> Versions:
    """Return those of this process."""
    package = Path(__file__).parents[2]
    digest = hashlib.sha256()
    for folder, pattern in ((package, "*.py"), (models_dir(), "*")):
        for path in sorted(folder.rglob(pattern)):
            if path.is_file() and path.suffix != ".pyc":
                digest.update(path.relative_to(folder).as_posix().encode() + b"\0")
                digest.update(path.read_bytes())
    return Versions(
        workbench=digest.hexdigest()[:12],
        drake=metadata.version("drake"),
        numpy=metadata.version("numpy"),
        numba=metadata.version("numba"),
        processor=platform.machine(),
    )


def check_versions(worker: str, there: Versions, here: Versions) -> None:
    """Refuse a worker that would fly otherwise.

    Raises:
        WorkbenchError: naming the first that is not the same.
    """
    for name, other, own in zip(Versions._fields, there, here, strict=True):
        if other != own and name == "workbench":
            raise WorkbenchError(
                f"the worker {worker} has another state of the workbench's source than there is "
                f"here: {INSTALL}"
            )
        if other != own:
            what = "a processor of kind" if name == "processor" else name
            raise WorkbenchError(
                f"the worker {worker} has {what} {other}, and here it is {own}: {INSTALL}"
            )
