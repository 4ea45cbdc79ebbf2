"""A quadrotor in MuJoCo: one free body, four thrusts with reaction torques, a ground to land on."""

import math
import time

import mujoco
from serving import serve

STEP = 0.001
"""Of the physics [s]; MuJoCo's Euler integration."""
STEPS = 4
"""Of the physics a control period: 250 Hz."""
MASS, ARM, MOMENT, GRAVITY, HEIGHT = 1.5, 0.2, 0.016, 9.81, 10.0
INERTIA = (0.03, 0.03, 0.05)
MODEL = f"""
<mujoco>
  <option timestep="{STEP}" gravity="0 0 -{GRAVITY}"/>
  <worldbody>
    <geom type="plane" size="100 100 1"/>
    <body name="drone" pos="0 0 {HEIGHT}">
      <freejoint/>
      <inertial pos="0 0 0" mass="{MASS}" diaginertia="{" ".join(map(str, INERTIA))}"/>
      <geom type="box" size="0.2 0.2 0.05"/>
      <site name="a" pos="{ARM} {-ARM} 0"/>
      <site name="b" pos="{ARM} {ARM} 0"/>
      <site name="c" pos="{-ARM} {ARM} 0"/>
      <site name="d" pos="{-ARM} {-ARM} 0"/>
    </body>
  </worldbody>
  <actuator>
    <motor site="a" gear="0 0 1 0 0 {MOMENT}" ctrlrange="0 12"/>
    <motor site="b" gear="0 0 1 0 0 {-MOMENT}" ctrlrange="0 12"/>
    <motor site="c" gear="0 0 1 0 0 {MOMENT}" ctrlrange="0 12"/>
    <motor site="d" gear="0 0 1 0 0 {-MOMENT}" ctrlrange="0 12"/>
  </actuator>
</mujoco>
"""


def flight(speed: float, edge: float, duration: float) -> dict[str, float]:
    """Fly a step of velocity with a controller in plain Python, `thrusts`."""
    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    state = data.qpos, data.qvel
    begun = time.process_time()
    for index in range(round(duration / (STEPS * STEP))):
        wanted = speed if index * STEPS * STEP >= edge else 0.0
        data.ctrl[:] = thrusts(state[0].tolist(), state[1].tolist(), wanted)
        mujoco.mj_step(model, data, STEPS)
    seconds = time.process_time() - begun
    return {"seconds": seconds, "missed": abs(float(data.qvel[0]) - speed)}


def bare(duration: float) -> dict[str, float]:
    """Let it hang on constant thrusts: one call, with no Python in the loop."""
    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    data.ctrl[:] = MASS * GRAVITY / 4
    begun = time.process_time()
    mujoco.mj_step(model, data, round(duration / STEP))
    seconds = time.process_time() - begun
    return {"seconds": seconds, "missed": abs(float(data.qpos[2]) - HEIGHT)}


def thrusts(q: list[float], v: list[float], speed: float) -> tuple[float, float, float, float]:
    """Return the rotors' thrusts [N] for a wanted velocity along x: two PD laws."""
    _, _, z, w, x, y, k = q
    up = (2 * (x * k + w * y), 2 * (y * k - w * x), 1 - 2 * (x * x + y * y))  # body z, in the world
    force = (3 * (speed - v[0]), -3 * v[1], GRAVITY + 4 * (HEIGHT - z) - 4 * v[2])
    size = math.sqrt(force[0] ** 2 + force[1] ** 2 + force[2] ** 2)
    aim = (force[0] / size, force[1] / size, force[2] / size)
    turn = (
        up[1] * aim[2] - up[2] * aim[1],
        up[2] * aim[0] - up[0] * aim[2],
        up[0] * aim[1] - up[1] * aim[0],
    )
    # the tilt is small and so is yaw: the turn in the world is nearly that in the body
    roll = INERTIA[0] * (100 * turn[0] - 18 * v[3])
    pitch = INERTIA[1] * (100 * turn[1] - 18 * v[4])
    yaw = INERTIA[2] * (-10 * k - 5 * v[5])
    lift = MASS * (force[0] * up[0] + force[1] * up[1] + force[2] * up[2]) / 4
    roll, pitch, yaw = roll / (4 * ARM), pitch / (4 * ARM), yaw / (4 * MOMENT)
    return (
        lift - roll - pitch + yaw,
        lift + roll - pitch - yaw,
        lift + roll + pitch + yaw,
        lift - roll + pitch - yaw,
    )


if __name__ == "__main__":
    serve({"flight": flight, "bare": bare})
