"""The Home screen with a flight in a can."""

import itertools
import math
from dataclasses import replace

import pytest
from PyQt6.QtCore import Qt

from workbench.control.mode import FlightMode, Reason
from workbench.gui.home.rotor_card import RotorState
from workbench.gui.instruments.instrument import Sign
from workbench.link import drone_topics
from workbench.link.backplane import Published
from workbench.live.messages import Pace, Phase
from workbench.live.view import LiveView
from workbench.plant.faults import Fault
from workbench.session.snapshot import NearestClearance

MINUS = "\N{MINUS SIGN}"


def shown(home, view, clock, **changes):
    """Show a view whose snapshot differs by some values, once all numbers are due."""
    clock.now += 1.0
    home.show_view(replace(view, snapshot=replace(view.snapshot, **changes)))


def test_before_a_flight_nothing_is_claimed(home):
    assert home.cards["motion"].table.texts == (("–",) * 4,) * 3
    assert home.cards["battery"].text == "–"
    assert home.cards["attitude"].indicator.attitude is None
    assert "nothing flies yet" in home.cards["clock"].spoken


def test_a_flight_that_starts_says_what_is_done(home):
    home.show_view(LiveView(said="compiling the law"))
    assert home.cards["clock"].note == "compiling the law"


def test_motion_is_in_the_world_with_its_total(flown, canned, clock):
    shown(
        flown,
        canned.views[-1],
        clock,
        displacement=(3.0, -4.0, 12.0),
        v_WB=(-0.004, 2.0, 0.0),
        vdot_WB=(1.0, 2.0, -2.0),
    )
    assert flown.cards["motion"].table.texts == (
        ("3.00", f"{MINUS}4.00", "12.00", "13.00"),
        ("0.00", "2.00", "0.00", "2.00"),
        ("1.00", "2.00", f"{MINUS}2.00", "3.00"),
    )
    assert flown.cards["motion"].note == "world frame W"


def test_units_are_those_preferred(flown, canned, clock, workspace):
    shown(flown, canned.views[-1], clock, v_WB=(10.0, 0.0, 0.0), roll_pitch_yaw=(0.5, 0.0, 0.0))
    workspace.preferences.set("speed_unit", "km/h")
    workspace.preferences.set("angle_unit", "radian")
    assert flown.cards["motion"].table.texts[1][0] == "36.00"
    assert "km/h" in flown.cards["motion"].table.spoken
    assert flown.cards["attitude"].table.texts[0] == ("0.500",)


def test_the_horizon_follows_every_view_and_digits_do_not(flown, canned, clock):
    view = canned.views[-1]
    before = flown.cards["attitude"].table.texts
    half = math.radians(10.0)
    clock.now += 0.001
    turned = replace(
        view.snapshot,
        q_WB=(math.cos(half), 0.0, math.sin(half), 0.0),
        roll_pitch_yaw=(0.0, math.radians(20.0), 0.0),
    )
    flown.show_view(replace(view, snapshot=turned))
    nose_up = flown.cards["attitude"].indicator.attitude.nose_up
    assert math.degrees(nose_up) == pytest.approx(-20.0, abs=0.05)
    assert flown.cards["attitude"].table.texts == before
    clock.now += 0.5
    flown.show_view(replace(view, snapshot=turned))
    assert flown.cards["attitude"].table.texts[1] == ("20.0",)
    assert flown.cards["attitude"].table.texts[3] == ("090.0",)


def test_numbers_change_ten_times_a_second(flown, canned, clock, monkeypatch):
    """Sixty views in a second: more changes of a digit would be illegible."""
    shows = []
    monkeypatch.setattr(flown.cards["motion"], "show_numbers", lambda *_: shows.append(clock.now))
    for _ in range(60):
        clock.now += 1 / 60
        flown.show_view(canned.views[-1])
    assert 9 <= len(shows) <= 11
    assert min(b - a for a, b in itertools.pairwise(shows)) > 0.04


def test_the_clock_shows_simulated_time_finer_in_a_pause(flown, canned, clock):
    assert flown.cards["clock"].simulated == "0:03.0"
    assert flown.cards["clock"].note == "1.00\N{NO-BREAK SPACE}× real time"
    flown.show_view(replace(canned.views[-1], phase=Phase.PAUSED))
    assert flown.cards["clock"].simulated == "0:03.000"
    assert flown.cards["clock"].note == "paused"
    assert flown.cards["condition"].note == "paused"


def test_in_a_pause_every_view_counts(flown, canned):
    flown.show_view(replace(canned.views[-1], phase=Phase.PAUSED))
    step = replace(canned.views[-1].snapshot, v_WB=(7.0, 0.0, 0.0))
    flown.show_view(replace(canned.views[-1], phase=Phase.PAUSED, snapshot=step))
    assert flown.cards["motion"].table.texts[1][0] == "7.00"


