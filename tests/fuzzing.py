"""Corrupted files, as copying, editors, spreadsheets or an attacker could produce them."""

from __future__ import annotations

import copy
from typing import Any

import yaml
from hypothesis import strategies as st

EXTREME_NUMBERS = (
    "nan",
    "-1",
    "0",
    "1e999",
    "-inf",
    "1e-320",
    "0x10",
    "1_000",
    "9" * 400,
    "1,5",
    "٣",
)
ODD_WORDS = (
    "", " ", "\0", "../../etc/passwd", "/etc/passwd", "~", "null", "true",
    "<script>alert(1)</script>", "$(touch x)", "`id`", "a;b|c&d", "=1+1", "{{7*7}}", "%s%n",
    "x" * 5000,
    "e\u0301\u202e", "\ufeff",
    "!!python/object/apply:os.system [id]", "&a [*a]", "*nothing", "- - - -", "'", '"', "\\",
)  # fmt: skip
YAML_LEAVES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(10**18), 10**18),
    st.floats(allow_nan=True, allow_infinity=True),
    st.sampled_from(ODD_WORDS),
    st.sampled_from(EXTREME_NUMBERS),
    st.text(max_size=20),
)
YAML_VALUES = st.recursive(
    YAML_LEAVES,
    lambda inner: (
        st.lists(inner, max_size=5) | st.dictionaries(st.text(max_size=6), inner, max_size=4)
    ),
    max_leaves=12,
)


@st.composite
def corrupted_bytes(draw: Any, whole: bytes, *, within: int | None = None, most: int = 6) -> bytes:
    """`whole` with a few bytes changed, put in, taken out, repeated, or its end cut off.

    within: only the first so many bytes are touched (a header).
    """
    body = bytearray(whole)
    for _ in range(draw(st.integers(1, most))):
        end = max(min(len(body), within or len(body)), 1)
        at = draw(st.integers(0, end - 1))
        kind = draw(
            st.sampled_from(("flip", "set", "insert", "delete", "repeat", "cut", "zero", "ff"))
        )
        width = draw(st.integers(1, 16))
        if kind == "flip" and body:
            body[at] ^= 1 << draw(st.integers(0, 7))
        elif kind in ("set", "insert"):
            new = draw(st.binary(min_size=1, max_size=8))
            body[at : at + (len(new) if kind == "set" else 0)] = new
        elif kind == "delete":
            del body[at : at + width]
        elif kind == "repeat":
            body[at:at] = body[at : at + 20 * width]
        elif kind == "cut":
            del body[at:]
        else:
            size = len(body[at : at + 8])
            body[at : at + 8] = (b"\0" if kind == "zero" else b"\xff") * size
    return bytes(body)


@st.composite
def corrupted_table(draw: Any, text: str) -> bytes:
    """A csv with cells, rows and columns changed, in some encoding or other."""
    rows = [line.split(",") for line in text.splitlines()]
    for _ in range(draw(st.integers(1, 6))):
        row = draw(st.integers(0, len(rows) - 1))
        kind = draw(
            st.sampled_from(("cell", "cell", "cell", "drop", "twice", "short", "long", "swap"))
        )
        if kind == "cell" and rows[row]:
            new = draw(st.sampled_from(ODD_WORDS + EXTREME_NUMBERS) | st.text(max_size=12))
            rows[row][draw(st.integers(0, len(rows[row]) - 1))] = new
        elif kind == "drop" and len(rows) > 1:
            del rows[row]
        elif kind == "twice":
            rows.insert(row, list(rows[draw(st.integers(0, len(rows) - 1))]))
        elif kind == "short":
            rows[row] = rows[row][:-1]
        elif kind == "long":
            rows[row] = [*rows[row], "1"]
        elif kind == "swap":
            rows[row] = rows[row][::-1]
    joined = draw(st.sampled_from((",", ",", ",", ";", "\t"))).join
    lines = draw(st.sampled_from(("\n", "\r\n", "\r"))).join(joined(row) for row in rows)
    return lines.encode(draw(st.sampled_from(("utf-8", "utf-8", "utf-16", "utf-8-sig"))), "replace")


@st.composite
def absurd_numbers(draw: Any, text: str, *, header: int) -> bytes:
    """A csv whose layout is right and whose numbers are not: blocks of cells frozen, scaled, lost.

    header: rows that stay as they are.
    """
    rows = [line.split(",") for line in text.splitlines()]
    rows = rows[: header + draw(st.integers(1, len(rows) - header))]
    width = len(rows[0])
    for _ in range(draw(st.integers(1, 4))):
        top = draw(st.integers(header, len(rows) - 1))
        left = draw(st.integers(1, width - 1))
        bottom, right = draw(st.integers(top, len(rows) - 1)), draw(st.integers(left, width - 1))
        kind = draw(st.sampled_from(("lost", "same", "scaled", "shifted", "huge", "zero", "one")))
        by = draw(st.floats(-1e4, 1e4))
        first = rows[top][left]
        for row in rows[top : bottom + 1]:
            for i in range(left, right + 1):
                row[i] = _absurd_number(kind, row[i], first, by)
    return "\n".join(",".join(row) for row in rows).encode()


def _absurd_number(kind: str, cell: str, first: str, by: float) -> str:
    number = float(cell) if cell.strip() else 0.0
    plain = {"lost": "", "same": first, "huge": "1e300", "zero": "0", "one": "1"}
    moved = {"scaled": number * by, "shifted": number + by}
    return plain[kind] if kind in plain else repr(moved[kind])


@st.composite
def corrupted_yaml(draw: Any, content: dict[str, Any]) -> bytes:
    """A study.yaml with values replaced, keys lost, added or misspelt."""
    tree = copy.deepcopy(content)
    for _ in range(draw(st.integers(1, 4))):
        place = tree
        while True:
            keys = list(place) if isinstance(place, dict) else list(range(len(place)))
            if not keys:
                break
            key = draw(st.sampled_from(keys))
            inner = place[key]
            if isinstance(inner, dict | list) and inner and draw(st.booleans()):
                place = inner
                continue
            _change_entry(draw, place, key)
            break
    return yaml.safe_dump(tree, allow_unicode=True).encode("utf-8", "surrogatepass")


def _change_entry(draw: Any, place: Any, key: Any) -> None:
    kind = draw(st.sampled_from(("value", "value", "value", "lose", "add", "misspell")))
    if kind == "value":
        place[key] = draw(YAML_VALUES)
    elif kind == "lose":
        del place[key]
    elif isinstance(place, list):
        place.append(draw(YAML_VALUES))
    elif kind == "add":
        place[draw(st.text(max_size=8))] = draw(YAML_VALUES)
    else:
        place[f"{key}_x"] = place.pop(key)
