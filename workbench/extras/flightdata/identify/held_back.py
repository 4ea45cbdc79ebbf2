"""Predictions of the part of a flight that was held back from the search."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.extras.flightdata.identify.flight_piece import make_piece
from workbench.extras.flightdata.identify.model_rows import model_rows
from workbench.extras.flightdata.identify.search import IdentificationResult, identify

RATE_HORIZON_S = 0.2
"""Horizon of predictions of the angular velocity [s]."""
HELD_BACK_SHARE = 0.2
"""Last share of a flight, held back from a second search."""


@dataclass(frozen=True)
class HeldBackPrediction:
    """The errors of a model that predicts the last fifth of the flights, held back from its search.

    Attributes:
        force: RMS error of specific force along z [m/s²].
        constant_force: the same for a prediction by its mean.
        level: RMS error of specific force along x and y [m/s²].
        constant_level: the same for a prediction by their means.
        turn: RMS error of angular velocity after `ahead` [rad/s].
        constant_turn: the same for a prediction by a constant rate.
        ahead: [s].
    """

    force: float
    constant_force: float
    level: float
    constant_level: float
    turn: float
    constant_turn: float
    ahead: float

    @property
    def refuted(self) -> frozenset[str]:
        """What the model predicts no better than a constant does: force, level, turn."""
        pairs = {
            "force": (self.force, self.constant_force),
            "level": (self.level, self.constant_level),
            "turn": (self.turn, self.constant_turn),
        }
        # Not less, rather than more: an error that is no number refutes, too.
        return frozenset(name for name, (error, constant) in pairs.items() if not error < constant)


def prediction_errors(found: IdentificationResult) -> HeldBackPrediction:
    """Return the errors of predictions of flights by a result, from each instant onwards.

    Args:
        found: result from other flights, or another part of them.
    """
    force, mean, level, means, turn, held = [], [], [], [], [], []
    for flight in found.flights:
        for run in flight.pieces(RATE_HORIZON_S + 0.5):
            piece = make_piece(run, found.vehicle)
            rows = model_rows(found.vehicle, found.fit.named, piece)
            skip = round(0.3 / piece.row)
            error, change = piece.force - rows[:, 3:], piece.force - piece.force.mean(axis=0)
            force.append(error[skip:, 2])
            mean.append(change[skip:, 2])
            level.append(error[skip:, :2])
            means.append(change[skip:, :2])
            many = max(1, round(RATE_HORIZON_S / piece.row))
            went = np.cumsum(piece.turn, axis=0) * piece.row
            should = np.cumsum(rows[:, :3], axis=0) * piece.row
            change = went[many:] - went[:-many]
            turn.append((change - should[many:] + should[:-many])[skip:])
            held.append(change[skip:])

    def rms(parts: list[np.ndarray]) -> float:
        return float(np.sqrt(np.mean(np.concatenate([part.ravel() for part in parts]) ** 2)))

    return HeldBackPrediction(
        rms(force), rms(mean), rms(level), rms(means), rms(turn), rms(held), RATE_HORIZON_S
    )


def held_back_prediction(
    found: IdentificationResult, tell: Callable[[float], None], stopped: Callable[[], bool]
) -> HeldBackPrediction | None:
    """Return what a search without the last part of the flights predicts of it."""
    first, last = [], []
    for flight in found.flights:
        count = int(flight.good.sum())
        seen = np.cumsum(flight.good) <= (1.0 - HELD_BACK_SHARE) * count
        first.append(replace(flight, good=flight.good & seen))
        last.append(replace(flight, good=flight.good & ~seen))
    if stopped():
        return None
    try:
        blind = identify(found.vehicle, first, tell, stopped)
    except WorkbenchError:  # what is left is too short to be identified from
        return None
    rest = replace(blind, flights=tuple(last))
    if stopped() or not any(flight.pieces(1.0) for flight in last):
        return None
    return prediction_errors(rest)
