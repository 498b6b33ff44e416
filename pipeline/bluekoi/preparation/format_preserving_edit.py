"""Lines of a text that an edit left alone, as they were before a program formatted them."""

from __future__ import annotations

from collections.abc import Sequence
from difflib import SequenceMatcher


def with_unedited_lines_restored(former: str, plain: str, edited: str) -> str:
    """`edited` with the lines of `former` wherever it is equal to `plain`.

    plain: `former` as the program formats it. edited: the same after the edit.
    """
    new, formatted = edited.splitlines(keepends=True), plain.splitlines(keepends=True)
    kept = _original_lines_of_formatted(former.splitlines(keepends=True), formatted)
    lines: list[str] = []
    for tag, first, last, begin, end in _diff_opcodes(formatted, new):
        if tag == "equal":
            lines += [line for some in kept[first:last] for line in some]
        elif last - first == end - begin:
            lines += map(_with_indent_of, kept[first:last], new[begin:end])
        else:
            lines += new[begin:end]
    return "".join(lines + kept[-1])


def _original_lines_of_formatted(former: Sequence[str], plain: Sequence[str]) -> list[list[str]]:
    """For each line of `plain`, and its end, the lines of `former` that it stands for."""
    kept: list[list[str]] = [[] for _ in range(len(plain) + 1)]
    words, plain_words = (["".join(line.split()) for line in text] for text in (former, plain))
    for tag, first, last, begin, _ in _diff_opcodes(words, plain_words):
        if tag == "equal":
            for n, line in enumerate(former[first:last]):
                kept[begin + n].append(line)
        else:
            kept[begin] += former[first:last]
    return kept


def _diff_opcodes(a: Sequence[str], b: Sequence[str]) -> Sequence[tuple[str, int, int, int, int]]:
    return SequenceMatcher(None, a, b, autojunk=False).get_opcodes()


def _with_indent_of(former: Sequence[str], line: str) -> str:
    """A line that is indented as the former one."""
    like = former[0] if former else line
    return like[: len(like) - len(like.lstrip())] + line.lstrip()
