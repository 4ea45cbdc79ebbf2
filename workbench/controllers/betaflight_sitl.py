"""Betaflight 4.6 itself, as a separate program, below the outer loop of `betaflight`.

Angles and throttle of that loop, and the yaw rate, are stick inputs of the firmware, in angle mode,
or in rate mode if `acro` is 1. From these and the motion the firmware computes four motor signals;
a speed controller converts a full signal to `motor_speed`. Parameters are those of `betaflight`
that MSP can set and read back. See docs/betaflight-sitl.md.
"""

import logging
from collections.abc import Mapping
from typing import Any

from workbench.autopilots.betaflight import (
    GAINS,
    LEAST,
    MOST,
    Betaflight,
    Sticks,
    betaflight_program,
    motion_packet,
)
from workbench.common.errors import WorkbenchError
from workbench.control.betaflight_outer import DEGREES, outer_loop
from workbench.control.controller import COMMON
from workbench.controllers import (
    GRAVITY,
    State,
    arctan2,
    attitude_matrix,
    into_body,
    level_heading,
    position_error,
    velocity_setpoint,
)
from workbench.controllers import betaflight as law

PERIOD = law.PERIOD
DIVIDERS = law.DIVIDERS
BASE = 8000.0
"""Rate of its gyro; the time between packets is a whole number of gyro periods [Hz]."""
RATE = 670.0
"""Rate for a full stick in rate mode [deg/s]."""
CHECK = 1050.0
"""Lowest throttle stick [us]."""
IDLE = 0.055
"""Motor signal at zero throttle."""
OURS = ("acro", "motor_speed")
PARAMETERS = tuple(
    row
    for row in law.PARAMETERS
    if row.name in GAINS or row.name in OURS or row.name.startswith("outer_")
)
MEMORY = (
    *(State(f"outer_i_{k}", "m/s^2") for k in "xyz"),
    State("angle_x", "deg"),
    State("angle_y", "deg"),
    State("throttle", "1"),
    State("flies", "1"),
)

SETTINGS: Mapping[str, object] = {
    "acc_calibration": "0,0,0,1",
    "baro_hardware": "NONE",
    "mag_hardware": "NONE",
    "pwr_on_arm_grace": 0,
    "small_angle": 180,
    "auto_disarm_delay": 0,
    "runaway_takeoff_prevention": "OFF",
    "simplified_pids_mode": "OFF",
    "rc_smoothing": "OFF",
    "rates_type": "ACTUAL",
    **{f"{axis}_{name}": 67 for axis in ("roll", "pitch", "yaw") for name in ("rc_rate", "srate")},
    **{f"{axis}_expo": 0 for axis in ("roll", "pitch", "yaw")},
    "blackbox_device": "VIRTUAL",
    "blackbox_sample_rate": "1/1",
}
"""Settings by its command line: linear sticks, and no delays that are meant for a pilot."""


