"""A control law of your own, in the file that flies it: P on velocity, PD on tilt.

    python own_law.py [OUTPUT.png]

`workbench step --controller own_law.py --axis x` and the other commands take this file, too.
"""

import sys
from pathlib import Path

from workbench.controllers import (
    GRAVITY,
    attitude_error,
    attitude_matrix,
    gain,
    into_body,
    moment,
    tilted,
    velocity_setpoint,
)

PARAMETERS = [
    gain("p_velocity", "1/s", (0.1, 20.0), 3.0, "velocity P gain"),
    gain("p_tilt", "1/s^2", (0.0, 500.0), 150.0, "tilt P gain"),
    gain("d_tilt", "1/s", (0.0, 100.0), 20.0, "tilt D gain"),
    gain("p_yaw", "1/s", (0.0, 30.0), 4.0, "yaw rate P gain"),
]


def update(measured, setpoint, g, vehicle, memory, dt, loops):
    """Return the force along the thrust axis and the moments, and no memory."""
    v_x, v_y, v_z, yaw_rate = velocity_setpoint((0.0, 0.0, 0.0), measured, setpoint, g)
    v, p = measured.v_WBcm, g.p_velocity
    f_W = tilted(p * (v_x - v[0]), p * (v_y - v[1]), p * (v_z - v[2]) + GRAVITY, g)
    R = attitude_matrix(measured.q_WT)
    f, w = into_body(R, f_W), into_body(R, measured.w_WB)
    e = attitude_error(f, w, (R[6] * yaw_rate, R[7] * yaw_rate, R[8] * yaw_rate))
    alpha = g.p_tilt * e[0] - g.d_tilt * w[0], g.p_tilt * e[1] - g.d_tilt * w[1], g.p_yaw * e[2]
    return (vehicle.mass * f[2], *moment(alpha, w, vehicle.inertia)), memory


if __name__ == "__main__":
    import matplotlib.pyplot as plt

    import workbench as wb

    plt.switch_backend("Agg")
    plt.rcParams.update(wb.STYLE)
    figure, axes = plt.subplots(figsize=(6.4, 3.8), layout="constrained")
    for law in (__file__, "pd"):
        step = wb.fly_step("x", 1.0, scenario=wb.Scenario(controller=law))
        name, found = Path(law).stem, step.metrics
        print(f"{name}: rise time {found.rise_time:.2f} s, overshoot {found.overshoot:.1f} %")
        axes.plot(step.time, step.response, label=name)
    axes.set(xlabel="time [s]", ylabel="velocity along x [m/s]", xlim=(0, 4))
    axes.set_title("own_law does not compensate drag, pd does")
    axes.legend(loc="lower right")
    figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "own_law.png")
