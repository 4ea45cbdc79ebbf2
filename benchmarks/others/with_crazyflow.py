"""crazyflow: rigid body and rotors at 500 Hz with its own controller of position, compiled by JAX.

A flight is one compiled call. The worlds are on one device, whose threads are XLA's own matter, or
shared out between as many as the environment's DEVICES says, by crazyflow's own means.
"""

import functools
import os
import time

os.environ["XLA_FLAGS"] = f"--xla_force_host_platform_device_count={os.environ['DEVICES']}"
os.environ["SCIPY_ARRAY_API"] = "1"

import jax
import jax.numpy as jnp
import numpy as np
from crazyflow.sim import Sim
from crazyflow.sim.sharding import world_mesh
from serving import serve

DEVICES = int(os.environ["DEVICES"])
RATE = 500
"""Of its physics and attitude control [Hz]; that of position has a hundred."""


def flight(distance: float, duration: float) -> dict[str, float]:
    """Fly one to a point."""
    worlds = _worlds(1, duration)
    begun = time.process_time()
    found = _fly(worlds, np.array([distance]), duration)
    seconds = time.process_time() - begun
    return {"seconds": seconds, "missed": abs(float(found[0]) - distance)}


def sweep(count: int, duration: float) -> dict[str, float]:
    """Fly many to points of their own."""
    aims = np.linspace(0.5, 1.5, count)
    worlds = _worlds(count, duration)
    begun = time.perf_counter()
    _fly(worlds, aims, duration)
    return {"seconds": time.perf_counter() - begun}


def steps(count: int, duration: float, calls: int) -> dict[str, float]:
    """Fly many to points of their own in several calls, each asked for anew."""
    aims = np.linspace(0.5, 1.5, count)
    worlds = _worlds(count, duration)
    _begin(worlds)
    each = round(duration * RATE / calls)
    worlds.state_control(_commands(aims))
    worlds.step(each)  # compiled for as many steps
    worlds.data.states.pos.block_until_ready()
    begun, used = time.perf_counter(), time.process_time()
    for _ in range(calls):
        worlds.state_control(_commands(aims))
        worlds.step(each)
    worlds.data.states.pos.block_until_ready()
    return {"seconds": time.perf_counter() - begun, "processor": time.process_time() - used}


@functools.cache
def _worlds(count: int, duration: float) -> Sim:
    """Return worlds that have flown once, so that all is compiled."""
    mesh = world_mesh(jax.devices()) if count > 1 and DEVICES > 1 else None
    worlds = Sim(n_worlds=count, control="state", freq=RATE, mesh=mesh)
    _fly(worlds, np.ones(count), duration)
    return worlds


def _fly(worlds: Sim, aims: np.ndarray, duration: float) -> np.ndarray:
    """Return where along x they came to [m]."""
    _begin(worlds)
    worlds.state_control(_commands(aims))
    worlds.step(round(duration * RATE))
    return np.asarray(worlds.data.states.pos)[:, 0, 0]


def _begin(worlds: Sim) -> None:
    """Put all a metre high."""
    worlds.reset()
    state = worlds.data.states
    worlds.data = worlds.data.replace(states=state.replace(pos=state.pos.at[..., 2].set(1.0)))


def _commands(aims: np.ndarray) -> jax.Array:
    """Return the setpoints that lead to places along x [m]."""
    command = np.zeros((len(aims), 1, 16), dtype=np.float32)
    command[:, 0, 0], command[:, 0, 2], command[:, 0, 12] = aims, 1.0, 1.0
    return jnp.asarray(command)


if __name__ == "__main__":
    serve({"flight": flight, "sweep": sweep, "steps": steps})
