"""A folder of recordings: one csv a trial, and data.yaml that says what its columns are.

columns:
time:     {column: time_s, unit: s}
position: {column: position_m, unit: m}
motor:    {column: force_n, unit: N}
constants: {mass: 2.5}            # for all trials
trials:                           # default: every csv of the folder
- {file: run1.csv, condition: slow, role: fit, group: all, constants: {mass: 2.6}}
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import yaml

from ..data import Float
from ..data.strict_yaml import load_yaml_without_duplicates
from ..errors import InputError, InputIssue, did_you_mean, input_error, unreadable_reason
from ..files import found_instead_of_file, read_text
from .model import Model
from .trials import FIT_ROLE, Trial
from .units import conversion_factor

if TYPE_CHECKING:
    import pandas as pd

DATA_YAML_NAME = "data.yaml"
DATA_YAML_KEYS = ("columns", "constants", "trials")
"""Keys of data.yaml."""
COLUMN_KEYS = ("column", "unit")
"""Keys of an entry of `columns`."""
TRIAL_KEYS = ("file", "name", "condition", "group", "role", "constants", "start_s", "end_s",
              "evidence")  # fmt: skip
"""Keys of an entry of `trials`."""
TIME_COLUMN_KEY = "time"
"""Entry of `columns` for the time."""
CSV_SEPARATORS = (";", "\t")
"""Separators of a csv other than the comma."""


def read_trials(model: Model, folder: Path) -> list[Trial]:
    """Trials of a folder: by the model's own reader where it has one, else by data.yaml.

    Raises: InputError naming file, key or column, and what was expected.
    """
    if not folder.is_dir():
        found = "a file" if folder.exists() else "no such folder"
        raise input_error(folder, "", found, f"a folder with {DATA_YAML_NAME} and csv files")
    if model.read is not None and not (folder / DATA_YAML_NAME).exists():
        return list(model.read(folder))
    settings = _read_data_yaml(folder / DATA_YAML_NAME)
    columns = _csv_columns_and_unit_factors(model, settings, folder / DATA_YAML_NAME)
    rows = settings.get("trials")
    if rows is None:
        rows = [{"file": p.name} for p in sorted(folder.iterdir()) if p.suffix.lower() == ".csv"]
        if not rows:
            raise input_error(folder, "", "no csv", "one csv a trial")
    if not isinstance(rows, list) or not rows:
        raise input_error(folder / DATA_YAML_NAME, "trials", rows, "a list of {file: NAME.csv}")
    shared = _numbers_by_name(settings.get("constants", {}), folder / DATA_YAML_NAME, "constants")
    _check_keys(
        shared,
        tuple(c.name for c in model.constants),
        folder / DATA_YAML_NAME,
        "constants",
        "a constant of the model",
    )
    return [_read_trial(model, folder, row, columns, shared) for row in rows]


def _read_data_yaml(path: Path) -> dict[str, Any]:
    if not path.exists():
        raise input_error(path, "", "no such file", "the columns of the csv files",
                          "See docs/own_models.md for an example.")  # fmt: skip
    try:
        found = load_yaml_without_duplicates(read_text(path))
    except UnicodeDecodeError as error:
        found_text = f"no text ({unreadable_reason(error)})"
        raise input_error(path, "", found_text, "a yaml file in UTF-8") from None
    except yaml.YAMLError as error:
        tab = "Indent by spaces, not by tabs." if "'\\t'" in str(error) else ""
        raise input_error(
            path,
            "",
            " ".join(str(error).replace('"<unicode string>", ', "").split()),
            "a yaml file",
            tab,
        ) from None
    if not isinstance(found, dict):
        raise input_error(path, "", type(found).__name__, f"keys {', '.join(DATA_YAML_KEYS)}")
    _check_keys(found, DATA_YAML_KEYS, path, "")
    return found


def _check_keys(
    given: Mapping[str, Any], keys: tuple[str, ...], path: Path, where: str,
    expected: str = "a known key",
) -> None:  # fmt: skip
    unknown = [str(k) for k in given if k not in keys]
    if unknown:
        raise InputError([InputIssue(str(path), where or k, f"'{k}'", expected,
                                     did_you_mean(k, keys) if keys else "The model has none.")
                          for k in unknown])  # fmt: skip


def _csv_columns_and_unit_factors(
    model: Model, settings: Mapping[str, Any], path: Path
) -> dict[str, tuple[str, float]]:
    """Time, inputs and observations -> column of the csv and factor to the model's unit."""
    wanted = {TIME_COLUMN_KEY: "s"} | {i.name: i.unit for i in model.inputs}
    wanted |= {o.name: o.unit for o in model.observations}
    given = settings.get("columns")
    if not isinstance(given, dict):
        raise input_error(path, "columns", given, f"an entry for each of {', '.join(wanted)}")
    findings = [InputIssue(str(path), "columns", f"'{k}'", "time, an input or an observation",
                           did_you_mean(str(k), wanted))
                for k in given if k not in wanted]  # fmt: skip
    findings += [InputIssue(str(path), "columns", f"no '{k}'", f"{k}: {{column: NAME, unit: {u}}}")
                 for k, u in wanted.items() if k not in given]  # fmt: skip
    if findings:
        raise InputError(findings)
    out = {}
    for name, unit in wanted.items():
        entry = given[name]
        if not isinstance(entry, dict) or set(entry) != set(COLUMN_KEYS):
            raise input_error(path, f"columns: {name}", entry, f"{{column: NAME, unit: {unit}}}")
        out[name] = (str(entry["column"]),
                     conversion_factor(str(entry["unit"]), unit, str(path),
                                       f"columns: {name}"))  # fmt: skip
    _check_one_unit_per_column(given, path)
    return out


