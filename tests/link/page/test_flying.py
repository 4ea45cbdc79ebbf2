"""Flying from the page in a real browser, touched as on a phone, before a played flight."""

import pytest

from tests.link.page.expecting import expect

pytestmark = pytest.mark.slow

LONG = 20_000
"""For what a slow machine takes [ms]."""


def test_it_takes_control_by_touch_takes_off_and_flies_ahead(flight, open_page, touch):
    page = open_page(flight.url)
    touch.take_control(page)
    page.tap("[data-what=arm]")
    page.tap("[data-what=take_off]")
    expect(page.locator("#condition")).to_have_text("hovering", timeout=LONG)
    assert flight.done == ["arm", "take_off"]
    assert flight.commands[0][1:] == (0.0, 0.0, 0.0, 0.0)
    fingers = touch.Fingers(page)
    x, y = touch.centre(page, "#right")
    fingers.put(1, x, y)
    fingers.put(1, x, y - 100)
    touch.wait(lambda: flight.commands[-1][1] > 0.8, "flown ahead")
    _, v_x, v_y, v_z, yaw_rate = flight.commands[-1]
    # Ahead is along the yaw of 0.6 rad, at the 1 m/s that is chosen.
    assert (v_x, v_y, v_z, yaw_rate) == pytest.approx((0.8245, 0.5641, 0.0, 0.0), abs=2e-3)
    expect(page.locator("#condition")).to_have_text("cruising", timeout=LONG)
    fingers.lift(1)
    touch.wait(lambda: flight.commands[-1][1:] == (0.0, 0.0, 0.0, 0.0), "sprung back")
    knob = page.locator("#right .knob").evaluate("knob => knob.style.transform")
    assert knob.replace("-0px", "0px") == "translate(0px, 0px)"


def test_two_thumbs_move_two_sticks(flight, open_page, touch):
    touch.in_the_air(flight)
    page = open_page(flight.url)
    touch.take_control(page)
    page.get_by_role("radio", name="2", exact=True).tap()
    fingers = touch.Fingers(page)
    left, right = touch.centre(page, "#left"), touch.centre(page, "#right")
    fingers.put(1, *left)
    fingers.put(2, *right)
    fingers.put(1, left[0] + 100, left[1])
    fingers.put(2, right[0], right[1] + 100)
    touch.wait(lambda: flight.commands, "commanded")
    touch.wait(
        lambda: flight.commands[-1][4] < -0.39 and flight.commands[-1][1] < -1.0, "both moved"
    )
    fingers.lift(1)
    touch.wait(lambda: flight.commands[-1][4] == 0.0, "left sprung back")
    assert flight.commands[-1][1] < -1.0
    fingers.cancel()
    touch.wait(lambda: flight.commands[-1][1:] == (0.0, 0.0, 0.0, 0.0), "right sprung back")


@pytest.mark.parametrize("event", ["blur", "pagehide"])
def test_a_page_that_loses_the_eye_springs_the_sticks_back(flight, open_page, event, touch):
    touch.in_the_air(flight)
    page = open_page(flight.url)
    touch.take_control(page)
    fingers = touch.Fingers(page)
    x, y = touch.centre(page, "#left")
    fingers.put(1, x, y)
    fingers.put(1, x, y - 100)
    touch.wait(lambda: flight.commands, "commanded")
    touch.wait(lambda: flight.commands[-1][3] > 0.9, "climbed")
    page.evaluate("name => window.dispatchEvent(new Event(name))", event)
    touch.wait(lambda: flight.commands[-1][3] == 0.0, "neutral")
    count = len(flight.commands)
    fingers.put(1, x, y - 90)  # the finger is still down, and counts no more
    touch.wait(lambda: len(flight.commands) > count + 5, "commanded on")
    assert all(each[3] == 0.0 for each in flight.commands[count:])


def test_a_lost_network_holds_the_drone_and_control_is_not_regained(
    flight, networks, open_page, touch
):
    touch.in_the_air(flight)
    proxy = networks.Proxy(flight.url)
    try:
        page = open_page(proxy.url)
        touch.take_control(page)
        fingers = touch.Fingers(page)
        x, y = touch.centre(page, "#right")
        fingers.put(1, x, y)
        fingers.put(1, x, y - 100)
        touch.wait(lambda: flight.velocity[0] > 0.8, "flown ahead")
        proxy.cut()
        lost = flight.now
        touch.wait(lambda: flight.velocity == (0.0, 0.0, 0.0), "held")
        assert flight.commands[-1][0] <= lost + 0.02
        expect(page.locator("#connection")).to_contain_text("Lost", timeout=LONG)
        expect(page.locator("#holder")).to_have_text("Who flies is not known")
        expect(page.locator("#height")).to_have_text("–")
        count = len(flight.commands)
        proxy.mend()
        expect(page.locator("#connection")).to_have_text("Connected", timeout=LONG)
        expect(page.locator("#holder")).to_have_text("Nobody flies", timeout=LONG)
        fingers.put(1, x, y - 90)
        expect(page.locator("#height")).not_to_have_text("–")
        assert len(flight.commands) == count
    finally:
        proxy.close()


def test_a_silent_page_loses_control_and_the_drone_lands(flight, open_page, touch):
    touch.in_the_air(flight)
    page = open_page(flight.url)
    touch.take_control(page)
    touch.wait(lambda: flight.commands, "commanded")
    page.evaluate("Object.defineProperty(document, 'hidden', { get: () => true })")
    touch.wait(lambda: flight.authority.state(flight.now).stage.value == "hold", "held")
    flight.pace = 5.0
    touch.wait(lambda: flight.mode == 7, "landed")
    expect(page.locator("#said")).to_contain_text("was silent", timeout=LONG)
    expect(page.locator("#take")).to_have_text("Take control")


def test_stop_in_the_air_asks_once_more(flight, open_page, touch):
    touch.in_the_air(flight)
    page = open_page(flight.url)
    expect(page.locator("#condition")).to_have_text("hovering", timeout=LONG)
    touch.take_control(page)
    page.tap("#stop")
    expect(page.locator("#stop")).to_have_text("Sure?")
    assert flight.done == []
    page.wait_for_timeout(400)  # a press within 0.3 s counts as the same
    page.tap("#stop")
    touch.wait(lambda: flight.done == ["stop"], "stopped")


def test_a_finger_that_trembles_does_not_answer_for_the_pilot(flight, open_page, touch):
    touch.in_the_air(flight)
    page = open_page(flight.url)
    expect(page.locator("#condition")).to_have_text("hovering", timeout=LONG)
    touch.take_control(page)
    page.evaluate("for (let press = 0; press < 3; press++) document.getElementById('stop').click()")
    expect(page.locator("#stop")).to_have_text("Sure?")
    assert flight.done == []


def test_stop_asks_where_it_is_not_known_whether_the_drone_flies(flight, open_page, touch):
    flight.tells_mode = False
    page = open_page(flight.url)
    touch.take_control(page)
    page.tap("#stop")
    expect(page.locator("#stop")).to_have_text("Sure?")
    assert flight.done == []


def test_stop_on_the_ground_stops_at_once(flight, open_page, touch):
    page = open_page(flight.url)
    expect(page.locator("#condition")).to_have_text("off", timeout=LONG)
    touch.take_control(page)
    page.tap("#stop")
    touch.wait(lambda: flight.done == ["stop"], "stopped")
