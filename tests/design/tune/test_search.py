"""The search, on a problem in closed form."""

import math

import numpy as np
import pytest

from workbench.design.tune.evaluation import Budget, Evaluation
from workbench.design.tune.search import ENOUGH_RESERVE, find_candidate, find_from

START = np.log([1.0, 0.2])


def search(problem, start=START, evaluations=400, **more):
    evaluation = Evaluation(problem, Budget(evaluations, **more))
    return evaluation, find_candidate(evaluation, [start], seed=0)


def test_it_finds_what_meets_all(second_order):
    _, best = search(second_order("x.rise_time<=0.3", "x.overshoot<=5", "x.peak_rotor_use<=0.9"))
    assert best.met
    w, z = np.exp(best.point)
    assert w * w / 100.0 <= 0.9
    assert 100.0 * math.exp(-math.pi * z / math.sqrt(1.0 - z * z)) <= 5.0


@pytest.mark.parametrize("seed", range(8))
def test_it_finds_it_from_anywhere(second_order, seed):
    problem = second_order("x.rise_time<=0.3", "x.overshoot<=5", "x.peak_rotor_use<=0.9")
    start = np.random.default_rng(seed).uniform(problem.low, problem.high)
    assert search(problem, start)[1].met


def test_it_ends_where_there_is_enough_to_spare(second_order):
    problem = second_order("x.rise_time<=3", "x.overshoot<=60")
    evaluation = Evaluation(problem, Budget(400), enough=ENOUGH_RESERVE)
    best = find_candidate(evaluation, [np.log([10.0, 0.8])], seed=0)
    assert best.reserve >= ENOUGH_RESERVE
    assert evaluation.budget.spent == 1


def test_it_leaves_the_most_to_spare_that_there_is(second_order):
    """At the best point all three have equal reserves: solved for, on a grid."""
    problem = second_order("x.rise_time<=0.3", "x.overshoot<=5", "x.peak_rotor_use<=0.9")
    _, best = search(problem)
    w, z = np.meshgrid(np.linspace(5.0, 10.0, 400), np.linspace(0.4, 0.99, 400))
    rise = 1.0 - (1.0 - 0.4167 * z + 2.917 * z * z) / w / 0.3
    overshoot = 1.0 - 20.0 * np.exp(-np.pi * z / np.sqrt(1.0 - z * z))
    use = 1.0 - w * w / 90.0
    assert best.reserve == pytest.approx(
        np.minimum(np.minimum(rise, overshoot), use).max(), abs=2e-3
    )


def test_where_no_start_leads_anywhere_others_are_tried(second_order):
    """All around the start flights diverge, so nothing says where to go."""
    problem = second_order("x.rise_time<=0.3", "x.overshoot<=5", "x.peak_rotor_use<=0.9")
    values = type(problem).values

    class Diverging(type(problem)):
        def values(self, points):
            near = np.abs(points - START).max(axis=1) < 0.5
            return np.where(near[:, None], np.inf, values(self, points))

    lost = Diverging(problem.requirements)
    assert not find_from(Evaluation(lost, Budget(400)), [START]).met
    assert search(lost)[1].met


def test_the_nearest_is_kept_where_there_is_nothing(second_order):
    evaluation, best = search(second_order("x.rise_time<=0.1", "x.peak_rotor_use<=0.5"))
    assert not best.met
    assert best.reserve == max(candidate.reserve for candidate in evaluation.seen)


def test_equal_seeds_look_at_equal_points(second_order):
    problems = [second_order("x.rise_time<=0.1", "x.peak_rotor_use<=0.5") for _ in range(2)]
    for problem in problems:
        search(problem)
    assert np.array_equal(*(np.array(problem.looked) for problem in problems))


def test_no_point_is_looked_at_twice(second_order):
    problem = second_order("x.rise_time<=0.1", "x.peak_rotor_use<=0.5")
    evaluation, _ = search(problem)
    assert len({point.tobytes() for point in problem.looked}) == len(problem.looked)
    assert evaluation.budget.spent == len(problem.looked)


def test_all_points_are_within_the_bounds(second_order):
    problem = second_order("x.rise_time<=0.001")
    search(problem, problem.high)
    looked = np.array(problem.looked)
    assert (looked >= problem.low - 1e-12).all()
    assert (looked <= problem.high + 1e-12).all()


def test_the_budget_ends_it_with_the_best_so_far(second_order):
    evaluation, best = search(second_order("x.rise_time<=0.1", "x.overshoot<=1"), evaluations=4)
    assert evaluation.budget.ended
    assert evaluation.budget.spent <= 8  # what one derivative needs may go over
    assert best.reserve == max(candidate.reserve for candidate in evaluation.seen)


def test_time_ends_it_too(second_order):
    evaluation, _ = search(second_order("x.rise_time<=0.1", "x.peak_rotor_use<=0.5"), seconds=1e-9)
    assert evaluation.budget.spent == 1


def test_it_can_be_stopped_and_keeps_the_best(second_order):
    problem = second_order("x.rise_time<=0.3", "x.overshoot<=5", "x.peak_rotor_use<=0.9")
    budget = Budget(1000)
    heard = []

    def listen(best):
        heard.append(best.reserve)
        if budget.spent > 6:
            budget.told = True

    best = find_from(Evaluation(problem, budget, listen), [START])
    assert budget.spent < 20
    assert best.reserve == heard[-1]
    assert heard == sorted(heard)


def test_a_part_of_a_budget_stops_with_the_whole():
    whole = Budget(10)
    part = whole.part(5)
    assert not part.ended
    whole.told = True
    assert part.stopped
    assert part.ended


def test_the_most_promising_start_is_climbed_from_first(second_order):
    """From the near one all is met at once, and nothing around the far one is looked at again."""
    problem = second_order("x.rise_time<=0.3", "x.overshoot<=5", "x.peak_rotor_use<=0.9")
    far, near = np.log([0.5, 0.1]), np.log([8.0, 0.7])
    assert find_from(Evaluation(problem, Budget(400)), [far, near]).met
    others = [point for point in problem.looked if not np.array_equal(point, far)]
    assert max(np.abs(point - near).max() for point in others) < np.abs(far - near).max() / 2.0
