"""The drag of body and rotors as a continuous LeafSystem, for linear models."""

import sys
from typing import Any, TypeAlias

from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.framework import BasicVector_, LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from workbench.plant.vehicle import Vehicle
from workbench.systems.air.drag import drag_wrench, rotor_rows


# A template is filled where it is first used: Drake looks through the stack for whose it is, which
# takes a tenth of a second each time within nested imports. Hence `scope`, too.
@TemplateSystem.define("ContinuousDrag_", [float, AutoDiffXd], scope=sys.modules[__name__])
def ContinuousDrag_(T: Any) -> Any:
    """The same drag as `Air` has, at any moment and in the wind that it is given.

    Input ports:
        state (13): q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        speeds (n): of the rotors [rad/s].
        wind (3): velocity of the air in W [m/s]; where nothing is connected, the air is still.
    Output port:
        wrench (6): force [N] and moment about the body's origin [N·m], in B.
    Numeric parameter 0: drag area of the body [m²] and density of the air [kg/m³].
    """

    class Impl(LeafSystem_[T]):
        def _construct(
            self, *, vehicle: Vehicle, drag_area: float, air_density: float, converter: Any = None
        ) -> None:
            LeafSystem_[T].__init__(self, converter)
            self.vehicle = vehicle
            self.drag_area = drag_area
            self.air_density = air_density
            self._rotors = rotor_rows(vehicle.rotors).tolist()
            self.DeclareNumericParameter(BasicVector_[T]([T(drag_area), T(air_density)]))
            self._state = self.DeclareVectorInputPort("state", 13)
            self._speeds = self.DeclareVectorInputPort("speeds", len(vehicle.rotors))
            self._wind = self.DeclareVectorInputPort("wind", 3)
            self.DeclareVectorOutputPort(
                "wrench",
                6,
                self._calc_wrench,
                {self.all_input_ports_ticket(), self.all_parameters_ticket()},
            )

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(
                self,
                vehicle=other.vehicle,
                drag_area=other.drag_area,
                air_density=other.air_density,
                converter=converter,
            )

        def _calc_wrench(self, context: Any, output: Any) -> None:
            wind = self._wind.Eval(context).tolist() if self._wind.HasValue(context) else [0.0] * 3
            area, density = context.get_numeric_parameter(0).CopyToVector().tolist()
            wrench = drag_wrench(
                self._state.Eval(context).tolist(),
                self._speeds.Eval(context).tolist(),
                wind,
                0.5 * density * area,
                self.vehicle.p_BoBcm_B,
                self._rotors,
            )
            output.SetFromVector(wrench)

    return Impl


ContinuousDrag: TypeAlias = Any
"""An instance of `ContinuousDrag_`; what fills a template has no type of its own."""
