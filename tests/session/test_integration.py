"""The step in the air, from the numbers of a vehicle."""

import dataclasses

from workbench.common.resources import find_model
from workbench.plant.loading import load_vehicle
from workbench.session.integration import air_step, quickest_rotor


def test_the_quickest_rotor_bounds_the_step_whichever_it_is_and_either_way(case):
    vehicle = load_vehicle(find_model("dh_drone"))
    for place in range(len(vehicle.rotors)):
        for name in ("time_constant_up", "time_constant_down"):
            rotors = list(vehicle.rotors)
            rotors[place] = dataclasses.replace(rotors[place], **{name: 0.003})
            lag = quickest_rotor(dataclasses.replace(vehicle, rotors=tuple(rotors)))
            with case(place, name):
                assert lag == 0.003
                step, third = air_step(1 / 128, lag, False)
                assert (step, third) == (1 / 384, False)  # the longest whole part below it
