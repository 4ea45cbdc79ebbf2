"""Predictions of the part of a flight that was held back from the search."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.extras.flightdata.identify.flight_piece import make_piece
from workbench.extras.flightdata.identify.model_rows import model_rows
from workbench.extras.flightdata.identify.search import IdentificationResult, identify
from workbench.plant.gravity import GRAVITY

RATE_HORIZON_S = 0.2
"""Horizon of predictions of the angular velocity [s]."""
HELD_BACK_SHARE = 0.2
"""Last share of a flight, held back from a second search."""
MIN_THRUST_CHANGE_M_S2 = 1.0
"""RMS change of thrust over mass from which on it is judged [m/s²]: a tenth of the weight.

Quiet flights have 0.2 to 0.8, as much as gusts and a sagging battery make; doublets have 1.5 and
more."""

MIN_LEVEL_CHANGE_M_S2 = 0.08
"""RMS change of level specific force from which on drag is judged [m/s²].

Flights that hardly leave their place have 0.05, as noise and gusts do; slow circles have 0.1."""


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
        commanded_force: RMS change of thrust over mass that the commands ask for [m/s²].
        modelled_level: RMS change of specific force along x and y that the model predicts [m/s²].
    """

    force: float
    constant_force: float
    level: float
    constant_level: float
    turn: float
    constant_turn: float
    ahead: float
    commanded_force: float
    modelled_level: float

    @property
    def quiet(self) -> frozenset[str]:
        """What changes too little to be refuted: force and level, neither expected nor measured."""
        rows = (
            (
                "force",
                self.force,
                self.constant_force,
                self.commanded_force,
                MIN_THRUST_CHANGE_M_S2,
            ),
            ("level", self.level, self.constant_level, self.modelled_level, MIN_LEVEL_CHANGE_M_S2),
        )
        return frozenset(
            name
            for name, error, constant, expected, least in rows
            if max(expected, constant) < least and math.isfinite(error) and not error < constant
        )

    @property
    def refuted(self) -> frozenset[str]:
        """What moves, and the model predicts no better than a constant: force, level, turn."""
        pairs = {
            "force": (self.force, self.constant_force),
            "level": (self.level, self.constant_level),
            "turn": (self.turn, self.constant_turn),
        }
        # Not less, rather than more: an error that is no number refutes, too.
        missed = {name for name, (error, constant) in pairs.items() if not error < constant}
        return frozenset(missed - self.quiet)


def prediction_errors(found: IdentificationResult) -> HeldBackPrediction:
    """Return the errors of predictions of flights by a result, from each instant onwards.

    Args:
        found: result from other flights, or another part of them.
    """
    force, mean, level, means, turn, held, squares, modelled = ([] for _ in range(8))
    for flight in found.flights:
        for run in flight.pieces(RATE_HORIZON_S + 0.5):
            piece = make_piece(run, found.vehicle)
            rows = model_rows(found.vehicle, found.fit.named, piece)
            skip = round(0.3 / piece.row)
            error, change = piece.force - rows[:, 3:], piece.force - piece.force.mean(axis=0)
            force.append(error[skip:, 2])
            mean.append(change[skip:, 2])
            squares.append((piece.commands**2).sum(axis=1))
            level.append(error[skip:, :2])
            means.append(change[skip:, :2])
            modelled.append((rows[:, 3:5] - rows[:, 3:5].mean(axis=0))[skip:])
            many = max(1, round(RATE_HORIZON_S / piece.row))
            went = np.cumsum(piece.turn, axis=0) * piece.row
            should = np.cumsum(rows[:, :3], axis=0) * piece.row
            change = went[many:] - went[:-many]
            turn.append((change - should[many:] + should[:-many])[skip:])
            held.append(change[skip:])

    def rms(parts: list[np.ndarray]) -> float:
        return float(np.sqrt(np.mean(np.concatenate([part.ravel() for part in parts]) ** 2)))

    # of squares of speeds or shares: a thrust curve is no steeper
    hover = float(np.mean(np.concatenate(squares)))
    commanded = GRAVITY / max(hover, 1e-12) * rms([each - each.mean() for each in squares])
    return HeldBackPrediction(
        force=rms(force),
        constant_force=rms(mean),
        level=rms(level),
        constant_level=rms(means),
        turn=rms(turn),
        constant_turn=rms(held),
        ahead=RATE_HORIZON_S,
        commanded_force=commanded,
        modelled_level=rms(modelled),
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
