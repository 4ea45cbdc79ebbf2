"""Inertias as bodies can have them: what Drake would refuse or silently change, said and mended."""

import dataclasses

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.values import shortened
from workbench.plant.model import Inertial, Link, Model
from workbench.plant.remarks import Remarks

_ROUNDING = 1e-6
"""Moments of a flat plate meet the triangle rule exactly; beyond it, this share of the largest is
how few digits they are written with, and needs no remark."""
_EXACT = 1e-15
"""Beyond the rule by more than this share, Drake takes a quite different inertia."""


def repair_inertias(model: Model, remarks: Remarks) -> Model:
    """Return the model with inertias that bodies can have, and remarks on those that could not.

    A link without mass becomes a frame. Where the largest moment exceeds the other two together,
    which no body's does, it is lowered to their sum: one number changes, and of a drone it is that
    of yaw. Products of inertia too large for their moments are left out.

    Raises:
        WorkbenchError: for a negative mass or a negative moment, whose meaning is not plain.
    """
    links = tuple(
        link
        if link.inertial is None
        else dataclasses.replace(link, inertial=_repaired(model, link, link.inertial, remarks))
        for link in model.links
    )
    return dataclasses.replace(model, links=links)


def _repaired(model: Model, link: Link, inertial: Inertial, remarks: Remarks) -> Inertial | None:
    """Return a link's inertia as a body can have it, None for a link without mass."""
    element = f"inertia of link '{shortened(link.name)}'"
    if inertial.mass < 0.0:
        raise WorkbenchError(
            f"{model.source}: link '{shortened(link.name)}' has the mass {inertial.mass:g}: "
            "give it a mass of 0 kg or more"
        )
    if min(inertial.moments) < 0.0:
        raise WorkbenchError(
            f"{model.source}: link '{shortened(link.name)}' has a negative moment of inertia "
            f"({_list(inertial.moments)}): give it moments of 0 kg m^2 or more"
        )
    if inertial.mass == 0.0:
        text = "its mass is 0; taken as a frame without inertia"
        remarks.add("repaired", model.source, element, text)
        return None
    principal, axes = _principal(inertial)
    if principal[0] < -_ROUNDING * principal[2]:
        text = f"products ({_list(inertial.products)}) too large for the moments; left out"
        remarks.add("repaired", model.source, element, text)
        inertial = dataclasses.replace(inertial, products=(0.0, 0.0, 0.0))
        principal, axes = _principal(inertial)
    small, middle, large = principal
    excess = large - small - middle
    if excess > _ROUNDING * large:
        text = (
            f"no body has principal moments of {_list(principal)} kg m^2, the largest more than "
            f"the other two together; it is taken as {small + middle:.3g}"
        )
        remarks.add("repaired", model.source, element, text)
    if excess > _EXACT * large:
        return _turned(inertial, np.array([small, middle, small + middle]), axes)
    if principal[2] == 0.0:
        remarks.add("repaired", model.source, element, "it is 0; taken as a point mass")
    return inertial


def _principal(inertial: Inertial) -> tuple[np.ndarray, np.ndarray]:
    """Return principal moments, smallest first, and their axes in I as columns."""
    xx, yy, zz = inertial.moments
    xy, xz, yz = inertial.products
    moments, axes = np.linalg.eigh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
    return moments, axes


def _turned(inertial: Inertial, principal: np.ndarray, axes: np.ndarray) -> Inertial:
    """Return an inertia with other principal moments about the same axes."""
    if np.linalg.det(axes) < 0.0:
        axes = axes * np.array([1.0, 1.0, -1.0])
    turn = RigidTransform(RotationMatrix.ProjectToRotationMatrix(axes), np.zeros(3))
    xx, yy, zz = (float(moment) for moment in principal)
    return dataclasses.replace(
        inertial, X_LI=inertial.X_LI @ turn, moments=(xx, yy, zz), products=(0.0, 0.0, 0.0)
    )


def _list(values: object) -> str:
    return ", ".join(f"{float(value):.3g}" for value in values)  # type: ignore[attr-defined]
