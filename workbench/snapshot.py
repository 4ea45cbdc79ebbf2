"""The present of a flight as a frozen copy, for a screen."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from workbench.systems.flight_mode import FlightMode


@dataclass(frozen=True)
class Snapshot:
    """What a flight is at one time; frames and units as in `Recording`."""

    time: float
    p_WB: tuple[float, ...]
    q_WB: tuple[float, ...]
    v_WB: tuple[float, ...]
    w_WB: tuple[float, ...]
    thrusts: tuple[float, ...]
    reference: tuple[float, ...]
    mode: FlightMode
    charge: float

    @classmethod
    def from_signals(cls, time: float, signals: Mapping[str, np.ndarray]) -> "Snapshot":
        """Return the snapshot of the recorder's signals at a time [s]."""
        state = signals["state"]
        q_WB = state[0:4] / np.linalg.norm(state[0:4])
        return cls(
            time=time,
            q_WB=tuple(q_WB.tolist()),
            p_WB=tuple(state[4:7].tolist()),
            w_WB=tuple(state[7:10].tolist()),
            v_WB=tuple(state[10:13].tolist()),
            thrusts=tuple(signals["thrusts"].tolist()),
            reference=tuple(signals["reference"].tolist()),
            mode=FlightMode(int(signals["mode"][0])),
            charge=float(signals["charge"][0]),
        )
