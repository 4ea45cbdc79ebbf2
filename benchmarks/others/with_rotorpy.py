"""RotorPy: its own loop at its own 100 Hz, and its batched vehicles and controller on torch."""

import functools
import multiprocessing
import time
from multiprocessing.pool import Pool

import numpy as np
import torch
from rotorpy.controllers.quadrotor_control import BatchedSE3Control, SE3Control
from rotorpy.environments import Environment
from rotorpy.trajectories.hover_traj import BatchedHoverTraj, HoverTraj
from rotorpy.vehicles.crazyflie_params import quad_params
from rotorpy.vehicles.multirotor import (
    BatchedMultirotor,
    BatchedMultirotorParams,
    Multirotor,
)
from serving import serve

RATE = 100
"""Of its loop [Hz]; what `Environment` has by itself."""
PROCESSES = 2
"""One a core: more than one thread makes torch slower with arrays of this size."""
HOVER = 1788.53
"""Speed of its rotors at the start [rad/s], as RotorPy has it itself."""


def flight(distance: float, duration: float) -> dict[str, float]:
    """Fly to a point as `Environment.run` does, with the sensors it has by itself."""
    vehicle, controller = Multirotor(quad_params), SE3Control(quad_params)
    aim = HoverTraj(x0=np.array([distance, 0.0, 0.0]))
    world = Environment(vehicle=vehicle, controller=controller, trajectory=aim, sim_rate=RATE)
    begun = time.process_time()
    result = world.run(t_final=duration, terminate=False)
    seconds = time.process_time() - begun
    return {"seconds": seconds, "missed": abs(float(result["state"]["x"][-1][0]) - distance)}


def sweep(count: int, duration: float) -> dict[str, float]:
    """Fly many to points of their own: controller and step alone, without sensors and recording."""
    shares = [(count + index) // PROCESSES for index in range(PROCESSES)]
    work = [(share, duration) for share in shares if share]
    pool = _pool()
    begun = time.perf_counter()
    pool.starmap(_fly, work, chunksize=1)
    return {"seconds": time.perf_counter() - begun}


@functools.cache
def _pool() -> Pool:
    """Return processes that have flown once."""
    pool = multiprocessing.get_context("spawn").Pool(PROCESSES)
    pool.starmap(_fly, [(2, 0.1)] * PROCESSES, chunksize=1)
    return pool


def _fly(count: int, duration: float) -> float:
    """Return how far along x the farthest came [m]."""
    torch.set_num_threads(1)
    device = torch.device("cpu")
    state = {
        name: torch.zeros(count, 3, dtype=torch.float64) for name in ("x", "v", "w", "wind")
    } | {
        "q": torch.tensor([0.0, 0.0, 0.0, 1.0], dtype=torch.float64).repeat(count, 1),
        "rotor_speeds": torch.full((count, 4), HOVER, dtype=torch.float64),
    }
    still = state["wind"]
    parameters = BatchedMultirotorParams([quad_params] * count, count, device)
    vehicles = BatchedMultirotor(parameters, count, state, device, integrator="rk4")
    controller = BatchedSE3Control(parameters, count, device)
    aims = np.zeros((count, 3))
    aims[:, 0] = np.linspace(0.5, 1.5, count)
    aim = BatchedHoverTraj(count, aims)
    these = np.arange(count)
    with torch.no_grad():
        for index in range(round(duration * RATE)):
            at = index / RATE
            command = controller.update(at, state, aim.update(at), idxs=these)
            state = vehicles.step(state, command, 1.0 / RATE, idxs=these)
            state["wind"] = still
    return float(state["x"][:, 0].abs().max())


if __name__ == "__main__":
    serve({"flight": flight, "sweep": sweep})
