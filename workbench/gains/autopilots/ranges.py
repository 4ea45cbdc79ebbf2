"""Ranges that PX4 and ArduPilot state for their own parameters, narrower than a law's rows.

They are advice: a ground station warns beyond them, and manufacturers exceed them. So the workbench
accepts all values that a law's rows allow, and reports those beyond these ranges. Betaflight's are
those of its law, and the Crazyflie states none.

Sources: PX4-Autopilot, mc_rate_control_params.yaml and
multicopter_position_control_gain_params.yaml; ArduPilot, AC_PosControl.cpp, AC_AttitudeControl.cpp,
AC_AttitudeControl_Multi.cpp (@Range). A filter of 0 Hz is off, whatever its range.
"""

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from workbench.common.parameter import Parameter

Ranges = Mapping[str, tuple[float, float]]

PX4: Ranges = MappingProxyType(
    {
        "MPC_Z_P": (0.1, 1.5),
        "MPC_XY_VEL_P_ACC": (1.2, 5.0),
        "MPC_XY_VEL_D_ACC": (0.1, 2.0),
        "MPC_Z_VEL_P_ACC": (2.0, 15.0),
        "MPC_Z_VEL_I_ACC": (0.2, 3.0),
        "MC_ROLLRATE_P": (0.01, 0.5),
        "MC_ROLLRATE_D": (0.0, 0.01),
        "MC_PITCHRATE_P": (0.01, 0.6),
        "MC_YAWRATE_P": (0.0, 0.6),
    }
)


def _of_rates() -> Iterable[tuple[str, tuple[float, float]]]:
    for axis in ("RLL", "PIT", "YAW"):
        yaw = axis == "YAW"
        name = f"ATC_RAT_{axis}_"
        yield f"{name}P", (0.1, 2.5) if yaw else (0.01, 0.5)
        yield f"{name}I", (0.01, 1.0) if yaw else (0.01, 2.0)
        yield f"{name}D", (0.0, 0.02) if yaw else (0.0, 0.05)
        yield f"{name}FLTT", (1.0, 50.0) if yaw else (5.0, 100.0)
        yield f"{name}FLTE", (0.0, 20.0) if yaw else (0.0, 100.0)
        yield f"{name}FLTD", (5.0, 50.0) if yaw else (5.0, 100.0)
        yield f"ATC_ANG_{axis}_P", (3.0, 12.0)


ARDUPILOT: Ranges = MappingProxyType(
    {
        "PSC_NE_POS_P": (0.5, 4.0),
        "PSC_NE_VEL_P": (0.1, 10.0),
        "PSC_NE_VEL_I": (0.1, 10.0),
        "PSC_D_POS_P": (0.5, 4.0),
        "PSC_D_VEL_P": (1.0, 10.0),
        "PSC_D_VEL_IMAX": (1.0, 10.0),
        "PSC_D_ACC_P": (0.01, 0.25),
        "PSC_D_ACC_FLTT": (1.0, 50.0),
        "PSC_D_ACC_FLTE": (1.0, 100.0),
        "PSC_D_ACC_FLTD": (1.0, 100.0),
        **dict(_of_rates()),
    }
)


def beyond(ranges: Ranges, rows: Iterable[Parameter], values: Mapping[str, float]) -> list[str]:
    """Return values beyond the firmware's own ranges, as `NAME 0.8 (0.01 .. 0.5)`."""
    found = []
    for row in rows:
        if row.name not in ranges or row.name not in values:
            continue
        value, (least, most) = values[row.name], ranges[row.name]
        off = row.unit == "Hz" and value == 0.0
        if not (least <= value <= most or off or value == row.default):
            found.append(f"{row.name} {value:.4g} ({least:g} .. {most:g})")
    return found
