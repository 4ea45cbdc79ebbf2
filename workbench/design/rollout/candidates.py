"""What differs between the candidates of a batch, as arrays."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from workbench.errors import WorkbenchError, unknown_name
from workbench.parameters import MOST_ROTORS, PARAMETERS
from workbench.systems.air.settings import AirSettings
from workbench.systems.cascade import Gains

KNOWN = frozenset(row.name for row in PARAMETERS)
COLUMNS = (*Gains._fields, *AirSettings._fields)


class Candidates(NamedTuple):
    """N candidates for a vehicle with n rotors.

    Attributes:
        gains: (N, 18) see `cascade.Gains`.
        air: (N, 19) see `AirSettings`.
        shares: (N, n) of their thrust that rotors give.
    """

    gains: np.ndarray
    air: np.ndarray
    shares: np.ndarray


def make_candidates(
    gains: Sequence[Mapping[str, float]] | np.ndarray, own: Mapping[str, float], rotors: int
) -> Candidates:
    """Return candidates as arrays.

    Args:
        gains: values by name of each candidate, or an array (N, 18) with a column for each of
            `cascade.Gains`; of those within the parameter table's limits or not.
        own: every value, for what the candidates do not name.
        rotors: how many there are.

    Raises:
        WorkbenchError: if a name is unknown, a value no number, or the array of another size.
    """
    weak = [f"rotor_{number}" for number in range(1, min(rotors, MOST_ROTORS) + 1)]
    names = (*COLUMNS, *weak)
    if isinstance(gains, np.ndarray):
        table = _from_array(gains, [own[name] for name in names])
    else:
        table = _from_mappings(gains, names, own)
    many = len(Gains._fields)
    shares = np.ones((len(table), rotors))
    shares[:, : len(weak)] = table[:, len(COLUMNS) :]
    return Candidates(table[:, :many].copy(), table[:, many : len(COLUMNS)].copy(), shares)


def _from_array(gains: np.ndarray, own: Sequence[float]) -> np.ndarray:
    """Return a table of all columns, the first of which are given."""
    many = len(Gains._fields)
    if gains.ndim != 2 or gains.shape[1] != many:
        raise WorkbenchError(
            f"the gains are an array of {' x '.join(map(str, gains.shape)) or 'no'} numbers: give "
            f"one with a row a candidate and {many} columns, those of cascade.Gains"
        )
    table = np.tile(np.array(own, dtype=float), (len(gains), 1))
    table[:, :many] = gains
    return table


def _from_mappings(
    gains: Sequence[Mapping[str, float]], names: Sequence[str], own: Mapping[str, float]
) -> np.ndarray:
    """Return a table of all columns, with a row for each mapping."""
    table = np.empty((len(gains), len(names)))
    for number, values in enumerate(gains):
        for name in values.keys() - KNOWN:
            raise unknown_name("parameter", name, KNOWN)
        whole = {**own, **values}
        try:
            table[number] = [whole[name] for name in names]
        except (TypeError, ValueError):
            raise WorkbenchError(
                f"candidate {number + 1} has a value that is no number: give every parameter one"
            ) from None
    return table
