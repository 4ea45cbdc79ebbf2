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
READERS, ESTIMATION = "workbench/logs/readers", "workbench/estimation"
IDENTIFY, PREDICT = "workbench/design/identify", "workbench/design/predict"
ORACLE = "tests/oracles/test_reference_flights.py"
LOOPS = "tests/oracles/test_loops_by_hand.py"
ROTORS = "tests/dynamics/test_rotors.py"
LAW = "tests/controllers/test_pd.py"
EQUATIONS = "tests/controllers/test_equations.py"
PARSED = "tests/logs/test_parsed_values.py"
FIT, PAST = "tests/design/identify/test_fit.py", "tests/design/predict/test_past.py"


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
        "TIME_CONSTANT = 0.02",
        "TIME_CONSTANT = 0.01",
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
        "past = m.i_rate_z if m.i_rate_z * m.i_rate_z > MOST_TURN * MOST_TURN else 0.0",
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
        f"{CONTROLLERS}/px4.py",
        '"MPC_XY_VEL_I_ACC": 0.2 *',
        '"MPC_XY_VEL_I_ACC": 2.0 *',
        ("tests/controllers/test_rules.py",),
    ),
    Mutation(
        "commands: rounded down in place of to the nearest",
        f"{CONTROL}/flight_law.py",
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
        "workbench/link/server/client_session.py",
        "min(OPERATION_BURST, self._operations + OPERATIONS * passed)",
        "self._operations + OPERATIONS * passed",
        ("tests/link/server/test_hub.py",),
    ),
    Mutation(
        "server: topics wait without limit",
        "workbench/live/network.py",
        "self.offer(published, MOST_TOPICS)",
        "self.offer(published, 1000 * MOST_TOPICS)",
        ("tests/live/test_server_process.py",),
    ),
    Mutation(
        "mailbox: the first command is dropped",
        f"{SYSTEMS}/bridge.py",
        "            self._commands.pop()\n",
        "            self._commands.popleft()\n",
        ("tests/systems/test_bridge.py",),
    ),
    Mutation(
        "export: a gain that must not fly is written",
        "workbench/gains/autopilots/exchange.py",
        'raise WorkbenchError(f"{firmware.file_name(name)} {why}; nothing is exported")',
        "continue",
        ("tests/gains/autopilots/test_exchange.py",),
    ),
    Mutation(
        "injection: its loops stay as they are at its end",
        "workbench/session/session.py",
        "            self._live.close_loops()\n        self._injecting = None",
        "            pass\n        self._injecting = None",
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
        "bound = min(wish.bound, ROOM * min(rule, now))",
        "bound = min(wish.bound, ROOM * max(rule, now))",
        ("tests/design/tune/test_requirement.py",),
    ),
    Mutation(
        "tune: an unstable loop has a margin above 0",
        f"{DESIGN}/tune/measure.py",
        "GROWTH_AS_MARGIN = -0.1",
        "GROWTH_AS_MARGIN = 0.1",
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
        f"{DESIGN}/compare.py",
        "away[flight.time > flight.time[-1] - 1.0].mean()",
        "away[flight.time < flight.time[-1] - 1.0].mean()",
        ("tests/design/test_compare.py",),
    ),
    Mutation(
        "compare: the smallest overshoot of the vehicles in place of the worst",
        f"{DESIGN}/compare.py",
        "known.overshoot[~gone].max(initial=0.0)",
        "known.overshoot[~gone].min(initial=0.0)",
        ("tests/design/test_compare.py",),
    ),
    Mutation(
        "regress: saturation of all rotors in place of any",
        f"{DESIGN}/regress/measures.py",
        "(flight.judged.commanded_speeds >= FULL * limits).any(axis=1)",
        "(flight.judged.commanded_speeds >= FULL * limits).all(axis=1)",
        ("tests/design/regress/test_measures.py",),
    ),
    Mutation(
        "load: a torque at ten times its arm",
        f"{DESIGN}/load_step.py",
        "lever = SHARE * float(np.linalg.norm(hubs, axis=1).mean())",
        "lever = float(np.linalg.norm(hubs, axis=1).mean())",
        ("tests/design/test_load_step.py",),
    ),
    Mutation(
        "session: a gain that a law cannot design with stays",
        "workbench/session/live_context.py",
        "                gains.SetFromVector(before)\n                raise",
        "                raise",
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
        "_LAPSE = 0.0065",
        "_LAPSE = 0.005",
        ("tests/systems/sensors/test_standard_atmosphere.py",),
    ),
    Mutation(
        "magnetometer: turned the wrong way",
        f"{SYSTEMS}/sensors/noisy_sensor.py",
        'field = (motion(inputs["state"], p_BS).R_WB @ R_BS).T @ field_W',
        'field = (motion(inputs["state"], p_BS).R_WB @ R_BS) @ field_W',
        ("tests/systems/sensors/test_magnetometer.py",),
    ),
    Mutation(
        "battery: empty in half the time",
        f"{SYSTEMS}/battery.py",
        "used = PERIOD * _power(thrusts) / self._hover_power / duration",
        "used = 2.0 * PERIOD * _power(thrusts) / self._hover_power / duration",
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
        "self._gate(context) ** 2 * told[:, 1]",
        "self._gate(context) * told[:, 1]",
        ("tests/systems/test_navigation.py",),
    ),
    Mutation(
        "payload: the law is not designed anew when it becomes known",
        f"{SYSTEMS}/flight_computer.py",
        "SetFromVector(list(payload))\n        self.design(context)",
        "SetFromVector(list(payload))",
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
        f"{READERS}/ulog.py",
        'Row(_RATES, ("thrust_body[2]",), _THRUST, "1", np.negative)',
        'Row(_RATES, ("thrust_body[2]",), _THRUST, "1")',
        (PARSED,),
    ),
    Mutation(
        "log: PX4's stamps of samples taken where some are zero",
        f"{READERS}/ulog.py",
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
        "channels[int(function) - MOTOR_1 + 1] = channel",
        "channels[channel] = channel",
        (PARSED,),
    ),
    Mutation(
        "log: pitch rate setpoint of a Crazyflie not turned",
        f"{READERS}/crazyflie_usd.py",
        '("rate_setpoint.w_y", "rad/s", -_DEG)',
        '("rate_setpoint.w_y", "rad/s", _DEG)',
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
        "workbench/logs/measured_flight.py",
        "max(bridge, BRIDGE * told_every))",
        "np.inf)",
        ("tests/logs/test_measured_flight.py",),
    ),
    Mutation(
        "log: clock offsets the other way",
        "workbench/logs/flight_contents.py",
        "return float((lags[best] + part) * _GRID), float(at)",
        "return float(-(lags[best] + part) * _GRID), float(at)",
        ("tests/logs/test_flight_contents.py",),
    ),
    # identification and prediction
    Mutation(
        "identify: specific force a row early",
        f"{IDENTIFY}/fit.py",
        "blocks(flight.force, block)[1:],",
        "blocks(flight.force, block)[:-1],",
        (FIT,),
    ),
    Mutation(
        "identify: grid of averaged samples moved the other way",
        f"{IDENTIFY}/fit.py",
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
        f"{IDENTIFY}/report.py",
        "last.append(replace(flight, good=flight.good & ~seen))",
        "last.append(replace(flight, good=flight.good & seen))",
        (FIT,),
    ),
    Mutation(
        "identify: impacts not spread",
        f"{IDENTIFY}/flight.py",
        "binary_dilation(hard, np.ones(2 * round(AWAY * flight.rate) + 1))",
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
        "seen[0] if seen[3] <= GPS_HELD else 0.0",
        "seen[0]",
        ("tests/estimation/test_complementary_motion.py",),
    ),
    Mutation(
        "estimator: a range finder that looks up",
        f"{ESTIMATION}/ekf.py",
        "if down > LEAST_LOOK:",
        "if abs(down) > LEAST_LOOK:",
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
        "workbench/gateways/ros_messages/making.py",
        "_diagonal([*_turned(turn, velocity)",
        '_diagonal([*_turned({**turn, "w": -turn["w"]}, velocity)',
        ("tests/gateways/ros_messages/test_conversion.py",),
    ),
    Mutation(
        "margins: delay of the nearer side",
        "workbench/design/judge/margins.py",
        "delay_margin=float((turn / crossings)",
        "delay_margin=float((np.minimum(turn, 2.0 * math.pi - turn) / crossings)",
        ("tests/design/judge/test_margins.py",),
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
