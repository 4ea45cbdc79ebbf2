"""Whether a flight operation has the effect that its acknowledgement tells a station of."""

import asyncio
from typing import Any

from workbench.common.errors import WorkbenchError
from workbench.extras.gateways.mavlink_modes import EFFECT_MODES
from workbench.link import AsyncClient

EFFECT_TIMEOUT_S = 2.0
"""Simulated time within which an operation must have an effect [s]."""
EFFECT_PATIENCE_S = 20.0
"""The same by the clock [s], for a flight that is paused or slow."""
EFFECT_POLL_PERIOD_S = 0.01


class NoEffectError(WorkbenchError):
    """A flight operation was accepted, but has no effect."""


async def wait_for_effect(client: AsyncClient, what: str, started: float) -> None:
    """Wait until the flight mode shows an operation.

    Args:
        client: of the link, open.
        what: the operation.
        started: its simulated time [s].

    Raises:
        NoEffectError: if it has no effect.
    """
    now = asyncio.get_running_loop().time
    ends = now() + EFFECT_PATIENCE_S
    condition = "not known"
    while now() < ends:
        state: Any = client.latest("drone_state")
        if state is not None and state.time > started:
            condition = str(state["condition"])
            if int(state["mode"]) in EFFECT_MODES[what]:
                return
            if state.time > started + EFFECT_TIMEOUT_S:
                break
        await asyncio.sleep(EFFECT_POLL_PERIOD_S)
    raise NoEffectError(f"{what} had no effect: the drone's state is {condition}")
