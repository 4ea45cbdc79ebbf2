"""Take a crate with an arm of two links, carry it a metre, and set it down.

    python take_crate.py [OUTPUT.png]

The law carries the weight of the crate while the gripper is closed, and no longer.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import workbench as wb

plt.switch_backend("Agg")
plt.rcParams.update(wb.STYLE)

session = wb.Session(wb.load_scenario(wb.find_scenario("take-crate")))
places = []
for _ in range(26 * 16):
    session.tick(1.0 / 16.0)
    places.append(session.pose("world", "crate").translation())
flown, crate = session.recording(), np.array(places)
time = np.arange(1, len(crate) + 1) / 16.0

taut = flown.tensions.sum(axis=1)
held = flown.between(14.0, 15.0).total_thrust.mean()
free = flown.between(21.5, 22.5).total_thrust.mean()
print(f"thrust {held:.2f} N with the crate and {free:.2f} N without: {held - free:.2f} N less")
print(f"it stands {crate[-1, 0]:.2f} m from where it was taken")

figure, (places, forces) = plt.subplots(2, figsize=(6.4, 5), sharex=True, layout="constrained")
places.plot(flown.time, flown.p_WB[:, 2], label="drone, height")
places.plot(time, crate[:, 2], label="crate, height")
places.plot(time, crate[:, 0], "--", label="crate, way to the east")
forces.plot(flown.time, flown.force_W[:, 2], label="lift of the rotors")
forces.plot(flown.time, taut, label="hold of the gripper")
places.set(ylabel="[m]", ylim=(-0.2, 2.0), title="An arm carries a crate")
forces.set(ylabel="force [N]", xlabel="time [s]")
places.legend(loc="upper left")
forces.legend()
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "take_crate.png")
