"""Change the source in one place at a time, and tell which test and which spec notice.

`python tools/mutations.py` says of each mutation in `MUTATIONS` what it is, the first test that
fails, and the cases of the project's own specs that `workbench regress` finds changed. Each is made
in a copy of the project in a temporary folder; the project itself stays as it is. All of it takes
an hour or two; a word chooses mutations: `python tools/mutations.py battery`.

Exit code 0: a test kills each mutation. 1: one lives on. 2: the list does not fit the source, or
the tests fail without any mutation.
"""

import argparse
import contextlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
LEFT_OUT = (".*", "__pycache__", "out", "build", "dist", "node_modules")
"""Of the project's folder; not copied."""

DYNAMICS, CONTROL, SYSTEMS = "workbench/dynamics", "workbench/control", "workbench/systems"
CONTROLLERS, DESIGN = "workbench/controllers", "workbench/design"
READERS = "workbench/extras/flightdata/readers"
ESTIMATION = "workbench/estimation"
IDENTIFY, PREDICT = "workbench/extras/flightdata/identify", "workbench/extras/flightdata/predict"
ORACLE = "tests/oracles/test_reference_flights.py"
LOOPS = "tests/oracles/test_loops_by_hand.py"
ROTORS = "tests/dynamics/test_rotors.py"
LAW = "tests/controllers/test_pd.py"
EQUATIONS = "tests/controllers/test_equations.py"
PARSED = "tests/extras/flightdata/test_parsed_values.py"
JOINT_FORCES = "tests/systems/test_joint_forces.py"
BALL_FLIGHTS = "tests/diagram/test_ball_joints.py"
BALL_FORCES = "tests/systems/test_ball_forces.py"
JOINTED_FLIGHTS = "tests/diagram/test_joints.py"
CABLES = "tests/diagram/test_cables.py"
JOINTED_MODELS = "tests/design/linear/test_joints.py"
FIT, PAST = (
    "tests/extras/flightdata/identify/test_fit.py",
    "tests/extras/flightdata/predict/test_past.py",
)


@dataclass(frozen=True)
class Mutation:
    """A change of the source that some test should notice.

    Attributes:
        what: it is.
        file: below the project's folder.
        old: text that stands there once.
        new: what takes its place.
        tests: files that should notice, the fastest first.
    """

    what: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]


class MutationError(Exception):
    """The list does not fit the source, or what should pass without a mutation fails."""


