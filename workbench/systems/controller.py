"""The cascaded controller as a LeafSystem: one port of inputs around the pure control law."""

from typing import Any

from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.framework import LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from workbench.plant.rotors import allocation_matrix
from workbench.plant.vehicle import Vehicle
from workbench.systems.cascade import (
    Gains,
    Guidance,
    Reference,
    wanted_specific_force,
    wanted_velocity,
    wanted_wrench,
)
from workbench.systems.mixer import mix

IDLE_SPEED_SHARE = 0.1
"""Armed rotors turn at this share of their largest speed, and never slower while flying."""

INPUT_SIZES = {
    "state": 13,
    "acceleration": 3,
    "reference": len(Reference._fields),
    "guidance": len(Guidance._fields),
    "gains": len(Gains._fields),
}
"""What the controller's input is stacked of, in this order."""

_ACCELERATION = 13
_REFERENCE = _ACCELERATION + 3
_GUIDANCE = _REFERENCE + len(Reference._fields)
_GAINS = _GUIDANCE + len(Guidance._fields)


@TemplateSystem.define("CascadedController_", T_list=[float, AutoDiffXd])
def CascadedController_(T: Any) -> Any:
    """Velocity PD -> attitude PD -> mixer, without state or time of its own.

    Input port:
        signals: stacked, because every port read from Python costs as much as the law itself:
            state (13): q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s];
            acceleration (3): estimate in W [m/s²]; reference (8), guidance (9) and gains (18):
            see `cascade`.
    Output port:
        rotor_speeds (n): commanded speeds [rad/s].
    """

    class Impl(LeafSystem_[T]):  # type: ignore[misc,valid-type]
        def _construct(self, *, vehicle: Vehicle, converter: Any = None) -> None:
            LeafSystem_[T].__init__(self, converter)
            self.vehicle = vehicle
            inertia = vehicle.inertia
            self._mass = vehicle.mass
            self._inertia = (*inertia[0].tolist(), *inertia[1, 1:].tolist(), float(inertia[2, 2]))
            self._allocation = allocation_matrix(vehicle.rotors, vehicle.p_BoBcm_B).tolist()
            self._constants = [rotor.motor_constant for rotor in vehicle.rotors]
            self._max_thrusts = [rotor.max_thrust for rotor in vehicle.rotors]
            self._idle_thrusts = [IDLE_SPEED_SHARE**2 * t for t in self._max_thrusts]
            self._signals = self.DeclareVectorInputPort("signals", sum(INPUT_SIZES.values()))
            self.DeclareVectorOutputPort(
                "rotor_speeds",
                len(vehicle.rotors),
                self._calc_rotor_speeds,
                {self._signals.ticket()},
            )

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(self, vehicle=other.vehicle, converter=converter)

        def _calc_rotor_speeds(self, context: Any, output: Any) -> None:
            signals = self._signals.Eval(context).tolist()
            guidance = signals[_GUIDANCE:_GAINS]
            motors = guidance[0]
            thrusts = list(self._idle_thrusts)
            if guidance[1] > 0.0:
                gains = signals[_GAINS:]
                wanted = wanted_velocity(
                    signals[4:7], signals[_REFERENCE:_GUIDANCE], guidance, gains
                )
                f_W = wanted_specific_force(
                    signals[10:13], signals[_ACCELERATION:_REFERENCE], wanted, gains
                )
                force, m_x, m_y, m_z = wanted_wrench(
                    signals[:4], signals[7:10], f_W, wanted[3], self._mass, self._inertia, gains
                )
                mix(
                    force,
                    m_x,
                    m_y,
                    m_z,
                    self._allocation,
                    self._idle_thrusts,
                    self._max_thrusts,
                    thrusts,
                )
            output.SetFromVector(
                [motors * (f / k) ** 0.5 for f, k in zip(thrusts, self._constants, strict=True)]
            )

    return Impl


CascadedController = CascadedController_[None]
