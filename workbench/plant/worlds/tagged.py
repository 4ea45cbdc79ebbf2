"""YAML with tags of Drake's."""

import yaml

from workbench.common.yaml_files import FastLoader


class TaggedLoader(FastLoader):
    """Reads what has a tag of Drake's, as `!Rpy`, as if it had none."""


def _without_tag(loader: yaml.SafeLoader, _: str, node: yaml.Node) -> object:
    if isinstance(node, yaml.MappingNode):
        return loader.construct_mapping(node, deep=True)
    if isinstance(node, yaml.SequenceNode):
        return loader.construct_sequence(node, deep=True)
    return loader.construct_scalar(node)


TaggedLoader.add_multi_constructor("!", _without_tag)
