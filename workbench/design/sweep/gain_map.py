"""A metric over two gains around those in use: quick enough to follow a slider."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.design.metrics import FLOWN, SWEPT, Metric, find_metric
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.sweep.ranges import SweepRange


@dataclass(frozen=True)
class GainMap:
    """A metric of flown steps on a grid of two gains; N_y rows of N_x values.

    Attributes:
        x: the gain along the columns.
        y: the gain along the rows.
        metric: what was measured.
        values: (N_y, N_x), NaN where a flight was lost or never got there.
        lost: (N_y, N_x) whether the flight was lost.
    """

    x: SweepRange
    y: SweepRange
    metric: Metric
    values: np.ndarray
    lost: np.ndarray


def gain_map(
    engine: RolloutEngine,
    gains: Mapping[str, float],
    x: SweepRange,
    y: SweepRange,
    *,
    metric: str = "overshoot",
    axis: str = "x",
    amplitude: float = 1.0,
    duration: float = 2.0,
    heading: float = 0.0,
    stop: Callable[[], bool] | None = None,
) -> GainMap | None:
    """Fly a step at every point of a grid; some 30 ms for 32 x 32 flights of 2 s on two cores.

    Nothing of it is flown on the full diagram: what is chosen from it should be.

    Args:
        engine: of the vehicle.
        gains: of the controller's gains and limits, those that are not the engine's own, by name.
        x: a gain or limit of the controller, and its values along the columns.
        y: another one, along the rows.
        metric: of the flight, see `metrics.FLOWN`.
        axis: of the step, x, y, z or yaw.
        amplitude: of its command [m/s] or [rad/s].
        duration: flown after the command's edge [s].
        heading: yaw of the drone at the start [rad].
        stop: asked every few milliseconds; true gives the map up.

    Returns:
        The map, or None if it was given up.

    Raises:
        WorkbenchError: if the two are no different gains, or that makes no step.
    """
    names = [row.name for row in engine.controller.parameters]
    for each in (x, y):
        if each.name not in names:
            raise unknown_name("gain", each.name, names)
    if x.name == y.name:
        raise WorkbenchError(f"both axes of the map are {x.name}: give two different gains")
    wanted = find_metric(metric, SWEPT)
    if wanted not in FLOWN:
        raise unknown_name("metric of a flight", metric, [each.name for each in FLOWN])
    columns, rows = (part.ravel() for part in np.meshgrid(x.grid, y.grid))
    for name in gains:
        if name not in names:
            raise unknown_name("gain", name, names)
    values = {**engine.gains, **gains}
    table = np.tile([values[name] for name in names], (len(rows), 1))
    table[:, names.index(x.name)] = columns
    table[:, names.index(y.name)] = rows
    measured = engine.measure(table, axis, amplitude, duration=duration, heading=heading, stop=stop)
    if len(measured) < len(table):
        return None
    if metric == "peak_rotor_use":
        found = measured.peak_rotor_use
    else:
        found = getattr(measured.metrics, metric)
    lost, shape = np.isfinite(measured.diverged_at), (len(y.grid), len(x.grid))
    return GainMap(x, y, wanted, np.where(lost, np.nan, found).reshape(shape), lost.reshape(shape))
