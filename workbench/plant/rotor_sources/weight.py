"""What the rotors of a model have to lift."""

from workbench.common.errors import WorkbenchError
from workbench.plant.model import Model


def total_mass(model: Model) -> float:
    """Return the mass of all links [kg].

    Raises:
        WorkbenchError: if there is none.
    """
    mass = sum(link.inertial.mass for link in model.links if link.inertial)
    if not mass > 0.0:
        raise WorkbenchError(
            f"{model.source}: no link has a mass, and the rotors' constants depend on it: give the "
            "base link an inertial with a mass"
        )
    return mass
