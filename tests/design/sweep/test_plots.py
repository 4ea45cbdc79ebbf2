"""Pictures show what was flown: every candidate, what was lost, the present and the best."""

import dataclasses

import numpy as np
import pytest
from matplotlib.collections import PatchCollection, QuadMesh

from workbench.common.errors import WorkbenchError
from workbench.design.sweep.best import prove_best
from workbench.design.sweep.plot_sweep import (
    cell_edges,
    colour_limits,
    plot_sweep,
    rank_correlation,
)
from workbench.design.sweep.ranges import parse_range

NAN = float("nan")


def assert_readable(figure, tmp_path):
    """No text lies on another's or is cut off, and every axis has a unit."""
    figure.savefig(tmp_path / "figure.png")
    texts = list(figure.texts)
    for legend in (*figure.legends, *(axes.get_legend() for axes in figure.axes)):
        texts += legend.get_texts() if legend else []
    for axes in figure.axes:
        if not axes.axison:
            continue
        assert "[" in axes.get_ylabel() or "[" in axes.get_xlabel()
        texts += [axes.xaxis.label, axes.yaxis.label, axes._left_title]
    width, height = figure.canvas.get_width_height()
    boxes = [(t.get_text(), t.get_window_extent()) for t in texts if t.get_text()]
    for index, (text, box) in enumerate(boxes):
        assert box.x0 >= 0 and box.y0 >= 0 and box.x1 <= width and box.y1 <= height, text
        for other, its_box in boxes[index + 1 :]:
            assert not box.overlaps(its_box), f"'{text}' lies on '{other}'"


def legend_of(figure):
    legends = [*figure.legends, *(axes.get_legend() for axes in figure.axes)]
    return {text.get_text() for legend in legends if legend for text in legend.get_texts()}


def test_a_map_has_a_cell_a_candidate_and_hatches_what_was_lost(lost_table, tmp_path):
    best = prove_best(lost_table, "rise_time")
    figure = plot_sweep(lost_table, "rise_time", best)
    assert_readable(figure, tmp_path)
    axes = figure.axes[0]
    mesh = next(c for c in axes.collections if isinstance(c, QuadMesh))
    cells = np.ma.filled(mesh.get_array(), NAN)
    assert cells.shape == (2, 3)
    expected = lost_table.column("rise_time").reshape(3, 2).T
    np.testing.assert_array_equal(cells, expected)
    hatched = next(c for c in axes.collections if isinstance(c, PatchCollection))
    assert hatched.get_hatch() == "////"
    assert len(hatched.get_paths()) == int(np.isfinite(lost_table.diverged_at).sum())
    marks = {line.get_label(): line.get_xydata()[0].tolist() for line in axes.lines}
    assert marks == {"present": [225.0, 4.45], "best": best.parameters.tolist()}
    assert legend_of(figure) == {"present", "best", "diverged"}


def test_a_map_of_a_part_of_a_grid_is_drawn(lost_table, tmp_path):
    few = dataclasses.replace(
        lost_table,
        parameters=lost_table.parameters[:1],
        values=lost_table.values[:1],
        diverged_at=lost_table.diverged_at[:1],
    )
    assert_readable(plot_sweep(few, "overshoot"), tmp_path)


def test_candidates_off_a_grid_are_dots(lost_table, tmp_path):
    table = dataclasses.replace(lost_table, method="sobol")
    figure = plot_sweep(table, "rise_time")
    assert_readable(figure, tmp_path)
    dots, crosses = figure.axes[0].collections
    lost = np.isfinite(table.diverged_at)
    np.testing.assert_array_equal(dots.get_offsets(), table.parameters[~lost])
    np.testing.assert_array_equal(crosses.get_offsets(), table.parameters[lost])
    assert legend_of(figure) == {"diverged", "present"}


def rows(count):
    return [[0.1 * i, 0.2 * i, i, 0.0, 2.0, 1.0, 2.0, 0.1, 0.5] for i in range(count)]


def test_one_parameter_makes_curves(make_table, tmp_path):
    values = [*rows(4), [NAN] * 9]
    table = make_table(values, [NAN] * 4 + [0.5], "kp_roll=100..500:5")
    figure = plot_sweep(table, "peak")
    assert_readable(figure, tmp_path)
    first = figure.axes[0].lines[0]
    np.testing.assert_array_equal(first.get_xdata(), [100.0, 200.0, 300.0, 400.0, 500.0])
    np.testing.assert_array_equal(first.get_ydata(), [2.0] * 4 + [NAN])
    assert figure.axes[0].get_title(loc="left") == "peak"
    span = figure.axes[0].patches[0]
    assert (span.get_x(), span.get_x() + span.get_width()) == (450.0, 550.0)
    assert legend_of(figure) == {"present", "diverged"}


def test_many_parameters_make_clouds_with_rank_correlations(make_table, tmp_path):
    names = ("kp_roll=100..400", "kd_roll=10..40:log", "vary.mass=0.8..1.2", "max_tilt=0.2..0.5")
    table = make_table([*rows(6), [NAN] * 9], [NAN] * 6 + [0.1], *names, method="random")
    figure = plot_sweep(table, "overshoot")
    assert_readable(figure, tmp_path)
    titles = [axes.get_title(loc="left") for axes in figure.axes if axes.axison]
    assert titles == [f"{n.split('=')[0]}: rank correlation +1.00" for n in names]
    assert legend_of(figure) == {"candidates", "diverged", "present"}


@pytest.mark.parametrize(("count", "more"), [(1, ()), (2, ()), (3, ("candidates",))])
def test_a_sweep_in_which_all_is_lost_is_drawn(make_table, tmp_path, count, more):
    names = ("kp_roll=100..400:2", "kd_roll=10..40:2", "vary.mass=0.8..1.2:2")[:count]
    table = make_table([[NAN] * 9] * 3, [0.1, 0.2, 0.3], *names)
    figure = plot_sweep(table, "overshoot")
    assert_readable(figure, tmp_path)
    assert legend_of(figure) == {"diverged", "present", *more}


def test_a_metric_that_is_not_there_is_a_sentence(lost_table):
    with pytest.raises(WorkbenchError, match="did you mean"):
        plot_sweep(lost_table, "rise")


def test_edges_are_half_way():
    assert cell_edges(np.array([1.0, 2.0, 4.0]), parse_range("kp_roll=1..4")).tolist() == [
        0.5,
        1.5,
        3.0,
        5.0,
    ]
    log = cell_edges(np.array([1.0, 100.0]), parse_range("kp_roll=1..100:log"))
    np.testing.assert_allclose(log, [0.1, 10.0, 1000.0])


def test_a_few_wild_candidates_do_not_fill_the_scale():
    values = np.array([*np.linspace(0.0, 1.0, 99), 1000.0, NAN])
    low, high = colour_limits(values)
    assert low == 0.0
    assert high < 1.0
    assert colour_limits(np.linspace(0.0, 1.0, 11)) == (0.0, 1.0)
    assert colour_limits(np.full(3, 2.0)) == (2.0, 3.0)
    assert colour_limits(np.full(3, NAN)) == (0.0, 1.0)


def test_rank_correlation_is_scipys():
    from scipy.stats import spearmanr

    chance = np.random.default_rng(1)
    x, y = chance.normal(size=(2, 50))
    y = y + x
    assert rank_correlation(x, y) == pytest.approx(spearmanr(x, y).statistic)
    y[3] = NAN
    expected = spearmanr(np.delete(x, 3), np.delete(y, 3)).statistic
    assert rank_correlation(x, y) == pytest.approx(expected)
    assert np.isnan(rank_correlation(x, np.ones(50)))
