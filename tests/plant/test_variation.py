"""Delays by hand, at 1/1024 and 1/128 s."""

import pytest

from workbench.common.errors import WorkbenchError
from workbench.plant.variation import Variation


@pytest.mark.parametrize(
    ("variation", "seen", "acting"),
    [
        (Variation(), (0, 0), (0, 0)),
        (Variation(control_delay=2), (2, 0), (0, 0)),
        (Variation(sensing_delay=0.003), (1, 5), (0, 0)),  # 3 steps: the state before step 5
        (Variation(control_delay=1, sensing_delay=8 / 1024), (2, 0), (0, 0)),
        (Variation(command_delay=0.004), (0, 0), (0, 4)),
        (Variation(command_delay=7 / 1024), (0, 0), (0, 7)),
        (Variation(command_delay=0.011), (0, 0), (1, 3)),
    ],
    ids=str,
)
def test_delays_are_whole_steps_of_physics(variation, seen, acting):
    delays = variation.delays(1 / 1024, 1 / 128)
    assert (delays.seen, delays.acting) == (seen, acting)


@pytest.mark.parametrize("name", ["sensing_delay", "command_delay"])
@pytest.mark.parametrize("value", [-0.001, 0.2, float("nan")])
def test_what_is_no_delay_is_refused(name, value):
    with pytest.raises(WorkbenchError, match=f"the {name} is .* s: give 0 .. 0.1 s"):
        Variation(**{name: value}).check()