def test_a_slow_machine_is_told_of(flown, canned, clock):
    clock.now += 1.0
    flown.show_view(replace(canned.views[-1], pace=Pace(1.0, 0.62, 0.0, 0.0, True)))
    assert flown.cards["clock"].note == "too slow: 0.62\N{NO-BREAK SPACE}× of 1\N{NO-BREAK SPACE}×"
    assert flown.cards["clock"].sign is Sign.WARNING
    clock.now += 1.0
    flown.show_view(replace(canned.views[-1], pace=Pace(2.0, 1.4, 0.0, 0.0, True)))
    reached = "1.40\N{NO-BREAK SPACE}× of 2\N{NO-BREAK SPACE}× real time"
    assert flown.cards["clock"].note == reached


def test_a_broken_flight_shows_its_last_values_as_such(flown, canned):
    nothing = (math.nan,) * 3
    wrecked = replace(
        canned.views[-1].snapshot,
        p_WB=nothing,
        q_WB=(math.nan,) * 4,
        v_WB=(math.inf, 1e300, math.nan),
        roll_pitch_yaw=nothing,
        thrusts=(math.nan,) * 4,
        charge=math.nan,
        wind=nothing,
        displacement=nothing,
    )
    flown.show_view(replace(canned.views[-1], phase=Phase.BROKEN, snapshot=wrecked))
    flown.grab()
    assert flown.cards["clock"].note == "broken: last values"
    assert flown.cards["condition"].note == "broken: reset to fly again"
    assert flown.cards["attitude"].indicator.attitude is None
    assert flown.cards["motion"].table.texts[1][0] == "–"


def test_a_flight_that_is_not_heard_of_is_told_of(flown, clock, qtbot):
    flown.show()
    clock.now += 7.0
    qtbot.waitUntil(
        lambda: flown.cards["clock"].note == "no news for 7.0\N{NO-BREAK SPACE}s", timeout=5000
    )
    assert flown.cards["clock"].sign is Sign.WARNING


def test_home_is_where_the_flight_began_and_how_far_it_is_is_level(flown, canned, clock):
    """A window may open while the drone is on its way."""
    view, way = canned.views[-1], {"p_WB": (10.0, 20.0, 15.0), "displacement": (3.0, -4.0, 12.0)}
    flown.begin(replace(view, snapshot=replace(view.snapshot, **way)))
    shown(flown, view, clock, **way)
    card = flown.cards["gps"]
    assert (card.map.home.east, card.map.home.north) == (7.0, 24.0)
    assert card.table.texts[3] == ("5.00",)
    assert "5.0 metres from home: 3.0 east, -4.0 north" in card.map.spoken


def test_gps_can_be_read_to_a_centimetre(flown, canned):
    reading = canned.views[-1].snapshot.gps
    latitude, longitude, altitude, _ = (row[0] for row in flown.cards["gps"].table.texts)
    # A degree of latitude is 111 km: 1 cm is 9e-8 degrees.
    assert float(latitude) == pytest.approx(math.degrees(reading.latitude), abs=6e-8)
    assert float(longitude) == pytest.approx(math.degrees(reading.longitude), abs=6e-8)
    assert float(altitude) == pytest.approx(reading.altitude, abs=0.006)


def test_the_map_has_the_way_also_while_nobody_looked(home, workspace, canned, clock):
    workspace.signals.begin(canned.views[0].topics)
    home.begin(canned.views[0])
    for published in canned.published:
        workspace.signals.add(published)
    shown(home, canned.views[-1], clock)
    trail = home.cards["gps"].map.trail.points
    east = canned.views[-1].snapshot.p_WB[0]
    assert trail[0][1] == pytest.approx(0.0, abs=0.05)
    assert trail[-1][1] == pytest.approx(east, abs=0.25)
    assert trail[-1][2] == pytest.approx(canned.views[-1].snapshot.p_WB[1], abs=0.1)
    assert len(trail) > 10
    assert home.cards["gps"].map.place.east == east


def test_sensors_that_measure_show_their_readings(flown, canned):
    now = canned.views[-1].snapshot
    force = now.imu.specific_force
    row = [each.replace(MINUS, "-") for each in flown.cards["imu"].table.texts[1]]
    assert [float(each) for each in row] == pytest.approx(force, abs=0.006)
    heights = flown.cards["height"].table.texts
    assert float(heights[1][0]) == pytest.approx(now.barometer.pressure / 100.0, abs=0.006)
    assert float(heights[2][0]) == pytest.approx(now.height, abs=0.006)
    assert flown.cards["imu"].sign is Sign.GOOD
    field = [float(each.replace(MINUS, "-")) for each in flown.cards["imu"].table.texts[2]]
    assert field == pytest.approx(
        [1e6 * each for each in now.magnetometer.magnetic_field], abs=0.006
    )


