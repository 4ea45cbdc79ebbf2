"""Playwright's assertions, imported when they are used: only slow tests have a browser."""

from typing import Any


def expect(part: Any) -> Any:
    """Return playwright's assertions about a part of a page, which wait until they hold."""
    from playwright.sync_api import expect as expect_in_browser

    return expect_in_browser(part)
