"""What a flight depends on besides its scenario: versions and the machine."""

import platform
from importlib import metadata

PACKAGES = {
    "workbench": "drake-drone-workbench",
    "drake": "drake",
    "numpy": "numpy",
    "numba": "numba",
}
UNKNOWN = "unknown"
PHYSICS = "2"
"""Of how the vehicle is stepped; logs that do not say it are of 1, Drake's discrete plant."""


def versions() -> dict[str, str]:
    """Return the versions of what computes here, by name, and the platform."""
    found = {name: _version(package) for name, package in PACKAGES.items()}
    machine = {"python": platform.python_version(), "platform": platform.platform()}
    return {"physics": PHYSICS} | found | machine


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return UNKNOWN
