"""Plain yaml in which a key stands once and numbers are decimal.

Of two entries of one name, one would be ignored.
"""

from __future__ import annotations

import re
from collections.abc import Hashable
from typing import Any

import yaml

MISLEADING_NUMBER_PATTERN = re.compile(r"[-+]?0[0-9xb_][0-9a-fA-F_]*|.*[:_].*")
"""Numbers of YAML 1.1 that are not what they look like: 010 is 8, 1:30 is 90, 0x10 is 16."""


class _UniqueKeyLoader(yaml.SafeLoader):
    """Plain yaml, in which a key stands once and numbers are decimal."""


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


def _construct_decimal_number(loader: _UniqueKeyLoader, node: yaml.ScalarNode) -> int | float:
    if MISLEADING_NUMBER_PATTERN.fullmatch(node.value):
        raise yaml.constructor.ConstructorError(
            None, None, f"'{node.value}' is no decimal number; put a name in quotes",
            node.start_mark,
        )  # fmt: skip
    is_whole = node.tag == "tag:yaml.org,2002:int"
    return loader.construct_yaml_int(node) if is_whole else loader.construct_yaml_float(node)


_UniqueKeyLoader.add_constructor(
    yaml.resolver.BaseResolver.DEFAULT_MAPPING_TAG, _construct_mapping_without_duplicates
)

for _tag in ("int", "float"):
    _UniqueKeyLoader.add_constructor(f"tag:yaml.org,2002:{_tag}", _construct_decimal_number)


def load_yaml_without_duplicates(text: str) -> Any:
    """Content of a yaml text: plain values only, no Python objects.

    Raises: yaml.YAMLError where it cannot be read, a key stands twice or a number is not decimal.
    """
    return yaml.load(text, _UniqueKeyLoader)  # noqa: S506  a subclass of SafeLoader
