"""Follow the poles of the sampled closed loop while kp of roll and pitch grows.

    python poles_over_gain.py [OUTPUT.png]

Poles of the z plane are drawn as s = ln(z) / period. The search for the limit halves an interval.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import workbench as wb

plt.switch_backend("Agg")
plt.rcParams.update(wb.STYLE)

study = wb.LinearStudy()  # reads the vehicle once


def poles(factor):
    """Return the poles with kp_roll and kp_pitch scaled by a factor [1/s]."""
    gains = {name: factor * study.gains[name] for name in ("kp_roll", "kp_pitch")}
    model = study.sampled(gains=gains)
    z = np.linalg.eigvals(model.A)
    return np.log(z[np.abs(z) > 1e-6]) / model.period


def growth(factor):
    """Return the growth rate of the fastest growing mode that oscillates [1/s]."""
    return max(s.real for s in poles(factor) if abs(s.imag) > 1.0)


low, high = 1.0, 6.0
while high - low > 0.01:
    middle = 0.5 * (low + high)
    low, high = (middle, high) if growth(middle) < 0.0 else (low, middle)
print(f"growth rate of the oscillation now {growth(1.0):.2f} 1/s")
print(f"kp may grow by a factor of {low:.2f}")

figure, axes = plt.subplots(figsize=(6.4, 4.6), layout="constrained")
for factor in np.geomspace(0.3, 1.2 * high, 60):
    s = poles(factor)
    dots = axes.scatter(s.real, s.imag, c=np.full(len(s), factor), s=6, vmin=0.3, vmax=1.2 * high)
now = poles(1.0)
axes.plot(now.real, now.imag, "kx", ms=6, label="now")
axes.axvline(0.0, color="tab:red", lw=0.8)
axes.set(xlabel="real part [1/s]", ylabel="imaginary part [rad/s]", xlim=(-60, 10), ylim=(-5, 45))
axes.set_title(f"unstable from {low:.2f} times the kp of roll and pitch on")
figure.colorbar(dots, label="factor on kp")
axes.legend(loc="upper left")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "poles_over_gain.png")