def _check_one_unit_per_column(columns: Mapping[str, Mapping[str, Any]], path: Path) -> None:
    """Nothing, where no column of the csv is said to be in two units."""
    units: dict[str, dict[str, str]] = {}
    for name, entry in columns.items():
        units.setdefault(str(entry["column"]), {})[str(entry["unit"])] = name
    twice = {c: names for c, names in units.items() if len(names) > 1}
    if twice:
        raise InputError([
            InputIssue(str(path), "columns", " and ".join(
                f"'{c}' in {unit} as {name}" for unit, name in names.items()
            ), "one unit of a column", "Each quantity needs a column of its own.")
            for c, names in twice.items()
        ])  # fmt: skip


def _read_trial(
    model: Model, folder: Path, row: Any, columns: Mapping[str, tuple[str, float]],
    shared: Mapping[str, float],
) -> Trial:  # fmt: skip
    settings = folder / DATA_YAML_NAME
    if not isinstance(row, dict) or "file" not in row:
        raise input_error(settings, "trials", row, "{file: NAME.csv}")
    _check_keys(row, TRIAL_KEYS, settings, "trials")
    path = folder / str(row["file"])
    table = _read_columns_in_model_units(path, columns)
    start, end = (_checked_number(row.get(k, d), settings, k)
                  for k, d in (("start_s", -np.inf), ("end_s", np.inf)))  # fmt: skip
    if start > end:
        raise input_error(path, "start_s, end_s", f"an end at {end:g} s before the start at "
                          f"{start:g} s", "a start before the end")  # fmt: skip
    kept = (table[TIME_COLUMN_KEY] >= start) & (table[TIME_COLUMN_KEY] <= end) | ~np.isfinite(
        table[TIME_COLUMN_KEY]
    )
    if len(kept) and not kept.any():
        raise input_error(path, "start_s, end_s", f"no sample from {start:g} to {end:g} s",
                          "times within those of the file, "
                          f"{_time_range_text(table[TIME_COLUMN_KEY])} s")  # fmt: skip
    own = _numbers_by_name(row.get("constants", {}), settings, f"trials: {path.name}: constants")
    side = row.get("evidence", {})
    if not isinstance(side, dict):
        raise input_error(settings, f"trials: {path.name}: evidence", side, "{NAME: [value, std]}")
    evidence = {str(k): _value_and_std(v, settings, str(k)) for k, v in side.items()}
    return Trial(
        name=str(row.get("name", path.stem)),
        times=table[TIME_COLUMN_KEY][kept],
        observed={o.name: table[o.name][kept] for o in model.observations},
        inputs={i.name: table[i.name][kept] for i in model.inputs},
        constants={**shared, **own},
        condition=str(row.get("condition", path.stem)),
        group=str(row.get("group", "all")),
        role=str(row.get("role", FIT_ROLE)),
        evidence=evidence,
        source=str(path),
    )


