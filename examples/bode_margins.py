"""Draw the Bode plot of the pitch loop with python-control, and mark its margins.

    python bode_margins.py [OUTPUT.png]

The model is exact: sampled at the control rate, with hold and rotor lag. The loops of velocity stay
closed: they turn the phase at low frequencies. The last line is half the sample rate.
"""

import math
import sys

import control
import matplotlib.pyplot as plt
import numpy as np

import workbench as wb

plt.switch_backend("Agg")
plt.rcParams.update(wb.STYLE)

model = wb.LinearStudy().sampled()
loop = model.open_loop("pitch_acceleration")  # a control.StateSpace with the period loop.dt
margins = wb.loop_margins(model, "pitch_acceleration")
degrees = math.degrees(margins.phase_margin)

print(f"{loop.nstates} states, a sample every {1e3 * loop.dt:.2f} ms")
print(f"crossover {margins.crossover:.1f} rad/s, phase margin {degrees:.0f} deg")
print(f"gain margin {margins.gain_margin:.1f}, delay margin {1e3 * margins.delay_margin:.0f} ms")

figure, (size, phase) = plt.subplots(2, figsize=(6.4, 5), sharex=True, layout="constrained")
frequencies = np.geomspace(1.0, math.pi / loop.dt, 400)
control.bode_plot(loop, frequencies, ax=np.array([[size], [phase]]), dB=True, deg=True, title="")
size.axhline(0.0, color="0.4", lw=0.8)
size.axvline(margins.crossover, color="tab:red", ls=":")
phase.axvline(margins.crossover, color="tab:red", ls=":")
phase.axhline(-180.0, color="0.4", lw=0.8)
size.set_title(f"pitch loop at its actuator: phase margin {degrees:.0f} deg")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "bode_margins.png")
