"""Fly 500 drones that differ from what their controller knows, in turbulence.

    python monte_carlo.py [OUTPUT.png]

Mass, inertia and rotor lag are drawn at random. `Batch` flies them in step, each with its own seed.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import workbench as wb

plt.switch_backend("Agg")
plt.rcParams.update(wb.STYLE)

COUNT, PERIODS = 500, 4 * 128  # four seconds of control periods

random = np.random.default_rng(1)
mass, inertia, lag = 1.0 + np.array([[0.1], [0.3], [0.5]]) * random.uniform(-1, 1, (3, COUNT))
batch = wb.Batch(
    COUNT,
    variations=[wb.Variation(m, i, r) for m, i, r in zip(mass, inertia, lag, strict=True)],
    parameters={"turbulence": 4.0},
    seed=1,
)
batch.setpoint.velocity[:, 0] = 2.0  # in W [m/s]
forward, climb = np.zeros((PERIODS, COUNT)), np.zeros((PERIODS, COUNT))
for period in range(PERIODS):
    batch.step()
    forward[period], climb[period] = batch.velocity[:, 0], batch.velocity[:, 2]
time = np.arange(1, PERIODS + 1) / 128.0
overshoot = 100.0 * (forward.max(axis=0) / 2.0 - 1.0)
sink = np.corrcoef(mass, climb[-128:].mean(axis=0))[0, 1]

print(f"{int(batch.lost.sum())} of {COUNT} are lost")
print(
    f"peak over the command: median {np.median(overshoot):.1f} %, 95 % of the flights below", end=""
)
print(f" {np.quantile(overshoot, 0.95):.1f} %")
print(f"correlation of mass and climb rate {sink:.2f}")

figure, (steps, drift) = plt.subplots(1, 2, figsize=(6.4, 3.6), layout="constrained")
for share, alpha in ((0.0, 0.15), (0.05, 0.3), (0.25, 0.5)):
    low, high = np.quantile(forward, (share, 1.0 - share), axis=1)
    steps.fill_between(time, low, high, color="tab:blue", alpha=alpha, lw=0)
steps.plot(time, np.median(forward, axis=1), "k", lw=1)
steps.set(xlabel="time [s]", ylabel="velocity along x [m/s]", title="all, 90 %, 50 %, median")
drift.scatter(mass, climb[-128:].mean(axis=0), c=lag, s=6)
drift.set(xlabel="mass over the known mass", ylabel="climb rate [m/s]", title="colour: rotor lag")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "monte_carlo.png")
