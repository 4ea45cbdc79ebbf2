"""Which of the shipped extras are here, for tests of the core over all that is installed."""

from collections.abc import Iterable
from pathlib import Path

import workbench

NO_EXTRA = "install the workbench with workbench.extras to try it"
"""Why a test of what an extra adds is skipped."""
FORMATS = (Path(workbench.__file__).parent / "extras" / "formats").is_dir()
"""Whether SDF, MJCF and gym-pybullet-drones are read."""


def readable(paths: Iterable[str]) -> list[str]:
    """Return the published descriptions that are read here."""
    return [path for path in paths if FORMATS or "rotors_description" in path]
