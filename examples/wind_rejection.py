"""Hold a position in wind, turbulence and a gust, with and without integral action.

    python wind_rejection.py [OUTPUT.png]

The law `pd` has no integral action, so a steady wind holds it away from its position; `lqi` has.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import workbench as wb

plt.switch_backend("Agg")
plt.rcParams.update(wb.STYLE)

WIND = {"wind_x": 5.0, "turbulence": 7.7}  # [m/s]; light turbulence of MIL-F-8785C
GUST_AT, GUST = 8.0, [0.0, 6.0, 0.0]  # [s], [m/s]

figure, (off, air) = plt.subplots(2, figsize=(6.4, 5), sharex=True, layout="constrained")
for law in ("pd", "lqi"):
    session = wb.Session(wb.Scenario(controller=law, duration=12.0), WIND)
    session.tick(GUST_AT)
    session.gust(GUST, duration=2.0)
    session.tick(12.0 - GUST_AT)
    flown = session.recording()
    distance = np.linalg.norm(flown.p_WB - flown.p_WB[0], axis=1)
    calm = distance[(flown.time > 5.0) & (flown.time < GUST_AT)]
    print(
        f"{law}: {calm.mean():.2f} m off in the wind, "
        f"{distance[flown.time >= GUST_AT].max():.2f} m in the gust"
    )
    off.plot(flown.time, distance, label=law)
air.plot(flown.time, flown.wind_W[:, :2], label=["east", "north"])
off.set(ylabel="distance from the position [m]", title="pd has no integral action, lqi has")
air.set(ylabel="velocity of the air [m/s]", xlabel="time [s]")
off.legend()
air.legend()
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "wind_rejection.png")
