"""Series of a flight against its snapshots, which come another way."""

import numpy as np
import pytest

from tests.jointed import drone, joint, link
from workbench.common.errors import WorkbenchError
from workbench.gui.signals import Signals, events_in
from workbench.link.backplane import Published
from workbench.link.drone_topics import EVENTS_SIGNAL, fixed_topic
from workbench.live.view import LiveView
from workbench.scenario.scenario import Scenario, VehicleConfig
from workbench.session.session import Session
from workbench.systems.bridge import Bridge


def filled(canned, seconds=180.0):
    signals = Signals(seconds)
    signals.begin(canned.views[0].topics)
    for published in canned.published:
        signals.add(published)
    return signals


def test_a_series_is_what_was_flown(canned):
    signals = filled(canned)
    for view in canned.views[30::40]:
        time, v_x = signals.series("velocity_data.v_x")
        flown = np.interp(view.snapshot.time, time, v_x)
        assert flown == pytest.approx(view.snapshot.v_WB[0], abs=2e-3)


def test_several_numbers_of_a_field_are_a_series_each(canned):
    signals = filled(canned)
    _, thrust = signals.series("rotors.thrust.3")
    assert thrust[-1] == pytest.approx(canned.views[-1].snapshot.thrusts[3], rel=0.02)
    assert signals.units["rotors.thrust.3"] == "N"


def test_only_the_wanted_seconds_are_kept(canned):
    signals = filled(canned, seconds=1.0)
    time, _ = signals.series("velocity_data.v_x")
    assert time[-1] == pytest.approx(3.0, abs=0.01)
    assert 1.0 <= time[-1] - time[0] <= 2.0
    since, _ = signals.series("velocity_data.v_x", since=2.5)
    assert since[0] == pytest.approx(2.5, abs=0.01)


def test_the_newest_of_a_topic_has_its_texts_too(canned):
    signals = filled(canned)
    assert signals.newest("drone_state")
    assert signals.newest("nonsense") == {}


def test_an_unknown_signal_is_named(canned):
    with pytest.raises(WorkbenchError, match="velocity_data.v_q"):
        filled(canned).series("velocity_data.v_q")


def test_a_new_flight_begins_empty(canned):
    signals = filled(canned)
    signals.begin(canned.views[0].topics)
    assert len(signals.series("velocity_data.v_x")[0]) == 0
    assert signals.now == 0.0


def test_a_joint_has_the_unit_of_its_motion_once_the_vehicle_is_known(tmp_path, workspace):
    """A topic has one unit for all of its joints, whichever turn and slide."""
    limit = '<limit lower="-1" upper="1" effort="9"/><servo kind="{}" {}/>'
    swing = limit.format("position", 'stiffness="4" damping="0.1"')
    leg = limit.format("velocity", 'damping="5"')
    parts = (
        joint("Swing", "revolute", "base", "arm", more=swing)
        + link("arm", 0.1)
        + joint("leg", "prismatic", "base", "foot", more=leg)
        + link("foot", 0.1)
    )
    scenario = Scenario(vehicle=VehicleConfig(model=drone(tmp_path, parts)))
    session = Session(scenario, bridge=Bridge())
    view = LiveView(vehicle=session.vehicle, topics=session.topics)
    units = {
        "joint_states.position.swing": "rad",
        "joint_states.velocity.swing": "rad/s",
        "joint_states.position.leg": "m",
        "joint_states.velocity.leg": "m/s",
        "joint_setpoints.position.swing": "rad",
        "joint_setpoints.velocity.leg": "m/s",
    }
    workspace.flight.begun.emit(view)
    assert {name: workspace.signals.units[name] for name in units} == units
    assert not [unit for unit in workspace.signals.units.values() if " or " in unit]
    workspace.signals.begin(session.topics)
    assert workspace.signals.units["joint_states.position.leg"] == "rad or m"


def test_events_have_the_severity_that_is_nearest_to_theirs():
    """That of a newer server may be one more, and then it is a failure."""
    topic = fixed_topic(EVENTS_SIGNAL.id)
    for severity, word in (
        (-1, "information"),
        (0, "information"),
        (1, "warning"),
        (2, "failure"),
        (3, "failure"),
        (7, "failure"),
    ):
        values = {"severity": severity, "said": "it tilts"}
        payload = topic.pack([values[field.name] for field in topic.fields])
        published = Published(1_500_000_000, 0, ((EVENTS_SIGNAL.id, payload),))
        assert events_in([published]) == [(1.5, word, "it tilts")]
