"""The common parts of figures: style, titles, labels with units, and legends outside the data."""

import io
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, ParamSpec

import numpy as np
from matplotlib import rc_context
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from workbench.common.plain_text import plain_name, plain_text

if TYPE_CHECKING:
    from matplotlib.transforms import Transform

P = ParamSpec("P")
STYLE: Any = {
    "axes.axisbelow": True,
    "axes.grid": True,
    "axes.labelsize": 9,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "axes.titlesize": 10,
    "axes.titley": 1.0,  # else every draw looks for ticks above the axes
    "figure.dpi": 130,
    "font.size": 9,
    "grid.color": "0.88",
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "lines.linewidth": 1.5,
    "savefig.dpi": 130,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
}

MAX_TICK_CHARS = 40
"""Largest number of characters that are shown of a name at a tick."""
MAX_LABEL_CHARS = 300
"""Largest number of characters in a text of a figure."""

_SVG: Any = {"svg.fonttype": "none", "svg.hashsalt": "workbench", "path.simplify": True}


@dataclass(frozen=True)
class Palette:
    """Colours that are distinct for every kind of colour vision; lines also differ in dashes."""

    command: str = "0.25"
    ours: str = "#0072B2"
    mean: str = "#D55E00"
    paper: str = "#7A3E9D"
    window: str = "#F7EDCB"
    limit: str = "#C0392B"
    series: tuple[str, ...] = (
        "#0072B2",
        "#D55E00",
        "#009E73",
        "#AA4499",
        "#E69F00",
        "#56B4E9",
        "#6B4C2A",
        "#555555",
    )


LEFT_MARGIN_IN, RIGHT_MARGIN_IN, BOTTOM_MARGIN_IN, TOP_MARGIN_IN = 0.72, 2.35, 0.48, 0.6
"""Margins around stacked panels for labels, legends and the title [inch]. A layout engine measures
every text, which takes almost as long as drawing the figure."""
PANEL_GAP_SHARE = 0.32
"""Space between panels, as a share of the height of a panel."""
Y_LABEL_OFFSET_IN = 0.3
"""Place of the y labels of stacked panels, from the left edge of the figure [inch]. To align them
measures the numbers of each axis, for each of its neighbours."""

PALETTE = Palette()


def styled(make: Callable[P, Figure]) -> Callable[P, Figure]:
    """Decorate a function that makes a figure: our style, and names as they are.

    The user's own style does not change.
    """

    @wraps(make)
    def made(*args: P.args, **options: P.kwargs) -> Figure:
        with rc_context(STYLE):
            return as_text(make(*args, **options))

    return made


def as_text(figure: Figure) -> Figure:
    """Let all texts of a figure but the numbers at axes be shown as they are, and return it.

    Names come from files, and matplotlib would typeset what stands between two dollar signs.
    """
    for text in _figure_texts(figure):
        text.set_parse_math(False)
        shown = plain_text(text.get_text(), MAX_LABEL_CHARS).replace("\t", " ")
        if shown != text.get_text():
            text.set_text(shown)
    return figure


def _figure_texts(artist: Artist) -> Iterator[Text]:
    """Yield the texts below an artist but those at ticks, which each drawing makes again."""
    for child in artist.get_children():
        if isinstance(child, Text):
            yield child
        elif isinstance(child, Axis):
            yield child.label
        else:
            yield from _figure_texts(child)


def tick_name(name: str) -> str:
    """Return a name from outside for a tick, where matplotlib typesets the numbers."""
    return plain_name(name, MAX_TICK_CHARS).replace("$", r"\$")


def curve_name(name: str) -> str:
    """Return a name from outside for a legend, from which matplotlib omits those with a first _."""
    shown = plain_name(name)
    return f"\N{HAIR SPACE}{shown}" if shown.startswith("_") else shown


