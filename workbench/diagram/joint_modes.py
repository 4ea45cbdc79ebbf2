"""The modes of a vehicle's joints about the start of a flight, and how fast they are."""

from dataclasses import dataclass

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder

from workbench.plant.description import Description
from workbench.plant.gathered import merged_model
from workbench.plant.multibody import add_plant, mobility
from workbench.systems.ball_forces import FRICTION_SPEED, BallRow, ball_rows
from workbench.systems.cables import CableRow, cable_rows
from workbench.systems.joint_forces import JointRow, joint_rows

_RANGE_SAMPLES = 9
"""Number of positions in the range of a joint; one without limits turns once, or slides 3 m."""
_GRAVITY_STEP = 1e-5
"""Step of a joint for derivatives of the weight's forces [rad or m]."""


@dataclass(frozen=True)
class JointMode:
    """A mode of the joints under a free vehicle whose rotors carry its weight.

    Attributes:
        joint: the freedom that moves most in it, or the cable.
        eigenvalue: [1/s]; of a complex pair the one with a positive imaginary part.
    """

    joint: str
    eigenvalue: complex

    @property
    def rate(self) -> float:
        """Magnitude of the eigenvalue [1/s]."""
        return abs(self.eigenvalue)


def joint_modes(
    plant: MultibodyPlant,
    rows: tuple[JointRow, ...],
    balls: tuple[BallRow, ...] = (),
    cables: tuple[CableRow, ...] = (),
) -> tuple[JointMode, ...]:
    """Return the modes of the joints at their start, and those along cables, the fastest first.

    With the mass matrix M of the whole, M dv/dt = -(K + G) q - D v for the positions q of joints: K
    has springs, servos and followers, D damping, smoothed friction and both of these, G the weight.

    Args:
        plant: finalised.
        rows: its freedoms, see `joint_rows`.
        balls: its ball joints, which begin where the rates of their angles are their velocities.
        cables: of the vehicle, taut.
    """
    along = _modes_along(plant, cables)
    turns = [(ball, axis) for ball in balls for axis in range(3)]
    names = [*(row.name for row in rows), *(ball.name for ball, _ in turns)]
    if not names:
        return tuple(sorted(along, key=lambda mode: -mode.rate))
    context, n = plant.CreateDefaultContext(), len(names)
    start = plant.GetPositions(context).copy()
    positions = [*(row.position for row in rows), *(ball.position + axis for ball, axis in turns)]
    places = [*(row.velocity for row in rows), *(ball.velocity + axis for ball, axis in turns)]
    K, D = (np.zeros((plant.num_velocities(), n)) for _ in range(2))
    for number, (ball, axis) in enumerate(turns, start=len(rows)):
        K[ball.velocity + axis, number] += ball.stiffness
        D[ball.velocity + axis, number] += ball.damping + ball.friction / FRICTION_SPEED
    for number, row in enumerate(rows):
        K[row.velocity, number] += row.stiffness + (row.servo.spring if row.servo else 0.0)
        D[row.velocity, number] += row.damping + row.friction / FRICTION_SPEED
        D[row.velocity, number] += row.servo.damper if row.servo else 0.0
        if row.leader >= 0:
            across = np.zeros(n)
            across[[number, row.leader]] = 1.0, -row.multiplier
            K[places] += row.mimic_stiffness * np.outer(across, across)
            D[places] += row.mimic_damping * np.outer(across, across)
    for number, position in enumerate(positions):
        weights = []
        for step in (-_GRAVITY_STEP, _GRAVITY_STEP):
            moved = start.copy()
            moved[position] += step
            plant.SetPositions(context, moved)
            weights.append(plant.CalcGravityGeneralizedForces(context))
        K[:, number] -= (weights[1] - weights[0]) / (2.0 * _GRAVITY_STEP)
    plant.SetPositions(context, start)
    inverse = mobility(plant, context)[places]
    found = _modes(names, inverse @ K, inverse @ D)
    return tuple(sorted([*found, *along], key=lambda mode: -mode.rate))


def _modes_along(plant: MultibodyPlant, cables: tuple[CableRow, ...]) -> list[JointMode]:
    """Return the modes of the lengths of cables, all taut: parallel ones are stiffer together."""
    if not cables:
        return []
    stretch = np.array([cable.stretch for cable in cables])
    W = stretch @ mobility(plant, plant.CreateDefaultContext()) @ stretch.T
    stiffness, damping = (
        np.array([getattr(cable, word) for cable in cables]) for word in ("stiffness", "damping")
    )
    return _modes([cable.name for cable in cables], W * stiffness, W * damping)


def _modes(names: list[str], K: np.ndarray, D: np.ndarray) -> list[JointMode]:
    """Return the modes of d²q/dt² = -K q - D dq/dt with the names of the elements of q."""
    n = len(names)
    values, vectors = np.linalg.eig(np.block([[np.zeros((n, n)), np.eye(n)], [-K, -D]]))
    return [
        JointMode(names[int(np.argmax(np.abs(vector[n:])))], complex(value))
        for value, vector in zip(values, vectors.T, strict=True)
        if value.imag >= 0.0
    ]


def joint_study(description: Description) -> tuple[tuple[JointMode, ...], np.ndarray, np.ndarray]:
    """Return the modes of the joints of a description at their start, the fastest first, and the
    least and the largest place of the centre of mass in B (3) [m], as each joint moves through its
    range alone; that of a load on a cable has none.

    Raises:
        WorkbenchError: as `add_plant` does.
    """
    builder = DiagramBuilder()
    plant, _ = add_plant(builder, description.undrawn(), time_step=0.0)
    merged = merged_model(description.model, description.base_link)
    rows, balls = joint_rows(plant, merged), ball_rows(plant, merged)
    drone = plant.GetBodyByName(description.base_link).model_instance()
    cables = cable_rows(plant, description.model, drone)
    context = plant.CreateDefaultContext()
    base = plant.GetBodyByName(description.base_link)
    whole = plant.GetBodyIndices(base.model_instance())
    start, centres = plant.GetPositions(context).copy(), []
    loads = {
        name for joint in description.model.joints if joint.is_free for name in joint.freedom_names
    }
    for row in (row for row in rows if row.name not in loads):
        for share in np.linspace(0.0, 1.0, _RANGE_SAMPLES):
            moved = start.copy()
            lower, upper = max(row.lower, -np.pi), min(row.upper, np.pi)
            moved[row.position] = lower + share * (upper - lower)
            plant.SetPositions(context, moved)
            centres.append(plant.CalcSpatialInertia(context, base.body_frame(), whole).get_com())
    if not centres:
        centres = [plant.CalcSpatialInertia(context, base.body_frame(), whole).get_com()]
    modes = joint_modes(plant, rows, balls, cables)
    return modes, np.min(centres, axis=0), np.max(centres, axis=0)
