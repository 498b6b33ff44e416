"""Keys of study.yaml that stand in the file as comments: `# matrix:`."""

from __future__ import annotations

import re
from collections.abc import Collection

SECTION_KEY_PATTERN = re.compile(r"(\w+):")
INDENTED_KEY_PATTERN = re.compile(r"(?P<indent>\s+)(?P<comment># )?(?P<key>\w+):(?: |$)")


def with_commented_keys_in_place(text: str, names: Collection[str]) -> str:
    """The text with those keys of `names` (`section.key`) that stand in it only as a comment made
    keys without a value, each below its own explanation.
    """
    lines = text.splitlines(keepends=True)
    section = ""
    keys: set[str] = set()
    commented: dict[str, tuple[int, str]] = {}
    for number, line in enumerate(lines):
        if begin := SECTION_KEY_PATTERN.match(line):
            section = begin[1]
        elif found := INDENTED_KEY_PATTERN.match(line):
            name = f"{section}.{found['key']}"
            if not found["comment"]:
                keys.add(name)
            elif name in names:
                commented[name] = (number, f"{found['indent']}{found['key']}:\n")
    for name, (number, line) in commented.items():
        if name not in keys:
            lines[number] = line
    return "".join(lines)
