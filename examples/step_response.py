"""Fly a step of velocity along x on the full diagram, and read its metrics.

    python step_response.py [OUTPUT.png]

The dashed line is the step of the linear model, which knows no limits of tilt or rotors.
"""

import sys

import matplotlib.pyplot as plt

import workbench as wb

plt.switch_backend("Agg")
plt.rcParams.update(wb.STYLE)

AMPLITUDE = 2.0  # [m/s]

step = wb.fly_step("x", AMPLITUDE)
found = step.metrics
linear = wb.linear_step(wb.LinearStudy().sampled(), "reference_v_x", "v_x", len(step.time))

print(f"rise time {found.rise_time:.2f} s")
print(f"settling time {found.settling_time:.2f} s, overshoot {found.overshoot:.1f} %")
print(f"the fastest rotor runs at {100 * step.peak_rotor_use:.0f} % of its limit")

figure, axes = plt.subplots(figsize=(6.4, 3.8), layout="constrained")
axes.plot(step.time, AMPLITUDE * linear, "--", color="0.5", label="linear model")
axes.plot(step.time, step.response, label="flown")
final = found.steady_state_value
axes.axhspan(0.98 * final, 1.02 * final, color="tab:green", alpha=0.2, label="within 2 %")
axes.axvline(found.settling_time, color="tab:green", ls=":", label="settled")
axes.set(xlabel="time since the command's edge [s]", ylabel="velocity along x [m/s]", xlim=(0, 4))
axes.set_title(f"rise {found.rise_time:.2f} s, overshoot {found.overshoot:.1f} %")
axes.legend(loc="lower right")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "step_response.png")
