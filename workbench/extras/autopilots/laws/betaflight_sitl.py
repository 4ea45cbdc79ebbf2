"""Betaflight 4.6 itself, as a separate program, below the outer loop of `betaflight`.

Angles and throttle of that loop, and the yaw rate, are stick inputs of the firmware, in angle mode,
or in rate mode if `acro` is 1. From these and the motion the firmware computes four motor signals;
a speed controller converts a full signal to `motor_speed`. Parameters are those of `betaflight`
that MSP can set and read back. See docs/betaflight-sitl.md.
"""

import logging
from collections.abc import Mapping, Sequence

from workbench.common.errors import WorkbenchError
from workbench.control.controller import COMMON_PARAMETERS
from workbench.controllers import (
    GRAVITY,
    Gains,
    KnownBody,
    KnownRotor,
    KnownVehicle,
    LawResult,
    LawSetpoint,
    Matrix3,
    MeasuredMotion,
    Memory,
    Probes,
    State,
    Wrench,
    arctan2,
    attitude_matrix,
    into_body,
    level_heading,
    position_error,
    velocity_setpoint,
)
from workbench.extras.autopilots.betaflight_outer import RADIAN_DEG, outer_loop
from workbench.extras.autopilots.laws import betaflight as law
from workbench.extras.autopilots.programs.betaflight import Betaflight
from workbench.extras.autopilots.programs.betaflight_build import betaflight_program
from workbench.extras.autopilots.programs.betaflight_msp import MSP_GAIN_LOCATIONS
from workbench.extras.autopilots.programs.betaflight_packets import (
    MAX_CHANNEL_US,
    MIN_CHANNEL_US,
    ReceiverChannels,
    motion_packet,
)
from workbench.plant.vehicle import Vehicle

PERIOD = law.PERIOD
DIVIDERS = law.DIVIDERS
SITL_GYRO_RATE_HZ = 8000.0
"""Rate of its gyro; the time between packets is a whole number of gyro periods [Hz]."""
FULL_STICK_DEG_S = 670.0
"""Rate for a full stick in rate mode [deg/s]."""
MIN_THROTTLE_STICK_US = 1050.0
"""Lowest throttle stick [us]."""
SITL_IDLE_SIGNAL = 0.055
"""Motor signal at zero throttle."""
LAW_ONLY_PARAMETERS = ("acro", "motor_speed")
PARAMETERS = tuple(
    row
    for row in law.PARAMETERS
    if row.name in MSP_GAIN_LOCATIONS
    or row.name in LAW_ONLY_PARAMETERS
    or row.name.startswith("outer_")
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


class BetaflightFlight:
    """One flight's Betaflight.

    Args:
        vehicle: a `KnownVehicle`.
        dt: between updates [s].
    """

    def __init__(self, vehicle: KnownVehicle, dt: float) -> None:
        denominator = round(SITL_GYRO_RATE_HZ * dt)
        if not 1 <= denominator <= 16 or abs(SITL_GYRO_RATE_HZ * dt / denominator - 1.0) > 0.03:
            raise WorkbenchError(
                f"Betaflight has no control loop that runs every {dt:g} s: take a control_period "
                "of 1/1024 s"
            )
        self._rotors, turned = betaflight_order(vehicle.rotors)
        yaw = {"yaw_motors_reversed": "ON" if turned else "OFF"}
        settings = {"pid_process_denom": denominator, **SETTINGS, **yaw}
        self._firmware = Betaflight(betaflight_program(), settings)
        self._ordered: dict[str, float] = {}
        self._held = self.gains

    def update(
        self,
        measured: MeasuredMotion,
        setpoint: LawSetpoint,
        g: Gains,
        vehicle: KnownBody,
        memory: Memory,
        dt: float,
        loops: Probes,
    ) -> LawResult:
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
            hover = SITL_IDLE_SIGNAL + (1.0 - SITL_IDLE_SIGNAL) * g.outer_hover
            roll, pitch, throttle, *integrals = outer_loop(
                (s_x - v[0], s_y - v[1], s_z - v[2]),
                after[:3],
                setpoint.a_WBcm,
                (cos, sin),
                g._replace(angle_limit=float(round(g.angle_limit))),
                (SITL_IDLE_SIGNAL, hover),
                measured.elapsed[0] or DIVIDERS[0] * dt,
            )
            after = (*integrals, roll, pitch, throttle)
        rates, a = into_body(R, measured.w_WB), measured.a_WBcm
        force = into_body(R, (a[0], a[1], a[2] + GRAVITY))
        packet = motion_packet(rates, force, measured.q_WT)
        signals = self._firmware.step(packet, self._sticks(after[3:], yaw_rate, R, level, g))
        return rotor_wrench(signals, self._rotors, g.motor_speed), (*after, 1.0)

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

    def _sticks(
        self, wanted: Sequence[float], yaw_rate: float, R: Matrix3, level: float, g: Gains
    ) -> ReceiverChannels:
        """Return the sticks for roll and pitch angles [deg], throttle, and a yaw rate [rad/s]."""
        roll, pitch, throttle = wanted
        acro, full = g.acro > 0.5, float(round(g.angle_limit))
        if acro:
            roll = g.outer_p_angle * (roll - RADIAN_DEG * arctan2(R[7], R[8]))
            pitch = g.outer_p_angle * (pitch - RADIAN_DEG * arctan2(-R[6], level))
            full = FULL_STICK_DEG_S
        half = 0.5 * (MAX_CHANNEL_US - MIN_CHANNEL_US)
        return ReceiverChannels(
            roll=MIN_CHANNEL_US + half * (1.0 + roll / full),
            pitch=MIN_CHANNEL_US + half * (1.0 + pitch / full),
            throttle=MIN_THROTTLE_STICK_US + (MAX_CHANNEL_US - MIN_THROTTLE_STICK_US) * throttle,
            yaw=MIN_CHANNEL_US + half * (1.0 - RADIAN_DEG * yaw_rate / FULL_STICK_DEG_S),
            angle=not acro,
        )

    def _order(self, g: Gains) -> None:
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
        wanted = {name: getattr(g, name) for name in MSP_GAIN_LOCATIONS}
        if wanted != self._ordered:
            self._firmware.set_gains(wanted)
            self._ordered = wanted


def program(vehicle: KnownVehicle, dt: float) -> BetaflightFlight:
    """Start Betaflight for one flight of a vehicle, a `KnownVehicle`.

    Raises:
        WorkbenchError: if it cannot be built or started, or the vehicle is not a quadrotor in X.
    """
    return BetaflightFlight(vehicle, dt)


def rule(vehicle: Vehicle) -> dict[str, float]:
    """Return the values of `betaflight` for a vehicle."""
    known = {row.name for row in (*PARAMETERS, *COMMON_PARAMETERS)}
    return {name: value for name, value in law.rule(vehicle).items() if name in known}


def betaflight_order(rotors: Sequence[KnownRotor]) -> tuple[tuple[KnownRotor, ...], bool]:
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


def rotor_wrench(signals: Sequence[float], rotors: Sequence[KnownRotor], full: float) -> Wrench:
    """Return force [N] and moment [N·m] of the rotors in T.

    Args:
        signals: of M1 .. M4, 0 .. 1.
        rotors: see `betaflight_order`.
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
