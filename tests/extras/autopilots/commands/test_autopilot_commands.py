"""What commands say about the laws of autopilots, and `workbench sitl` about names."""

import pytest

from workbench.commands.cli import main


def test_a_law_tells_from_which_attitudes_it_recovers(run):
    said = run("controllers", "mellinger")
    assert "attitudes: as in the firmware, it recovers only where" in said.out
    assert "tilt of 90°" in run("controllers", "mellinger", "--json").json["attitudes"]
    assert "attitudes:" not in run("controllers", "pd").out


def test_an_unknown_autopilot_is_refused_with_the_nearest(refused):
    said = refused("sitl", "px5")
    assert "unknown autopilot 'px5': did you mean 'px4'? known are ardupilot, px4" in said


def test_the_nearest_firmware_and_law_is_named(refused, case):
    for words, said in (
        ("gains export a.params --for px5", "unknown --for 'px5': did you mean 'px4'? known are"),
        ("step --controller px5", "unknown controller 'px5': did you mean 'px4'? known are"),
    ):
        with case(words):
            assert said in refused(*words.split())


def test_the_help_lists_firmwares_and_laws(capsys, case):
    for words, said in (
        ("gains import --help", "{ardupilot,betaflight,crazyflie,px4}"),
        ("fly --help", "geometric, indi, ardupilot, betaflight, crazyflie, mellinger, px4"),
        ("predict --help", "mellinger, px4, or a .py file"),
    ):
        with pytest.raises(SystemExit):
            main(words.split())
        with case(words):
            assert said in " ".join(capsys.readouterr().out.split())
