"""What rotors turn at once where joints swing freely: less than all that flies."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Context

from workbench.plant.cables import cable_ends, cable_stretch
from workbench.plant.model import Cable, Freedom, Model
from workbench.plant.vehicle import TurnedBody, Vehicle

MAX_SWING_RATE_RAD_S = 20.0
"""Rate of a joint, by its damping or its spring, above which it counts as rigid: above the
bandwidth of an attitude loop. Of joints with damping alone it is that of their motion together: in
a chain of light links each is damped strongly, and the chain still swings."""


def turned_body(
    plant: MultibodyPlant, context: Context, model: Model, cables: Sequence[Cable]
) -> TurnedBody | None:
    """Return the body that rotors turn, None if all that flies turns with it.

    A taut cable passes on the motion along it, and nothing else: it takes one freedom of its ends.
    With the joints that swing eliminated from the mass matrix (its Schur complement A, 6 x 6 at the
    origin of B), the inertia is that against a moment alone; the centre is where a force does not
    turn the body: x and y for a vertical force, which hangs weights from their hinges, z for a
    horizontal one. For a rigid body both are its own.

    Args:
        plant: finalised.
        context: of the plant, with all joints at zero.
        model: of bodies, from `merged_model`, of which the plant was made.
        cables: that are taut in flight.
    """
    mass = plant.CalcMassMatrix(context)
    inverse = np.linalg.inv(mass)
    damping: dict[int, float] = {}  # of joints with nothing else, by their place
    free: list[int] = []
    for joint in model.joints:
        (freedom,), made = joint.freedoms, plant.GetJointByName(joint.name)
        places = range(made.velocity_start(), made.velocity_start() + made.num_velocities())
        if joint.mimic:
            continue
        if freedom.servo or freedom.stiffness or freedom.friction:
            free += [p for p in places if _swings(freedom, 1.0 / inverse[p, p])]
        else:
            damping |= dict.fromkeys(places, freedom.damping)
    swings = np.hstack([np.eye(len(mass))[:, free], _slow_motions(inverse, damping)])
    if not swings.shape[1]:
        return None
    base = plant.GetBodyByName(model.links[0].name)
    own = base.floating_velocities_start_in_v() + np.arange(6)
    drone = base.model_instance()
    along = [cable_stretch(plant, context, cable_ends(plant, cable, drone)) for cable in cables]
    ways = _allowed(np.array(along).reshape(len(along), len(mass)), own, swings)
    mass = ways.T @ mass @ ways
    between, loose = mass[:6, 6:], mass[6:, 6:]
    A = mass[:6, :6] - between @ np.linalg.solve(loose, between.T)
    inertia = np.linalg.inv(np.linalg.inv(A)[:3, :3])
    centre = (
        -A[1, 5] / A[5, 5],
        A[0, 5] / A[5, 5],
        0.5 * (A[1, 3] / A[3, 3] - A[0, 4] / A[4, 4]),
    )
    x, y, z = (float(value) for value in centre)
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = (0.5 * (inertia + inertia.T)).tolist()
    return TurnedBody((x, y, z), ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))


def _slow_motions(inverse: np.ndarray, damping: Mapping[int, float]) -> np.ndarray:
    """Return the motions of damped joints below `MAX_SWING_RATE_RAD_S`, as columns (nv, m).

    With their mass matrix M and damping D, both with all else free, they decay at the eigenvalues
    of M⁻¹ D. All of them are of the form L w, M⁻¹ = L L^T, with w an eigenvector of L^T D L.

    Args:
        inverse: of the mass matrix (nv, nv).
        damping: of each joint, by the place of its velocity.
    """
    places = list(damping)
    L = np.linalg.cholesky(inverse[np.ix_(places, places)])
    rates, motions = np.linalg.eigh(L.T @ np.diag(list(damping.values())) @ L)
    found = np.zeros((len(inverse), len(places)))
    found[places] = L @ motions
    return found[:, rates < MAX_SWING_RATE_RAD_S]


def _allowed(along: np.ndarray, own: np.ndarray, swings: np.ndarray) -> np.ndarray:
    """Return the motions that keep the lengths of cables, as columns (nv, 6 + m).

    The first six are those of the base link, which joints follow as little as they can; in the
    others joints alone move.

    Args:
        along: how velocities lengthen each cable (c, nv).
        own: places of the velocities of the base link (6).
        swings: motions in which joints swing, as columns (nv, k).
    """
    base = np.eye(along.shape[1])[:, own]
    if not len(along):
        return np.hstack([base, swings])
    longer = along @ swings
    follow = -np.linalg.pinv(longer) @ along[:, own]
    _, sizes, rows = np.linalg.svd(longer)
    loose = rows[int((sizes > 1e-9).sum()) :].T
    return np.hstack([base + swings @ follow, swings @ loose])


def _swings(freedom: Freedom, inertia: float) -> bool:
    """Return whether a joint with friction, spring or servo leaves what is below it behind."""
    if freedom.friction:
        return False
    damping, stiffness = freedom.damping, freedom.stiffness
    if freedom.servo:
        servo = freedom.servo.driving(inertia)
        damping, stiffness = damping + servo.damper, stiffness + servo.spring
    damped = damping / inertia
    sprung = (stiffness / inertia) ** 0.5
    return max(damped, sprung) < MAX_SWING_RATE_RAD_S


def as_turned(vehicle: Vehicle) -> Vehicle:
    """Return a vehicle as its law knows it: with the inertia of the body that its rotors turn."""
    if not vehicle.turned:
        return vehicle
    return replace(vehicle, p_BoBcm_B=vehicle.turned.p_BoBcm_B, I_BBcm_B=vehicle.turned.I_BBcm_B)
