"""docs/study_keys.md from the fields of a study; a test checks that it is current.

python docs/study_keys_page.py
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from bluekoi.study.key_reference import SETTINGS_CLASS_BY_FILE, setting_keys

PAGE = Path(__file__).resolve().parent / "study_keys.md"
HEAD = """# Keys of a study

This page lists the keys of `study.yaml` and the columns of `trials.csv`. A key that is not listed
is refused. `bluekoi check --explain KEY` shows the line of one key. Quantities have SI units if
their name does not state another unit. Angles are positive counter-clockwise, seen from above."""


def page() -> str:
    """Text of docs/study_keys.md."""
    return (
        "\n".join([HEAD, *(line for file in SETTINGS_CLASS_BY_FILE for line in _table(file))])
        + "\n"
    )


def _table(file: str) -> Iterator[str]:
    yield f"\n## {file}\n"
    yield "| key | unit | default | allowed | meaning |\n|---|---|---|---|---|"
    for k in setting_keys():
        if k.file == file:
            yield f"| `{k.name}` | {k.unit} | {k.default} | {k.allowed} | {k.meaning} |"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
