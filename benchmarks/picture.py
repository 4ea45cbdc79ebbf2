"""A picture of the sweeps: flights a second of each simulator, on a scale of powers of ten."""

from pathlib import Path

from matplotlib.figure import Figure
from spread import number
from targets import Figures

COUNT = 1024
"""Candidates of the bars."""


def save_picture(figures: Figures, path: Path) -> None:
    """Draw a bar a simulator, with quartiles, and save it."""
    rows = [row for row in figures["sweep"] if "reason" not in row and row["candidates"] == COUNT]
    rows.sort(key=lambda row: row["rollouts_a_second"]["median"])
    figure = Figure(figsize=(7.0, 0.5 * len(rows) + 1.0), layout="constrained")
    axes = figure.subplots()
    places = range(len(rows))
    rates = [row["rollouts_a_second"] for row in rows]
    medians = [each["median"] for each in rates]
    below = [each["median"] - each["lower"] for each in rates]
    above = [each["upper"] - each["median"] for each in rates]
    colours = ["#1b6ca8" if row["simulator"].startswith("compiled") else "#a0a0a0" for row in rows]
    axes.barh(places, medians, xerr=[below, above], color=colours, ecolor="black", capsize=2)
    for place, median, upper in zip(places, medians, above, strict=True):
        axes.annotate(
            number(median),
            (median + upper, place),
            xytext=(4, 0),
            textcoords="offset points",
            va="center",
        )
    axes.set_yticks(places, [row["simulator"] for row in rows])
    axes.set_xscale("log")
    axes.set_xlim(right=6.0 * max(medians))
    axes.set_xlabel(f"closed-loop flights of 5 s a second, {COUNT:,} candidates")
    axes.grid(axis="x", alpha=0.3)
    axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=100, metadata={"Software": None})