MUTATIONS = (
    # physics
    Mutation(
        "spin-up torque: the other sign",
        f"{DYNAMICS}/rotors.py",
        "rotor.moment_constant * static + rotor.inertia * slope",
        "rotor.moment_constant * static - rotor.inertia * slope",
        (ROTORS, LOOPS, ORACLE),
    ),
    Mutation(
        "spin-up torque: half of it",
        f"{DYNAMICS}/rotors.py",
        "rotor.moment_constant * static + rotor.inertia * slope",
        "rotor.moment_constant * static + 0.5 * rotor.inertia * slope",
        (ROTORS, LOOPS, ORACLE),
    ),
    Mutation(
        "gyroscopic moment of the rotors: half of it",
        f"{DYNAMICS}/rotors.py",
        "turned, size = speed * rotor.direction * rotor.inertia, abs(speed)",
        "turned, size = 0.5 * speed * rotor.direction * rotor.inertia, abs(speed)",
        (ROTORS, ORACLE),
    ),
    Mutation(
        "gyroscopic moment of the rotors: the other sign",
        f"{SYSTEMS}/rotors.py",
        "whole_moment = into_world(R_WB, (m_x - g_x, m_y - g_y, m_z - g_z))",
        "whole_moment = into_world(R_WB, (m_x + g_x, m_y + g_y, m_z + g_z))",
        ("tests/systems/test_rotors.py", ORACLE),
    ),
    Mutation(
        "drag torque: the other sign",
        f"{DYNAMICS}/rotors.py",
        "torque = rotor.direction * (rotor.moment_constant * static + rotor",
        "torque = rotor.direction * (-rotor.moment_constant * static + rotor",
        (ROTORS, LOOPS, ORACLE),
    ),
    Mutation(
        "thrust: a fiftieth more",
        f"{DYNAMICS}/rotors.py",
        "return share * rotor.motor_constant * speed",
        "return 1.02 * share * rotor.motor_constant * speed",
        (ROTORS, ORACLE),
    ),
    Mutation(
        "thrust: its linear part left out",
        f"{DYNAMICS}/rotors.py",
        "rotor.motor_constant * speed * (speed + rotor.linear_speed)",
        "rotor.motor_constant * speed * speed",
        (ROTORS, ORACLE),
    ),
    Mutation(
        "inflow: the other sign",
        f"{DYNAMICS}/rotors.py",
        "thrust - share * rotor.inflow_coefficient",
        "thrust + share * rotor.inflow_coefficient",
        (ROTORS, ORACLE),
    ),
    Mutation(
        "ground effect: a tenth more",
        f"{DYNAMICS}/rotors.py",
        "near = rotor.ground_effect_coefficient",
        "near = 1.1 * rotor.ground_effect_coefficient",
        (ROTORS, ORACLE),
    ),
    Mutation(
        "battery: its voltage does not fall under load",
        f"{DYNAMICS}/rotors.py",
        "voltage = open_circuit - drop * power",
        "voltage = open_circuit - 0.0 * drop * power",
        (ROTORS, "tests/systems/test_battery.py", ORACLE),
    ),
    Mutation(
        "rotor lag: up and down exchanged",
        f"{DYNAMICS}/rotors.py",
        "return up / rotor.time_constant_up + down / rotor.time_constant_down",
        "return up / rotor.time_constant_down + down / rotor.time_constant_up",
        (ROTORS, ORACLE),
    ),
    Mutation(
        "gyroscopic term of the body: the other sign",
        f"{DYNAMICS}/rigid_body.py",
        "n_x = m_x - b_y * h_z + b_z * h_y",
        "n_x = m_x + b_y * h_z - b_z * h_y",
        (ORACLE,),
    ),
    Mutation(
        "moment of a force beside the centre of mass: the other sign",
        f"{DYNAMICS}/rigid_body.py",
        "t_y - c_z * f_x + c_x * f_z,",
        "t_y + c_z * f_x - c_x * f_z,",
        (ORACLE,),
    ),
    Mutation(
        "drag of the body: twice as much",
        f"{DYNAMICS}/air/drag.py",
        "drag = -half_drag * (",
        "drag = -2.0 * half_drag * (",
        ("tests/dynamics/air/test_drag.py", ORACLE),
    ),
    Mutation(
        "drag of the rotors: the other sign",
        f"{DYNAMICS}/rotors.py",
        "drag = size * rotor.rotor_drag_coefficient",
        "drag = -size * rotor.rotor_drag_coefficient",
        ("tests/dynamics/air/test_drag.py", ORACLE),
    ),
    Mutation(
        "wind: from where it should blow to",
        f"{SYSTEMS}/rotors.py",
        "v_W = v_x - u_x, v_y - u_y, v_z - u_z",
        "v_W = v_x + u_x, v_y + u_y, v_z + u_z",
        ("tests/systems/test_rotors.py", "tests/oracles/test_wind.py"),
    ),
    Mutation(
        "payload: at the body's origin",
        "workbench/plant/payload.py",
        "RigidTransform(list(self.place)),",
        "RigidTransform(),",
        ("tests/session/test_payload.py", ORACLE),
    ),
    Mutation(
        "payload: the plant does not carry it",
        "workbench/diagram/airframe.py",
        "            whole += own\n",
        "",
        ("tests/session/test_payload.py",),
    ),
    # joints
    Mutation(
        "limit of a joint: it pulls",
        f"{SYSTEMS}/joint_forces.py",
        "return force - stop if stop > 0.0 else force",
        "return force - stop",
        (JOINT_FORCES,),
    ),
    Mutation(
        "limit of a joint: a tenth stiffer",
        f"{SYSTEMS}/joint_forces.py",
        "stop_stiffness=inertia * STOP_RATE_RAD_S**2",
        "stop_stiffness=1.1 * inertia * STOP_RATE_RAD_S**2",
        (JOINTED_FLIGHTS,),
    ),
    Mutation(
        "friction of a joint: the other sign",
        f"{SYSTEMS}/joint_forces.py",
        "force = force - row.friction * v",
        "force = force + row.friction * v",
        (JOINT_FORCES,),
    ),
    Mutation(
        "cable: it pushes",
        f"{SYSTEMS}/cables.py",
        "if not (opened and row.hooked) and stretch > -TAUT_TOLERANCE_M:",
        "if not (opened and row.hooked):",
        (CABLES,),
    ),
    Mutation(
        "cable: it pulls at one end alone",
        f"{SYSTEMS}/cables.py",
        "((first, arm_A_W, 1.0), (second, arm_B_W, -1.0))",
        "((second, arm_B_W, -1.0),)",
        (CABLES,),
    ),
    Mutation(
        "cable: a tenth stiffer",
        f"{SYSTEMS}/cables.py",
        "cable.stiffness or mass * STOP_RATE_RAD_S**2",
        "cable.stiffness or 1.1 * mass * STOP_RATE_RAD_S**2",
        (CABLES,),
    ),
    Mutation(
        "cable: its hook stays closed",
        f"{SYSTEMS}/cables.py",
        "if not (opened and row.hooked) and stretch",
        "if stretch",
        (CABLES,),
    ),
    Mutation(
        "cable: hooks open one between links that hold no load, too",
        f"{SYSTEMS}/cables.py",
        "if not (opened and row.hooked) and stretch",
        "if not opened and stretch",
        (CABLES,),
    ),
    Mutation(
        "ball joint: its limit pulls",
        f"{SYSTEMS}/ball_forces.py",
        "if stop > 0.0:",
        "if stop:",
        (BALL_FORCES,),
    ),
    Mutation(
        "ball joint: half the angle in its spring",
        f"{SYSTEMS}/ball_forces.py",
        "angle = 2.0 * atan2(size, q_PC[0])",
        "angle = atan2(size, q_PC[0])",
        (BALL_FORCES,),
    ),
    Mutation(
        "ball joint: friction about the axes of the parent",
        f"{SYSTEMS}/ball_forces.py",
        "for x in into_body(R_PC, w_PC_P)",
        "for x in into_world(R_PC, w_PC_P)",
        (BALL_FORCES,),
    ),
    Mutation(
        "ball joint: its forces do not reach the plant",
        f"{SYSTEMS}/joint_forces.py",
        "if ball.acts:",
        "if not ball.acts:",
        (JOINTED_FLIGHTS,),
    ),
    Mutation(
        "ball joint: its frame does not turn in the plant",
        "workbench/diagram/ball_frames.py",
        "        if turned:",
        "        if not turned:",
        (BALL_FLIGHTS,),
    ),
    Mutation(
        "trim: a position is held without an offset",
        f"{DESIGN}/linear/trim.py",
        "jacobian[rows, places.held] = found[:, asked.stop : asked.stop + HELD_SIZE]",
        "pass",
        (JOINTED_MODELS,),
    ),
    Mutation(
        "mimic joint: no force on its leader",
        f"{SYSTEMS}/joint_forces.py",
        "forces[leader.velocity] += row.multiplier * force",
        "forces[leader.velocity] += 0.0 * force",
        (JOINT_FORCES,),
    ),
    Mutation(
        "rotor on a link: it acts on the base link",
        f"{SYSTEMS}/rotors.py",
        "yield body, (",
        "yield self.bodies[0], (",
        (JOINTED_FLIGHTS,),
    ),
    Mutation(
        "spring of a joint: left out",
        "workbench/plant/multibody.py",
        "if freedom.stiffness:",
        "if freedom.stiffness < 0.0:",
        (JOINTED_MODELS,),
    ),
    Mutation(
        "several freedoms of a joint: all about the first axis",
        "workbench/plant/gathered.py",
        "Joint(name, each.kind, parent, child, X_MJ, each.axis_J, (single,), mimic)",
        "Joint(name, each.kind, parent, child, X_MJ, joint.axis_J, (single,), mimic)",
        ("tests/plant/test_joints.py",),
    ),
    Mutation(
        "joints in linear models: their velocities in the place of their positions",
        f"{DESIGN}/linear/vehicle.py",
        "[base, own.size + np.arange(rotors), joints, rest]",
        "[base, own.size + np.arange(rotors), joints[::-1], rest]",
        (JOINTED_MODELS,),
    ),
    Mutation(
        "swinging joints: a law knows them as rigid",
        "workbench/plant/swinging.py",
        "MAX_SWING_RATE_RAD_S = 20.0",
        "MAX_SWING_RATE_RAD_S = 0.0",
        (JOINTED_MODELS,),
    ),
    Mutation(
        "swinging joints: a slack tie holds",
        "workbench/plant/loading.py",
        ">= each.length - TAUT_TOLERANCE_M",
        ">= 0.0",
        ("tests/plant/test_swinging.py",),
    ),
    # law
    Mutation(
        "law: the other sign of the gyroscopic term",
        f"{CONTROL}/law_parts.py",
        "xx * a_x + xy * a_y + xz * a_z + w_y * h_z - w_z * h_y",
        "xx * a_x + xy * a_y + xz * a_z - w_y * h_z + w_z * h_y",
        (LAW,),
    ),
    Mutation(
        "law: acceleration fed back the wrong way",
        "workbench/controllers/pd.py",
        "g.kp_velocity_x * e[0] - g.kd_velocity_x * a[0] + drag[0]",
        "g.kp_velocity_x * e[0] + g.kd_velocity_x * a[0] + drag[0]",
        (LAW,),
    ),
    Mutation(
        "law: drag of the yaw taken twice in place of given back",
        "workbench/controllers/pd.py",
        "g.kp_yaw_rate * e[2] + vehicle.yaw_drag * w[2]",
        "g.kp_yaw_rate * e[2] - vehicle.yaw_drag * w[2]",
        (LAW, LOOPS),
    ),
    Mutation(
        "law: tilt error too large by half",
        f"{CONTROL}/law_parts.py",
        "scale = (2.0 / upright) ** 0.5 / length",
        "scale = 1.5 * (2.0 / upright) ** 0.5 / length",
        (LAW,),
    ),
    Mutation(
        "law: derivative filter twice as fast",
        f"{SYSTEMS}/acceleration_estimate.py",
        "ESTIMATE_TIME_CONSTANT_S = 0.02",
        "ESTIMATE_TIME_CONSTANT_S = 0.01",
        ("tests/systems/test_acceleration_estimate.py", LOOPS),
    ),
    Mutation(
        "mixer: a saturated tilting moment does not shrink",
        f"{CONTROL}/mixer.py",
        "if spread > 0.0 and tilt * spread > room:",
        "if spread < 0.0 and tilt * spread > room:",
        ("tests/control/test_mixer.py",),
    ),
    Mutation(
        "law: INDI's spin-up with the other sign",
        f"{CONTROLLERS}/indi.py",
        "passed * (m_z + spin_up - m.moment_filtered_z)",
        "passed * (m_z - spin_up - m.moment_filtered_z)",
        (EQUATIONS,),
    ),
    Mutation(
        "law: INDI takes the product of inertia yz for xz",
        f"{CONTROLLERS}/indi.py",
        "M_x + xx * d_x + xy * d_y + xz * d_z",
        "M_x + xx * d_x + xy * d_y + yz * d_z",
        (EQUATIONS,),
    ),
    Mutation(
        "law: PID's integral of yaw with the other sign",
        f"{CONTROLLERS}/pid.py",
        "g.kp_yaw_rate * e[2] + m.i_rate_z + vehicle.yaw_drag",
        "g.kp_yaw_rate * e[2] - m.i_rate_z + vehicle.yaw_drag",
        (EQUATIONS,),
    ),
    Mutation(
        "law: PID's integral of yaw without a limit",
        f"{CONTROLLERS}/pid.py",
        "past = m.i_rate_z if m.i_rate_z * m.i_rate_z > MAX_RATE_INTEGRAL * MAX_RATE_INTEGRAL "
        "else 0.0",
        "past = 0.0 * m.i_rate_z",
        (EQUATIONS,),
    ),
    Mutation(
        "law: LQI's integral along y with the other sign",
        f"{CONTROLLERS}/lqi.py",
        "level * (g.level_velocity * e[1] + g.level_integral * m.integral_y)",
        "level * (g.level_velocity * e[1] - g.level_integral * m.integral_y)",
        (EQUATIONS,),
    ),
    Mutation(
        "rule: PX4's velocity integral ten times as large",
        "workbench/extras/autopilots/laws/px4.py",
        '"MPC_XY_VEL_I_ACC": 0.2 *',
        '"MPC_XY_VEL_I_ACC": 2.0 *',
        ("tests/controllers/test_rules.py",),
    ),
    Mutation(
        "commands: rounded down in place of to the nearest",
        f"{CONTROL}/law_signals.py",
        "math.floor(steps * speed / full + 0.5)",
        "math.floor(steps * speed / full)",
        ("tests/control/test_flight_law.py",),
    ),
    # safety
    Mutation(
        "flight mode: a landing without a position is arrested where it sinks",
        f"{CONTROL}/flight_mode.py",
        "now.v_WB[2] < -0.5 * settings.landing_speed",
        "now.v_WB[2] > -0.5 * settings.landing_speed",
        ("tests/control/test_flight_mode.py",),
    ),
    Mutation(
        "flight mode: a position is lost while the GPS is young",
        f"{CONTROL}/flight_mode.py",
        "return health.gps_age > settings.gps_timeout",
        "return health.gps_age < settings.gps_timeout",
        ("tests/control/test_flight_mode.py",),
    ),
    Mutation(
        "flight mode: the true charge lands in place of the known one",
        f"{CONTROL}/flight_mode.py",
        "known = now.charge if now.known_charge is None else now.known_charge",
        "known = now.charge",
        ("tests/control/test_flight_mode.py",),
    ),
    Mutation(
        "authority: a lease of 0 commands",
        "workbench/link/authority.py",
        "self._lease == lease != 0",
        "self._lease == lease",
        ("tests/link/test_authority.py",),
    ),
    Mutation(
        "server: operations of an idle client are saved up",
        "workbench/link/server/rate_limiter.py",
        "            OPERATION_BURST_BYTES, self._operations + OPERATION_BYTES_PER_S * passed\n",
        "            1e12, self._operations + OPERATION_BYTES_PER_S * passed\n",
        ("tests/link/server/test_hub.py",),
    ),
    Mutation(
        "server: topics wait without limit",
        "workbench/live/server_process.py",
        "self.offer(published, MAX_TOPIC_BYTES)",
        "self.offer(published, 1000 * MAX_TOPIC_BYTES)",
        ("tests/live/test_server_process.py",),
    ),
    Mutation(
        "mailbox: the first command is dropped",
        f"{SYSTEMS}/bridge.py",
        "            self.commands.pop()\n",
        "            self.commands.popleft()\n",
        ("tests/systems/test_bridge.py",),
    ),
    Mutation(
        "export: a gain that must not fly is written",
        "workbench/extras/autopilots/gain_files/exported_gains.py",
        'raise WorkbenchError(f"{firmware.file_name(name)} {why}; nothing is exported")',
        "continue",
        ("tests/extras/autopilots/gain_files/test_exchange.py",),
    ),
    Mutation(
        "injection: its loops stay as they are at its end",
        "workbench/session/session.py",
        "self._bench.computer.close_loops(self._live.context_of(self._bench.computer))",
        "pass",
        ("tests/session/test_injection.py",),
    ),
    # design
    Mutation(
        "tune: the best corner is flown in place of the worst",
        f"{DESIGN}/tune/proof.py",
        "found.append((min(corners",
        "found.append((max(corners",
        ("tests/design/tune/test_proof.py",),
    ),
    Mutation(
        "tune: a step from steady flight is measured from hover",
        f"{DESIGN}/tune/measure.py",
        "response = response - response[:, :1]",
        "response = response + 0.0",
        ("tests/design/tune/test_proof.py",),
    ),
    Mutation(
        "tune: a guard keeps the larger margin",
        f"{DESIGN}/tune/requirement.py",
        "bound = min(wish.bound, LIMIT_ROOM_FACTOR * min(rule, now))",
        "bound = min(wish.bound, LIMIT_ROOM_FACTOR * max(rule, now))",
        ("tests/design/tune/test_requirement.py",),
    ),
    Mutation(
        "tune: an unstable loop has a margin above 0",
        f"{DESIGN}/tune/measure.py",
        "MARGIN_PER_GROWTH_S = -0.1",
        "MARGIN_PER_GROWTH_S = 0.1",
        ("tests/design/tune/test_measure.py",),
    ),
    Mutation(
        "tune: a flight that diverges uses no rotor",
        f"{DESIGN}/tune/measure.py",
        "use = np.where(flown.diverged, math.inf, flown.peak_rotor_use)",
        "use = np.where(flown.diverged, 0.0, flown.peak_rotor_use)",
        ("tests/design/tune/test_measure.py",),
    ),
    Mutation(
        "tune: a flight that is lost is a proof",
        f"{DESIGN}/tune/proof.py",
        "    if response.loss:\n        return math.nan\n",
        "",
        ("tests/design/tune/test_proof.py",),
    ),
    Mutation(
        "compare: the error in wind is that before its last second",
        f"{DESIGN}/comparison_bench.py",
        "away[flight.time > flight.time[-1] - 1.0].mean()",
        "away[flight.time < flight.time[-1] - 1.0].mean()",
        ("tests/design/test_compare.py",),
    ),
    Mutation(
        "compare: the smallest overshoot of the vehicles in place of the worst",
        f"{DESIGN}/comparison_bench.py",
        "known.overshoot[~gone].max(initial=0.0)",
        "known.overshoot[~gone].min(initial=0.0)",
        ("tests/design/test_compare.py",),
    ),
    Mutation(
        "regress: saturation of all rotors in place of any",
        f"{DESIGN}/regress/measures.py",
        "(flight.judged.commanded_speeds >= SATURATED_COMMAND_SHARE * limits).any(axis=1)",
        "(flight.judged.commanded_speeds >= SATURATED_COMMAND_SHARE * limits).all(axis=1)",
        ("tests/design/regress/test_measures.py",),
    ),
    Mutation(
        "load: a torque at ten times its arm",
        f"{DESIGN}/load_step.py",
        "lever = USUAL_LOAD_SHARE * float(np.linalg.norm(hubs, axis=1).mean())",
        "lever = float(np.linalg.norm(hubs, axis=1).mean())",
        ("tests/design/test_load_step.py",),
    ),
    Mutation(
        "session: a gain that a law cannot design with stays",
        f"{SYSTEMS}/flight_computer.py",
        "get_mutable_numeric_parameter(number).SetFromVector(values)",
        "get_mutable_numeric_parameter(number)",
        ("tests/session/test_failing_laws.py",),
    ),
    # sensors and battery
    Mutation(
        "IMU: gravity the wrong way",
        f"{SYSTEMS}/sensors/noisy_sensor.py",
        "force_W[2] += GRAVITY",
        "force_W[2] -= GRAVITY",
        ("tests/systems/sensors/test_imu.py",),
    ),
    Mutation(
        "IMU, GPS, barometer: twice the noise",
        f"{SYSTEMS}/sensors/noisy_sensor.py",
        "deviation = model.stddev if scale == 1.0",
        "deviation = 2.0 * model.stddev if scale == 1.0",
        ("tests/systems/sensors/test_noisy_sensor.py",),
    ),
    Mutation(
        "GPS: velocity as noisy as position",
        "workbench/plant/sensors.py",
        "place, speed = self.horizontal_position, self.horizontal_velocity",
        "place, speed = self.horizontal_position, self.horizontal_position",
        ("tests/systems/sensors/test_gps.py",),
    ),
    Mutation(
        "lidar: twice the noise",
        f"{SYSTEMS}/sensors/lidar.py",
        "ranges += offset + deviation * normal",
        "ranges += offset + 2.0 * deviation * normal",
        ("tests/systems/sensors/test_lidar.py",),
    ),
    Mutation(
        "barometer: temperature falls by 5 in place of 6.5 K/km",
        f"{SYSTEMS}/sensors/barometer.py",
        "_LAPSE_RATE = 0.0065",
        "_LAPSE_RATE = 0.005",
        ("tests/systems/sensors/test_standard_atmosphere.py",),
    ),
    Mutation(
        "magnetometer: turned the wrong way",
        f"{SYSTEMS}/sensors/noisy_sensor.py",
        'field = (sensor_motion(inputs["state"], p_BS).R_WB @ R_BS).T @ field_W',
        'field = (sensor_motion(inputs["state"], p_BS).R_WB @ R_BS) @ field_W',
        ("tests/systems/sensors/test_magnetometer.py",),
    ),
    Mutation(
        "battery: empty in half the time",
        f"{SYSTEMS}/battery.py",
        "used = BATTERY_PERIOD_S * _power(thrusts) / self._hover_power / duration",
        "used = 2.0 * BATTERY_PERIOD_S * _power(thrusts) / self._hover_power / duration",
        ("tests/systems/test_battery.py",),
    ),
    Mutation(
        "battery: the law is told a voltage that rises under load",
        f"{SYSTEMS}/battery.py",
        "output.SetFromVector([max(0.0, rest - self._pack.resistance * current) / self._full])",
        "output.SetFromVector([max(0.0, rest + self._pack.resistance * current) / self._full])",
        ("tests/systems/test_charge.py",),
    ),
    Mutation(
        "estimate: the age of the barometer with the other sign",
        f"{SYSTEMS}/navigation.py",
        "z[AGES] = time - barometer[0]",
        "z[AGES] = barometer[0] - time",
        ("tests/systems/test_navigation.py",),
    ),
    Mutation(
        "estimate: the gate of the GPS not squared",
        f"{SYSTEMS}/navigation.py",
        "self._gate(context) ** 2 * innovations[:, 1]",
        "self._gate(context) * innovations[:, 1]",
        ("tests/systems/test_navigation.py",),
    ),
    Mutation(
        "payload: the law is not designed anew when it becomes known",
        f"{SYSTEMS}/flight_computer.py",
        "{self.gains_index, self.payload_index, self.hooks_index}",
        "{self.gains_index, self.hooks_index}",
        ("tests/systems/test_flight_computer.py",),
    ),
    Mutation(
        "delays: a step longer than they say",
        "workbench/diagram/core.py",
        "DiscreteTimeDelay(rates.control_period, periods - 1, port.size())",
        "DiscreteTimeDelay(rates.control_period, periods, port.size())",
        ("tests/diagram/test_workbench.py",),
    ),
    # logs
    Mutation(
        "log: thrust of PX4's rate setpoint downwards",
        f"{READERS}/ulog_topics.py",
        'SignalRow(_RATES_TOPIC, ("thrust_body[2]",), _THRUST_SIGNALS, "1", np.negative)',
        'SignalRow(_RATES_TOPIC, ("thrust_body[2]",), _THRUST_SIGNALS, "1")',
        (PARSED,),
    ),
    Mutation(
        "log: PX4's stamps of samples taken where some are zero",
        f"{READERS}/ulog_tables.py",
        "not (sampled > 0).all()",
        "not (sampled > 0).any()",
        (PARSED,),
    ),
    Mutation(
        "log: PX4's samples from before the begin kept",
        f"{READERS}/topic_log.py",
        "np.flatnonzero(time >= 0.0)",
        "np.flatnonzero(np.isfinite(time))",
        (PARSED,),
    ),
    Mutation(
        "log: ArduPilot's height setpoint downwards",
        f"{READERS}/dataflash.py",
        '("PSCD", "D", "z", -1.0)',
        '("PSCD", "D", "z", 1.0)',
        (PARSED,),
    ),
    Mutation(
        "log: ArduPilot's motors by channel in place of function",
        f"{READERS}/dataflash.py",
        "channels[motor] = channel",
        "channels[channel] = channel",
        (PARSED,),
    ),
    Mutation(
        "log: pitch rate setpoint of a Crazyflie not turned",
        f"{READERS}/crazyflie_usd.py",
        '("rate_setpoint.w_y", "rad/s", -_USD_DEG_IN_RAD)',
        '("rate_setpoint.w_y", "rad/s", _USD_DEG_IN_RAD)',
        (PARSED,),
    ),
    Mutation(
        "log: offset of a mapping without its sign",
        f"{READERS}/mapped_csv.py",
        'factor * numbers["offset"] + zero',
        'factor * numbers["sign"] * numbers["offset"] + zero',
        (PARSED,),
    ),
    Mutation(
        "log: commands of a simulated flight a row early",
        f"{READERS}/states_csv.py",
        "np.append(values[1:], values[-1:])",
        "values",
        (PARSED,),
    ),
    Mutation(
        "log: an interpolated sample of NanoBench kept",
        f"{READERS}/nanobench.py",
        "rows[begin + 1 : stop] = False",
        "rows[begin + 2 : stop] = False",
        (PARSED,),
    ),
    Mutation(
        "log: motors bridged over any gap",
        "workbench/extras/flightdata/identify/measured.py",
        "max(bridge, MAX_MISSING_SAMPLES * told_every))",
        "np.inf)",
        ("tests/extras/flightdata/identify/test_measured.py",),
    ),
    Mutation(
        "log: clock offsets the other way",
        "workbench/logs/flight_contents.py",
        "return float((lags[best] + part) * _OFFSET_STEP_S), float(at)",
        "return float(-(lags[best] + part) * _OFFSET_STEP_S), float(at)",
        ("tests/logs/test_flight_contents.py",),
    ),
    # identification and prediction
    Mutation(
        "identify: specific force a row early",
        f"{IDENTIFY}/flight_piece.py",
        "block_means(flight.force, block)[1:],",
        "block_means(flight.force, block)[:-1],",
        (FIT,),
    ),
    Mutation(
        "identify: grid of averaged samples moved the other way",
        f"{IDENTIFY}/flight_piece.py",
        "early += 0.5 * flight.period",
        "early -= 0.5 * flight.period",
        (FIT,),
    ),
    Mutation(
        "identify: a stopped search does not say what it lacks",
        f"{IDENTIFY}/fit.py",
        "        covariance += np.outer(left, left)\n",
        "",
        (FIT,),
    ),
    Mutation(
        "identify: validated on what was fitted",
        f"{IDENTIFY}/held_back.py",
        "last.append(replace(flight, good=flight.good & ~seen))",
        "last.append(replace(flight, good=flight.good & seen))",
        (FIT,),
    ),
    Mutation(
        "identify: impacts not spread",
        f"{IDENTIFY}/flight.py",
        "binary_dilation(hard, np.ones(2 * round(CONTACT_MARGIN_S * flight.rate) + 1))",
        "hard",
        (FIT,),
    ),
    Mutation(
        "predict: windows over a gap",
        f"{PREDICT}/prediction.py",
        "samples[:, None] + np.arange(ahead + 1)].all(axis=1)]\n",
        "samples[:, None] + np.arange(1)].all(axis=1)]\n",
        (PAST,),
    ),
    Mutation(
        "predict: thrust before a start looks ahead",
        f"{PREDICT}/past.py",
        "mean_before(each, samples - 1, before) for each",
        "mean_before(each, samples + 1, before) for each",
        (PAST,),
    ),
    Mutation(
        "predict: memory of an update later",
        f"{PREDICT}/past.py",
        "np.clip(counts.astype(int) - 1, 0",
        "np.clip(counts.astype(int), 0",
        (PAST,),
    ),
    Mutation(
        "predict: tilt of the estimate the other way",
        f"{PREDICT}/past.py",
        "found[:, 7] = -GRAVITY * tilt[:, 0]",
        "found[:, 7] = GRAVITY * tilt[:, 0]",
        (PAST,),
    ),
    # estimation
    Mutation(
        "estimator: a late fix not carried to the present",
        f"{ESTIMATION}/complementary.py",
        "- arm[i] + z[GPS + 1] * v_y[i]",
        "- arm[i]",
        ("tests/estimation/test_complementary_motion.py",),
    ),
    Mutation(
        "estimator: a fix held for ever",
        f"{ESTIMATION}/complementary.py",
        "seen[0] if seen[3] <= GPS_HOLD_TIME_S else 0.0",
        "seen[0]",
        ("tests/estimation/test_complementary_motion.py",),
    ),
    Mutation(
        "estimator: a range finder that looks up",
        f"{ESTIMATION}/ekf_measurements.py",
        "if down > MIN_BEAM_COSINE:",
        "if abs(down) > MIN_BEAM_COSINE:",
        ("tests/estimation/test_ekf.py",),
    ),
    Mutation(
        "estimator: negative ages of heights",
        f"{ESTIMATION}/run.py",
        "z[rows, AGES + place] = imu.stamp[rows] - sensor.stamp[new]",
        "z[rows, AGES + place] = sensor.stamp[new] - imu.stamp[rows]",
        ("tests/estimation/test_run.py",),
    ),
    Mutation(
        "turbulence: vertical speed not in the airspeed",
        f"{DYNAMICS}/air/update.py",
        "e_z = state[12] - settings.wind_z",
        "e_z = 0.0",
        ("tests/dynamics/air/test_update.py",),
    ),
    Mutation(
        "ROS: variances of velocity turned the other way",
        "workbench/link/ros_messages/making.py",
        "[*_body_variances(turn, velocity), 0.0",
        '[*_body_variances({**turn, "w": -turn["w"]}, velocity), 0.0',
        ("tests/link/ros_messages/test_conversion.py",),
    ),
    Mutation(
        "margins: delay of the nearer side",
        "workbench/design/judge/margins.py",
        "delay_margin=float((turn / crossings)",
        "delay_margin=float((np.minimum(turn, 2.0 * math.pi - turn) / crossings)",
        ("tests/design/judge/test_margins.py",),
    ),
    # limits, stamps and axes of what others read, and of what a drone carries
    Mutation(
        "a cloud's layers: elevations vary fastest",
        "workbench/link/ros_messages/making.py",
        "return np.stack([x, y, z], axis=-1).reshape(-1, 3)",
        "return np.stack([x, y, z], axis=-1).transpose(1, 0, 2).reshape(-1, 3)",
        ("tests/link/ros_messages/test_conversion.py",),
    ),
    Mutation(
        "ROS: a GPS velocity has the time of its frame",
        "workbench/link/ros_messages/making.py",
        '"header": header(values["stamp"], ROS_MAP_FRAME),',
        '"header": header(t_ns, ROS_MAP_FRAME),',
        ("tests/link/ros_messages/test_conversion.py",),
    ),
    Mutation(
        "MAVLink: a course of 360 degrees",
        "workbench/extras/gateways/mavlink_messages.py",
        "course = round(100.0 * (math.degrees(math.atan2(east, north)) % 360.0)) % 36000",
        "course = round(100.0 * (math.degrees(math.atan2(east, north)) % 360.0))",
        ("tests/extras/gateways/test_mavlink.py",),
    ),
    Mutation(
        "MAVLink: a current that does not fit",
        "workbench/extras/gateways/mavlink_messages.py",
        "_integer(1e2 * amperes, UNKNOWN_16 // 2, -1)",
        "_integer(1e2 * amperes, UNKNOWN_16, -1)",
        ("tests/extras/gateways/test_mavlink.py",),
    ),
    Mutation(
        "authority: who takes over lets the client's velocity fly on",
        "workbench/link/authority.py",
        "holds = self._hand is ControlOwner.CLIENT or self._hold_due",
        "holds = self._hold_due",
        ("tests/link/test_authority.py",),
    ),
    Mutation(
        "rule: PX4's heading wraps by half a turn",
        "workbench/extras/autopilots/laws/px4.py",
        "if yaw_sp < -math.pi:\n        yaw_sp = yaw_sp + 2.0 * math.pi",
        "if yaw_sp < -math.pi:\n        yaw_sp = yaw_sp + math.pi",
        ("tests/extras/autopilots/laws/test_px4_setpoints.py",),
    ),
    Mutation(
        "rule: PX4's second velocity on the far side of the circle",
        "workbench/extras/autopilots/laws/px4.py",
        "s = (along * along - size + most * most) ** 0.5 - along",
        "s = (along * along - size + most * most) ** 0.5 + along",
        ("tests/extras/autopilots/laws/test_px4_setpoints.py",),
    ),
    Mutation(
        "contact: spheres stand out of a box",
        "workbench/plant/multibody.py",
        "return box_corners(np.maximum(0.5 * np.array(shape.size()) - CORNER_RADIUS_M, 0.0))",
        "return box_corners(0.5 * np.array(shape.size()))",
        ("tests/plant/test_contact.py",),
    ),
    Mutation(
        "contact: bodies of a drone touch each other",
        "workbench/plant/multibody.py",
        "    if len(drone) > 1:\n        bodies",
        "    if len(drone) > 100:\n        bodies",
        ("tests/plant/test_contact.py",),
    ),
    Mutation(
        "spring of a joint: its rest at 0",
        "workbench/plant/multibody.py",
        "spring(made, freedom.rest, freedom.stiffness)",
        "spring(made, 0.0, freedom.stiffness)",
        ("tests/plant/test_contact.py",),
    ),
    Mutation(
        "MJCF: a joint's reference in degrees",
        "workbench/extras/formats/mjcf_body.py",
        "self.references[name] = scale * reference",
        "self.references[name] = reference",
        ("tests/extras/formats/test_mjcf_joints.py",),
    ),
    Mutation(
        "sweep: flights of other versions go on",
        "workbench/design/sweep/sweep.py",
        '        "versions": process_versions(),\n',
        "",
        ("tests/design/sweep/test_kept_flights.py",),
    ),
    Mutation(
        "regress: an error of tracking counts before the edge",
        "workbench/design/regress/measures.py",
        "[judged] ** 2)))",
        " ** 2)))",
        ("tests/design/regress/test_measures.py",),
    ),
    Mutation(
        "magnetometer: iron on board turned the wrong way",
        "workbench/systems/sensors/noisy_sensor.py",
        "return field + R_BS.T @ settings if",
        "return field + R_BS @ settings if",
        ("tests/systems/sensors/test_magnetometer.py",),
    ),
    Mutation(
        "barometer: downwash falls below the ground",
        "workbench/systems/sensors/barometer.py",
        "math.exp(-max(0.0, height) / GROUND",
        "math.exp(-abs(height) / GROUND",
        ("tests/systems/sensors/test_barometer.py",),
    ),
    Mutation(
        "estimator: a sample counts before it was taken",
        "workbench/estimation/run.py",
        "np.searchsorted(imu.stamp, sensor.stamp), np",
        "np.searchsorted(imu.stamp, sensor.stamp, 'right') - 1, np",
        ("tests/estimation/test_run.py",),
    ),
    Mutation(
        "step: what settles in the last fifth counts",
        "workbench/design/step_metrics.py",
        "(1.0 - SETTLED_LAST_SHARE) * duration)",
        "duration)",
        ("tests/design/test_step_metrics.py",),
    ),
    Mutation(
        "step: a begin below rest counts",
        "workbench/design/step_metrics.py",
        "np.abs(np.asarray(response)[..., 0]) <= SETTLING_BAND",
        "np.asarray(response)[..., 0] <= SETTLING_BAND",
        ("tests/design/test_step_metrics.py",),
    ),
    Mutation(
        "excitation: a turn to one side is a swing",
        "workbench/live/excitation_guard.py",
        "least = max(min(max(rate), -min(rate)) for rate in rates)",
        "least = max(max(max(rate), -min(rate)) for rate in rates)",
        ("tests/live/test_excitation_guard.py",),
    ),
    Mutation(
        "identify: a velocity without an attitude",
        "workbench/extras/flightdata/identify/measured.py",
        "known & turned",
        "known",
        ("tests/extras/flightdata/identify/test_measured.py",),
    ),
    Mutation(
        "predict: a share of the thrust from no past",
        "workbench/extras/flightdata/predict/past.py",
        "told = samples > before  # else",
        "told = samples > -1  # else",
        ("tests/extras/flightdata/predict/test_past.py",),
    ),
    Mutation(
        "cable: the arm of its other end",
        "workbench/systems/cables.py",
        "((first, arm_A_W, 1.0), (second, arm_B_W, -1.0))",
        "((first, arm_B_W, 1.0), (second, arm_B_W, -1.0))",
        ("tests/systems/test_cables.py",),
    ),
    Mutation(
        "servo: its effort limited on one side",
        "workbench/systems/joint_forces.py",
        "return -servo.max_effort + 0.0 * v if effort < -servo.max_effort else effort",
        "return effort",
        ("tests/systems/test_joint_forces.py",),
    ),
    Mutation(
        "servo: a late setpoint beyond its limits",
        "workbench/systems/servo_commands.py",
        "asked = servo.within(waiting[late - 1][i] if late else wanted[i])",
        "asked = waiting[late - 1][i] if late else servo.within(wanted[i])",
        ("tests/systems/test_servo_commands.py",),
    ),
    Mutation(
        "export: a value that Betaflight refuses",
        "workbench/extras/autopilots/gain_files/exported_gains.py",
        'if firmware.strict else ""\n        if taken:',
        'if firmware.strict else ""\n        if False:',
        ("tests/extras/autopilots/gain_files/test_versions.py",),
    ),
    Mutation(
        "linear model: the IMU reads the rate at the begin of a sample",
        "workbench/design/linear/sampled_model.py",
        "0.5 * (before + w_B) + noise[:3]",
        "before + noise[:3]",
        ("tests/design/linear/test_sampled.py",),
    ),
    Mutation(
        "regress: pitch judged as roll",
        "workbench/design/regress/signals.py",
        "lambda flown: tilt_angles(flown.q_WB)[1]",
        "lambda flown: tilt_angles(flown.q_WB)[0]",
        ("tests/design/regress/test_signals.py",),
    ),
    Mutation(
        "regress: a setpoint of the period before",
        "workbench/design/regress/flight.py",
        "setpoint = np.append(until[1:], until[-1:])",
        "setpoint = until",
        ("tests/design/regress/test_signals.py",),
    ),
    Mutation(
        "bridge: commands wait through a reset",
        "workbench/systems/bridge.py",
        "for waiting in (self.commands, self._samples,",
        "for waiting in (self._samples,",
        ("tests/systems/test_bridge.py",),
    ),
    Mutation(
        "reach: of a slider only the way upwards",
        "workbench/plant/reach.py",
        "for end in (abs(each.lower), abs(each.upper))",
        "for end in (abs(each.upper),)",
        ("tests/plant/test_reach.py",),
    ),
    Mutation(
        "logs: other samples with one stamp are copies",
        "workbench/extras/flightdata/readers/clock.py",
        "equal = (each[1:] == each[:-1]) | (",
        "equal = (each[1:] == each[1:]) | (",
        ("tests/extras/flightdata/test_clock.py",),
    ),
    Mutation(
        "excitation: the next one's home is where it was asked for",
        "workbench/live/exciter.py",
        "        if not self.end():  # one",
        "        self.end()\n        if True:  # one",
        ("tests/live/test_exciting.py",),
    ),
    Mutation(
        "screens: a reduced gain's margin in dB with the other sign",
        "workbench/gui/tuning/limits.py",
        "        factor=-1.0,",
        "        factor=1.0,",
        ("tests/gui/tuning/test_step_metrics_live.py",),
    ),
    Mutation(
        "screens: a power density by the factor, not its square",
        "workbench/gui/units.py",
        "of.factor**2",
        "of.factor",
        ("tests/gui/test_units.py",),
    ),
    Mutation(
        "overlay: a log is aligned the other way",
        "workbench/gui/visualization/overlays.py",
        "self.shift = float(other - own)",
        "self.shift = float(own - other)",
        ("tests/gui/visualization/test_log_view.py",),
    ),
    Mutation(
        "charts: undershoot limited on the other side",
        "workbench/gui/visualization/limit_lines.py",
        "yield level(label, -0.01 * value * by)",
        "yield level(label, 0.01 * value * by)",
        ("tests/gui/visualization/test_limits.py",),
    ),
    Mutation(
        "sticks: keys that change sides start where the stick is",
        "workbench/gui/joystick/keyboard_sticks.py",
        "start = max(0.0, towards * place)",
        "start = towards * place",
        ("tests/gui/joystick/test_keyboard_sticks.py",),
    ),
    Mutation(
        "excitation: room for a tilt to one side alone",
        "workbench/live/excitation_guard.py",
        "self._check_way((sign * forward).tolist(), needed, where)",
        "self._check_way(forward.tolist(), needed, where)",
        ("tests/live/test_excitation_guard.py",),
    ),
    Mutation(
        "server: a good login clears what others guessed",
        "workbench/link/server/admission.py",
        "        self._guesses.pop(network_of(host), None)\n",
        "        self._guesses.clear()\n",
        ("tests/link/server/test_security.py",),
    ),
    Mutation(
        "server: operations as long as data",
        "workbench/link/wire.py",
        "if kind == _CONTROL_FRAME_KIND and length > self.largest_operation:",
        "if kind == _CONTROL_FRAME_KIND and length > self.largest:",
        ("tests/link/test_wire.py",),
    ),
    Mutation(
        "judge: a delay margin in s as ms",
        "workbench/commands/judgement_tables.py",
        '_number(1e3 * margins.delay_margin, ".1f")',
        '_number(margins.delay_margin, ".1f")',
        ("tests/commands/test_judge.py",),
    ),
    Mutation(
        "tune: margins in JSON in rad as degrees",
        "workbench/commands/tune.py",
        "    factor = metric.file_factor",
        "    factor = 1.0",
        ("tests/commands/test_tune.py",),
    ),
    Mutation(
        "map: what has not settled has a number",
        "workbench/analysis/predicting.py",
        "    values[decay > duration] = np.nan  # they have not settled\n",
        "",
        ("tests/analysis/test_mapping.py",),
    ),
    Mutation(
        "fork: the numbers of a step have the command before it",
        "workbench/analysis/predicting.py",
        "response = branch.response(step.axis) - before",
        "response = branch.response(step.axis)",
        ("tests/analysis/test_predicting.py",),
    ),
    Mutation(
        "regress: products of inertia are no condition",
        "workbench/design/regress/baseline.py",
        'for j, column in list(enumerate("xyz"))[i:]:',
        'for j, column in list(enumerate("xyz"))[i:i+1]:',
        ("tests/design/regress/test_baseline.py",),
    ),
    Mutation(
        "regress: samples of a sensor before their delivery",
        "workbench/design/regress/signals.py",
        "delivered = found[sensor].stamps + found[sensor].latency",
        "delivered = found[sensor].stamps",
        ("tests/design/regress/test_signals.py",),
    ),
    Mutation(
        "trim: above a low ceiling",
        "workbench/design/linear/trim.py",
        'height = min(TRIM_HEIGHT_M, max(0.0, gains["max_height"] - CEILING_DISTANCE_M))',
        "height = TRIM_HEIGHT_M",
        ("tests/design/linear/test_trim.py",),
    ),
    Mutation(
        "translate: a shared gain is that of one axis",
        "workbench/design/translate/translation.py",
        "value = sum(each) / len(each)",
        "value = each[0]",
        ("tests/design/translate/test_translation.py",),
    ),
    Mutation(
        "barometer: the whole downwash at any thrust",
        "workbench/systems/sensors/barometer.py",
        'share = float(inputs["thrusts"].sum()) / weight',
        "share = 1.0",
        ("tests/systems/sensors/test_barometer.py",),
    ),
    Mutation(
        "sidecar: products of inertia in another order",
        "workbench/plant/repaired_inertia.py",
        "        products=(xy, xz, yz),",
        "        products=(xy, yz, xz),",
        ("tests/plant/test_inertia_repair.py",),
    ),
    Mutation(
        "sidecar: the axis of a rotor in the frame of the body",
        "workbench/plant/rotor_sources/sidecar.py",
        "axis_B = X_BL.rotation().multiply(np.array(axis_L) / length)",
        "axis_B = np.array(axis_L) / length",
        ("tests/plant/rotor_sources/test_sidecar.py",),
    ),
    Mutation(
        "recording: setpoints of places to which nothing flies",
        "workbench/session/recording.py",
        "follows, self.reference[:, index], np.nan",
        "follows >= 0, self.reference[:, index], np.nan",
        ("tests/session/test_recording.py",),
    ),
    Mutation(
        "estimate: an angular velocity in rad/s under deg/s",
        "workbench/commands/estimate.py",
        '"rad/s": ("deg/s", math.degrees(1.0)),',
        '"rad/s": ("deg/s", 1.0),',
        ("tests/commands/test_printed_units.py",),
    ),
    Mutation(
        "judge: the bandwidth in its column is the crossover",
        "workbench/commands/judgement_tables.py",
        '_number(margins.bandwidth, ".3g")',
        '_number(margins.crossover, ".3g")',
        ("tests/commands/test_printed_units.py",),
    ),
    Mutation(
        "log: a stream that is late is early",
        "workbench/commands/log.py",
        'f"{1000.0 * each.offset:+.0f}"',
        'f"{-1000.0 * each.offset:+.0f}"',
        ("tests/commands/test_printed_units.py",),
    ),
    Mutation(
        "options: what varies is left out",
        "workbench/commands/chosen_vehicle.py",
        "**dict(args.vary))",
        "**{})",
        ("tests/commands/test_options.py",),
    ),
    Mutation(
        "measurement: a held place is planned as steered",
        "workbench/analysis/judging.py",
        "model = subject.study.sampled(point, gains)",
        "model = subject.study.sampled(HOVER_POINT, gains)",
        ("tests/analysis/test_judging.py",),
    ),
    Mutation(
        "alarms: the roll of a swing at another heading",
        "workbench/live/alarms.py",
        '"roll": ahead * state[7] + aside * state[8]',
        '"roll": ahead * state[7] - aside * state[8]',
        ("tests/live/test_alarms.py",),
    ),
    Mutation(
        "translate: a loop that is half differs by all of it",
        "workbench/design/translate/loop_difference.py",
        "np.abs(two / one - 1.0)",
        "np.abs(one / two - 1.0)",
        ("tests/design/translate/test_translation.py",),
    ),
    Mutation(
        "tune: the least promising start first",
        "workbench/design/tune/search.py",
        'np.argsort(-reserves, kind="stable")',
        'np.argsort(reserves, kind="stable")',
        ("tests/design/tune/test_search.py",),
    ),
    # where what is flown, sent and shown begins, ends and begins anew
    Mutation(
        "identify: whitened rows begin with those that lack their past",
        "workbench/extras/flightdata/identify/whitening.py",
        "return through[order : len(rows)] /",
        "return through[: len(rows)] /",
        ("tests/extras/flightdata/identify/test_whitening.py",),
    ),
    Mutation(
        "identify: a low-pass twice as late",
        "workbench/extras/flightdata/identify/quantities.py",
        "math.sqrt(2.0) / (2.0 * math.pi * flight.gyro_lowpass)",
        "math.sqrt(2.0) / (math.pi * flight.gyro_lowpass)",
        ("tests/extras/flightdata/identify/test_report.py",),
    ),
    Mutation(
        "predict: both components of an uncertain wind from one draw",
        "workbench/extras/flightdata/predict/uncertainty.py",
        "uncertainty.wind * float(drawn[6])",
        "uncertainty.wind * float(drawn[5])",
        ("tests/extras/flightdata/predict/test_what_if.py",),
    ),
    Mutation(
        "telemetry log: the latest arrival sets the clock",
        "workbench/extras/flightdata/readers/tlog_clock.py",
        "    begin = np.full(part[-1] + 1, np.inf)\n    np.minimum.at(",
        "    begin = np.full(part[-1] + 1, -np.inf)\n    np.maximum.at(",
        ("tests/extras/flightdata/test_tlog.py",),
    ),
    Mutation(
        "MAVLink: a mission without the limit of speed",
        "workbench/extras/gateways/mavlink_flight.py",
        "min(self._speed, limits.level_speed) / max(level, 1e-9)",
        "self._speed / max(level, 1e-9)",
        ("tests/extras/gateways/test_mavlink_flight.py",),
    ),
    Mutation(
        "MAVLink: a changed mission is flown on",
        "workbench/extras/gateways/mavlink_vehicle.py",
        "        if changes:\n            self._stop_mission()\n",
        "",
        ("tests/extras/gateways/test_mavlink.py",),
    ),
    Mutation(
        "Betaflight SITL: the axes of the rates",
        "workbench/extras/autopilots/programs/betaflight_packets.py",
        "numbers = (*to_frd(rates), *(",
        "numbers = (*rates, *(",
        ("tests/extras/autopilots/programs/test_betaflight_packets.py",),
    ),
    Mutation(
        "wind: turbulence that begins anew remembers",
        "workbench/systems/wind.py",
        "            discrete_state.set_value(self._filters, np.zeros(EDDY_MEMORY_SIZE))\n",
        "            pass\n",
        ("tests/systems/test_wind.py",),
    ),
    Mutation(
        "telemetry: stamps of before a reset",
        "workbench/systems/telemetry.py",
        "start = start\n        self._stamps = dict.fromkeys(self._stamps, math.nan)\n",
        "start = start\n",
        ("tests/systems/test_telemetry.py",),
    ),
    Mutation(
        "loads: no faster than their origin",
        "workbench/diagram/free_loads.py",
        "float(np.linalg.norm(V_WL.translational())) + turning",
        "float(np.linalg.norm(V_WL.translational()))",
        ("tests/diagram/test_cables.py",),
    ),
    Mutation(
        "joint modes: the sign of the weight",
        "workbench/diagram/joint_modes.py",
        "K[:, number] -= (weights[1]",
        "K[:, number] += (weights[1]",
        ("tests/diagram/test_joints.py",),
    ),
    Mutation(
        "fork: a step in place of the command",
        "workbench/design/fork.py",
        "asked[AXIS_NAMES.index(step.axis)] += step.amplitude",
        "asked[AXIS_NAMES.index(step.axis)] = step.amplitude",
        ("tests/design/test_fork.py",),
    ),
    Mutation(
        "measurement: a single period is told",
        "workbench/live/measurer.py",
        "periods >= MIN_INJECTION_PERIODS and",
        "periods >= 1 and",
        ("tests/live/test_measurer.py",),
    ),
    Mutation(
        "ring: a lidar on a mast is below the body",
        "workbench/gui/instruments/ring_scan.py",
        "height - self._p_BS @ np.array(down_B)",
        "height + self._p_BS @ np.array(down_B)",
        ("tests/gui/instruments/test_lidar_ring.py",),
    ),
    Mutation(
        "a force of a log: the array that is known best decides",
        f"{DESIGN}/regress/case_log.py",
        "what, share = min(shares.items()",
        "what, share = max(shares.items()",
        ("tests/extras/flightdata/test_judged_log.py",),
    ),
    Mutation(
        "a sample that a log has twice: counts twice",
        "workbench/logs/sensor_samples.py",
        "prepend=-np.inf) > 0.0",
        "prepend=-np.inf) >= 0.0",
        ("tests/logs/test_sensor_samples.py",),
    ),
    Mutation(
        "the end of a cut log: that of the topic that ends first",
        "workbench/logs/readers/mcap_log.py",
        "last = max((max(each.t_ns)",
        "last = min((max(each.t_ns)",
        ("tests/logs/test_record.py",),
    ),
    Mutation(
        "the film of a log: begins at the log's zero",
        "workbench/logs/flight_film.py",
        "now = float(time[index] - time[0])",
        "now = float(time[index])",
        ("tests/logs/test_flight_film.py",),
    ),
    Mutation(
        "roles of a server without commands: the asked one",
        "workbench/link/server/policy.py",
        "return login.role if self.allow_commands else Role.VIEW",
        "return login.role",
        ("tests/link/server/test_policy.py",),
    ),
    Mutation(
        "the largest rate that may be excited: the tilt times the time",
        "workbench/live/step_drive.py",
        "self.limit = session.get(axis.limit) / tilt",
        "self.limit = session.get(axis.limit) * tilt",
        ("tests/live/test_exciting.py",),
    ),
    Mutation(
        "another law beside a flight: with the gains of the one that flies",
        "workbench/analysis/subject.py",
        'present.find(name).system != "controller"',
        'present.find(name).system == "controller"',
        ("tests/analysis/test_others.py",),
    ),
    Mutation(
        "deaths of the analyst: also counted after an answer",
        "workbench/analysis/analyst.py",
        "self._deaths = 1 if worker.answered else self._deaths + 1",
        "self._deaths = self._deaths + 1",
        ("tests/analysis/test_deaths.py",),
    ),
    Mutation(
        "home on the map: on the other side of the start",
        "workbench/gui/home/gps_card.py",
        "start = [p - d for p, d",
        "start = [p + d for p, d",
        ("tests/gui/home/test_home_screen.py",),
    ),
    Mutation(
        "a gain that flies: an answer counts though a later value was published",
        "workbench/gui/gains/flown_gains.py",
        "and self._published.get(name, -1.0) < time - _SAME_STEP_TOLERANCE_S",
        "and self._published.get(name, -1.0) < time + 1e9",
        ("tests/gui/gains/test_flown_gains.py",),
    ),
    Mutation(
        "outputs of an autopilot: front right and rear left exchanged",
        "workbench/extras/autopilots/sitl_flight.py",
        "wanted = ((True, False, 1), (False, True, 1)",
        "wanted = ((False, True, 1), (True, False, 1)",
        ("tests/extras/autopilots/programs/test_bridges.py",),
    ),
    Mutation(
        "the mask of a rate setpoint: the bits of roll and yaw exchanged",
        f"{READERS}/tlog_topics.py",
        "_wanted(flu, 1, 2, 4)",
        "_wanted(flu, 4, 2, 1)",
        ("tests/extras/flightdata/test_tlog.py",),
    ),
    Mutation(
        "the push that closes an attitude: the sign of a quaternion counts",
        f"{PREDICT}/driven.py",
        "sign, half, mass = 2.0 if between[0] >= 0.0 else -2.0,",
        "sign, half, mass = 2.0,",
        ("tests/extras/flightdata/predict/test_driven.py",),
    ),
    Mutation(
        "the effect of an order: what the drone showed before counts",
        "workbench/extras/gateways/mavlink_effect.py",
        "if state is not None and state.time > started:",
        "if state is not None:",
        ("tests/extras/gateways/test_mavlink_flight.py",),
    ),
    Mutation(
        "a camera's calibration: x and y of the principal point exchanged",
        "workbench/link/ros_messages/picture_messages.py",
        '"k": (fx, 0.0, cx, 0.0, fy, cy,',
        '"k": (fx, 0.0, cy, 0.0, fy, cx,',
        ("tests/link/ros_messages/test_conversion.py",),
    ),
    Mutation(
        "the log of a later flight: with orders of the one before",
        "workbench/live/log_keeper.py",
        "        self._others.clear()\n",
        "",
        ("tests/live/test_log_keeper.py",),
    ),
    Mutation(
        "speeds of a judged log: the order of motors counts from 0",
        "workbench/logs/judged_log.py",
        "places = [number - 1 for number in order]",
        "places = [number % rotors for number in order]",
        ("tests/extras/flightdata/test_judged_log.py",),
    ),
    Mutation(
        "machine code of two processes: types of records by numba's count",
        "workbench/common/code_cache.py",
        "Record.mangling_args = property(_layout_name)",
        "",
        ("tests/common/test_code_cache.py",),
    ),
    # what must not depend on a frame, an origin or an order; what is connected; limits
    Mutation(
        "drag of the yaw: arms from the origin of the body",
        "workbench/plant/drag.py",
        "arms = np.array([rotor.p_BR[:2] for rotor in frame.rotors]) - frame.p_ToTcm_T[:2]",
        "arms = np.array([rotor.p_BR[:2] for rotor in frame.rotors])",
        ("tests/plant/test_drag.py",),
    ),
    Mutation(
        "tilt of rotors: its point turned the other way",
        "workbench/plant/tilt.py",
        "p_BJ=float_triple(R @ each.p_BJ)",
        "p_BJ=float_triple(R.T @ each.p_BJ)",
        ("tests/plant/test_tilt.py",),
    ),
    Mutation(
        "lag of a servo: without its delay",
        "workbench/plant/servo.py",
        "return behind + self.time_constant + self.delay",
        "return behind + self.time_constant",
        ("tests/plant/test_servos.py",),
    ),
    Mutation(
        "motion of bodies on joints: translational before angular acceleration",
        "workbench/systems/body_motion.py",
        "for part in (A.rotational(), A.translational())]",
        "for part in (A.translational(), A.rotational())]",
        ("tests/systems/test_body_motion.py",),
    ),
    Mutation(
        "bias of a sensor: the number of the first sample",
        "workbench/systems/noise.py",
        "[0, 0, 1, 0]",
        "[0, 0, 0, 0]",
        ("tests/systems/test_noise.py",),
    ),
    Mutation(
        "walls between updates of the mode: of another mode",
        "workbench/systems/mode_manager.py",
        "with_walls(guide, walls, p_WB, FlightMode(int(mode)), settings)",
        "with_walls(guide, walls, p_WB, FlightMode.OFF, settings)",
        ("tests/systems/test_mode_manager.py",),
    ),
    Mutation(
        "rotor on a link: its axis turned the other way",
        "workbench/diagram/forces.py",
        "axis = X_BL.rotation().inverse().multiply(np.array(rotor.axis_B))",
        "axis = X_BL.rotation().multiply(np.array(rotor.axis_B))",
        ("tests/diagram/test_joints.py",),
    ),
    Mutation(
        "obstacles: measured a period before they are read",
        "workbench/diagram/workbench.py",
        "period=_wall_period(setup.rates),\n            lead=setup.rates.physics_step",
        "period=_wall_period(setup.rates),\n            lead=_wall_period(setup.rates)",
        ("tests/diagram/test_workbench.py",),
    ),
    Mutation(
        "yaw rate: without the authority of the pilot",
        "workbench/control/guidance.py",
        "yaw_rate = authority * reference[3]",
        "yaw_rate = reference[3]",
        ("tests/control/test_guidance.py",),
    ),
    Mutation(
        "repeated flight: with what its pilot ended",
        "workbench/session/script.py",
        "scripted = [action for action in scripted if action.at < ended]",
        "scripted = [action for action in scripted if action.at <= ended]",
        ("tests/session/test_script.py",),
    ),
    Mutation(
        "injection: commands behind the lag of the rotors",
        "workbench/design/judge/loop_measurement.py",
        "response[:, : len(most)] *= lag[:, None]",
        "response[:, : len(most)] *= 1.0",
        ("tests/design/judge/test_measured_loop.py",),
    ),
    Mutation(
        "slowest rate: margins of the actuator's cut alone",
        "workbench/design/judge/sampled_stability.py",
        "for margins in (loop.actuator, loop.error))",
        "for margins in (loop.actuator,))",
        ("tests/design/judge/test_sampled_stability.py",),
    ),
    Mutation(
        "sensitivity: settled on the first side of its band",
        "workbench/design/judge/sensitivity.py",
        '"settling_time": max(settled, key=',
        '"settling_time": min(settled, key=',
        ("tests/design/judge/test_hermite.py",),
    ),
)


