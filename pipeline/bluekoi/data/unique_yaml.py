"""Plain yaml in which a key stands once: of two entries of one name, one would be ignored."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

import yaml


class _UniqueKeyLoader(yaml.SafeLoader):
    """Plain yaml, in which a key stands once."""


def _construct_mapping_without_duplicates(
    loader: _UniqueKeyLoader, node: yaml.MappingNode
) -> dict[Hashable, Any]:
    names = [key.value for key, _ in node.value if isinstance(key, yaml.ScalarNode)]
    if len(set(names)) < len(names):
        keys = [key for key, _ in node.value if isinstance(key, yaml.ScalarNode)]
        twice = next(key for i, key in enumerate(keys) if key.value in names[:i])
        raise yaml.constructor.ConstructorError(
            None, None, f"the key '{twice.value}' stands twice", twice.start_mark
        )
    return loader.construct_mapping(node, deep=True)


_UniqueKeyLoader.add_constructor(
    yaml.resolver.BaseResolver.DEFAULT_MAPPING_TAG, _construct_mapping_without_duplicates
)


def load_yaml_without_duplicates(text: str) -> Any:
    """Content of a yaml text: plain values only, no Python objects.

    Raises: yaml.YAMLError where it cannot be read or a key stands twice.
    """
    return yaml.load(text, _UniqueKeyLoader)  # noqa: S506  a subclass of SafeLoader
