"""What the gateway to ROS 2 is told."""

import argparse

import pytest

from workbench.common.errors import WorkbenchError
from workbench.extras.gateways.ros2_options import (
    Ros2Options,
    add_ros2_options,
    domain_number,
    ros2_options,
)


def parsed(*words):
    parser = argparse.ArgumentParser()
    add_ros2_options(parser)
    return parser.parse_args(words)


@pytest.mark.parametrize(("said", "number"), [(None, 0), ("", 0), ("0", 0), ("42", 42)])
def test_the_environment_names_the_domain(monkeypatch, said, number):
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    if said is not None:
        monkeypatch.setenv("ROS_DOMAIN_ID", said)
    assert domain_number(None) == number


def test_an_option_beats_the_environment(monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "42")
    assert domain_number(7) == 7


@pytest.mark.parametrize("said", ["233", "-1", "one", "1.0", "9" * 40])
def test_a_wrong_domain_in_the_environment_is_named(monkeypatch, said):
    monkeypatch.setenv("ROS_DOMAIN_ID", said)
    with pytest.raises(WorkbenchError, match="ROS_DOMAIN_ID is '.*0 to 232"):
        domain_number(None)


@pytest.mark.parametrize("number", [-1, 233])
def test_a_wrong_domain_in_an_option_is_named(number):
    with pytest.raises(WorkbenchError, match=f"--domain is '{number}'"):
        Ros2Options(domain=number).check()


@pytest.mark.parametrize("words", [("--interface", "192.0.2.7"), ("--config", "<CycloneDDS/>")])
def test_nobody_in_the_network_may_fly(words):
    with pytest.raises(WorkbenchError, match="on this computer only, as DDS has no login"):
        ros2_options(parsed("--allow-commands", *words))
    assert not ros2_options(parsed(*words)).allow_commands


def test_alone_on_this_computer_and_only_watching_by_default():
    assert ros2_options(parsed()) == Ros2Options()
    assert Ros2Options().interface == "lo"


def test_a_configuration_is_text_or_a_file(tmp_path):
    file = tmp_path / "cyclone dds.xml"
    file.write_text("<CycloneDDS/>")
    assert ros2_options(parsed("--config", " <A/>")).configuration == " <A/>"
    assert ros2_options(parsed("--config", str(file))).configuration == file.as_uri()
    assert ros2_options(parsed("--config", file.as_uri())).configuration == file.as_uri()
    with pytest.raises(WorkbenchError, match="no such file"):
        ros2_options(parsed("--config", str(tmp_path / "none.xml")))


def test_an_interface_that_is_not_here_is_named_with_those_that_are():
    with pytest.raises(WorkbenchError, match="--interface wlan77: .* write one of .*lo"):
        Ros2Options(interface="wlan77").check()


@pytest.mark.parametrize(
    ("said", "possible"),
    [("my drone", "my_drone"), ("fleet//a", "fleet/drone/a"), ("1a", "drone_1a")],
)
def test_a_namespace_may_be_nested_and_has_names_of_ros(said, possible):
    Ros2Options(namespace="fleet/drone_1").check()
    with pytest.raises(WorkbenchError, match=f"is not a name in ROS 2: .* such as {possible}$"):
        Ros2Options(namespace=said).check()
