"""Write docs/phone.png, the page before a real flight: `python tools/page_pictures.py`.

It needs playwright and Chromium.
"""

import io
import shutil
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from PIL import Image
from playwright.sync_api import expect, sync_playwright

from workbench.common.resources import find_scenario
from workbench.link.server.config import ServerConfig
from workbench.live.flight import LiveFlight
from workbench.scenario.scenario_file import load_scenario

OUT = Path(__file__).resolve().parent.parent / "docs" / "phone.png"
UPRIGHT, LYING = (360, 740), (740, 360)
GAP = 20
COLOURS = 256
LONG = 60.0
"""For a slow machine [s]."""


def main() -> int:
    """Fly, look and write."""
    found = next(filter(None, map(shutil.which, ("chromium", "google-chrome"))), None)
    if found is None:
        print("Chromium is not there: run `sudo apt-get install chromium`", file=sys.stderr)
        return 2
    with (
        LiveFlight(load_scenario(find_scenario("network"))) as flight,
        sync_playwright() as driver,
    ):
        flight.serve(ServerConfig(port=0, web=True)).result(LONG)
        while flight.latest().network.server is None:
            time.sleep(0.05)
        server = flight.latest().network.server
        assert server
        browser = driver.chromium.launch(executable_path=found, args=["--no-sandbox"])
        upright = look(browser, server.page, UPRIGHT, "light", fly)
        lying = look(browser, server.page, LYING, "dark", fly)
        refused = look(browser, server.page, LYING, "light", ask_without_control)
        browser.close()
    whole = Image.new("RGB", (UPRIGHT[0] + GAP + LYING[0], UPRIGHT[1]), "white")
    whole.paste(upright, (0, 0))
    whole.paste(lying, (UPRIGHT[0] + GAP, 0))
    whole.paste(refused, (UPRIGHT[0] + GAP, LYING[1] + GAP))
    whole.quantize(COLOURS).save(OUT, optimize=True)
    print(f"{OUT}: {OUT.stat().st_size // 1000} kB")
    return 0


def look(
    browser: Any, url: str, size: tuple[int, int], scheme: str, act: Callable[[Any], None]
) -> Image.Image:
    """Return a picture of the page after somebody did something."""
    width, height = size
    context = browser.new_context(
        viewport={"width": width, "height": height}, color_scheme=scheme, has_touch=True
    )
    page = context.new_page()
    page.goto(url)
    expect(page.locator("#nearest")).to_contain_text(" m ", timeout=1000 * LONG)
    act(page)
    picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    context.close()
    return picture


def ask_without_control(page: Any) -> None:
    """Ask for what only the holder may do."""
    page.tap("[data-what=land]", force=True)
    expect(page.locator("#said")).to_be_visible()


def fly(page: Any) -> None:
    """Take off, and hold the right stick ahead."""
    page.tap("#take")
    page.tap("[data-what=take_off]")
    expect(page.locator("#condition")).to_have_text("hovering", timeout=1000 * LONG)
    box = page.locator("#right .pad").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    session = page.context.new_cdp_session(page)
    for kind, to in (("touchStart", y), ("touchMove", y - 45)):
        point = {"x": x, "y": to, "id": 1}
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [point]})
    expect(page.locator("#condition")).to_have_text("cruising", timeout=1000 * LONG)
    page.wait_for_timeout(700)


if __name__ == "__main__":
    sys.exit(main())
