"""Propellers that turn in the picture.

The dynamics treat rotors as part of the body. For drawing, a separate geometry source has their
shapes, turned by the integral of their speeds.
"""

import math
from typing import Any

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.common.value import AbstractValue, Value
from pydrake.geometry import (
    FrameId,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    Role,
    SceneGraph,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    DiscreteValues,
    OutputPort,
)

from workbench.plant.gathered import link_of
from workbench.plant.rotors import Rotor
from workbench.plant.vehicle import Vehicle
from workbench.systems.cached import cached
from workbench.systems.discrete_system import DiscreteSystem
from workbench.systems.weak_callback import weakly


class PropellerDisplay(DiscreteSystem):
    """Turns the propellers' shapes about their rotors' axes, as fast as the rotors turn.

    Their frames are fixed to a frame that moves with the base link. The scene graph asks for all
    poses at each physics step, because contact needs some of them; then only that frame's pose is
    computed.

    Input ports:
        state (13): of the plant.
        speeds (m): whose first n are the rotors' speeds [rad/s].
    Output port:
        poses: a `FramePoseVector` for the scene graph.

    Args:
        vehicle: which has the rotors.
        turning: numbers of those that are drawn, see `turning_rotors`.
        body: the scene graph's frame that goes with the base link.
        frames: the scene graph's frame for each of these, on `body`.
        size: of the speeds port, m.
        period: between pictures [s].
    """

    def __init__(
        self,
        *,
        vehicle: Vehicle,
        turning: list[int],
        body: FrameId,
        frames: list[FrameId],
        size: int,
        period: float,
    ) -> None:
        super().__init__()
        rotors = [vehicle.rotors[index] for index in turning]
        self._turning = turning
        self._body, self._frames = body, frames
        self._period = period
        self._places = [_place(vehicle, rotor) for rotor in rotors]
        self._turns = np.array([r.direction / r.velocity_slowdown for r in rotors])
        self._state = self.DeclareVectorInputPort("state", 13)
        self._speeds = self.DeclareVectorInputPort("speeds", size)
        self.DeclareDiscreteState(len(rotors))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)
        self._turned = cached(self._calc_turned, "X_BL", {self.xd_ticket()})
        self.DeclareAbstractOutputPort(
            "poses",
            lambda: Value(FramePoseVector()),
            weakly(self._calc_poses),
            {self._state.ticket(), self.xd_ticket()},
        )

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        """Turn on by the present speeds, slowed down as the description asks."""
        angles = context.get_discrete_state(0).CopyToVector()
        speeds = self._speeds.Eval(context)[self._turning]
        turned = angles + self._period * self._turns * speeds
        discrete_state.set_value(np.fmod(turned, 2.0 * math.pi))

    def _calc_turned(self, context: Context) -> tuple[RigidTransform, ...]:
        angles = context.get_discrete_state(0).CopyToVector()
        turns = (RigidTransform(RotationMatrix.MakeZRotation(angle)) for angle in angles)
        places = zip(self._places, turns, strict=True)
        return tuple(X_BR @ turn @ X_RL for (X_BR, X_RL), turn in places)

    def _calc_poses(self, context: Context, output: AbstractValue) -> None:
        state = self._state.Eval(context)
        q_WB = state[:4] / math.sqrt(state[:4] @ state[:4])
        poses = output.get_mutable_value()
        # By keyword: by position, pydrake tries every other constructor first, for 60 µs.
        X_WB = RigidTransform(quaternion=Quaternion(wxyz=q_WB), p=state[4:7])
        poses.set_value(self._body, X_WB)
        turned = self._turned(context)
        for frame, X_BL in zip(self._frames, turned, strict=True):
            poses.set_value(frame, X_BL)


def add_propeller_display(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    vehicle: Vehicle,
    state: OutputPort,
    speeds: OutputPort,
    *,
    period: float,
) -> PropellerDisplay:
    """Take the propellers' shapes off the plant and draw them turning.

    Args:
        builder: of the diagram.
        plant: which has the shapes.
        scene_graph: in which they are.
        vehicle: whose rotors to draw.
        state: see `PropellerDisplay`.
        speeds: see `PropellerDisplay`.
        period: between pictures [s].
    """
    source = scene_graph.RegisterSource("propellers")
    turning = turning_rotors(vehicle)
    body = scene_graph.RegisterFrame(source, GeometryFrame("propellers"))
    frames = [
        _move_shapes(plant, scene_graph, (source, body), vehicle, vehicle.rotors[index])
        for index in turning
    ]
    display = builder.AddNamedSystem(
        "propeller_display",
        PropellerDisplay(
            vehicle=vehicle,
            turning=turning,
            body=body,
            frames=frames,
            size=speeds.size(),
            period=period,
        ),
    )
    builder.Connect(state, display.GetInputPort("state"))
    builder.Connect(speeds, display.GetInputPort("speeds"))
    builder.Connect(display.get_output_port(), scene_graph.get_source_pose_port(source))
    return display


def turning_rotors(vehicle: Vehicle) -> list[int]:
    """Return the numbers of the rotors that have a link of their own to turn."""
    links: list[str] = []
    turning = []
    for index, rotor in enumerate(vehicle.rotors):
        if rotor.joint and rotor.link not in (vehicle.base_link, *links):
            turning.append(index)
            links.append(rotor.link)
    return turning


def _place(vehicle: Vehicle, rotor: Rotor) -> tuple[RigidTransform, RigidTransform]:
    """Return X_BR, with z along the rotor's axis, and X_RL of its link L."""
    R_BR = RotationMatrix.MakeFromOneVector(np.array(rotor.axis_B), axis_index=2)
    X_BR = RigidTransform(R_BR, np.array(rotor.p_BR))
    return X_BR, X_BR.inverse() @ _link_pose(vehicle, rotor)


def _link_pose(vehicle: Vehicle, rotor: Rotor) -> RigidTransform:
    """Return X_BL of a rotor's link L."""
    frame = vehicle.frame(rotor.link)
    return RigidTransform(RotationMatrix(np.array(frame.R_BF)), np.array(frame.p_BF))


def _move_shapes(
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    parent: tuple[Any, FrameId],
    vehicle: Vehicle,
    rotor: Rotor,
) -> FrameId:
    """Copy a rotor link's drawn shapes to a frame on `parent`, and draw the old ones no more.

    The parent is a source and its frame.
    """
    source, body = parent
    frame = scene_graph.RegisterFrame(source, body, GeometryFrame(rotor.name))
    inspector = scene_graph.model_inspector()
    base = plant.GetBodyByName(vehicle.base_link)
    drone = plant.GetModelInstanceName(base.model_instance())
    X_LB = _link_pose(vehicle, rotor).inverse()
    for geometry in plant.GetVisualGeometriesForBody(base):
        if link_of(inspector.GetName(geometry), drone) != rotor.link:
            continue
        shape, X_LG = inspector.GetShape(geometry), X_LB @ inspector.GetPoseInFrame(geometry)
        copy = GeometryInstance(X_LG, shape, f"{rotor.name}_{inspector.GetName(geometry)}")
        copy.set_illustration_properties(inspector.GetIllustrationProperties(geometry))
        scene_graph.RegisterGeometry(source, frame, copy)
        # Sensors go on seeing what they would without a picture, hence no perception role here.
        scene_graph.RemoveRole(plant.get_source_id(), geometry, Role.kIllustration)
    return frame
