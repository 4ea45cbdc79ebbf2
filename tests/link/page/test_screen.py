"""What the page shows in a real browser, as a phone does, before a played flight."""

import json

import pytest

from tests.hostile_names import NAMES, acting
from tests.link.page.expecting import expect

pytestmark = pytest.mark.slow

LONG = 20_000
"""For what a slow machine takes [ms]."""
LONGEST = {
    "condition": "descending",
    "connection": "Connected",
    "nearest": "12 m behind right",
    "speed": "12.5",
    "height": "100.5",
    "battery": "100",
    "age": "999",
    "why": "phone was silent for 0.5 s: the drone holds; nobody flew for 5 s: the drone lands",
}
"""Words that must have room."""
LOST = {"condition": "", "connection": "Lost: again in 8 s"}
WRITE = """words => {
    for (const [id, text] of Object.entries(words)) document.getElementById(id).textContent = text;
}"""
SHOW = """async text => {
    const { Screen } = await import("./screen.js");
    const { Phase } = await import("./link.js");
    const name = JSON.parse(text);
    const control = { hand: "client", peer: 9, name, reason: name, stage: "live" };
    const hello = { vehicle: name, peer: 1, limits: { level_speed: 8 } };
    const screen = new Screen();
    const before = document.querySelectorAll("*").length;
    screen.link({ phase: Phase.OPEN, silent: false, flying: false, control, hello });
    screen.say(name);
    const shown = ["#vehicle", "#holder", "#why", "#said p"].map(
        (each) => document.querySelector(each).textContent);
    return {
        shown: [...shown, document.title],
        more: document.querySelectorAll("*").length - before,
        wide: document.documentElement.scrollWidth,
    };
}"""
"""Show a name wherever the page shows one, at once, so that the flight writes nothing over it."""
MEASURE = """() => {
    const all = (names) => [...document.querySelectorAll(names)];
    const seen = (names) => all(names).filter((each) => each.offsetParent);
    const said = (found) => found.map((each) => each.textContent);
    const words = seen("button, dd, dt, h1, figcaption, #pace span, #connection, #holder");
    const touched = seen("button, #pace label");
    return {
        wide: document.documentElement.scrollWidth,
        cut: said(words.filter((each) => each.scrollWidth > each.clientWidth + 1)),
        small: said(touched.filter((each) => each.offsetWidth < 40 || each.offsetHeight < 40)),
        pads: seen(".pad").map((each) => each.getBoundingClientRect().toJSON()),
    };
}"""


def test_the_page_shows_the_flight_and_who_flies(flight, open_page, touch):
    touch.in_the_air(flight)
    page = open_page(flight.url)
    expect(page.locator("#connection")).to_have_text("Connected", timeout=LONG)
    expect(page.locator("#condition")).to_have_text("hovering")
    expect(page.locator("#height")).to_have_text("1.5")
    expect(page.locator("#battery")).to_have_text("87")
    expect(page.locator("#nearest")).to_contain_text("4.0 m")  # the wall at x = -4
    expect(page.locator("#heading")).to_have_text("Heading 056°")  # a yaw of 0.6 rad
    expect(page.locator("#holder")).to_have_text("Nobody flies")
    assert page.title() == "dh_drone"


def test_a_drone_without_lidar_says_so(played, open_page):
    flight = played.PlayedFlight(lidar=False)
    try:
        page = open_page(flight.url)
        expect(page.locator("#nearest")).to_have_text("No lidar", timeout=LONG)
    finally:
        flight.close()


def test_refusals_are_told_in_words(flight, open_page, touch):
    first, second = open_page(flight.url), open_page(flight.url)
    touch.take_control(first)
    expect(second.locator("#holder")).to_have_text("phone flies", timeout=LONG)
    second.tap("#take")
    expect(second.locator("#said")).to_contain_text(
        "Could not take control: phone flies", timeout=LONG
    )
    second.tap("#said button")
    expect(second.locator("#said")).to_be_hidden()
    second.tap("#hold", force=True)
    expect(second.locator("#said")).to_contain_text("take control first")
    first.tap("[data-what=land]")
    expect(first.locator("#said")).to_contain_text("the drone is on the ground", timeout=LONG)


