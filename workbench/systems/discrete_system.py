"""The base of Python's systems without continuous state."""

from pydrake.systems.framework import LeafSystem


class DiscreteSystem(LeafSystem):
    """A system without continuous state.

    Drake asks each system for its derivatives at each stage of a step. Its bindings then look for
    a method of this name in Python, for 2 µs a system, or a quarter of a flight's time, unless they
    remember that the name stands for one of C++. They never call it.
    """

    DoCalcTimeDerivatives = LeafSystem.CalcTimeDerivatives