def test_the_ring_has_what_the_cloud_says(flown):
    ring = flown.cards["lidar"].ring.ring
    assert math.isfinite(ring.nearest)
    texts = flown.cards["lidar"].table.texts
    assert float(texts[0][0]) == pytest.approx(ring.nearest, abs=0.006)


def test_an_obstacle_that_is_near_is_said_in_words(flown, canned, clock):
    near = NearestClearance(0.7, (1.0, 0.0, 0.0), warning=True)
    shown(flown, canned.views[-1], clock, clearance=near)
    assert flown.cards["lidar"].note == "obstacle near"
    assert flown.cards["lidar"].sign is Sign.WARNING
    assert flown.cards["lidar"].table.texts[3] == ("0.70",)


def test_sensors_that_are_off_say_so_and_how_to_switch_them_on(flown, canned, clock):
    shown(
        flown,
        canned.views[-1],
        clock,
        sensors=(),
        imu=None,
        gps=None,
        lidar=None,
        barometer=None,
        height=None,
        magnetometer=None,
    )
    for name in ("imu", "gps", "lidar", "height"):
        card = flown.cards[name]
        assert card.note == "off"
        assert card.hint.isVisibleTo(flown)
        assert "Settings" in card.hint.sentence
    assert flown.cards["gps"].map.isVisibleTo(flown)


def test_imu_and_magnetometer_are_shown_also_alone(flown, canned, clock):
    now = canned.views[-1].snapshot
    for kind, off in (("imu", [True, True, False]), ("magnetometer", [False, False, True])):
        others = tuple(each for each in now.sensors if each.kind != kind)
        shown(flown, canned.views[-1], clock, sensors=others, **{kind: None})
        table = flown.cards["imu"].table
        assert table.isVisibleTo(flown)
        assert [row == ("", "", "off") for row in table.texts] == off
        assert flown.cards["imu"].sign is Sign.GOOD


def test_the_imu_that_only_the_estimator_reads_is_in_use(flown, canned, clock):
    """With an estimator the magnetometer is on, too, so the table stays; a button switches on."""
    view = canned.views[-1]
    others = tuple(each for each in view.snapshot.sensors if each.kind != "imu")
    named = replace(view, scenario=replace(view.scenario, estimator="ekf"))
    shown(flown, named, clock, sensors=others, imu=None)
    card = flown.cards["imu"]
    assert card.table.texts[:2] == (("", "", "in use"), ("", "", "in use"))
    assert card.table.toolTip().startswith("The estimator reads the IMU")
    snapshot = replace(view.snapshot, sensors=others, imu=None)
    flown.begin(replace(named, snapshot=snapshot))
    assert flown.offers["imu"].isVisibleTo(flown)
    assert flown.offers["imu"].button.accessibleName() == "Fly with the IMU"


def test_one_of_two_height_sensors_is_off(flown, canned, clock):
    now = canned.views[-1].snapshot
    left = tuple(each for each in now.sensors if each.kind != "range_finder")
    shown(flown, canned.views[-1], clock, height=None, sensors=left)
    assert not flown.cards["height"].hint.isVisibleTo(flown)
    assert flown.cards["height"].table.texts[2] == ("off",)
    assert "off m" not in flown.cards["height"].table.spoken


def test_the_only_height_sensor_of_a_drone_is_off(flown, canned, clock):
    """The card names it; of two it says that neither is on."""
    view = canned.views[-1]
    for kinds, said in (
        (("barometer",), "The barometer is off in this flight. Fly with it here or from Settings."),
        (("range_finder",), "The range finder is off in this flight."),
        (("barometer", "range_finder"), "Neither is on in this flight. Fly with them here"),
        ((), ""),
    ):
        carried = tuple(each for each in view.vehicle.sensors if each.kind in kinds)
        drone = replace(view, vehicle=replace(view.vehicle, sensors=carried))
        shown(flown, drone, clock, barometer=None, height=None, sensors=())
        sentence = flown.cards["height"].hint.sentence
        assert sentence.startswith(said) and bool(sentence) is bool(said)


