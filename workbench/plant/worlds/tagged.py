"""YAML with tags of Drake's."""

from functools import lru_cache
from typing import TYPE_CHECKING, Any

from workbench.common.yaml_files import fast_loader

if TYPE_CHECKING:
    import yaml


@lru_cache(maxsize=1)
def tagged_loader() -> Any:
    """Return a loader that reads what has a tag of Drake's, as `!Rpy`, as if it had none."""
    loader: Any = type("TaggedLoader", (fast_loader(),), {})
    loader.add_multi_constructor("!", _without_tag)
    return loader


def _without_tag(loader: "yaml.SafeLoader", _: str, node: "yaml.Node") -> object:
    import yaml

    if isinstance(node, yaml.MappingNode):
        return loader.construct_mapping(node, deep=True)
    if isinstance(node, yaml.SequenceNode):
        return loader.construct_sequence(node, deep=True)
    return loader.construct_scalar(node)
