"""Mass, centre and inertia that the sidecar beside a description states, in place of its own."""

import dataclasses
import math
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.plant.inertia_repair import repair_inertias
from workbench.plant.model import Inertial, Model
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.sidecar_file import find_sidecar, load_body


def with_stated_body(model: Model, base_link: str, sidecar: Path | None, remarks: Remarks) -> Model:
    """Return a model with the body of a sidecar, where that states one.

    All mass is in the base link then, whose frame the centre of mass is given in: that changes
    nothing of how a rigid body moves.

    Args:
        model: whose links carry all of the drone.
        base_link: whose frame is the body frame.
        sidecar: a file that was asked for, instead of one that lies beside.
        remarks: where to note it.

    Raises:
        WorkbenchError: with file and line, for what cannot be.
    """
    path = sidecar or find_sidecar(model.source)
    found = load_body(path) if path else None
    if not found:
        return model
    file, rows = found

    def refuse(key: str, reason: str) -> WorkbenchError:
        return WorkbenchError(f"{file.where('body', key)}body.{key} {reason}")

    if not 0.0 < rows.mass < math.inf:
        raise refuse("mass", "should be a positive number of kg")
    if len(rows.center_of_mass) != 3 or not np.isfinite(rows.center_of_mass).all():
        raise refuse("center_of_mass", "should be three numbers: x, y, z in m")
    if len(rows.inertia) != 6 or not np.isfinite(rows.inertia).all():
        raise refuse("inertia", "should be six numbers: xx, yy, zz, xy, xz, yz in kg m²")
    xx, yy, zz, xy, xz, yz = rows.inertia
    moments = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if moments[0] <= 0.0:
        raise refuse("inertia", "is of no body: its moments have to be positive")
    whole = Inertial(
        mass=rows.mass,
        X_LI=RigidTransform(rows.center_of_mass),
        moments=(xx, yy, zz),
        products=(xy, xz, yz),
    )
    remarks.add("assumed", file.path, "body", "mass, centre and inertia are those of this file")
    links = tuple(
        dataclasses.replace(link, inertial=whole if link.name == base_link else None)
        for link in model.links
    )
    return repair_inertias(dataclasses.replace(model, links=links), remarks)
