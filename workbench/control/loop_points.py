"""The places where a signal of the law can be cut, scaled, added to or measured.

At each a probe passes on gate times signal plus injection. With gates of 1 and injections of 0, as
in every normal flight, that changes no bit. A loop is opened by its gate, delayed or driven by its
injection, and its transfer functions are derivatives by injections: linear models, margins and
their proof in flight all go through here.
"""

from typing import Any

from workbench.common.jitable import register_jitable

Scalar = Any
Signal = Any
"""A sequence of scalars: a list in Python, an array in compiled code."""


@register_jitable(forceinline=True)
def probe(signal: Scalar, place: int, loops: Signal) -> Scalar:
    """Return what goes on from a point, and note what came there.

    Args:
        signal: that comes.
        place: of the point in the controller's `POINTS`.
        loops: gates, injections, and places for the signals, one each a point; None where all
            are closed and nobody listens.
    """
    if loops is None:
        return signal
    count = len(loops) // 3
    loops[2 * count + place] = signal
    return loops[place] * signal + loops[count + place]


@register_jitable(forceinline=True)
def probe3(signals: Signal, first: int, loops: Signal) -> tuple[Scalar, Scalar, Scalar]:
    """Return what goes on from three points, the first of which is at a place; see `probe`."""
    x, y, z = signals
    return probe(x, first, loops), probe(y, first + 1, loops), probe(z, first + 2, loops)
