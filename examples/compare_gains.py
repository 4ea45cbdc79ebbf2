"""Compare two sets of gains: the same step, the tilt that it needs, and the margins.

    python compare_gains.py [OUTPUT.png]

A soft and a stiff set for roll, pitch and the velocity along x.
"""

import math
import sys

import matplotlib.pyplot as plt
import numpy as np

import workbench as wb

plt.switch_backend("Agg")
plt.rcParams.update(wb.STYLE)

SETS = {
    "soft": {"kp_velocity_x": 2.0, "kp_pitch": 120.0},
    "stiff": {"kp_velocity_x": 7.0, "kp_pitch": 300.0},
}

study = wb.LinearStudy()
figure, (response, tilt) = plt.subplots(2, figsize=(6.4, 5), sharex=True, layout="constrained")
for name, gains in SETS.items():
    step = wb.fly_step("x", 1.0, settings=gains)
    pitch = wb.loop_margins(study.sampled(gains=gains), wb.find_loop("pitch").actuator)
    print(
        f"{name}: rise time {step.metrics.rise_time:.2f} s, "
        f"overshoot {step.metrics.overshoot:.1f} %, "
        f"phase margin of pitch {math.degrees(pitch.phase_margin):.0f} deg"
    )
    response.plot(step.time, step.response, label=name)
    tilt.plot(step.time, np.degrees(step.recording.between(1.0, np.inf).tilt), label=name)
response.axhline(1.0, color="0.4", ls="--", lw=1)
response.set(ylabel="velocity along x [m/s]", title="a step of 1 m/s with two sets of gains")
tilt.set(ylabel="tilt [deg]", xlabel="time since the command's edge [s]", xlim=(0, 3))
response.legend(loc="lower right")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "compare_gains.png")