def mutated(text: str, mutation: Mutation) -> str:
    """Return a file's text with a mutation.

    Raises:
        MutationError: if what it replaces does not stand there exactly once.
    """
    count = text.count(mutation.old)
    if count != 1:
        raise MutationError(
            f"{mutation.file}: '{mutation.old.strip()}' stands there {count} times, not once: "
            f"bring the mutation '{mutation.what}' in tools/mutations.py up to date"
        )
    return text.replace(mutation.old, mutation.new)


def check_list(mutations: Iterable[Mutation]) -> None:
    """Hold the list against the source.

    Raises:
        MutationError: with a line for each mutation that does not fit.
    """
    faults = []
    for mutation in mutations:
        try:
            mutated((ROOT / mutation.file).read_text(encoding="utf-8"), mutation)
            missing = [name for name in mutation.tests if not (ROOT / name).is_file()]
            if missing:
                raise MutationError(f"'{mutation.what}': there is no {', '.join(missing)}")
        except OSError as error:
            faults.append(f"{mutation.file}: cannot be read: {error}")
        except MutationError as error:
            faults.append(str(error))
    if faults:
        raise MutationError("\n".join(faults))


class Copy:
    """A copy of the project, in which one mutation at a time stands."""

    def __init__(self, folder: Path) -> None:
        self._root = folder / "project"
        shutil.copytree(ROOT, self._root, ignore=shutil.ignore_patterns(*LEFT_OUT))
        path = os.pathsep.join([str(self._root), *filter(None, [os.environ.get("PYTHONPATH")])])
        self._environment = {**os.environ, "PYTHONPATH": path, "QT_QPA_PLATFORM": "offscreen"}

    @contextlib.contextmanager
    def with_mutation(self, mutation: Mutation) -> Iterator[None]:
        """Let a mutation stand in the copy."""
        path = self._root / mutation.file
        before = path.read_text(encoding="utf-8")
        path.write_text(mutated(before, mutation), encoding="utf-8")
        yield
        path.write_text(before, encoding="utf-8")

    def failing_test(self, tests: Iterable[str]) -> str:
        """Run test files until a test fails; return its name, or "" if none does."""
        command = ["-m", "pytest", "-q", "-x", "-n", "0", "-p", "no:cacheprovider", "--tb=no"]
        for name in tests:
            done = self._run([*command, name])
            if done.returncode:
                failed = [
                    line.split(" - ")[0].removeprefix("FAILED ").removeprefix("ERROR ")
                    for line in done.stdout.splitlines()
                    if line.startswith(("FAILED ", "ERROR "))
                ]
                return failed[0] if failed else f"{name}, which ends with {done.returncode}"
        return ""

    def changed_cases(self) -> set[str]:
        """Fly the project's own specs; return the cases that are not as they should be."""
        done = self._run(["-m", "workbench", "regress", "--json"])
        if done.returncode not in (0, 1):
            said = done.stderr.strip().splitlines()
            raise MutationError(f"workbench regress: {said[-1] if said else 'ends badly'}")
        cases = json.loads(done.stdout)["cases"]
        return {f"{case['spec']}: {case['case']}" for case in cases if not case["passed"]}

    def _run(self, arguments: list[str]) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, *arguments],
            cwd=self._root,
            env=self._environment,
            capture_output=True,
            text=True,
            check=False,
        )