class Flown:
    """One flight's Betaflight.

    Args:
        vehicle: a `KnownVehicle`.
        dt: between updates [s].
    """

    def __init__(self, vehicle: Any, dt: float) -> None:
        denominator = round(BASE * dt)
        if not 1 <= denominator <= 16 or abs(BASE * dt / denominator - 1.0) > 0.03:
            raise WorkbenchError(
                f"Betaflight has no control loop that runs every {dt:g} s: take a control_period "
                "of 1/1024 s"
            )
        self._rotors, turned = motors(vehicle.rotors)
        yaw = {"yaw_motors_reversed": "ON" if turned else "OFF"}
        settings = {"pid_process_denom": denominator, **SETTINGS, **yaw}
        self._firmware = Betaflight(betaflight_program(), settings)
        self._ordered: dict[str, float] = {}
        self._held = self.gains

    def update(
        self, measured: Any, setpoint: Any, g: Any, vehicle: Any, memory: Any, dt: float, loops: Any
    ) -> tuple[Any, Any]:
        """Return the wrench in T, F [N] and m [N·m], and the memory."""
        m, v, rests = memory, measured.v_WBcm, memory.flies < 0.5
        self._order(g)
        if rests:
            self._firmware.arm()
        R = attitude_matrix(measured.q_WT)
        x, y, z = position_error(measured, setpoint)
        back = g.outer_p_position * x, g.outer_p_position * y, g.outer_p_height * z
        s_x, s_y, s_z, yaw_rate = velocity_setpoint(back, measured, setpoint, g)
        cos, sin, level = level_heading(R)
        after = (m.outer_i_x, m.outer_i_y, m.outer_i_z, m.angle_x, m.angle_y, m.throttle)
        if measured.elapsed[0] > 0.0 or rests:
            hover = IDLE + (1.0 - IDLE) * g.outer_hover
            roll, pitch, throttle, *integrals = outer_loop(
                (s_x - v[0], s_y - v[1], s_z - v[2]),
                after[:3],
                setpoint.a_WBcm,
                (cos, sin),
                g._replace(angle_limit=float(round(g.angle_limit))),
                (IDLE, hover),
                measured.elapsed[0] or DIVIDERS[0] * dt,
            )
            after = (*integrals, roll, pitch, throttle)
        rates, a = into_body(R, measured.w_WB), measured.a_WBcm
        force = into_body(R, (a[0], a[1], a[2] + GRAVITY))
        packet = motion_packet(rates, force, measured.q_WT)
        signals = self._firmware.step(packet, self._sticks(after[3:], yaw_rate, R, level, g))
        return made(signals, self._rotors, g.motor_speed), (*after, 1.0)

    @property
    def gains(self) -> dict[str, int]:
        """Its gains, as last read by MSP."""
        return self._firmware.gains

    @property
    def pid(self) -> int:
        """Id of its process."""
        return self._firmware.pid

    def report(self) -> dict[str, float]:
        """Return the numbers of packets sent, and of those not answered in time."""
        return {"packets": self._firmware.steps, "lost": self._firmware.lost}

    def records(self) -> dict[str, bytes]:
        """Return its blackbox log."""
        blackbox = self._firmware.blackbox()
        return {".bfl": blackbox} if blackbox else {}

    def close(self) -> None:
        """End it."""
        self._firmware.close()

    def _sticks(self, wanted: Any, yaw_rate: float, R: Any, level: float, g: Any) -> Sticks:
        """Return the sticks for roll and pitch angles [deg], throttle, and a yaw rate [rad/s]."""
        roll, pitch, throttle = wanted
        acro, full = g.acro > 0.5, float(round(g.angle_limit))
        if acro:
            roll = g.outer_p_angle * (roll - DEGREES * arctan2(R[7], R[8]))
            pitch = g.outer_p_angle * (pitch - DEGREES * arctan2(-R[6], level))
            full = RATE
        half = 0.5 * (MOST - LEAST)
        return Sticks(
            roll=LEAST + half * (1.0 + roll / full),
            pitch=LEAST + half * (1.0 + pitch / full),
            throttle=CHECK + (MOST - CHECK) * throttle,
            yaw=LEAST + half * (1.0 - DEGREES * yaw_rate / RATE),
            angle=not acro,
        )

    def _order(self, g: Any) -> None:
        """Send changed gains, and log the gains that it has confirmed."""
        if not self._firmware.confirmed:
            return
        held = self._firmware.gains
        if held != self._held:
            changed = [f"{name} {held[name]}" for name in held if held[name] != self._held[name]]
            logging.getLogger("workbench").info(
                f"Betaflight has, read back by MSP: {', '.join(changed)}"
            )
            self._held = held
        wanted = {name: getattr(g, name) for name in GAINS}
        if wanted != self._ordered:
            self._firmware.set_gains(wanted)
            self._ordered = wanted


def program(vehicle: Any, dt: float) -> Flown:
    """Start Betaflight for one flight of a vehicle, a `KnownVehicle`.

    Raises:
        WorkbenchError: if it cannot be built or started, or the vehicle is not a quadrotor in X.
    """
    return Flown(vehicle, dt)


def rule(vehicle: Any) -> dict[str, float]:
    """Return the values of `betaflight` for a vehicle."""
    known = {row.name for row in (*PARAMETERS, *COMMON)}
    return {name: value for name, value in law.rule(vehicle).items() if name in known}


def motors(rotors: Any) -> tuple[tuple[Any, ...], bool]:
    """Return the rotors in Betaflight's order, and whether all turn in the opposite direction.

    M1 is at the rear right, M2 front right, M3 rear left, M4 front left; M2 and M3 turn
    counter-clockwise.

    Raises:
        WorkbenchError: if the rotors are arranged otherwise.
    """
    places = {(each.m_y < 0.0, each.m_x > 0.0): each for each in rotors}
    order = ((False, False), (True, False), (False, True), (True, True))
    found = tuple(places[place] for place in order if place in places)
    turns = tuple(each.m_z > 0.0 for each in found)
    if len(rotors) != 4 or turns not in ((True, False, False, True), (False, True, True, False)):
        raise WorkbenchError(
            "Betaflight flies four rotors in X here, of which those on a diagonal turn alike: "
            "give a description of such a drone"
        )
    return found, turns[1]


def made(signals: Any, rotors: Any, full: float) -> tuple[float, float, float, float]:
    """Return force [N] and moment [N·m] of the rotors in T.

    Args:
        signals: of M1 .. M4, 0 .. 1.
        rotors: see `motors`.
        full: speed at a full signal [rad/s].
    """
    force = m_x = m_y = m_z = 0.0
    for signal, rotor in zip(signals, rotors, strict=True):
        speed = signal * full
        thrust = rotor.motor_constant * speed * (speed + rotor.linear_speed)
        force += rotor.force * thrust
        m_x += rotor.m_x * thrust
        m_y += rotor.m_y * thrust
        m_z += rotor.m_z * thrust
    return force, m_x, m_y, m_z
