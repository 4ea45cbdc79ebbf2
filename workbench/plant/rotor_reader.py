"""The rotors of a description, from whichever way of writing them it uses."""

from pathlib import Path

from workbench.plant.model import DeclaredPlugin, Model
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.mjcf_actuators import read_mjcf_actuators
from workbench.plant.rotor_sources.motor_plugins import is_motor_plugin, read_motor_plugins
from workbench.plant.rotor_sources.names import same_name
from workbench.plant.rotor_sources.pybullet import is_pybullet, read_pybullet
from workbench.plant.rotor_sources.sidecar import read_sidecar
from workbench.plant.rotor_sources.sidecar_file import find_sidecar
from workbench.plant.rotor_sources.velocity_plugin import (
    is_velocity_plugin,
    read_velocity_plugin,
    velocity_plugin_joints,
)
from workbench.plant.rotors import Rotor


def read_rotors(
    model: Model, base_link: str, remarks: Remarks, sidecar: Path | None = None
) -> tuple[Rotor, ...]:
    """Return the rotors that a description or the sidecar beside it declares, or none.

    Of several ways in one description the one that says most counts: sidecar, motor-model
    plugins, the paper's plugin block, gym-pybullet-drones' properties, MuJoCo's actuators.

    Args:
        model: what the description says.
        base_link: whose frame is the body frame B.
        remarks: where to note what was assumed, and what was there besides.
        sidecar: a file of rotors that was asked for, instead of one that lies beside.

    Raises:
        WorkbenchError: with file and line, where rotors are declared and cannot be read.
    """
    sidecar = sidecar or find_sidecar(model.source)
    if sidecar:
        if _declares_rotors(model):
            text = f"they are those of {sidecar.name}; its own are not used"
            remarks.add("ignored", model.source, "rotors", text)
        return read_sidecar(sidecar, model, base_link, remarks)
    blocks = [plugin for plugin in model.plugins if is_velocity_plugin(plugin)]
    rotors = read_motor_plugins(model, base_link, remarks)
    if len(blocks) > 1:
        text = "there are several; only the first counts"
        remarks.add("ignored", blocks[1].file, "velocity plugin", text)
    if rotors:
        _note_others(model, rotors, blocks[:1], remarks)
        return rotors
    if blocks:
        return read_velocity_plugin(model, blocks[0], base_link, remarks)
    if is_pybullet(model):
        return read_pybullet(model, base_link, remarks)
    return read_mjcf_actuators(model, base_link, remarks)


def _declares_rotors(model: Model) -> bool:
    return (
        bool(model.actuators)
        or is_pybullet(model)
        or any(is_motor_plugin(plugin) or is_velocity_plugin(plugin) for plugin in model.plugins)
    )


def _note_others(
    model: Model, rotors: tuple[Rotor, ...], blocks: list[DeclaredPlugin], remarks: Remarks
) -> None:
    """Note what tells of rotors besides motor-model plugins, where it says something else."""
    for block in blocks:
        named = velocity_plugin_joints(block)
        if not all(any(same_name(name, rotor.joint) for rotor in rotors) for name in named):
            text = "it names joints that no motor-model plugin turns; these plugins count"
            remarks.add("ignored", block.file, "velocity plugin", text)
    if is_pybullet(model):
        text = "they tell of rotors, and so do motor-model plugins; these count"
        remarks.add("ignored", model.source, "properties", text)
