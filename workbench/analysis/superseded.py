"""What becomes of a question that waits when a newer one of its kind comes."""

from workbench.common.errors import WorkbenchError


class SupersededError(WorkbenchError):
    """A newer question took the place of this one; nobody need be told."""

    def __init__(self) -> None:
        super().__init__("a newer question of this kind took its place")
