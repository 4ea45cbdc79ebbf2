"""The page before a real flight in real time: it flies, and without a network the drone holds."""

import math

import pytest

from tests.link.page.expecting import expect
from workbench.common.resources import find_scenario
from workbench.link.server.config import ServerConfig
from workbench.live.flight import LiveFlight
from workbench.scenario.scenario_file import load_scenario

pytestmark = pytest.mark.slow

STARTING = 60.0
LONG = 60_000
"""For what a slow machine takes [ms]."""


def test_a_phone_flies_and_is_lost(networks, open_page, touch):
    with LiveFlight(load_scenario(find_scenario("network"))) as flight:
        flight.serve(ServerConfig(port=0, web=True)).result(STARTING)
        # In slow motion: a page that a slow machine keeps waiting shall not lose control by it.
        flight.set_speed(0.25).result(STARTING)
        touch.wait(lambda: flight.latest().network.server is not None, "served")
        proxy = networks.Proxy(flight.latest().network.server.page)
        try:
            fly(flight, proxy, open_page, touch)
        finally:
            proxy.close()


def fly(flight, proxy, open_page, touch):
    page = open_page(proxy.url)
    expect(page.locator("#connection")).to_have_text("Connected", timeout=LONG)
    expect(page.locator("#nearest")).to_contain_text(" m ", timeout=LONG)
    touch.take_control(page)
    page.tap("[data-what=take_off]")
    expect(page.locator("#condition")).to_have_text("hovering", timeout=LONG)
    fingers = touch.Fingers(page)
    x, y = touch.centre(page, "#left")
    fingers.put(1, x, y)
    fingers.put(1, x, y - 100)
    touch.wait(lambda: flight.latest().snapshot.v_WB[2] > 0.5, "climbed")
    proxy.cut()
    expect(page.locator("#connection")).to_contain_text("Lost", timeout=LONG)
    touch.wait(lambda: math.hypot(*flight.latest().snapshot.v_WB) < 0.1, "held")
    control = flight.latest().network.control
    assert control.hand.value == "nobody"
    assert "the connection of phone ended" in control.reason
    proxy.mend()
    expect(page.locator("#connection")).to_have_text("Connected", timeout=LONG)
    expect(page.locator("#take")).to_have_text("Take control")
