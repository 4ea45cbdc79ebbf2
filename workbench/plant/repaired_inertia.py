"""Repair inertias of a description that no body can have."""

import dataclasses
import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.values import shortened_text
from workbench.plant.model import Inertial, Link, Model
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.sidecar import find_sidecar, load_sidecar

_INERTIA_TOLERANCE = 1e-6
"""Moments of a flat plate meet the triangle inequality exactly. A violation up to this share of the
largest moment comes from the few digits written, and needs no remark."""
_EXACT_INERTIA_TOLERANCE = 1e-15
"""For a violation above this share, Drake uses a very different inertia."""


def repair_inertias(model: Model, remarks: Remarks) -> Model:
    """Return the model with physically possible inertias, and remark on those that were not.

    A link without mass becomes a frame. A largest moment above the sum of the other two is
    impossible, and is lowered to that sum. This changes one number, for a drone that of yaw.
    Products of inertia too large for their moments are set to zero.

    Raises:
        WorkbenchError: for a negative mass or moment, as its meaning is unclear.
    """
    links = tuple(
        link
        if link.inertial is None
        else dataclasses.replace(
            link, inertial=_repaired_inertial(model, link, link.inertial, remarks)
        )
        for link in model.links
    )
    return dataclasses.replace(model, links=links)


def _repaired_inertial(
    model: Model, link: Link, inertial: Inertial, remarks: Remarks
) -> Inertial | None:
    """Return a physically possible inertia of a link, None for a link without mass."""
    element = f"inertia of link '{shortened_text(link.name)}'"
    if inertial.mass < 0.0:
        raise WorkbenchError(
            f"{model.source}: link '{shortened_text(link.name)}' has the mass {inertial.mass:g}: "
            "give it a mass of 0 kg or more"
        )
    if min(inertial.moments) < 0.0:
        raise WorkbenchError(
            f"{model.source}: link '{shortened_text(link.name)}' has a negative moment of inertia "
            f"({_listed_numbers(inertial.moments)}): give it moments of 0 kg m^2 or more"
        )
    if inertial.mass == 0.0:
        text = "its mass is 0; taken as a frame without inertia"
        remarks.add("repaired", model.source, element, text)
        return None
    principal, axes = np.linalg.eigh(inertial.matrix)  # the smallest moment first
    if principal[0] < -_INERTIA_TOLERANCE * principal[2]:
        text = (
            f"products ({_listed_numbers(inertial.products)}) too large for the moments; left out"
        )
        remarks.add("repaired", model.source, element, text)
        inertial = dataclasses.replace(inertial, products=(0.0, 0.0, 0.0))
        principal, axes = np.linalg.eigh(inertial.matrix)  # the smallest moment first
    small, middle, large = principal
    excess = large - small - middle
    if excess > _INERTIA_TOLERANCE * large:
        text = (
            f"no body has principal moments of {_listed_numbers(principal)} kg m^2, the largest "
            f"more than the other two together; it is taken as {small + middle:.3g}"
        )
        remarks.add("repaired", model.source, element, text)
    if excess > _EXACT_INERTIA_TOLERANCE * large:
        return _turned_inertial(inertial, np.array([small, middle, small + middle]), axes)
    if principal[2] == 0.0:
        remarks.add("repaired", model.source, element, "it is 0; taken as a point mass")
    return inertial


def _turned_inertial(inertial: Inertial, principal: np.ndarray, axes: np.ndarray) -> Inertial:
    """Return an inertia with other principal moments about the same axes."""
    if np.linalg.det(axes) < 0.0:
        axes = axes * np.array([1.0, 1.0, -1.0])
    turn = RigidTransform(RotationMatrix.ProjectToRotationMatrix(axes), np.zeros(3))
    xx, yy, zz = (float(moment) for moment in principal)
    return dataclasses.replace(
        inertial, X_LI=inertial.X_LI @ turn, moments=(xx, yy, zz), products=(0.0, 0.0, 0.0)
    )


def _listed_numbers(values: Iterable[float]) -> str:
    return ", ".join(f"{float(value):.3g}" for value in values)


def with_stated_body(model: Model, base_link: str, sidecar: Path | None, remarks: Remarks) -> Model:
    """Return a model with the body that a sidecar states, if any.

    All mass then is in the base link, and the centre of mass is given in its frame. The motion of a
    rigid body stays the same.

    Args:
        model: its links make up the drone.
        base_link: its frame is the body frame.
        sidecar: a requested one, instead of the one beside the description.
        remarks: receives a remark.

    Raises:
        WorkbenchError: with file and line, for impossible numbers.
    """
    path = sidecar or find_sidecar(model.source)
    if not path:
        return model
    file, sidecar_rows = load_sidecar(path)
    rows = sidecar_rows.body
    if not rows or not file.data["body"]:
        return model

    def refuse(key: str, reason: str) -> WorkbenchError:
        return WorkbenchError(f"{file.where('body', key)}body.{key} {reason}")

    if not 0.0 < rows.mass < math.inf:
        raise refuse("mass", "should be a positive number of kg")
    if len(rows.center_of_mass) != 3 or not np.isfinite(rows.center_of_mass).all():
        raise refuse("center_of_mass", "should be three numbers: x, y, z in m")
    if len(rows.inertia) != 6 or not np.isfinite(rows.inertia).all():
        raise refuse("inertia", "should be six numbers: xx, yy, zz, xy, xz, yz in kg m²")
    xx, yy, zz, xy, xz, yz = rows.inertia
    whole = Inertial(
        mass=rows.mass,
        X_LI=RigidTransform(rows.center_of_mass),
        moments=(xx, yy, zz),
        products=(xy, xz, yz),
    )
    if np.linalg.eigvalsh(whole.matrix)[0] <= 0.0:
        raise refuse("inertia", "does not fit any body: its moments have to be positive")
    remarks.add("assumed", file.path, "body", "mass, centre and inertia are those of this file")
    links = tuple(
        dataclasses.replace(link, inertial=whole if link.name == base_link else None)
        for link in model.links
    )
    return repair_inertias(dataclasses.replace(model, links=links), remarks)