class Verdict(NamedTuple):
    """Whether a test killed a mutation, and whether a spec noticed it."""

    killed: bool
    noticed: bool


def judge(copy: Copy, mutation: Mutation, options: argparse.Namespace, usual: set[str]) -> Verdict:
    """Print what notices a mutation."""
    print(mutation.what, flush=True)
    killer = changed = ""
    with copy.with_mutation(mutation):
        if options.tests:
            killer = copy.failing_test(mutation.tests)
            if not killer and options.whole:
                killer = copy.failing_test(["tests"])
            print(f"    tests:   {killer or 'NOT NOTICED'}", flush=True)
        if options.specs:
            changed = _changed(copy, usual)
            print(f"    regress: {changed or 'not noticed'}", flush=True)
    return Verdict(bool(killer), bool(changed))


def _changed(copy: Copy, usual: set[str]) -> str:
    """Return the first cases that a mutation changes, or why they could not be flown."""
    try:
        changed = sorted(copy.changed_cases() - usual)
    except MutationError as error:
        return str(error)
    more = f", and {len(changed) - 3} more" if len(changed) > 3 else ""
    return ", ".join(changed[:3]) + more


def main() -> int:
    """Run the mutations that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "words", nargs="*", help="only mutations whose description has one of these"
    )
    parser.add_argument("--list", action="store_true", help="check that the list fits, and show it")
    parser.add_argument("--no-tests", dest="tests", action="store_false", help="fly the specs only")
    parser.add_argument("--no-specs", dest="specs", action="store_false", help="run tests only")
    parser.add_argument(
        "--whole", action="store_true", help="run all tests where the likely ones notice nothing"
    )
    options = parser.parse_args()
    chosen = [
        mutation
        for mutation in MUTATIONS
        if not options.words or any(word in mutation.what for word in options.words)
    ]
    try:
        check_list(MUTATIONS)
        if not chosen:
            raise MutationError(f"no mutation has '{options.words[0]}': --list shows all")
        if options.list:
            for mutation in chosen:
                print(f"{mutation.what}  ({mutation.file})")
            return 0
        with tempfile.TemporaryDirectory() as folder:
            copy = Copy(Path(folder))
            usual: set[str] = set()
            if options.tests:
                print("the tests without a mutation", flush=True)
                failed = copy.failing_test(dict.fromkeys(t for m in chosen for t in m.tests))
                if failed:
                    raise MutationError(f"{failed} fails without any mutation: mend that first")
            if options.specs:
                print("the specs without a mutation", flush=True)
                usual = copy.changed_cases()
                for case in sorted(usual):
                    print(f"    not as it should be, and not counted: {case}", flush=True)
            verdicts = [judge(copy, mutation, options, usual) for mutation in chosen]
    except MutationError as error:
        print(error, file=sys.stderr)
        return 2
    killed = sum(verdict.killed for verdict in verdicts)
    noticed = sum(verdict.noticed for verdict in verdicts)
    if options.tests:
        print(f"{killed} of {len(chosen)} killed by tests")
    if options.specs:
        print(f"{noticed} of {len(chosen)} noticed by the specs")
    return 0 if killed == len(chosen) or not options.tests else 1


if __name__ == "__main__":
    sys.exit(main())