def test_warnings_of_the_flight_are_shown(flight, open_page):
    page = open_page(flight.url)
    expect(page.locator("#height")).not_to_have_text("–", timeout=LONG)
    flight.say(0, "information")
    flight.say(1, "the battery is low")
    expect(page.locator("#said")).to_contain_text("The battery is low", timeout=LONG)


def test_hostile_names_are_shown_as_text(flight, open_page, case):
    page = open_page(flight.url)
    expect(page.locator("#connection")).to_have_text("Connected", timeout=LONG)
    page.evaluate(SHOW, json.dumps("plain"))  # makes the choice of speeds
    for name in NAMES:
        with case(name[:60]):
            found = page.evaluate(SHOW, json.dumps(name))
            vehicle, holder, why, said, title = found["shown"]
            assert acting("".join(found["shown"]), "") == []
            assert found["more"] == 0  # element
            assert found["wide"] <= 360
            assert holder.endswith(" flies")
            assert why == vehicle and said[1:] == vehicle[1:]
            assert " ".join(vehicle.split()) == title
            if name.isprintable() and len(name) <= 48:
                assert (vehicle, holder) == (name, f"{name} flies")
            elif len(name) > 300:
                assert vehicle == f"{name[:300]}… ({len(name)} characters)"


def test_the_token_is_asked_for_and_forgotten_with_the_tab(played, open_page, tmp_path, touch):
    from workbench.link.server.config import ServerConfig

    tokens = tmp_path / "tokens"
    tokens.touch(mode=0o600)
    tokens.write_text("view: just-to-look-0123456\ncommand: to-fly-it-0123456789\n")
    flight = played.PlayedFlight(ServerConfig(port=0, web=True, token_file=str(tokens)))
    try:
        page = open_page(flight.url)
        page.fill("#token", "this-is-not-the-token")
        page.tap("text=Log in")
        expect(page.locator("#login-said")).to_contain_text("not that of role", timeout=LONG)
        page.fill("#token", "to-fly-it-0123456789")
        page.tap("text=Log in")
        expect(page.locator("#connection")).to_have_text("Connected", timeout=LONG)
        touch.take_control(page)
        touch.wait(lambda: flight.commands, "commanded")
        page.reload()
        expect(page.locator("#connection")).to_have_text("Connected", timeout=LONG)
        assert page.evaluate("localStorage.length") == 0
        other = open_page(flight.url + "#token=just-to-look-0123456&role=view")
        expect(other.locator("#connection")).to_have_text("Connected", timeout=LONG)
        assert "token" not in other.url
        other.tap("#take", force=True)
        expect(other.locator("#said")).to_contain_text("only watches", timeout=LONG)
        assert {peer.role.value for peer in flight.hub.status().clients} == {"view", "command"}
    finally:
        flight.close()


def test_a_page_from_elsewhere_is_refused(flight, networks, open_page, tmp_path):
    foreign = networks.FilesElsewhere(tmp_path)
    try:
        page = open_page(foreign.url)
        said = page.evaluate(
            """url => new Promise(done => {
                const socket = new WebSocket(url);
                socket.onopen = () => done("open");
                socket.onclose = event => done(`closed ${event.code}`);
            })""",
            flight.url.replace("http", "ws") + "ws",
        )
        assert said == "closed 1006"
        assert flight.hub.refusals.counts == {"origin": 1}
        assert flight.hub.status().clients == ()
    finally:
        foreign.close()


def test_nothing_is_cut_or_too_small_to_touch(flight, open_page, touch):
    page = open_page(flight.url)
    touch.take_control(page)
    flight.pace = 0.02  # so that nothing writes over the words
    for width, height in [(320, 568), (360, 740), (740, 360), (1280, 720)]:
        page.set_viewport_size({"width": width, "height": height})
        for words in (LONGEST, LOST):
            page.evaluate(WRITE, words)
            sizes = page.evaluate(MEASURE)
            assert sizes["wide"] <= width
            assert (width, sizes["cut"]) == (width, [])
            assert (width, sizes["small"]) == (width, [])
            for pad in sizes["pads"]:
                assert pad["width"] >= 130 and pad["left"] >= 0 and pad["right"] <= width
