"""Wishes as they are typed: what may stand in one, and what is wrong with another."""

import re

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller
from workbench.design.metrics import WISHED
from workbench.design.tune.wish import groups_of, parse_wish, subjects_of
from workbench.gui.typed_number import NUMBER, read_number

_BOUND = re.compile(rf"(?P<sign>[<>≤≥]=?)\s*(?P<number>{NUMBER})")


def completions(law: Controller) -> tuple[str, ...]:
    """Return the beginnings that a wish about a controller may have, as `x.rise_time <= `."""
    return tuple(
        f"{subject}.{metric.name} {'>=' if metric.better > 0 else '<='} "
        for metric in WISHED
        for subject in (*subjects_of(metric, law), *groups_of(metric, law))
    )


def what_is_wrong(text: str, law: Controller) -> str:
    """Return what is wrong with a wish, as a sentence; "" where nothing is."""
    bound = _BOUND.search(text)
    try:
        if bound:
            read_number(bound["number"])
        parse_wish(with_point(text), law=law)
    except WorkbenchError as error:
        return str(error)
    return ""


def with_point(text: str) -> str:
    """Return a wish with a point before the decimals of its number, where it has a comma."""
    bound = _BOUND.search(text)
    if bound is None:
        return text.strip()
    begin, end = bound.span("number")
    number = bound["number"].replace(",", ".").replace("\N{MINUS SIGN}", "-")
    return (text[:begin] + number + text[end:]).strip()
