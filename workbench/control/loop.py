"""A loop of a control law, and where it can be cut."""

from dataclasses import dataclass

from workbench.common.errors import unknown_name

LOOP_CUTS = ("actuator", "error")
LOOP_AXES = ("x", "y", "z", "yaw")


def loop_label(name: str) -> str:
    """Return a loop's name in words."""
    return name.replace("_", " ")


@dataclass(frozen=True)
class Loop:
    """One loop of a controller.

    Attributes:
        name: of the controlled quantity.
        error: the loop point of its error.
        actuator: the loop point of its output to the loop inside it; the error by default.
        hold: whether it is closed only while a position is held.
        axis: x, y, z or yaw: the step that goes through it, "" for none.
        gains: names of the parameters that a search may change for it.
        compares: what it compares, as text.
    """

    name: str
    error: str
    actuator: str = ""
    hold: bool = False
    axis: str = ""
    gains: tuple[str, ...] = ()
    compares: str = ""

    def point(self, cut: str) -> str:
        """Return the loop point of a cut, `actuator` or `error`.

        Raises:
            WorkbenchError: if it is neither.
        """
        if cut not in LOOP_CUTS:
            raise unknown_name("place to cut a loop", cut, LOOP_CUTS)
        return self.error if cut == "error" else self.actuator or self.error
