"""Land on legs with springs and dampers: how far they give way, and what the ground bears.

    python landing_gear.py [OUTPUT.png]

At rest each leg bears its share of the weight: it is compressed by m g / (4 k).
"""

import sys

import matplotlib.pyplot as plt

import workbench as wb

plt.switch_backend("Agg")
plt.rcParams.update(wb.STYLE)

DAMPINGS = ("1", "7", "15")  # [N s/m], of a leg

figure, (springs, ground) = plt.subplots(2, figsize=(6.4, 5), sharex=True, layout="constrained")
for damping in DAMPINGS:
    scenario = wb.load_scenario(wb.find_scenario("touch-down"))
    scenario.vehicle.args["damping"] = damping
    session = wb.Session(scenario, {"landing_speed": 0.5})
    session.run()
    flown = session.recording()
    legs = 1e3 * flown.joints[:, 0]
    forces = flown.contact_forces.reshape(len(flown.time), -1, 3)[:, :, 2].sum(axis=1)
    time = flown.time - flown.time[forces > 0.0][0]
    print(f"{damping} N s/m: {legs.max():.1f} mm at most, {legs[-1]:.1f} mm at rest")
    springs.plot(time, legs, label=f"damping {damping} N s/m")
    ground.plot(time, forces)
ground.axhline(flown.vehicle.mass * 9.81, color="grey", linestyle=":", label="weight")
springs.set(ylabel="compression of a leg [mm]", xlim=(-0.2, 1.8))
ground.set(ylabel="force of the ground [N]", xlabel="time from the touch-down [s]", ylim=(-2, 40))
springs.legend()
ground.legend()
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "landing_gear.png")
