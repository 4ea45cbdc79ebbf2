"""Refuse inertias that no body can have; Drake only warns, and flies another one in their place."""

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

from workbench.errors import WorkbenchError

_ROUNDING = 1e-6
"""Moments of a flat plate meet the triangle rule exactly; this share of the largest is let pass."""


def check_inertias(path: Path, robot: ET.Element) -> None:
    """Check the inertia of every link of a URDF.

    Raises:
        WorkbenchError: naming the link whose moments are no numbers, or not those of a body.
    """
    for link in robot.findall("link"):
        inertia = link.find("inertial/inertia")
        if inertia is None:
            continue
        try:
            xx, yy, zz, xy, xz, yz = (
                float(inertia.get(name, "0")) for name in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
            )
        except ValueError:
            raise WorkbenchError(
                f"{path}: link '{link.get('name')}' has an inertia that is no number: "
                "give ixx, iyy, izz, ixy, ixz and iyz in kg m^2"
            ) from None
        matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        if not np.isfinite(matrix).all() or not _is_of_a_body(np.linalg.eigvalsh(matrix)):
            raise WorkbenchError(
                f"{path}: link '{link.get('name')}' has an inertia that no body can have: its "
                "principal moments must be positive, and none larger than the other two together"
            )


def _is_of_a_body(moments: np.ndarray) -> bool:
    """Return whether principal moments, smallest first, are those of a body."""
    small, middle, large = moments
    return bool(small > 0.0 and small + middle >= large * (1.0 - _ROUNDING))
