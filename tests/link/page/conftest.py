"""Fixtures of the page: a played flight, a browser, and modules under node."""

import importlib.util
import shutil
import sys
import threading
from pathlib import Path

import pytest

HERE = Path(__file__).parent
CHROMIUM = ("/usr/bin/chromium", "chromium", "chromium-browser", "google-chrome")
PHONE = {"width": 360, "height": 740}


def load(name):
    """Return a module that stands beside the tests and is no test."""
    known = f"page_tests_{name}"
    if known not in sys.modules:
        spec = importlib.util.spec_from_file_location(known, HERE / f"{name}.py")
        sys.modules[known] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules[known])
    return sys.modules[known]


@pytest.fixture
def played():
    """Return the module of played flights; no thread may be left behind."""
    before = set(threading.enumerate())
    yield load("played_flight")
    left = [each.name for each in set(threading.enumerate()) - before]
    assert not left, f"threads are left: {left}"


@pytest.fixture(scope="session")
def touch():
    """Return what moves fingers."""
    return load("touch")


@pytest.fixture
def networks(played):
    """Return the module of what stands between a page and its server."""
    return load("networks")


@pytest.fixture
def flight(played):
    flight = played.PlayedFlight()
    yield flight
    flight.close()


@pytest.fixture(scope="module")
def browser():
    """Return a headless Chromium."""
    sync_api = pytest.importorskip(
        "playwright.sync_api", reason="needs playwright: pip install playwright"
    )
    found = next(filter(None, map(shutil.which, CHROMIUM)), None)
    if found is None:
        pytest.skip("needs Chromium: apt-get install chromium")
    with sync_api.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=found, args=["--no-sandbox"])
        yield browser
        browser.close()


@pytest.fixture
def open_page(browser):
    """Return what opens an address as a phone does; no script may fail."""
    contexts, errors = [], []

    def open_page(url, **more):
        context = browser.new_context(viewport=PHONE, has_touch=True, is_mobile=True, **more)
        contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: errors.append(error))
        page.goto(url)
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert not errors
