"""The flights of a batch of candidates, compiled."""

import numpy as np

from workbench.design.rollout.craft import Craft, Schedule
from workbench.design.rollout.flight import fly_candidate
from workbench.systems.air.air import SOURCES as AIR
from workbench.systems.compiled import LAW, compile_cached

OWN = ("rigid_body.py", "craft.py", "flight.py", "batch.py")
SOURCES = (
    *LAW,
    *AIR,
    "air/settings.py",
    "../plant/gravity.py",
    *(f"../design/rollout/{name}" for name in OWN),
)
"""The files that the compiled flights stand in, seen from the systems' folder."""


def fly_candidates(
    gains: np.ndarray,
    shares: np.ndarray,
    air: np.ndarray,
    reference: np.ndarray,
    guidance: np.ndarray,
    start: np.ndarray,
    craft: Craft,
    schedule: Schedule,
    velocity: np.ndarray,
    spin: np.ndarray,
    peak_use: np.ndarray,
    lost_at: np.ndarray,
) -> None:
    """Fly N candidates one after the other; this is what gets compiled.

    Args:
        gains: (N, 18) see `cascade.Gains`.
        shares: (N, n) of their thrust that rotors give.
        air: (N, 19) see `AirSettings`.
        reference: (8) from the edge on; none before. See `cascade.Reference`.
        guidance: (22) see `cascade.Guidance`.
        start: (13) state of the plant, which hovers.
        craft: what flies.
        schedule: when.
        velocity: (N, M, 3) places for the velocity in W from the edge on [m/s].
        spin: (N, M, 3) places for the angular velocity in W [rad/s].
        peak_use: (N) places for the largest share of its speed limit at which a rotor ran.
        lost_at: (N) places for the instant at which a candidate was lost, -1 if it was not.
    """
    # counting who holds a shared array would make threads wait for each other: each has its own
    own = Craft(
        craft.body.copy(),
        craft.rotors.copy(),
        craft.estimate,
        craft.rigid,
        craft.effects.copy(),
        craft.blades.copy(),
        craft.speeds.copy(),
        craft.clearance,
        craft.seed,
    )
    asked, guide = reference.copy(), guidance.copy()
    for i in range(len(gains)):
        use, lost = fly_candidate(
            gains[i].copy(),
            shares[i].copy(),
            air[i].copy(),
            asked,
            guide,
            start,
            own,
            schedule,
            velocity[i],
            spin[i],
        )
        peak_use[i] = use
        lost_at[i] = lost


compiled_flights = compile_cached(fly_candidates, SOURCES, "rollouts", nogil=True)
