"""A drone in one line: its mass, and the distance of its four rotors from the middle."""

from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.plant.model import Inertial, Link, Model
from workbench.plant.readers import DescriptionFormat, RotorDialect
from workbench.plant.rotors import Rotor


def read_frame(path, root, finder, remarks):
    """Return the model in a file; it has no root element, as it is not XML."""
    try:
        mass, arm = map(float, path.read_text(encoding="utf-8").split())
    except (OSError, ValueError) as error:
        raise WorkbenchError(f"{path}: give it a mass and a distance ({error})") from error
    turned = mass * arm**2 / 6.0
    inertial = Inertial(mass, RigidTransform(), (turned, turned, 2.0 * turned), (0.0, 0.0, 0.0))
    hub = Link("base_link", RigidTransform(), inertial, (), ())
    return Model(path, path.stem, (hub,), (), (), (), (), properties=(("frame_arm", str(arm)),))


def declares(model):
    """Return whether a model is from such a file."""
    return "frame_arm" in dict(model.properties)


def read_rotors(model, base_link, remarks):
    """Return four rotors that can lift three times the weight."""
    arm = float(dict(model.properties)["frame_arm"])
    mass, speed = model.links[0].inertial.mass, 900.0
    remarks.add(
        "assumed", model.source, "rotors", f"thrust of 3 times the weight at {speed:g} rad/s"
    )
    return tuple(
        Rotor(
            name=f"rotor_{number}",
            joint="",
            link=base_link,
            p_BR=(arm * x, arm * y, 0.0),
            axis_B=(0.0, 0.0, 1.0),
            direction=1 if number % 2 else -1,
            motor_constant=3.0 * mass * 9.81 / 4.0 / speed**2,
            moment_constant=0.016,
            time_constant_up=0.02,
            time_constant_down=0.02,
            max_rot_velocity=speed,
        )
        for number, (x, y) in enumerate(((0.7, 0.7), (-0.7, 0.7), (-0.7, -0.7), (0.7, -0.7)))
    )


FRAME = DescriptionFormat(read_frame, suffixes=(".frame",))
ROTORS = RotorDialect(declares, read_rotors, "properties")
