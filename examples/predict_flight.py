"""Log a flight of a drone that is not as described, and predict it with the described model.

    python predict_flight.py [OUTPUT.png]

With your own log, start at `read_flight`: it reads PX4, ArduPilot, Betaflight, Crazyflie and CSV.
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt

import workbench as wb
from workbench.extras import flightdata

plt.switch_backend("Agg")
plt.rcParams.update(wb.STYLE)

hidden = wb.VehicleConfig(variation=wb.Variation(mass=1.05, inertia=1.4, rotor_lag=2.0))
corners = ([2.0, 0.0, 1.5], [2.0, 2.0, 1.5], [0.0, 2.0, 1.5], [0.0, 0.0, 1.5])
script = [wb.Action(at=1.0 + 3.0 * k, go_to=corner) for k, corner in enumerate(corners)]
real = wb.Scenario(vehicle=hidden, duration=13.0, script=script)

with TemporaryDirectory() as folder:
    path = Path(folder) / "square.mcap"
    wb.LoggedFlight(path, real, {"turbulence": 2.0}).run(lambda share: None)
    log = wb.read_flight(path)

vehicle, law = wb.load_vehicle(wb.find_model("dh_drone")), wb.load_controller("pd")
gains = wb.flight_gains(vehicle, controller=law)
motion = flightdata.motion_of(log, vehicle)
found = flightdata.Predictor(vehicle, law, gains, real.rates.control_period).predict(motion)
closed = next(row for row in flightdata.summarized([found]).methods if row.method == "closed loop")
whole = found.whole

print(f"{len(found.starts)} predictions, half a second ahead: {100 * closed.position:.1f} cm")
print(f"the whole flight: {100 * whole.rmse:.0f} cm")
print(f"the setpoint, late: {100 * whole.late_rmse:.0f} cm")

figure, (above, over) = plt.subplots(1, 2, figsize=(6.4, 3.6), layout="constrained")
for name, path_W in (("logged", whole.real), ("predicted", whole.flown)):
    above.plot(path_W[:, 0], path_W[:, 1], label=name)
    over.plot(whole.time, path_W[:, 0], label=name)
over.plot(motion.time, motion.setpoint[:, 0], "--", color="0.5", lw=1, label="setpoint")
above.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", title="from above")
over.set(xlabel="time [s]", ylabel="x [m]", ylim=(-0.3, 2.9))
over.legend(loc="upper right", ncols=2)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "predict_flight.png")