def _time_range_text(times: Float) -> str:
    """First to last time of a file."""
    known = times[np.isfinite(times)]
    return f"{known.min():g} to {known.max():g}" if len(known) else "no times"


def _read_columns_in_model_units(
    path: Path, columns: Mapping[str, tuple[str, float]]
) -> dict[str, Float]:
    """Columns of a csv in the model's units."""
    table = _read_csv_cells(path)
    _check_columns_present(
        path, [str(c) for c in table.columns], list(dict.fromkeys(c for c, _ in columns.values()))
    )
    return {name: _as_numbers(path, table[c], c) * scale for name, (c, scale) in columns.items()}


def _read_csv_cells(path: Path) -> pd.DataFrame:
    """Rows of a csv as text or numbers; columns may be apart by semicolons or tabs, and decimals
    then follow a comma. A repeated name keeps its place with a suffix.
    """
    import pandas as pd  # noqa: PLC0415  a model with its own reader goes without

    if not path.is_file():
        there = path.exists() or path.is_symlink()
        found = found_instead_of_file(path, "of that name") if there else "no such file"
        raise input_error(path, "", found, "the csv that data.yaml names")
    try:
        head = path.read_text(encoding="utf-8-sig").partition("\n")[0]
        separator = next((s for s in CSV_SEPARATORS if s in head), ",")
        table = pd.read_csv(path, sep=separator, decimal="." if separator == "," else ",",
                            skipinitialspace=True, encoding="utf-8-sig")  # fmt: skip
    except UnicodeDecodeError:
        raise input_error(path, "", "bytes that are no text", "a csv",
                          "Save it as text in UTF-8.") from None  # fmt: skip
    except (ValueError, OSError) as error:
        expected = "a csv with a header and as many cells in every row"
        raise input_error(path, "", " ".join(str(error).split()), expected) from None
    if not isinstance(table.index, pd.RangeIndex):
        names = f"{len(table.columns)} names above {len(table.columns) + table.index.nlevels} cells"
        raise input_error(path, "header", names, "a name for each column",
                          "If the decimals follow a comma, columns must be apart by semicolons."
                          )  # fmt: skip
    return table.rename(columns=lambda c: str(c).strip())


def _check_columns_present(path: Path, names: Sequence[str], wanted: Sequence[str]) -> None:
    """Nothing, where each wanted column is there once."""
    lacking = [c for c in wanted if c not in names]
    found = f"no column {', '.join(map(repr, lacking))}"
    if lacking == list(wanted):
        raise input_error(path, "header", found, "the columns that data.yaml names",
                          f"The first row is: {', '.join(names)}.")  # fmt: skip
    again = [c for c in wanted if f"{c}.1" in names]
    findings = [InputIssue(str(path), "header", f"two columns '{c}'", "a name for each column")
                for c in again]  # fmt: skip
    findings = findings or [
        InputIssue(str(path), "header", f"no column '{c}'", "the column that data.yaml names",
                   did_you_mean(c, names)) for c in lacking
    ]  # fmt: skip
    if findings:
        raise InputError(findings)


def _as_numbers(path: Path, cells: pd.Series, name: str) -> Float:
    """A column as numbers, empty cells NaN."""
    import pandas as pd  # noqa: PLC0415

    values = pd.to_numeric(cells, errors="coerce").to_numpy(dtype=float)
    bad = np.flatnonzero(np.isnan(values) & cells.notna().to_numpy())
    if len(bad):
        raise input_error(path, f"row {bad[0] + 2}, column {name}", f"'{cells.iloc[bad[0]]}'",
                          "a number", "An empty cell means that nothing was seen.")  # fmt: skip
    return np.asarray(values)


def _numbers_by_name(given: Any, path: Path, where: str) -> dict[str, float]:
    if not isinstance(given, dict):
        raise input_error(path, where, given, "{name: number}")
    return {str(k): _checked_number(v, path, f"{where}: {k}") for k, v in given.items()}


def _checked_number(value: Any, path: Path, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise input_error(path, where, f"'{value}'", "a number")
    return float(value)


def _value_and_std(value: Any, path: Path, name: str) -> tuple[float, float]:
    if not isinstance(value, list) or len(value) != 2:
        raise input_error(path, f"evidence: {name}", value, "[value, standard deviation]")
    first, second = (_checked_number(v, path, f"evidence: {name}") for v in value)
    return first, second
