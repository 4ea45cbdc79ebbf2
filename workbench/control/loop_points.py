"""Loop points: where a signal of the control law can be cut, scaled, excited or measured.

At each point a probe computes

    signal after = gate * signal before + injection

With gates of 1 and injections of 0, as in every normal flight, this does not change a bit. A gate
opens or scales a loop, an injection delays or excites it, and transfer functions are derivatives
by injections. Linear models, margins and their verification in flight use these points.
"""

from workbench.common.jitable import register_jitable
from workbench.common.vectors import MutableNumbers, Numbers, Vector3
from workbench.control.flight_state import level_heading

Probes = MutableNumbers | None
"""Gates, injections and signals of all points, see `probe`."""


@register_jitable(forceinline=True)
def probe(signal: float, place: int, loops: Probes) -> float:
    """Return the signal after a loop point, and store the signal before it.

    Args:
        signal: before the point.
        place: index of the point in the controller's `POINTS`.
        loops: gates, injections, and room for the signals, one of each per point; None if all
            loops are closed and nothing is measured.
    """
    if loops is None:
        return signal
    count = len(loops) // 3
    loops[2 * count + place] = signal
    return loops[place] * signal + loops[count + place]


@register_jitable(forceinline=True)
def probe3(signals: Vector3, first: int, loops: Probes) -> Vector3:
    """Return the signals after three consecutive loop points, see `probe`."""
    x, y, z = signals
    return probe(x, first, loops), probe(y, first + 1, loops), probe(z, first + 2, loops)


@register_jitable(forceinline=True)
def probe_tilt(f_W: Vector3, R_WT: Numbers, first: int, loops: Probes) -> Vector3:
    """Return a force in W after the loop points of the setpoints of roll and pitch.

    Their signals are the tangents of the angles by which the force tilts, about x and y of the
    heading. So a closed gate and an injection of tan(angle) set an angle in place of what the loops
    outside ask for, and the vertical part of the force stays.

    Args:
        f_W: the force, or a vector along it, that points up.
        R_WT: attitude, row by row.
        first: index of the point of roll; that of pitch is the next one.
        loops: see `probe`.
    """
    if loops is None:
        return f_W
    cos, sin, _ = level_heading(R_WT)
    f_x, f_y, f_z = f_W
    roll, pitch = (sin * f_x - cos * f_y) / f_z, (cos * f_x + sin * f_y) / f_z
    left = f_z * (roll - probe(roll, first, loops))
    ahead = f_z * (probe(pitch, first + 1, loops) - pitch)
    return f_x + (cos * ahead - sin * left), f_y + (sin * ahead + cos * left), f_z