def stacked(
    title: str,
    panels: int,
    *,
    width: float = 8.2,
    height: float = 2.1,
    right: float = RIGHT_MARGIN_IN,
) -> tuple[Figure, list[Axes]]:
    """Return a figure of panels stacked over a common time axis [s].

    Args:
        title: over all of them.
        panels: number of panels.
        width: of the figure [inch].
        height: of a panel [inch].
        right: margin for legends [inch].
    """
    tall = height * panels + 0.5
    figure = Figure(figsize=(width, tall))
    figure.subplots_adjust(
        left=LEFT_MARGIN_IN / width,
        right=1.0 - right / width,
        bottom=BOTTOM_MARGIN_IN / tall,
        top=1.0 - TOP_MARGIN_IN / tall,
        hspace=PANEL_GAP_SHARE,
    )
    axes = figure.subplots(panels, 1, sharex=True, squeeze=False)[:, 0]
    figure.suptitle(title, x=0.01, ha="left", fontsize=11, fontweight="bold")
    for each in axes:
        each.yaxis.set_label_coords(
            (Y_LABEL_OFFSET_IN - LEFT_MARGIN_IN) / (width - LEFT_MARGIN_IN - right), 0.5
        )
    axes[-1].set_xlabel("time since the command's edge [s]")
    return figure, list(axes)


def titled(title: str, width: float, height: float) -> Figure:
    """Return a figure with a title and automatic layout; its size is in inches."""
    figure = Figure(figsize=(width, height), layout="constrained")
    figure.suptitle(title, x=0.01, ha="left", fontsize=11, fontweight="bold")
    return figure


def label_panel(axes: Axes, title: str, quantity: str, along: str = "") -> None:
    """Set the title of a panel, and the labels of its axes with units; `along` is of the x axis."""
    axes.set_title(title)
    axes.set_ylabel(quantity)
    if along:
        axes.set_xlabel(along)


def note(
    axes: Axes,
    text: str,
    place: tuple[float, float],
    offset: tuple[float, float] = (0.0, 0.0),
    *,
    within: "str | tuple[str, str] | Transform" = "data",
    size: float = 7.5,
    **more: Any,
) -> None:
    """Write a text in a panel.

    Args:
        axes: the panel.
        text: what to write.
        place: of the text, in data or as a share of the panel.
        offset: from the place [points].
        within: coordinates of the place, as matplotlib's `xycoords`.
        size: of the letters [points].
        more: properties of the text.
    """
    more |= {"xytext": offset, "textcoords": "offset points"}
    axes.annotate(text, place, xycoords=within, fontsize=size, **more)


def draw_command(axes: Axes, time: np.ndarray, values: np.ndarray, **more: Any) -> None:
    """Draw a command over time, constant between its changes; `more` are properties of the line."""
    look: dict[str, Any] = {"color": PALETTE.command, "lw": 1.0, "label": "command", **more}
    axes.plot(time, values, "--", drawstyle="steps-post", **look)


def series_look(index: int) -> dict[str, Any]:
    """Return colour and dashes of one of several lines."""
    dashes = ("-", "--", "-.", ":")
    return {"color": PALETTE.series[index % len(PALETTE.series)], "ls": dashes[index % len(dashes)]}


def legend(axes: Axes) -> None:
    """Put the legend to the right of the data."""
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.02), borderaxespad=0.0)


def widen(axes: Axes, *values: np.ndarray | float, least: float = 0.0) -> None:
    """Set y limits around all values with a margin; they span at least `least`.

    Numerical noise around a constant would otherwise fill the panel.
    """
    finite = [array[np.isfinite(array)] for array in map(np.atleast_1d, values)]
    everything = np.concatenate([array for array in finite if len(array)] or [np.zeros(1)])
    low, high = float(everything.min()), float(everything.max())
    middle, half = 0.5 * (low + high), 0.5 * max(high - low, least)
    axes.set_ylim(middle - 1.12 * half - 1e-9, middle + 1.12 * half + 1e-9)


def write_png(figure: Figure, to: Path | BinaryIO) -> None:
    """Write a figure; `savefig` would draw it twice, the first time only for the layout.

    The compression level makes files a tenth larger in two thirds of the time.
    """
    FigureCanvasAgg(figure).print_png(to, pil_kwargs={"compress_level": 3})


def inline_svg(figure: Figure) -> str:
    """Return a figure as an <svg> element for a page."""
    stream = io.StringIO()
    with rc_context(_SVG):
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    text = stream.getvalue()
    return text[text.index("<svg") :]
