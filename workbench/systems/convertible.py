"""Systems in Python that Drake converts to AutoDiffXd, for exact linear models."""

import sys
from collections.abc import Callable
from typing import Any

from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.framework import LeafSystem, LeafSystem_, SystemScalarConverter
from pydrake.systems.scalar_conversion import TemplateSystem


def convertible(make: Callable[[type], type[LeafSystem]]) -> TemplateSystem:
    """Return the template of a system, `NAME_`, with the instances `NAME_[float]` and AutoDiffXd.

    A conversion makes the other instance from the same arguments, which are `arguments`.

    Args:
        make: a function `NAME_` from the scalar type to a class. The class has the method `declare`
            in place of a constructor; its arguments are keywords.
    """

    def instance(T: type) -> type[LeafSystem]:
        system, base = make(T), LeafSystem_[T]

        def construct(
            self: Any, converter: SystemScalarConverter | None = None, **arguments: object
        ) -> None:
            base.__init__(self, converter)
            self.arguments = arguments
            self.declare(**arguments)

        def construct_copy(
            self: LeafSystem, other: LeafSystem, converter: SystemScalarConverter | None = None
        ) -> None:
            construct(self, converter, **vars(other)["arguments"])

        system._construct = construct
        system._construct_copy = construct_copy
        if "DoCalcTimeDerivatives" not in vars(system):  # see `DiscreteSystem`
            system.DoCalcTimeDerivatives = base.CalcTimeDerivatives
        return system

    # The template is filled where it is first used, and Drake looks through the stack for whose it
    # is, which takes a tenth of a second within nested imports: hence `scope`.
    scope = sys.modules[make.__module__]
    return TemplateSystem.define(make.__name__, [float, AutoDiffXd], scope=scope)(instance)
