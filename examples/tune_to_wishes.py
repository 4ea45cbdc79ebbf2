"""Tune the horizontal axes to a rise time and a phase margin, from gains that overshoot.

    python tune_to_wishes.py [OUTPUT.png]

The search includes the worst corners of mass, inertia and rotor lag. The result flies on the full
diagram before it counts.
"""

import math
import sys

import matplotlib.pyplot as plt

import workbench as wb

plt.switch_backend("Agg")
plt.rcParams.update(wb.STYLE)

BEFORE = {f"kp_velocity_{axis}": 7.0 for axis in "xy"}
BEFORE |= {f"kp_{axis}": 120.0 for axis in ("roll", "pitch")}
BEFORE |= {f"kd_{axis}": 13.0 for axis in ("roll", "pitch")}

wishes = wb.wishes_for(
    "level.rise_time <= 0.4 s",
    "level.overshoot <= 5 %",
    "tilt.phase_margin >= 40 deg",
    defaults=False,
)
tuned = wb.tune(wishes, settings=BEFORE)

study = wb.LinearStudy()
figure, axes = plt.subplots(figsize=(6.4, 3.8), layout="constrained")
for name, gains in (("before", BEFORE), ("after", tuned.gains)):
    step = wb.fly_step("x", 1.0, settings=gains)
    margins = wb.loop_margins(study.sampled(gains=gains), wb.find_loop("pitch").actuator)
    print(
        f"{name}: rise time {step.metrics.rise_time:.2f} s, "
        f"overshoot {step.metrics.overshoot:.1f} %, "
        f"phase margin {math.degrees(margins.phase_margin):.0f} deg"
    )
    axes.plot(step.time, step.response, label=name)
print(f"all wishes are met: {tuned.met}, after {tuned.evaluations} candidates")
axes.axhline(1.0, color="0.4", ls="--", lw=1)
axes.set(xlabel="time since the command's edge [s]", ylabel="velocity along x [m/s]", xlim=(0, 4))
axes.set_title("wished: rise within 0.4 s, overshoot below 5 %, phase margin of 40 deg")
axes.legend(loc="lower right")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "tune_to_wishes.png")
