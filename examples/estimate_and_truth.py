"""Fly on the estimate of a Kalman filter, and compare its errors with the deviations it states.

    python estimate_and_truth.py [OUTPUT.png]

The drone flies on the estimate, as it would outdoors. The errors must lie within the band.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import workbench as wb

plt.switch_backend("Agg")
plt.rcParams.update(wb.STYLE)

noisy = wb.VehicleConfig(args={"gps_noise": "0.3"})  # [m], of the shipped description
session = wb.Session(wb.Scenario(estimator="ekf", vehicle=noisy))
for velocity, duration in (([1.5, 0.0, 0.0], 3.0), ([0.0, 1.0, 0.5], 3.0), ([0.0, 0.0, 0.0], 4.0)):
    session.command(velocity=velocity)
    session.tick(duration)
flown = session.recording()

# estimate: q_WB (4), p_WB (3), w_WB (3), v_WB (3); deviations: attitude, position, velocity, ..
errors = {
    "position x [m]": (flown.estimate[:, 4] - flown.p_WB[:, 0], flown.deviations[:, 3]),
    "height [m]": (flown.estimate[:, 6] - flown.p_WB[:, 2], flown.deviations[:, 5]),
    "velocity x [m/s]": (flown.estimate[:, 10] - flown.v_WB[:, 0], flown.deviations[:, 6]),
}
figure, panels = plt.subplots(3, figsize=(6.4, 5.4), sharex=True, layout="constrained")
for axes, (name, (error, deviation)) in zip(panels, errors.items(), strict=True):
    inside = 100.0 * np.mean(np.abs(error) < 3.0 * deviation)
    print(f"{name}: rms error {error.std():.3f}, {inside:.0f} % within three deviations")
    axes.fill_between(flown.time, -3 * deviation, 3 * deviation, color="tab:blue", alpha=0.2, lw=0)
    axes.plot(flown.time, error, lw=1)
    axes.set(ylabel=name)
panels[0].set_title("estimate minus truth, and three standard deviations that the filter states")
panels[-1].set(xlabel="time [s]")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "estimate_and_truth.png")
