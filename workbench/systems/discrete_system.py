"""The base of Python's systems without continuous state."""

from pydrake.systems.framework import Context, ContinuousState, LeafSystem


class DiscreteSystem(LeafSystem):
    """A system without continuous state.

    Drake asks each system for its derivatives at each stage of a step. Without this method Drake's
    bindings look for one in Python each time, which takes 2 µs a system: a quarter of a flight's
    time.
    """

    def DoCalcTimeDerivatives(self, context: Context, derivatives: ContinuousState) -> None:
        """Calculate nothing."""
