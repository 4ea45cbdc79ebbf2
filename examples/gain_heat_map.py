"""Sweep two gains of the horizontal axis, and draw the settling time as a heat map.

    python gain_heat_map.py [OUTPUT.png]

Flights are compiled; the best candidate flies on the full diagram, too. Grey: not settled or lost.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import workbench as wb

plt.switch_backend("Agg")
plt.rcParams.update(wb.STYLE)

table = wb.sweep(
    ["kp_velocity_x=1..12:16", "kp_pitch=50..400:16"],
    axis="x",
    amplitude=1.0,
    settings={"kd_pitch": 27.0},
)
best = wb.prove_best(table, "settling_time")
velocity, pitch = best.parameters
settling = table.column("settling_time").reshape(16, 16)
overshoot = table.column("overshoot").reshape(16, 16)
first = table.column("kp_velocity_x").reshape(16, 16)
second = table.column("kp_pitch").reshape(16, 16)

print(f"{len(table)} flights, of which {np.isfinite(settling).sum()} settled")
print(f"settles first with kp_velocity_x {velocity:.2f} 1/s, kp_pitch {pitch:.0f} 1/s^2")
print(f"settling time from {np.nanmin(settling):.2f} to {np.nanmax(settling):.2f} s")

figure, axes = plt.subplots(figsize=(6.4, 4.4), layout="constrained")
axes.set_facecolor("0.8")
axes.grid(visible=False)
mesh = axes.pcolormesh(first, second, settling, cmap="viridis_r", vmax=3.0, shading="nearest")
lines = axes.contour(first, second, overshoot, levels=[2, 5, 10, 20], colors="white", linewidths=1)
axes.clabel(lines, fmt="%g %%")
axes.plot(velocity, pitch, "r*", ms=12, label="settles first")
axes.set(xlabel="kp_velocity_x [1/s]", ylabel="kp_pitch [1/s²]")
axes.set_title("settling time of a 1 m/s step in colours, overshoot in lines")
figure.colorbar(mesh, label="settling time [s]", extend="max")
axes.legend(loc="upper right")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "gain_heat_map.png")
