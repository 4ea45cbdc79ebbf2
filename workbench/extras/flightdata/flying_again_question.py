"""The question how a logged flight would have gone with other gains, and its answer."""

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from workbench.analysis.queries import LONG_PROCESS, Gains, Query


@dataclass(frozen=True)
class FlyAgain(Query):
    """How would a logged flight have gone with these gains? Answered by `FlownAgain`.

    Attributes:
        log: path of the log.
        gains: gains of the controller that flies, of all sets if they are scheduled.
        controller: another controller, with its own gains; "" for that of the gains.
        flown: the controller that flew the log; "" for the one that the log names.
        draws: number of uncertain vehicles for the band, in addition to the nominal one. The last
            question's vehicles are used again if nothing else has changed.
    """

    process: ClassVar[int] = LONG_PROCESS
    answered_by: ClassVar[str] = "workbench.extras.flightdata.flying_again:fly_again"
    is_kept: ClassVar[bool] = False  # the file may change

    log: Path
    gains: Gains
    controller: str = ""
    flown: str = ""
    draws: int = 40


@dataclass(frozen=True)
class FlownAgain:
    """A logged flight, and the same flight with other gains, see `predict/what_if`.

    Columns of six are x, y, z, v_x, v_y, v_z [m, m/s].

    Attributes:
        vehicle: vehicle whose model flew it again.
        logged_vehicle: vehicle that the log names; "" without one.
        doubt: why the result may be wrong, as a sentence; else "".
        flown: the controller that flew the log.
        flown_gains: its values, as far as the log has them.
        time: time from the start of the log on (k) [s].
        setpoint: position (k, 3) [m].
        logged: motion of the log (k, 6).
        other: motion with other gains (k, 6); NaN once the drone is lost.
        low: lower edges of its band (k, 6).
        high: upper edges of its band (k, 6).
        off_setpoint: RMS distance of log and other flight from the setpoint (2, 3) [m]; like the
            next, as long as the drone is not lost.
        difference: RMS difference between the two (6).
        band: half of the band's width, mean over time (6).
        stays: whether the nominal vehicle survives.
        lost: number of lost vehicles.
        drawn: number of flown vehicles: the nominal one, and uncertain ones.
        grounded: number of the lost ones that reach the ground of the log.
        has_band: whether uncertain vehicles are flown; a recording of the workbench has none, and
            its setpoint is NaN.
    """

    vehicle: str
    logged_vehicle: str
    doubt: str
    flown: str
    flown_gains: Gains
    time: np.ndarray
    setpoint: np.ndarray
    logged: np.ndarray
    other: np.ndarray
    low: np.ndarray
    high: np.ndarray
    off_setpoint: np.ndarray
    difference: np.ndarray
    band: np.ndarray
    stays: bool
    lost: int
    drawn: int
    grounded: int = 0
    has_band: bool = True
