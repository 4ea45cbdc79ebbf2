"""What a load is as an action of a script."""

import numpy as np

from workbench.scenario.loads import LOAD_ROWS
from workbench.scenario.scenario import Action, Gust, Push

CENTRE = (0.1, -0.2, 0.3)


def test_a_load_acts_along_its_axis_with_its_size_and_a_force_at_the_centre_of_mass(case):
    """At the origin of the base, a force beside the centre of mass would turn the drone."""
    places = {"x": 0, "y": 1, "z": 2, "roll": 0, "pitch": 1, "yaw": 2}
    for row in LOAD_ROWS:
        kind, _, axis = row.name.partition("_")
        numbers = (-2.5 * np.eye(3)[places[axis]]).tolist()
        none = [0.0, 0.0, 0.0]
        with case(row.name):
            action = row.action(-2.5, 0.7, CENTRE)
            expected = {
                "force": Action(push=Push(numbers, list(CENTRE), 0.7, none)),
                "torque": Action(push=Push(none, list(CENTRE), 0.7, numbers)),
                "gust": Action(gust=Gust(numbers, 0.7)),
            }[kind]
            assert action == expected
            ended = row.action(0.0, 0.7, CENTRE)
            assert ended == (Action(gust=Gust()) if kind == "gust" else Action(push=Push()))
