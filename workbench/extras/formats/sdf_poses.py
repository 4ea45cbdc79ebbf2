"""Resolve the poses of the frames of a model, and the link of each frame."""

from pydrake.math import RigidTransform

from workbench.extras.formats.sdf_node import FRAME_SEMANTICS_VERSION, Node, known_names, node_pose
from workbench.extras.formats.sdf_tree import (
    MAX_SDF_MODEL_DEPTH,
    MODEL_FRAME_NAME,
    SdfFrame,
    SdfTree,
)
from workbench.plant.formats.values import shortened_text
from workbench.plant.remarks import Remarks

SDF_WORLD_FRAME = "world"
_JOINT_KEY_SUFFIX = "\njoint"
"""End of the key of a joint frame, as in old files a joint may have the name of a link."""


class Poses:
    """The frames of a model by full name; M is the model frame."""

    def __init__(self, tree: SdfTree, remarks: Remarks) -> None:
        """Add all frames.

        Args:
            tree: the model.
            remarks: receives remarks on repairs.

        Raises:
            WorkbenchError: naming the second of two frames with one name.
        """
        self._remarks = remarks
        self._frames: dict[str, SdfFrame] = {}
        self._X_MF = {MODEL_FRAME_NAME: RigidTransform()}
        self._links = {link.full_name: link.full_name for link in tree.links} | {
            SDF_WORLD_FRAME: SDF_WORLD_FRAME
        }
        self._placing: list[str] = []
        for model in tree.models:
            self._add(model)
        for link in tree.links:
            if link.full_name == SDF_WORLD_FRAME:
                raise link.fault("a link cannot be called 'world': rename it")
            self._add(
                SdfFrame(link.full_name, link, link.child("pose"), MODEL_FRAME_NAME, link, "")
            )
        for frame in tree.frames:
            carrier = frame.attribute("attached_to") or MODEL_FRAME_NAME
            pose = frame.child("pose")
            self._add(SdfFrame(frame.full_name, frame, pose, carrier, frame, carrier))
        for joint in tree.joints:
            child = joint_end(joint, "child")
            self._add(SdfFrame(joint_key(joint), joint, joint.child("pose"), child, joint, child))

    def _add(self, frame: SdfFrame) -> None:
        """Add a frame with a unique name."""
        name = frame.name
        twin = self._frames.get(name) or self._frames.get(f"{name}::{MODEL_FRAME_NAME}")
        plain, mark, _ = name.partition(_JOINT_KEY_SUFFIX)
        if mark and frame.owner.version >= FRAME_SEMANTICS_VERSION:
            # Before, joints could not be referred to, and could have the name of a link.
            twin = (
                twin or self._frames.get(plain) or self._frames.get(f"{plain}::{MODEL_FRAME_NAME}")
            )
        if twin:
            line = f" (the other is in {twin.owner.file}:{twin.owner.element.line})"
            raise frame.owner.fault(
                f"two have the name '{shortened_text(plain)}' in one model{line}: rename one"
            )
        self._frames[name] = frame

    def find(self, words: Node, name: str) -> str:
        """Return the full name for a name in an element.

        Raises:
            WorkbenchError: naming file and line, with similar names, if it is unknown.
        """
        full = self._look_up(words, name) or self._without_scope(words, name)
        if full is None:
            raise words.fault(
                f"{words.title} refers to '{shortened_text(name)}', which is not a link, joint, "
                "frame "
                "or model here: " + known_names(name, self._names_in(words.scope))
            )
        return full

    def _look_up(self, words: Node, name: str) -> str | None:
        """Return the full name for a name in an element, or None."""
        if name == MODEL_FRAME_NAME:
            return words.model
        if name == SDF_WORLD_FRAME:
            return SDF_WORLD_FRAME
        full = words.scope + name
        keys = (full, f"{full}::{MODEL_FRAME_NAME}", full + _JOINT_KEY_SUFFIX)
        return next((key for key in keys if key in self._frames), None)

    def _without_scope(self, words: Node, name: str) -> str | None:
        """Return the full name for a name without its unknown scope, in old files.

        Gazebo classic accepts `iris::base_link` in a model of any name.
        """
        scope, mark, bare = name.rpartition("::")
        if not mark or words.version >= FRAME_SEMANTICS_VERSION:
            return None
        full = self._look_up(words, bare)
        if full is not None:
            text = (
                f"'{shortened_text(name)}' is taken as '{shortened_text(bare)}': there is no "
                f"'{scope}' here"
            )
            self._remarks.add("repaired", words.file, words.title, text)
        return full

    def _names_in(self, scope: str) -> set[str]:
        """Return the names that can be used in a scope."""
        return {
            name.removeprefix(scope)
            .removesuffix(_JOINT_KEY_SUFFIX)
            .removesuffix(f"::{MODEL_FRAME_NAME}")
            for name in self._frames
            if name.startswith(scope) and "\n" not in name.removesuffix(_JOINT_KEY_SUFFIX)
        }

    def X_MF(self, name: str) -> RigidTransform:
        """Return the pose of a frame F.

        Args:
            name: its full name.

        Raises:
            WorkbenchError: naming file and line, if poses are relative to each other in a circle.
        """
        way: dict[str, str] = {}  # the base of each frame
        step = name
        while step not in self._X_MF:
            if step == SDF_WORLD_FRAME:
                self._X_MF[SDF_WORLD_FRAME] = self._X_BF(MODEL_FRAME_NAME).inverse()
                break
            if step in way:
                raise self._frames[step].owner.fault(
                    f"the pose of {self._frames[step].owner.title} is relative to itself, through "
                    "relative_to, attached_to or joints: break the loop"
                )
            way[step] = self._base(step)
            step = way[step]
        for frame, base in reversed(way.items()):
            self._X_MF[frame] = self._X_MF[base] @ self._X_BF(frame)
        return self._X_MF[name]

    def X_LF(self, part: Node, link: str) -> RigidTransform:
        """Return the pose of a part F of a link L, such as a visual.

        If its reference frame does not exist, it is relative to the link. Gazebo also shows such a
        model.

        Args:
            part: its element.
            link: the full name of the link.
        """
        pose = part.child("pose")
        base = _relative_to(pose)
        if not pose or not base:
            return node_pose(pose)
        full = self._look_up(pose, base)
        if full is None:
            self._remarks.add(
                "repaired",
                part.file,
                f"{part.title} of link '{link}'",
                f"its pose is relative to '{shortened_text(base)}', which does not exist; taken "
                "relative to the link",
            )
            return node_pose(pose)
        return self.X_MF(link).inverse() @ self.X_MF(full) @ node_pose(pose)

    def link_of(self, name: str) -> str:
        """Return the full name of the link that a frame is attached to, or `world`.

        Args:
            name: full name of the frame.

        Raises:
            WorkbenchError: naming file and line, if frames are attached to each other in a circle,
                or to a model without a link.
        """
        way: set[str] = set()
        while name not in self._links:
            frame = self._frames[name]
            if name in way:
                raise frame.inside.fault(
                    f"{frame.owner.title} is attached to itself, through attached_to or joints: "
                    "break the loop"
                )
            if not frame.carrier:
                raise frame.inside.fault(f"{frame.owner.title} has no link: add one")
            way.add(name)
            name = self.find(frame.inside, frame.carrier)
        link = self._links[name]
        self._links |= dict.fromkeys(way, link)
        return link

    def _base(self, name: str) -> str:
        """Return the full name of the reference frame of the pose of a frame."""
        frame = self._frames[name]
        return self.find(frame.pose or frame.owner, _relative_to(frame.pose) or frame.base)

    def _X_BF(self, name: str) -> RigidTransform:
        """Return the pose of a frame F in the reference frame B of its pose."""
        frame = self._frames[name]
        X_BP = node_pose(frame.pose)
        if not frame.placement:
            return X_BP
        if name in self._placing or len(self._placing) > MAX_SDF_MODEL_DEPTH:
            raise frame.inside.fault(
                f"the placement frames of {frame.owner.title} and models near it depend on one "
                "another: place one of them by its own frame"
            )
        self._placing.append(name)
        X_FP = self._X_in(self.find(frame.inside, frame.placement), name)
        self._placing.pop()
        return X_BP @ X_FP.inverse()

    def _X_in(self, name: str, model: str) -> RigidTransform:
        """Return the pose of a placement frame P in the frame F of its model."""
        X_FP = RigidTransform()
        way: set[str] = set()
        while name != model:
            if name in way or name in (MODEL_FRAME_NAME, SDF_WORLD_FRAME):
                frame = self._frames[model]
                raise frame.inside.fault(
                    f"the placement frame of {frame.owner.title} has no pose in it: use one that "
                    "is relative to the model or one of its links"
                )
            way.add(name)
            X_FP = self._X_BF(name) @ X_FP
            name = self._base(name)
        return X_FP


def joint_key(joint: Node) -> str:
    """Return the key of a joint frame, which no link can have."""
    return joint.full_name + _JOINT_KEY_SUFFIX


def joint_end(joint: Node, end: str) -> str:
    """Return the name of the parent or child in a joint.

    Raises:
        WorkbenchError: if it is missing.
    """
    node = joint.child(end)
    name = (node.text or node.attribute("link")) if node else ""
    if not name:
        raise joint.fault(f"{joint.title} has no <{end}>: name a link")
    return name


def _relative_to(pose: Node | None) -> str:
    """Return the name of the reference frame in a `<pose>`, or ""."""
    if not pose:
        return ""
    old = pose.attribute("frame") if pose.version < FRAME_SEMANTICS_VERSION else ""
    return pose.attribute("relative_to") or old
