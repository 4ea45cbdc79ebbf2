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
        state (13 k): of each body L: q_WL (w, x, y, z), p_WL [m], w_WL_W [rad/s], v_WL_W [m/s].
    Output ports:
        spatial_forces: on each body (k), at its origin, for the plant.
        tensions (c): of the cables [N].
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
                arm_A_W, p_WA, v_WA = _end_motion(motions[first], row.places[0])
                arm_B_W, p_WB, v_WB = _end_motion(motions[second], row.places[1])
                p_AB_W = [b - a for a, b in zip(p_WA, p_WB, strict=True)]
                v_AB_W = [b - a for a, b in zip(v_WA, v_WB, strict=True)]
                distance = sum(x * x for x in p_AB_W) ** 0.5
                stretch = distance - row.length
                tension = 0.0 * state[0]
                if not (opened and row.hooked) and stretch > -TAUT_TOLERANCE_M:
                    n_W = [x / distance for x in p_AB_W]
                    speed = sum(n * v for n, v in zip(n_W, v_AB_W, strict=True))
                    pull = row.stiffness * stretch + row.damping * speed
                    # at rest at its length a cable is taut, so that it has a linear model there
                    tension = pull if pull > -row.stiffness * TAUT_TOLERANCE_M else tension
                    f_W = [tension * x for x in n_W]
                    for body, arm_W, sign in ((first, arm_A_W, 1.0), (second, arm_B_W, -1.0)):
                        F_W = [*cross(arm_W, f_W), *f_W]
                        loads[body] = [a + sign * b for a, b in zip(loads[body], F_W, strict=True)]
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
                    for body, p_LE in zip(ends, row.places, strict=True)
                    for x in _end_motion(motions[body], p_LE)[1]
                ]
            )

        def _calc_tensions(self, context: Context, output: BasicVector) -> None:
            output.SetFromVector(self._loads(context)[0])

    return Impl


def _motions(state: Sequence[Any]) -> list[tuple[Any, ...]]:
    """Return for each body L R_WL row by row (9), p_WL, w_WL and v_WL in W."""
    return [
        (
            rotation(state[at : at + 4]),
            state[at + 4 : at + 7],
            state[at + 7 : at + 10],
            state[at + 10 : at + 13],
        )
        for at in range(0, len(state), 13)
    ]


def _end_motion(
    motion: Sequence[Any], p_LE: Vector3
) -> tuple[Vector3, Sequence[Any], Sequence[Any]]:
    """Return p_LE_W, p_WE and v_WE of the end E of a cable, for the motion of its body L."""
    R_WL, p_WL, w_WL, v_WL = motion
    p_LE_W = into_world(R_WL, p_LE)
    p_WE = [a + b for a, b in zip(p_WL, p_LE_W, strict=True)]
    v_WE = [a + b for a, b in zip(v_WL, cross(w_WL, p_LE_W), strict=True)]
    return p_LE_W, p_WE, v_WE


Cables: TypeAlias = Any
"""An instance of `Cables_`; what fills a template has no type of its own."""
