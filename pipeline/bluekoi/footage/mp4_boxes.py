"""What an mp4 or mov says about itself, read from its boxes without decoding.

A box is a 4-byte length, a 4-byte name and a body (ISO/IEC 14496-12). GoPro's settings lie in
moov/udta/GPMF as key, type, size, repeat (github.com/gopro/gpmf-parser, README).
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

BOXES_WITH_CHILDREN = (b"moov", b"udta", b"trak", b"mdia", b"edts")
"""Boxes of an mp4 file that contain others."""
TOP_LEVEL_BOXES = (b"ftyp", b"moov", b"mdat", b"free", b"wide", b"skip", b"pnot", b"uuid")
"""Boxes that an mp4 file may begin with."""
MAX_HEADER_BYTES = 64 * 2**20
MAX_BOX_DEPTH = 8
GPMF_NESTED_TYPE = 0
"""Type of a telemetry entry that contains others."""


@dataclass(frozen=True)
class ContainerBoxes:
    """Names of the top-level boxes, whether the last one is cut, edit lists, GoPro settings."""

    top: tuple[str, ...]
    cut: bool
    trimmed_s: float = 0.0
    gopro: dict[str, str] = field(default_factory=dict)

    @property
    def has_index(self) -> bool:
        """Whether the file's index (moov) is there."""
        return "moov" in self.top


def read_container_boxes(path: Path) -> ContainerBoxes | None:
    """Boxes of a file; None where it is no mp4 or mov at all."""
    size = path.stat().st_size
    with path.open("rb") as file:
        if file.read(8)[4:8] not in TOP_LEVEL_BOXES:
            return None
        top, cut, moov = [], False, b""
        for name, start, length in _read_top_level_boxes(file, size):
            top.append(name.decode("latin-1"))
            cut = start + length > size
            if name == b"moov" and length <= MAX_HEADER_BYTES:
                file.seek(start)
                moov = file.read(length)
    inner = dict(_nested_boxes(moov, 0))
    return ContainerBoxes(
        tuple(top),
        cut,
        _edit_list_offset_s(inner),
        _gopro_settings(inner.get("moov/udta/GPMF", b"")),
    )


def _read_top_level_boxes(file: object, size: int) -> Iterator[tuple[bytes, int, int]]:
    at = 0
    while at + 8 <= size:
        file.seek(at)  # type: ignore[attr-defined]
        head = file.read(16)  # type: ignore[attr-defined]
        length, name = struct.unpack(">I4s", head[:8])
        if length == 1 and len(head) == 16:
            length = struct.unpack(">Q", head[8:16])[0]
        length = size - at if length == 0 else length
        if length < 8:
            return
        yield name, at, length
        at += length


def _nested_boxes(body: bytes, depth: int, path: str = "") -> Iterator[tuple[str, bytes]]:
    """Path and body of each box inside `body`, the first of each path last (so it wins)."""
    found: list[tuple[str, bytes]] = []
    at = 0
    while at + 8 <= len(body):
        length, name = struct.unpack(">I4s", body[at : at + 8])
        length = len(body) - at if length == 0 else length
        if length < 8:
            break
        here = f"{path}/{name.decode('latin-1')}".lstrip("/")
        inside = body[at + 8 : at + length]
        found.append((here, inside))
        if name in BOXES_WITH_CHILDREN and depth < MAX_BOX_DEPTH:
            found.extend(_nested_boxes(inside, depth + 1, here))
        at += length
    return iter(found[::-1])


def _edit_list_offset_s(inner: dict[str, bytes]) -> float:
    """Seconds that the first track's edit list leaves out before the first frame shown."""
    edits = inner.get("moov/trak/edts/elst", b"")
    header = inner.get("moov/trak/mdia/mdhd", b"")
    if len(edits) < 20 or len(header) < 24:
        return 0.0
    wide_edit, wide_header = edits[0] == 1, header[0] == 1
    scale = struct.unpack(">I", header[20:24] if wide_header else header[12:16])[0]
    count = struct.unpack(">I", edits[4:8])[0]
    form, width = (">Qq", 20) if wide_edit else (">Ii", 12)
    times = [
        struct.unpack(form, edits[8 + i * width :][: struct.calcsize(form)])[1]
        for i in range(min(count, (len(edits) - 8) // width))
    ]
    starts = [t for t in times if t > 0]
    return starts[0] / scale if starts and scale else 0.0


def _gopro_settings(body: bytes) -> dict[str, str]:
    """Text settings of a GPMF block by their four-letter key, those of all devices joined."""
    return {
        key.decode("latin-1"): value.split(b"\0")[0].decode("latin-1").strip()
        for key, kind, value in gpmf_items(body, into_nested=True)
        if kind == ord("c")
    }


def gpmf_items(body: bytes, *, into_nested: bool = False) -> Iterator[tuple[bytes, int, bytes]]:
    """Key, type and value of each item of a GPMF block; what is in nested ones on its own too."""
    at = 0
    while at + 8 <= len(body):
        key, kind, size, repeat = struct.unpack(">4sBBH", body[at : at + 8])
        length = size * repeat
        yield key, kind, body[at + 8 : at + 8 + length]
        at += 8 if into_nested and kind == GPMF_NESTED_TYPE else 8 + (length + 3) // 4 * 4
