"""The sensors that a description declares."""

import dataclasses
from collections import Counter

from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.values import shortened
from workbench.plant.frame_tree import WORLD
from workbench.plant.model import DeclaredSensor, Model
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.mount import body_pose, triple
from workbench.plant.sensor_block import Block
from workbench.plant.sensor_frames import sensor_frames
from workbench.plant.sensor_kinds import READERS
from workbench.plant.sensors import Sensor

_FRAMES = ("gz_frame_id", "ignition_frame_id", "frame_id")
_MOST = 1000
_FASTEST = 1e6


def read_sensors(model: Model, base_link: str, remarks: Remarks) -> tuple[Sensor, ...]:
    """Return the sensors of a description, in the file's order.

    Args:
        model: what the description says.
        base_link: whose frame is the body frame B.
        remarks: where to note what was assumed, and sensors that are not used.

    Raises:
        WorkbenchError: with file and line, for a number that cannot be.
    """
    if len(model.sensors) > _MOST:
        raise WorkbenchError(
            f"{model.source}: it declares {len(model.sensors)} sensors: up to {_MOST} are read"
        )
    X_BM = body_pose(model, base_link)
    names = _Names()
    sensors: list[Sensor] = []
    for declared in model.sensors:
        kind = declared.element.get("type", "").strip()
        name = declared.element.get("name", "").strip() or kind
        element = f"sensor '{shortened(name)}'"
        link = model.link(declared.link)
        if kind not in READERS or link is None:
            where = "" if link else ", which is not there"
            text = (
                f"of type {shortened(kind)} on link '{shortened(declared.link)}'{where}; not used"
            )
            remarks.add("ignored", declared.file, element, text)
            continue
        block = Block(declared.file, shortened(name), declared.element)
        X_BS = X_BM @ link.X_ML @ declared.X_LS
        x, y, z = (triple(row) for row in X_BS.rotation().matrix())
        common = Sensor(
            name=names.unique(name, link.name),
            type=kind,
            frame=_asked_frame(block, declared),
            link=link.name,
            rate=_rate(block, declared, element, remarks),
            p_BS=triple(X_BS.translation()),
            R_BS=(x, y, z),
        )
        sensor = READERS[kind](common, block, remarks)
        if sensor:
            sensors.append(sensor)
    # A frame that is in nobody's way has the sensor's name, which is what the tree calls it too.
    others = {WORLD, *(link.name for link in model.links), *(frame.name for frame in model.frames)}
    return tuple(
        sensor if sensor.frame else dataclasses.replace(sensor, frame=names.own)
        for sensor, names in zip(sensors, sensor_frames(sensors, others), strict=True)
    )


class _Names:
    """Names given so far; a second sensor of a name is told apart by its link."""

    def __init__(self) -> None:
        self._given: set[str] = set()
        self._asked: Counter[str] = Counter()

    def unique(self, name: str, link: str) -> str:
        if name in self._given:
            name = f"{link}/{name}"
        stem = name
        while name in self._given:
            self._asked[stem] += 1
            name = f"{stem}_{self._asked[stem] + 1}"
        self._given.add(name)
        return name


def _asked_frame(block: Block, declared: DeclaredSensor) -> str:
    """Return what the file labels readings with, else the link if S lies in it, else nothing."""
    asked = next((text for tag in _FRAMES if (text := block.text(tag))), "")
    in_link = declared.X_LS.IsNearlyEqualTo(RigidTransform(), 1e-12)
    return asked or (declared.link if in_link else "")


def _rate(block: Block, declared: DeclaredSensor, element: str, remarks: Remarks) -> float:
    """Return samples per second; SDF and Gazebo have 0, each step, where it is not given."""
    if not block.has("update_rate"):
        text = "update_rate: not given, the usual one of its kind"
        remarks.add("assumed", declared.file, element, text)
    rate = block.non_negative("update_rate", 0.0)
    if rate > _FASTEST:
        raise block.fault("update_rate", f"give it at most {_FASTEST:g} per second")
    return rate
