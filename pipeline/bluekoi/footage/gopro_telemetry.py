"""Speed of the camera's own clock relative to the footage, from its telemetry.

A GoPro file has a track of GPMF payloads, one for about each second shown; every sensor's stream in
a payload bears STMP, the camera's clock in microseconds at its first sample
(github.com/gopro/gpmf-parser, README). In a time-lapse or TimeWarp that clock outruns the footage.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from .mp4_boxes import GPMF_NESTED_TYPE, gpmf_items
from .video_probe import open_container

GPMF_HANDLER_NAME = "GoPro MET"
MAX_PAYLOAD_BYTES = 2**20


def camera_seconds_per_footage_second(path: Path) -> float | None:
    """Seconds on the camera's clock per second of footage shown; None without telemetry."""
    with open_container(path) as container:
        tracks = [
            s
            for s in container.streams.data
            if GPMF_HANDLER_NAME in s.metadata.get("handler_name", "")
        ]
        if not tracks:
            return None
        entries, base = tracks[0].index_entries, tracks[0].time_base
        if len(entries) < 2 or not base:
            return None
        first, last = entries[0], entries[len(entries) - 1]
        shown_s = float((last.timestamp - first.timestamp) * base)
        stamps = [_sensor_timestamps(path, entry) for entry in (first, last)]
    names = stamps[0].keys() & stamps[1].keys()
    if not names or shown_s <= 0:
        return None
    return float(np.median([stamps[1][n] - stamps[0][n] for n in names])) * 1e-6 / shown_s


def _sensor_timestamps(path: Path, entry: Any) -> dict[str, int]:
    """STMP [microseconds] of each sensor's stream in a payload, by the stream's name."""
    if not 0 < entry.size <= MAX_PAYLOAD_BYTES:
        return {}
    with path.open("rb") as file:
        file.seek(entry.pos)
        body = file.read(entry.size)
    found = {}
    for device in _nested_gpmf_items(body, b"DEVC"):
        for stream in _nested_gpmf_items(device, b"STRM"):
            items = {key: value for key, _, value in gpmf_items(stream)}
            if len(items.get(b"STMP", b"")) == 8:
                name = items.get(b"STNM", b"").decode("latin-1")
                found[name] = struct.unpack(">Q", items[b"STMP"])[0]
    return found


def _nested_gpmf_items(body: bytes, wanted: bytes) -> Iterator[bytes]:
    return (
        value for key, kind, value in gpmf_items(body) if key == wanted and kind == GPMF_NESTED_TYPE
    )
