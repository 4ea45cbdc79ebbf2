"""Select the flying model among those in a file, or read all of them as one world."""

from workbench.common.errors import WorkbenchError
from workbench.extras.formats.detachable_joint import held_models
from workbench.extras.formats.sdf_include import SdfFile, SdfFiles, model_name
from workbench.extras.formats.sdf_node import Node
from workbench.extras.formats.sdf_tree import MODEL_FRAME_NAME, SdfFrame, SdfTree, build_sdf_tree
from workbench.plant.formats.sdf_pose import sdf_flag
from workbench.plant.formats.values import shortened_text
from workbench.plant.formats.xml import Element
from workbench.plant.remarks import Remarks

MAX_SDF_MODELS = 1000
MAX_MODEL_NAMES_SHOWN = 10
_SCENERY_MODELS = ("sun", "ground_plane")
"""Models that come with Gazebo and are in most worlds."""


def choose_model(
    file: SdfFile, files: SdfFiles, remarks: Remarks
) -> tuple[Node, SdfTree, list[Node]]:
    """Return the only model of a file or of its world, or the flying one of several.

    The flying model is the only one with a motor-model plugin or, if none has one, the only one
    that is not static. With it are the models that its plugins hold.

    Args:
        file: the file.
        files: finds included ones.
        remarks: receives a remark on other models.

    Returns:
        Its element, its tree, and the elements of the models that it holds.

    Raises:
        WorkbenchError: if there is no such model, or several.
    """
    tops = top_models(file)
    if not tops:
        raise WorkbenchError(f"{file.path}: there is no <model> in it, nor an <include> of one")
    if len(tops) > MAX_SDF_MODELS:
        raise WorkbenchError(
            f"{file.path}: there are more than {MAX_SDF_MODELS} models: give a file with the drone "
            "alone"
        )
    if len(tops) == 1:
        return tops[0], build_sdf_tree(file, tops[0], files), []
    top, tree = _flying_model(file, [top for top in tops if not is_scenery(top)], files)
    by_name = {top_name(each): each for each in reversed(tops) if each is not top}
    held = [by_name[name] for name in sorted(held_models(tree.plugins)) if name in by_name]
    if others := [top_name(each) for each in tops if each is not top and each not in held]:
        text = f"'{shortened_text(tree.name)}' flies; left out are {list_of_names(others)}"
        remarks.add("ignored", file.path, "models of the world", text)
    return top, tree, held


def world_element(file: SdfFile) -> Element:
    """Return the `<world>` in a file, or its root element without one.

    Raises:
        WorkbenchError: if there are several.
    """
    worlds = [each for each in file.root.findall("world") if isinstance(each, Element)]
    if len(worlds) > 1:
        raise WorkbenchError(f"{file.path}: has {len(worlds)} worlds: leave one in it")
    return worlds[0] if worlds else file.root


def world_of(file: SdfFile, world: Node, trees: list[SdfTree]) -> SdfTree:
    """Return models as parts of one tree with the frame of their world.

    Args:
        file: of the world.
        world: its `<world>`, or the element that contains the models.
        trees: of the models, see `build_sdf_tree`.
    """
    root = SdfFrame(
        world.model, owner=world, pose=None, base=MODEL_FRAME_NAME, inside=world, carrier=""
    )
    return SdfTree(
        name=world.attribute("name") or file.path.stem,
        static=True,
        sources=[source for tree in trees for source in tree.sources],
        models=[root, *(model for tree in trees for model in tree.models)],
        links=[link for tree in trees for link in tree.links],
        joints=[joint for tree in trees for joint in tree.joints],
        frames=[*world.children("frame"), *(frame for tree in trees for frame in tree.frames)],
        plugins=[plugin for tree in trees for plugin in tree.plugins],
    )


def _flying_model(file: SdfFile, tops: list[Node], files: SdfFiles) -> tuple[Node, SdfTree]:
    """Return the flying one of several models."""
    grown: list[tuple[Node, SdfTree]] = []
    faults: list[WorkbenchError] = []
    for top in tops:
        try:
            tree = build_sdf_tree(file, top, files)
        except WorkbenchError as fault:  # scenery may be missing
            faults.append(fault)
            continue
        if tree.missing and not has_motors(tree):
            faults.append(tree.missing[0][1])
        else:
            grown.append((top, tree))
    flying = [(top, tree) for top, tree in grown if has_motors(tree)]
    if not flying and faults:
        others = f" (and so with {len(faults) - 1} more models)" if len(faults) > 1 else ""
        raise WorkbenchError(f"{faults[0]}{others}")
    flying = flying or [(top, tree) for top, tree in grown if not tree.static]
    if not flying:
        raise WorkbenchError(
            f"{file.path}: all its models are static: give a file with the drone alone"
        )
    if len(flying) > 1:
        raise WorkbenchError(
            f"{file.path}: several of its models could be the drone: "
            f"{list_of_names([tree.name for _, tree in flying])}: give a file with that model alone"
        )
    return flying[0]


def top_models(file: SdfFile) -> list[Node]:
    """Return the models and includes of a file and of the worlds in it."""
    places = [file.root, *file.root.findall("world")]
    return [
        Node(top, file.path, file.version, "", MODEL_FRAME_NAME)
        for place in places
        for top in place
        if isinstance(top, Element) and top.tag in ("model", "include")
    ]


def is_scenery(top: Node) -> bool:
    """Return whether a model is certainly static, even if its file is missing."""
    static = top.child("static")
    if static and sdf_flag(static.element, static.text):
        return True
    return bool(gazebo_scenery_name(top))


def gazebo_scenery_name(top: Node) -> str:
    """Return `sun` or `ground_plane` for an include of that model of Gazebo, else ""."""
    name = model_name(top.text_of("uri")) if top.element.tag == "include" else ""
    name = name.lower().replace(" ", "_")
    return name if name in _SCENERY_MODELS else ""


def has_motors(tree: SdfTree) -> bool:
    """Return whether a model has a motor-model plugin of RotorS, PX4 or gz-sim."""
    return any(map(_is_motor, tree.plugins))


def motor_names(tree: SdfTree) -> list[str]:
    """Return the names of links and joints in the motor-model plugins of a model."""
    return [
        plugin.text_of(tag)
        for plugin in tree.plugins
        if _is_motor(plugin)
        for tag in ("jointName", "linkName")
    ]


def same_part(name: str, full_name: str) -> bool:
    """Return whether a name in a plugin may refer to a link or joint, ignoring scopes."""
    return _without_scopes(name) == _without_scopes(full_name)


def _without_scopes(name: str) -> str:
    return name.replace("::", "/").rpartition("/")[2]


def _is_motor(plugin: Node) -> bool:
    name = plugin.attribute("filename") + plugin.attribute("name")
    return "motormodel" in "".join(filter(str.isalnum, name)).lower()


def top_name(top: Node) -> str:
    """Return the name of a model, as far as it is known without opening other files."""
    return top.attribute("name") or top.text_of("name") or model_name(top.text_of("uri"))


def list_of_names(names: list[str]) -> str:
    """Return names for a message."""
    more = (
        f" and {len(names) - MAX_MODEL_NAMES_SHOWN} more"
        if len(names) > MAX_MODEL_NAMES_SHOWN
        else ""
    )
    return ", ".join(f"'{shortened_text(name)}'" for name in names[:MAX_MODEL_NAMES_SHOWN]) + more