def test_sensors_that_are_off_are_switched_on_by_a_button_of_their_card(
    flown, canned, workspace, monkeypatch, qtbot
):
    """The flight starts anew, with all of them; in a card of sensors that are on there is none."""
    flown.show()
    flown.resize(1190, 600)
    view, started = canned.views[-1], []
    kinds = {each.kind for each in view.snapshot.sensors}
    left = tuple(each for each in view.snapshot.sensors if each.kind not in ("imu", "gps"))
    assert {"imu", "magnetometer", "gps"} <= kinds
    monkeypatch.setattr(workspace.flight, "fly", lambda what, draw: started.append(what))
    monkeypatch.setattr(workspace.flight, "_view", view)
    assert not any(offer.isVisible() for offer in flown.offers.values())
    off = tuple(each for each in left if each.kind != "magnetometer")
    for sensors, added in ((left, ["imu"]), (off, ["imu", "magnetometer"])):
        snapshot = replace(view.snapshot, sensors=sensors, imu=None, gps=None)
        flown.begin(replace(view, snapshot=snapshot))
        assert [name for name, each in flown.offers.items() if each.isVisible()] == ["imu", "gps"]
        button = flown.offers["imu"].button
        assert button.accessibleName() == f"Fly with the {' and the '.join(added)}".replace(
            "imu", "IMU"
        )
        assert button.text() == "Fly with it" and "End this flight" in button.toolTip()
        qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
        assert started[-1].sensors.use == [*view.scenario.sensors.use, *added]
    card = flown.cards["imu"]
    for part in (card.heading, button, card.state):  # none hides another
        assert card.rect().contains(part.mapTo(card, part.rect().center()))
        assert card.childAt(part.mapTo(card, part.rect().center())) in (part, *part.children())


def test_a_card_whose_sensor_is_on_offers_no_flight_with_the_other(flown, canned):
    """As in the default flight, which has no magnetometer."""
    view = canned.views[-1]
    left = tuple(each for each in view.snapshot.sensors if each.kind != "magnetometer")
    flown.begin(replace(view, snapshot=replace(view.snapshot, sensors=left)))
    assert not flown.offers["imu"].isVisibleTo(flown)


def test_a_rotor_that_was_made_to_fail_is_named(flown, workspace, canned, clock):
    topic = next(
        each for each in canned.views[0].topics if each.id == drone_topics.PARAMETERS_SIGNAL.id
    )
    event = Published(0, 3_000_000_000, ((topic.id, topic.pack(["rotor_3", 0.0])),))
    workspace.flight.streamed.emit([event])
    shown(flown, canned.views[-1], clock, thrusts=(5.0, 5.0, 0.0, 5.0))
    assert flown.cards["rotors"].note == "failed: 3"
    assert flown.cards["rotors"].sign is Sign.BAD
    assert [each.state for each in flown.cards["rotors"].bars.readings].count(
        RotorState.STOPPED
    ) == 1


def test_the_reserve_follows_its_parameter(flown, workspace, canned, clock):
    assert flown.cards["battery"].note == "good, reserve 15\N{NO-BREAK SPACE}%"
    topic = next(
        each for each in canned.views[0].topics if each.id == drone_topics.PARAMETERS_SIGNAL.id
    )
    event = Published(0, 3_000_000_000, ((topic.id, topic.pack(["battery_reserve", 0.5])),))
    workspace.flight.streamed.emit([event])
    shown(flown, canned.views[-1], clock, charge=0.52)
    assert flown.cards["battery"].note == "low, reserve 50\N{NO-BREAK SPACE}%"


def test_modes_are_words(flown, canned, clock):
    shown(flown, canned.views[-1], clock, mode=FlightMode.OFF, wind=(0.0, 0.0, 0.0))
    assert flown.cards["condition"].spoken == "off, rotors off · no wind"
    lost = {"mode": FlightMode.LANDING, "reason": Reason.POSITION_LOST, "wind": (0.0, 0.0, 0.0)}
    shown(flown, canned.views[-1], clock, **lost)
    assert flown.cards["condition"].spoken == "landing, position lost · rotors on · no wind"
    for mode in FlightMode:
        shown(flown, canned.views[-1], clock, mode=mode)
        flown.cards["condition"].grab()
        assert flown.cards["condition"].mode is mode


def test_the_wall_clock_runs_without_a_flight(home, qtbot):
    home.show()
    qtbot.waitUntil(lambda: len(home.cards["clock"].wall) == 8, timeout=5000)
    first = home.cards["clock"].wall
    qtbot.waitUntil(lambda: home.cards["clock"].wall != first, timeout=5000)


def test_a_card_of_two_sensors_names_the_one_that_failed(flown, canned, clock):
    view = canned.views[-1]
    sensors = tuple(
        replace(each, fault=Fault.SILENT, age=1.25) if each.kind == "range_finder" else each
        for each in view.snapshot.sensors
    )
    shown(flown, view, clock, sensors=sensors)
    assert flown.cards["height"].note == "range finder silent, 1.2\N{NO-BREAK SPACE}s old"
