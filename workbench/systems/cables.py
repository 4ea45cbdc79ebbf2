"""Cables between bodies: one-sided springs with damping, which pull and never push.

With the distance d between its ends A and B, the unit vector n from A to B, and the length L, a
cable that is longer than L has the tension

    T = k (d - L) + c d(d - L)/dt,   0 if that is negative

and acts on A with T n and on B with -T n. A shorter one is slack. Drake's continuous plant has no
constraints. Unless a description states them, k and c come from the inertia between the ends: what
hangs on the cable has `STOP_RATE_RAD_S` as its natural frequency along it, and half of the critical
damping, see `joint_forces`.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, ModelInstanceIndex
from pydrake.systems.framework import BasicVector, BasicVector_, Context, LeafSystem, LeafSystem_

from workbench.common.vectors import Vector3, float_triple
from workbench.dynamics.rigid_body import cross, into_world, rotation
from workbench.plant.cables import TAUT_TOLERANCE_M, cable_ends, cable_stretch
from workbench.plant.model import Model
from workbench.plant.multibody import mobility
from workbench.plant.tree import hooked_cables
from workbench.systems.cached import cached
from workbench.systems.convertible import convertible
from workbench.systems.joint_forces import STOP_DAMPING_RATIO, STOP_RATE_RAD_S
from workbench.systems.spatial_forces import BodyLoads, declare_spatial_forces


class CableRow(NamedTuple):
    """A cable between two bodies.

    Attributes:
        name: of the cable.
        bodies: indices in the plant of those that carry its ends A and B.
        places: of the ends in the frames of the bodies [m].
        length: L [m].
        stiffness: k [N/m].
        damping: c [N s/m].
        stretch: change of the distance of its ends by the velocities of the plant, where all joints
            begin (nv).
        hooked: whether it ends in a hook, see `hooked_cables`.
    """

    name: str
    bodies: tuple[BodyIndex, BodyIndex]
    places: tuple[Vector3, Vector3]
    length: float
    stiffness: float
    damping: float
    stretch: np.ndarray
    hooked: bool


def cable_rows(
    plant: MultibodyPlant, model: Model, drone: ModelInstanceIndex
) -> tuple[CableRow, ...]:
    """Return the cables of a vehicle in a finalised plant.

    Args:
        plant: with the vehicle.
        model: of the vehicle.
        drone: the vehicle's model instance.
    """
    if not model.cables:
        return ()
    hooked = hooked_cables(model)
    context = plant.CreateDefaultContext()
    inverse = mobility(plant, context)
    rows = []
    for cable in model.cables:
        ends = cable_ends(plant, cable, drone)
        J = cable_stretch(plant, context, ends)
        mass = 1.0 / float(J @ inverse @ J)
        stiffness = cable.stiffness or mass * STOP_RATE_RAD_S**2
        rate = (stiffness / mass) ** 0.5
        (first, p_A), (second, p_B) = ends
        rows.append(
            CableRow(
                name=cable.name,
                bodies=(first.index(), second.index()),
                places=(float_triple(p_A), float_triple(p_B)),
                length=cable.length,
                stiffness=stiffness,
                damping=cable.damping or 2.0 * STOP_DAMPING_RATIO * mass * rate,
                stretch=J,
                hooked=cable in hooked,
            )
        )
    return tuple(rows)


@convertible
def Cables_(T: type) -> type[LeafSystem]:
    """The cables of a vehicle.

    Input port:
        state (13 k): of each body: q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
    Output ports:
        spatial_forces: on each body (k), at its origin, for the plant.
        tensions: of the cables (c) [N].
        ends (6 c): places of the ends A and B of each cable in W [m].
    Numeric parameter 0: 1 if the hooks are open, and no load hangs on its cable; initially 0.

    Args:
        T: the scalar type.
        rows: the cables (c).

    Attributes:
        bodies: indices in the plant of those with ends (k), in the order of the rows.
    """

    class Impl(LeafSystem_[T]):
        def declare(self, *, rows: Sequence[CableRow]) -> None:
            self.rows = tuple(rows)
            self.bodies = tuple(dict.fromkeys(body for row in rows for body in row.bodies))
            self._ends = [tuple(self.bodies.index(body) for body in row.bodies) for row in rows]
            self.DeclareNumericParameter(BasicVector_[T]([T(0.0)]))
            self._state = self.DeclareVectorInputPort("state", 13 * len(self.bodies))
            seen = {self._state.ticket(), self.pn_ticket()}
            self._loads = cached(self._calc_loads, "tensions, and forces on each body", seen)
            declare_spatial_forces(self, T, self._body_loads, seen)
            self.DeclareVectorOutputPort("tensions", len(rows), self._calc_tensions, seen)
            places = {self._state.ticket()}
            self.DeclareVectorOutputPort("ends", 6 * len(rows), self._calc_ends, places)

        def hooks_are_open(self, context: Context) -> bool:
            """Return whether no load hangs on its cable."""
            return bool(context.get_numeric_parameter(0).GetAtIndex(0) > 0.5)

        def _calc_loads(self, context: Context) -> tuple[list[Any], list[list[Any]]]:
            """Return the tensions (c), and moment and force on each body (k, 6), in W."""
            state = self._state.Eval(context).tolist()
            opened = self.hooks_are_open(context)
            tensions, loads = [], [[0.0 * state[0]] * 6 for _ in self.bodies]
            motions = _motions(state)
            for row, (first, second) in zip(self.rows, self._ends, strict=True):
                arms, apart, rate = _apart(row, motions[first], motions[second])
                distance = sum(x * x for x in apart) ** 0.5
                stretch = distance - row.length
                tension = 0.0 * state[0]
                if not (opened and row.hooked) and stretch > -TAUT_TOLERANCE_M:
                    n = [x / distance for x in apart]
                    speed = sum(a * b for a, b in zip(n, rate, strict=True))
                    pull = row.stiffness * stretch + row.damping * speed
                    # at rest at its length a cable is taut, so that it has a linear model there
                    tension = pull if pull > -row.stiffness * TAUT_TOLERANCE_M else tension
                    f_W = [tension * x for x in n]
                    for body, arm, sign in ((first, arms[0], 1.0), (second, arms[1], -1.0)):
                        whole = [*cross(arm, f_W), *f_W]
                        loads[body] = [
                            a + sign * b for a, b in zip(loads[body], whole, strict=True)
                        ]
                tensions.append(tension)
            return tensions, loads

        def _body_loads(self, context: Context) -> BodyLoads:
            return zip(self.bodies, self._loads(context)[1], strict=True)

        def _calc_ends(self, context: Context, output: BasicVector) -> None:
            motions = _motions(self._state.Eval(context).tolist())
            output.SetFromVector(
                [
                    x
                    for row, ends in zip(self.rows, self._ends, strict=True)
                    for body, place in zip(ends, row.places, strict=True)
                    for x in _end_motion(motions[body], place)[1]
                ]
            )

        def _calc_tensions(self, context: Context, output: BasicVector) -> None:
            output.SetFromVector(self._loads(context)[0])

    return Impl


def _motions(state: Sequence[Any]) -> list[tuple[Any, ...]]:
    """Return for each body R_WB row by row (9), p_WB, w_WB_W and v_WB_W."""
    return [
        (
            rotation(state[at : at + 4]),
            state[at + 4 : at + 7],
            state[at + 7 : at + 10],
            state[at + 10 : at + 13],
        )
        for at in range(0, len(state), 13)
    ]


def _apart(
    row: CableRow, first: Sequence[Any], second: Sequence[Any]
) -> tuple[tuple[Vector3, Vector3], Vector3, Vector3]:
    """Return the arms of both ends in W (3), the vector from A to B, and its rate (3)."""
    arm_A, (xA, yA, zA), (uA, vA, wA) = _end_motion(first, row.places[0])
    arm_B, (xB, yB, zB), (uB, vB, wB) = _end_motion(second, row.places[1])
    return (arm_A, arm_B), (xB - xA, yB - yA, zB - zA), (uB - uA, vB - vA, wB - wA)


def _end_motion(motion: Sequence[Any], place: Vector3) -> tuple[Vector3, Vector3, Vector3]:
    """Return the arm of an end in W, the end, and its velocity, for the motion of its body."""
    R, (x, y, z), w, (u, v, s) = motion
    arm = into_world(R, place)
    turn = cross(w, arm)
    return (
        arm,
        (x + arm[0], y + arm[1], z + arm[2]),
        (u + turn[0], v + turn[1], s + turn[2]),
    )


Cables: TypeAlias = Any
"""An instance of `Cables_`; what fills a template has no type of its own."""
