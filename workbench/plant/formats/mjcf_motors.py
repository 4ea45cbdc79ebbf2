"""Read the actuators of an MJCF file that push or turn a site of the drone."""

import math
from collections.abc import Iterator, Mapping
from pathlib import Path

from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.mjcf_document import (
    Compiler,
    Copies,
    Defaults,
    chosen,
    elements,
    elements_of,
    fault,
    servo_of,
)
from workbench.plant.formats.values import listed, number, numbers, shortened
from workbench.plant.formats.xml import Element, place
from workbench.plant.model import DeclaredActuator
from workbench.plant.remarks import Remarks

Sites = Mapping[str, tuple[str, RigidTransform]]
"""Link and pose in it of the sites, by name."""
_FILTERS = ("filter", "filterexact")
_ADVICE = (
    "the workbench knows actuators whose force is gain times control plus bias, with a filter of "
    "first order or without: write it as a <motor>"
)


def read_actuators(
    path: Path,
    root: Element,
    compiler: Compiler,
    defaults: Defaults,
    sites: Sites,
    copies: Copies,
    remarks: Remarks,
) -> Iterator[DeclaredActuator]:
    """Yield the actuators that apply a force or moment at a site of the drone, in MuJoCo's order.

    An actuator at a site that `<replicate>` copied is copied too.

    Args:
        path: of the file.
        root: of the document.
        compiler: its settings.
        defaults: its defaults.
        sites: of the drone.
        copies: what `<replicate>` did to the names of sites.
        remarks: receives remarks on other actuators.

    Raises:
        WorkbenchError: for an actuator whose force cannot be had.
    """
    disabled = {
        group
        for option in elements(root, "option")
        for group in numbers(option, "actuatorgroupdisable", "")
    }
    found: list[tuple[str, str, Element]] = []
    for index, child in enumerate(elements_of(root, "actuator")):
        element = defaults.applied(child, "")
        name = element.get("name") or f"actuator_{index}"
        site = element.get("site", "")
        if not site:
            text = f"a <{shortened(child.tag)}> that does not push a site of the drone; not used"
            remarks.add("ignored", path, f"actuator '{shortened(name)}'", text)
            continue
        if number(element, "group", "0") in disabled:
            raise fault(
                element, "group", "<option actuatorgroupdisable> switches it off: enable it"
            )
        found += [(suffix, name, element) for suffix in copies.suffixes(site)]
    for suffix, name, element in sorted(found, key=lambda each: each[0]):
        yield _actuator(element, name + suffix, element.get("site", "") + suffix, compiler, sites)


def _actuator(
    element: Element, name: str, site: str, compiler: Compiler, sites: Sites
) -> DeclaredActuator:
    """Return one actuator."""
    what = f"{place(element)}: actuator '{shortened(name)}'"
    if site not in sites:
        raise WorkbenchError(
            f"{what} is at the site '{shortened(site)}', which the drone "
            f"does not have: sites are {listed(list(sites))}"
        )
    if "refsite" in element.attrib:
        raise fault(element, "refsite", "a rotor pushes along its own site: leave it out")
    servo = servo_of(element)
    if element.tag not in ("motor", "general") or servo:
        raise WorkbenchError(f"{what} is a <{servo or element.tag}>: {_ADVICE}")
    least, most = _range(element, compiler)
    gear = _several(element, "gear", "1", 6)
    link, X_LS = sites[site]
    return DeclaredActuator(
        name=name,
        link=link,
        X_LS=X_LS,
        force_S=(gear[0], gear[1], gear[2]),
        moment_S=(gear[3], gear[4], gear[5]),
        least=least,
        most=most,
        time_constant=_lag(element),
    )


def _range(element: Element, compiler: Compiler) -> tuple[float, float]:
    """Return the least and the largest force over gear, infinite without limits."""
    kind = element.get("dyntype", "none")
    if kind not in ("none", *_FILTERS) or number(element, "actdim", "-1") > 1.0:
        raise fault(element, "dyntype", _ADVICE)
    gain = _several(element, "gainprm", "1", 3)
    if chosen(element, "gaintype", "fixed", "fixed affine muscle user dcmotor") not in (
        "fixed",
        "affine",
    ) or (element.get("gaintype") == "affine" and any(gain[1:3])):
        raise fault(element, "gaintype", _ADVICE)
    bias = _several(element, "biasprm", "0", 3)
    if element.get("biastype", "none") == "none":
        bias = [0.0] * 3
    elif element.get("biastype") != "affine" or any(bias[1:3]):
        raise fault(element, "biastype", _ADVICE)
    if gain[0] == 0.0:
        raise fault(element, "gainprm", "its control has no effect: give it a gain")
    low, high = _limits(element, "ctrl", compiler)
    if kind in _FILTERS:
        inner = _limits(element, "act", compiler)
        low, high = max(low, inner[0]), min(high, inner[1])
    ends = sorted(gain[0] * end + bias[0] for end in (low, high))
    force = _limits(element, "force", compiler)
    least, most = (min(max(end, force[0]), force[1]) for end in ends)
    return least, most


def _limits(element: Element, word: str, compiler: Compiler) -> tuple[float, float]:
    """Return the limits of a control, an activation or a force, infinite without any."""
    name = f"{word}range"
    limited = chosen(element, f"{word}limited", "auto", "auto true false")
    given = name in element.attrib
    if limited == "auto" and given and not compiler.autolimits:
        raise fault(element, name, f"without autolimits, MuJoCo asks for {word}limited: add it")
    if limited == "false" or not (given or limited == "true"):
        return -math.inf, math.inf
    values = numbers(element, name, "0 0")
    if len(values) != 2 or values[1] <= values[0]:
        raise fault(element, name, "give it two numbers, the smaller first")
    return values[0], values[1]


def _several(element: Element, name: str, default: str, size: int) -> list[float]:
    """Return the first numbers of an attribute, with zeros in place of missing ones."""
    return [*numbers(element, name, default), *[0.0] * size][:size]


def _lag(element: Element) -> float | None:
    """Return the time constant of an actuator with a first-order filter [s], None without."""
    if element.get("dyntype") not in _FILTERS:
        return None
    value = numbers(element, "dynprm", "1")[0]
    return value if value > 0.0 else None
