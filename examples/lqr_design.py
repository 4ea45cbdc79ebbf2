"""Design an LQR with python-control from the linear model of the vehicle, and fly it.

    python lqr_design.py [OUTPUT.png]

Its feedback of position, velocity, tilt and rate is a set of gains of the law `pd`. The design has
no rotor lag, hold or delay; the margins of the exact sampled loop show what these cost.
"""

import math
import sys

import control
import matplotlib.pyplot as plt
import numpy as np

import workbench as wb

plt.switch_backend("Agg")
plt.rcParams.update(wb.STYLE)

study = wb.LinearStudy()
model = study.bare_vehicle()
chain = [model.state_names.index(name) for name in ("p_x", "v_x", "pitch", "w_y")]
A = model.A[np.ix_(chain, chain)]
B = np.array([[0.0], [0.0], [0.0], [1.0]])  # the input is an angular acceleration [rad/s^2]
K, _, poles = control.lqr(A, B, np.diag([1e4, 2e3, 0.0, 0.0]), np.eye(1))

gains = {"kp_position_xy": K[0, 0] / K[0, 1]}
for velocity, angle in (("x", "pitch"), ("y", "roll")):
    gains[f"kp_velocity_{velocity}"] = wb.GRAVITY * K[0, 1] / K[0, 2]
    gains[f"kd_velocity_{velocity}"] = 0.0
    gains[f"kp_{angle}"] = K[0, 2]
    gains[f"kd_{angle}"] = K[0, 3]
margins = wb.loop_margins(study.sampled(gains=gains), wb.find_loop("pitch").actuator)

session = wb.Session(settings=gains)
session.go_to([1.0, 0.0, 1.5])
session.tick(4.0)
flown = session.recording()
closed = control.ss(A - B @ K, B * K[0, 0], np.eye(1, 4), 0.0)
design = control.step_response(closed, flown.time).outputs
error = np.abs(design - flown.p_WB[:, 0]).max()

print("designed poles:", ", ".join(f"{pole:.1f}" for pole in poles))
print(f"phase margin of pitch {math.degrees(margins.phase_margin):.0f} deg, 60 deg without lag")
print(f"flown and designed are {100 * error:.1f} cm apart at most")

figure, axes = plt.subplots(figsize=(6.4, 3.8), layout="constrained")
axes.plot(flown.time, design, "--", color="0.5", label="designed, without rotor lag")
axes.plot(flown.time, flown.p_WB[:, 0], label="flown on the full diagram")
axes.set(xlabel="time [s]", ylabel="x [m]", title="LQR: to a point 1 m ahead")
axes.legend(loc="lower right")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "lqr_design.png")
