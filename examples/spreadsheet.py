"""Cells of an Excel 2007+ file, read without Excel: the file is a zip of small xml tables."""

from __future__ import annotations

import html
import re
import zipfile
from pathlib import Path

import numpy as np

from bluekoi.data import Float
from bluekoi.errors import input_error

_CELL = re.compile(r'<c r="([A-Z]+)(\d+)"([^>]*?)(?:/>|>(.*?)</c>)', re.S)
_VALUE = re.compile(r"<v>(.*?)</v>", re.S)

Sheet = dict[str, dict[int, str]]


def sheets(path: Path) -> dict[str, Sheet]:
    """Sheet name -> column letter -> row number -> text of the cell.

    Raises: InputError where the file is not an Excel 2007+ file.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            return _sheets(archive)
    except (zipfile.BadZipFile, KeyError) as error:
        raise input_error(path, "", f"no workbook ({error})", "an Excel 2007+ file") from None


def _sheets(archive: zipfile.ZipFile) -> dict[str, Sheet]:
    shared = _shared(archive)
    names = re.findall(r'<sheet [^>]*name="([^"]+)"', _text(archive, "xl/workbook.xml"))
    return {
        html.unescape(name): _cells(_text(archive, f"xl/worksheets/sheet{i}.xml"), shared)
        for i, name in enumerate(names, start=1)
    }


def _text(archive: zipfile.ZipFile, name: str) -> str:
    return archive.read(name).decode("utf-8")


def _shared(archive: zipfile.ZipFile) -> list[str]:
    """Texts that cells refer to by number."""
    if "xl/sharedStrings.xml" not in archive.namelist():
        return []
    items = re.findall(r"<si>(.*?)</si>", _text(archive, "xl/sharedStrings.xml"), re.S)
    return [html.unescape(re.sub(r"<[^>]+>", "", item)) for item in items]


def _cells(xml: str, shared: list[str]) -> Sheet:
    out: Sheet = {}
    for column, row, attributes, body in _CELL.findall(xml):
        value = _VALUE.search(body)
        if value:
            text = shared[int(value[1])] if 't="s"' in attributes else value[1]
            out.setdefault(column, {})[int(row)] = text
    return out


def columns(sheet: Sheet, names: str) -> Float:
    """Rows in which all named columns hold numbers, (rows, columns)."""
    found = [{r: number(t) for r, t in sheet.get(n, {}).items()} for n in names]
    rows = sorted(set.intersection(*(set(f) for f in found))) if found else []
    table = np.array([[f[r] for f in found] for r in rows]).reshape(-1, len(names))
    return table[np.isfinite(table).all(axis=1)]


def number(text: str) -> float:
    """The number in a cell, NaN where it holds none."""
    try:
        return float(text)
    except ValueError:
        return float("nan")
