"""Files as a GoPro writes them: GPMF items, and a video's header with settings in it."""

from __future__ import annotations

import struct
from pathlib import Path


def gpmf_item(key: bytes, kind: str, size: int, value: bytes) -> bytes:
    """One GPMF item: header, value, filled up to fours of bytes."""
    head = struct.pack(">4sBBH", key, ord(kind) if kind else 0, size, len(value) // size)
    return head + value + b"\0" * (-len(value) % 4)


def gpmf_payload(sensors: dict[str, int]) -> bytes:
    """GPMF payload with the camera's clock [microseconds] in each sensor's stream."""
    streams = b""
    for name, stamp in sensors.items():
        inner = gpmf_item(b"STMP", "J", 8, struct.pack(">Q", stamp))
        inner += gpmf_item(b"STNM", "c", 1, name.encode()) + gpmf_item(b"ACCL", "s", 6, bytes(60))
        streams += gpmf_item(b"STRM", "", 1, inner)
    return gpmf_item(b"DEVC", "", 1, gpmf_item(b"DVNM", "c", 1, b"Camera") + streams)


def video_with_lens_mode(path: Path, letter: bytes) -> Path:
    """A video whose index stands last, with a GoPro's field of view written into its header."""
    data = path.read_bytes()
    body = gpmf_item(b"DEVC", "", 1, gpmf_item(b"VFOV", "c", 1, letter))
    gpmf = struct.pack(">I", 8 + len(body)) + b"GPMF" + body
    udta = struct.pack(">I", 8 + len(gpmf)) + b"udta" + gpmf
    at = data.rindex(b"moov") - 4
    moov = struct.unpack(">I", data[at : at + 4])[0]
    longer = struct.pack(">I", moov + len(udta))
    path.write_bytes(data[:at] + longer + data[at + 4 : at + moov] + udta)
    return path
