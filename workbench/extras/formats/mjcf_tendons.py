"""Tendons of MJCF: those between two sites, as cables, and those over joints, which drive them."""

from collections.abc import Collection, Iterator, Mapping

from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.common.vectors import float_triple
from workbench.extras.formats.mjcf_compiler import Compiler
from workbench.extras.formats.mjcf_defaults import Defaults
from workbench.extras.formats.mjcf_document import MjcfDocument
from workbench.extras.formats.mjcf_elements import (
    elements,
    elements_of,
    keyword_attribute,
    padded_numbers,
)
from workbench.plant.formats.values import attribute_number, attribute_numbers, shortened_text
from workbench.plant.formats.xml import Element, element_location
from workbench.plant.model import Cable


def drive_by_joints(root: Element, defaults: Defaults) -> None:
    """Let actuators of fixed tendons drive the joint that moves all of the tendon.

    The length of a fixed tendon is the sum of its joints' positions times their coefficients. Where
    `<equality>` makes all but one of them follow that one, as the fingers of a gripper, it is that
    joint's position times a factor, which is then a part of the gear.

    Args:
        root: of the document, whose actuators are changed.
        defaults: its defaults.
    """
    tendons = {each.get("name", ""): each for each in elements_of(root, "tendon", "fixed")}
    for actuator in elements_of(root, "actuator"):
        tendon = tendons.get(actuator.get("tendon", ""))
        leader, factor = _leading_joint(root, tendon) if tendon is not None else ("", 0.0)
        if leader and factor:
            gear = attribute_numbers(defaults.applied(actuator, ""), "gear", "1")[0]
            del actuator.attrib["tendon"]
            actuator.attrib |= {"joint": leader, "gear": repr(factor * gear)}


def _leading_joint(root: Element, tendon: Element) -> tuple[str, float]:
    """Return the joint that moves all of a fixed tendon, "" for none, and how far it does."""
    shares = {
        each.get("joint", ""): attribute_number(each, "coef", "1")
        for each in elements(tendon, "joint")
    }
    follows: dict[str, tuple[str, float]] = {}
    for each in elements_of(root, "equality", "joint"):
        offset, multiplier = padded_numbers(each, "polycoef", "0 1", 2)
        if each.get("active", "true") == "true" and offset == 0.0:
            follows[each.get("joint1", "")] = (each.get("joint2", ""), multiplier)
    leaders = [name for name in shares if follows.get(name, ("", 0.0))[0] not in shares]
    if len(leaders) != 1 or any(
        follows[name][0] != leaders[0] for name in shares if name != leaders[0]
    ):
        return "", 0.0
    moved = {name: follows[name][1] if name != leaders[0] else 1.0 for name in shares}
    return leaders[0], sum(share * moved[name] for name, share in shares.items())


def tendon_sites(root: Element) -> set[str]:
    """Return the sites that the spatial tendons of a document pass."""
    return {
        site.get("site", "")
        for tendon in elements_of(root, "tendon", "spatial")
        for site in elements(tendon, "site")
    }


def read_tendons(
    document: MjcfDocument,
    sites: Mapping[str, tuple[str, RigidTransform]],
    loads: Collection[str],
) -> Iterator[Cable]:
    """Yield the tendons that fly, as cables; a remark has those that do not.

    Args:
        document: with the tendons.
        sites: of the drone and its loads: link and pose.
        loads: links that fly freely.

    Raises:
        WorkbenchError: for one that a load hangs on, and that is no straight cable.
    """
    for number, tendon in enumerate(elements_of(document.root, "tendon", "spatial")):
        passed = [each.get("site", "") for each in elements(tendon)]
        element = document.defaults.applied(tendon, "")
        name = element.get("name") or f"tendon_{number + 1}"
        links = [sites[site][0] for site in passed if site in sites]
        length, why_not = _free_length(element, document.compiler)
        if len(passed) != 2 or len(links) != 2:
            why_not = "it does not run straight between two sites of the drone and its load"
        what = f"tendon '{shortened_text(name)}'"
        if why_not and set(links) & set(loads):
            raise WorkbenchError(
                f"{element_location(element)}: {what}: {why_not}: a load hangs on two <site>, "
                "with range='0 L', or with a stiffness and springlength='0 L'"
            )
        if why_not:
            document.remarks.add("ignored", document.path, what, f"{why_not}; not used")
            continue
        ends = [sites[site] for site in passed]
        if ends[0][0] in loads and ends[1][0] not in loads:
            ends.reverse()  # a load hangs on the second end
        (first, X_first), (second, X_second) = ends
        elastic = attribute_number(element, "stiffness", "0")
        yield Cable(
            name,
            first,
            float_triple(X_first.translation()),
            second,
            float_triple(X_second.translation()),
            length,
            elastic,
            attribute_number(element, "damping", "0") if elastic else 0.0,
        )


def _free_length(element: Element, compiler: Compiler) -> tuple[float, str]:
    """Return the length beyond which a tendon pulls [m], or why it is no cable."""
    if attribute_number(element, "stiffness", "0") > 0.0:
        rest = attribute_numbers(element, "springlength", "-1")
        pulls = len(rest) == 2 and rest[0] <= 0.0 < rest[1]
        return (rest[1], "") if pulls else (0.0, "its spring also pushes")
    limited = keyword_attribute(element, "limited", "auto", "auto true false")
    if limited == "false" or (limited == "auto" and "range" not in element.attrib):
        return 0.0, "its length has no limit"
    if limited == "auto" and not compiler.autolimits:
        return 0.0, "without autolimits, its length has no limit"
    limits = attribute_numbers(element, "range", "0 0")
    pulls = len(limits) == 2 and limits[0] <= 0.0 < limits[1]
    return (limits[1], "") if pulls else (0.0, "its range does not begin at 0")
