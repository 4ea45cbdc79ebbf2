"""Which loop swings, of a made-up swing whose loop passes on a known share of its command."""

import math

import numpy as np
import pytest

from workbench.control.controller_file import load_controller
from workbench.live.suspect import Suspect

FREQUENCY_HZ = 3.0


@pytest.mark.parametrize(("gain", "loop"), [(2.0, "pitch"), (0.9, "velocity x")])
def test_a_loop_that_amplifies_its_command_swings_and_else_the_one_around_it(gain, loop):
    """T = y / (y + e) is the gain at the frequency of the swing, whatever else the drone does."""
    law = load_controller()
    place = law.point_names.index(law.loop("pitch").error)
    suspect = Suspect(law, "pitch", FREQUENCY_HZ, 0.0)
    for update in range(128):  # three whole waves in a second
        time = update / 128
        assert not suspect.is_known(time)
        command = 0.1 * math.sin(2.0 * math.pi * FREQUENCY_HZ * time)
        drift = 1.0 + 0.2 * math.sin(2.0 * math.pi * time)
        signals = np.full(len(law.point_names), 7.0)
        signals[place] = (1.0 - gain) * command
        suspect.look(time, drift + gain * command, signals)
    assert suspect.is_known(1.0)
    assert suspect.loop == loop


@pytest.mark.parametrize(
    ("slow", "held", "loop"),
    [
        (True, True, "position x"),
        (True, False, "velocity x"),  # the pilot steers
        (False, True, "velocity x"),
    ],
)
def test_a_slow_swing_is_one_of_the_place_while_it_is_held(slow, held, loop):
    suspect = Suspect(load_controller(), "x", FREQUENCY_HZ, 0.0, slow=slow, held=held)
    assert suspect.loop == loop
