"""Read Drake's model directives in a world file, with Drake, as obstacles."""

import logging
from bisect import bisect_left
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import yaml
from pydrake.geometry import (
    SceneGraph,
)
from pydrake.multibody.parsing import (
    LoadModelDirectivesFromString,
    Parser,
    ProcessModelDirectives,
)
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.yaml_files import YamlFile, tagged_loader
from workbench.plant.formats.values import shortened_text
from workbench.plant.packages import PackageFinder
from workbench.plant.worlds.directive_includes import IncludeChecker
from workbench.plant.worlds.directive_obstacles import obstacle_of_body
from workbench.plant.worlds.world import StaticObstacle

MAX_DIRECTIVES = 1000
_MAX_DRAKE_MESSAGE_CHARS = 300
"""Largest number of characters of Drake's messages to pass on."""
_DIRECTIVE_KINDS = (
    "add_collision_filter_group",
    "add_directives",
    "add_frame",
    "add_model",
    "add_model_instance",
    "add_weld",
)


def read_directives(file: YamlFile, finder: PackageFinder) -> tuple[StaticObstacle, ...]:
    """Return the bodies in the `directives` of a world file as obstacles.

    They are added to a separate plant, so that errors occur here, and the plant of the flight has
    no other bodies than the drone. Packages that Drake would download are unknown.

    Args:
        file: its key `directives` is a list of mappings.
        finder: of the named files, which may refer to the packages given to it.

    Raises:
        WorkbenchError: naming file and line, if Drake rejects a directive, or a model could move.
    """
    items, includes = _directive_items(file), IncludeChecker(finder)
    if len(items) > MAX_DIRECTIVES:
        where = file.where("directives")
        raise WorkbenchError(f"{where}there are more than {MAX_DIRECTIVES}: leave some out")
    for index, item in enumerate(items):
        _find_directive_file(file, index, item, finder, includes)
    with _quiet_drake():
        plant, scene_graph = _accepted(file, items, finder)
    context = plant.CreateDefaultContext()
    bodies = [plant.get_body(BodyIndex(index)) for index in range(1, plant.num_bodies())]
    return tuple(
        obstacle_of_body(plant, scene_graph.model_inspector(), file, body, context)
        for body in bodies
    )


def _accepted(
    file: YamlFile, items: Sequence[yaml.Node], finder: PackageFinder
) -> tuple[MultibodyPlant, SceneGraph]:
    """Return a finalised plant with directives.

    Raises:
        WorkbenchError: for the first directive that Drake rejects.
    """
    try:
        plant, scene_graph = _processed(items, finder.packages)
        plant.Finalize()
    except (RuntimeError, ValueError, SystemExit) as error:
        bad = bisect_left(
            range(len(items)), True, key=lambda last: _fails(items[: last + 1], finder)
        )
        where = file.where("directives", bad) if bad < len(items) else file.where("directives")
        reason = " ".join(str(error).split())
        if len(reason) > _MAX_DRAKE_MESSAGE_CHARS:
            reason = f"{reason[:_MAX_DRAKE_MESSAGE_CHARS]}..."
        raise WorkbenchError(f"{where}Drake refuses it: {reason}") from error
    return plant, scene_graph


@contextmanager
def _quiet_drake() -> Iterator[None]:
    """Suppress Drake's log messages, as its exception has the reason."""
    logger = logging.getLogger("drake")
    logger.addFilter(_drop_record)
    try:
        yield
    finally:
        logger.removeFilter(_drop_record)


def _drop_record(_: logging.LogRecord) -> bool:
    return False


def _processed(
    items: Sequence[yaml.Node], packages: Mapping[str, Path]
) -> tuple[MultibodyPlant, SceneGraph]:
    """Return a plant with directives that is not finalised."""
    plant, scene_graph = MultibodyPlant(0.0), SceneGraph()
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    parser = Parser(plant)
    known = parser.package_map()
    for name in known.GetPackageNames():
        known.Remove(name)
    for name, folder in packages.items():
        known.Add(name, str(folder))
    key = yaml.ScalarNode("tag:yaml.org,2002:str", "directives")
    whole = yaml.MappingNode(
        "tag:yaml.org,2002:map", [(key, yaml.SequenceNode("tag:yaml.org,2002:seq", list(items)))]
    )
    text = str(yaml.serialize(whole, Dumper=yaml.SafeDumper))
    ProcessModelDirectives(LoadModelDirectivesFromString(text), parser)
    return plant, scene_graph


def _fails(items: Sequence[yaml.Node], finder: PackageFinder) -> bool:
    """Return whether Drake rejects these directives; it then rejects any longer list, too."""
    try:
        _processed(items, finder.packages)
    except (RuntimeError, ValueError, SystemExit):
        return True
    return False


def _directive_items(file: YamlFile) -> list[yaml.Node]:
    """Return the directives with their tags."""
    root = yaml.compose(file.text, Loader=tagged_loader())
    return next((node.value for key, node in root.value if key.value == "directives"), [])


def _find_directive_file(
    file: YamlFile,
    index: int,
    item: yaml.MappingNode,
    finder: PackageFinder,
    includes: IncludeChecker,
) -> None:
    """Find the file in a directive, and write its path into the directive.

    Raises:
        WorkbenchError: if the directive is invalid, or its file is missing or includes itself.
    """
    where = file.where("directives", index)
    kinds = [key.value for key, _ in item.value]
    if len(kinds) != 1:
        raise WorkbenchError(f"{where}a directive has one key, as add_model: this has {len(kinds)}")
    if kinds[0] not in _DIRECTIVE_KINDS:
        raise WorkbenchError(f"{where}{unknown_name('directive', kinds[0], _DIRECTIVE_KINDS)}")
    for key, node in item.value[0][1].value:
        if key.value != "file" or not isinstance(node, yaml.ScalarNode):
            continue
        path = finder.resolve(node.value, finder.source)
        finder.refuse_outside(node.value, finder.source, where.removesuffix(": "))
        if path is None or not path.is_file():
            scheme, _, rest = node.value.partition("://")
            package = rest.partition("/")[0]
            known = scheme != "package" or finder.folder(package)
            hint = (
                "give it relative to this file" if known else finder.hint(shortened_text(package))
            )
            raise WorkbenchError(
                f"{where}the file '{shortened_text(node.value)}' is not found: {hint}"
            )
        try:
            includes.check(path, has_directives=kinds[0] == "add_directives")
        except WorkbenchError as fault:
            raise WorkbenchError(f"{where}{fault}") from fault
        node.value = f"file://{path}"
