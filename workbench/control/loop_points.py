"""Loop points: where a signal of the control law can be cut, scaled, excited or measured.

At each point a probe computes

    signal after = gate * signal before + injection

With gates of 1 and injections of 0, as in every normal flight, this does not change a bit. A gate
opens or scales a loop, an injection delays or excites it, and transfer functions are derivatives
by injections. Linear models, margins and their verification in flight use these points.
"""

from workbench.common.jitable import Scalar, Vector, register_jitable


@register_jitable(forceinline=True)
def probe(signal: Scalar, place: int, loops: Vector) -> Scalar:
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
def probe3(signals: Vector, first: int, loops: Vector) -> tuple[Scalar, Scalar, Scalar]:
    """Return the signals after three consecutive loop points, see `probe`."""
    x, y, z = signals
    return probe(x, first, loops), probe(y, first + 1, loops), probe(z, first + 2, loops)
