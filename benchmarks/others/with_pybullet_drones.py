"""gym-pybullet-drones: its own environment and PID controller, without a screen."""

import time

import numpy as np
from gym_pybullet_drones.control.DSLPIDControl import DSLPIDControl
from gym_pybullet_drones.envs.CtrlAviary import CtrlAviary
from gym_pybullet_drones.utils.enums import DroneModel
from serving import serve


def flight(
    distance: float, edge: float, duration: float, physics: int, control: int
) -> dict[str, float]:
    """Hover, then fly to a point; `physics` and `control` are rates [Hz]."""
    start, aim = np.array([0.0, 0.0, 1.0]), np.array([distance, 0.0, 1.0])
    world = CtrlAviary(
        drone_model=DroneModel("cf2x"),
        initial_xyzs=start[None, :],
        pyb_freq=physics,
        ctrl_freq=control,
        gui=False,
        obstacles=False,
        user_debug_gui=False,
    )
    controller = DSLPIDControl(drone_model=DroneModel("cf2x"))
    action, still = np.zeros((1, 4)), np.zeros(3)
    begun = time.process_time()
    for index in range(round(duration * control)):
        seen = world.step(action)[0]
        action[0] = controller.computeControlFromState(
            control_timestep=1.0 / control,
            state=seen[0],
            target_pos=aim if index >= edge * control else start,
            target_rpy=still,
        )[0]
    seconds = time.process_time() - begun
    world.close()
    return {"seconds": seconds, "missed": abs(float(seen[0][0]) - distance)}


if __name__ == "__main__":
    serve({"flight": flight})
