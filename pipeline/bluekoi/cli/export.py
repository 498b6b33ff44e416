"""`bluekoi export`: results in the forms that other programs read."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .outputs import refuse_outputs_over_study_files
from .parameter_types import StudyName, TrialName
from .progress_notice import progress_notice
from .results_warnings import warn_of_outdated_results

if TYPE_CHECKING:
    from ..campaign import Campaign
    from ..data import Float, Track

EXPORTED_KEYPOINTS = ("head_tip", "hinge", "core_center", "tail_base")
"""Keypoints that are written: those on the rigid parts."""
EXPORTED_UNITS = {
    "heading_rad": "rad",
    "head_angle_rad": "rad",
    "speed_m_s": "m/s",
    "vx_m_s": "m/s",
    "vy_m_s": "m/s",
    "yaw_rate_rad_s": "rad/s",
    "x_m": "m",
    "y_m": "m",
}
"""Further columns of a track that are written, with their units."""
NETCDF_INDIVIDUAL_NAME = "robot"
"""Name of the only individual in the dataset."""


@click.command()
@click.argument("study", type=StudyName(path_type=Path))
@click.option("--results", type=click.Path(path_type=Path), help="Folder with the results.")
@click.option("--out", type=click.Path(path_type=Path), help="Folder to write to.")
@click.option(
    "--trial", "trials", type=TrialName(), multiple=True, help="Only this trial; may be repeated."
)
def export(study: Path, results: Path | None, out: Path | None, trials: tuple[str, ...]) -> None:
    """Write tracks of STUDY as netCDF for the Python package `movement` (0.17 or newer).

    For each trial ID, the file OUT/ID.nc contains the smoothed keypoints in pool coordinates, in
    metres. The model coefficients are written as OUT/coefficients.csv. Without --out, OUT is the
    folder `export` in the results folder.
    """
    from ..campaign import load_campaign  # noqa: PLC0415
    from ..study import load_study  # noqa: PLC0415

    folder = results or Path("results") / study.resolve().name
    target = out or folder / "export"
    with progress_notice("reading results"):
        campaign = load_campaign(folder, loaded := load_study(study))
    chosen = _selected_trials(campaign, trials, folder)
    names = ("coefficients.csv", *(f"{name}.nc" for name in chosen))
    refuse_outputs_over_study_files(study, (target / name for name in names))
    if campaign.coefficients:
        _write_coefficients(campaign.coefficients, target / "coefficients.csv")
    with progress_notice(f"writing {len(chosen)} trials") as wait:
        for done, name in enumerate(chosen, 1):
            write_netcdf(campaign, name, target / f"{name}.nc")
            wait.share = done / len(chosen)
    click.echo(f"{len(chosen)} trials written to {target}")
    if not trials and (missing := _trials_without_track(campaign)):
        click.echo(f"Without a track, not written: {', '.join(missing)}.", err=True)
    warn_of_outdated_results(loaded, folder)


def _selected_trials(campaign: Campaign, trials: tuple[str, ...], folder: Path) -> list[str]:
    from ..errors import did_you_mean, input_error  # noqa: PLC0415

    known = [t.trial_id for t in campaign.study.trials if t.trial_id in campaign.tracks]
    if not known:
        raise input_error(folder / "tracks", "", "no tracks", "those of a run", "bluekoi run STUDY")
    without = _trials_without_track(campaign)
    for name in trials:
        if name not in known:
            remedy = did_you_mean(name, known)
            if name in without:
                remedy = f"`bluekoi run {campaign.study.root}` says why this trial has none."
            raise input_error(folder / "tracks", "", f"no '{name}'", "a track", remedy)
    return [name for name in known if not trials or name in trials]


def _trials_without_track(campaign: Campaign) -> list[str]:
    return [t.trial_id for t in campaign.study.trials if t.trial_id not in campaign.tracks]


def write_netcdf(campaign: Campaign, trial_id: str, path: Path) -> None:
    """Write one trial as a `poses` dataset of movement: time, space, keypoint, individual.

    position (time, space, keypoint, individual), m; confidence without space, NaN; each rate and
    its standard deviation (time,). The classic netCDF format, which xarray reads.
    """
    import numpy as np  # noqa: PLC0415
    from scipy.io import netcdf_file  # noqa: PLC0415

    from ..files import atomic_write  # noqa: PLC0415

    track = campaign.tracks[trial_id]
    position = _keypoint_positions(campaign, trial_id, track)[..., None]
    names = {
        "space": ("x", "y"),
        "keypoint": EXPORTED_KEYPOINTS,
        "individual": (NETCDF_INDIVIDUAL_NAME,),
    }
    with atomic_write(path) as temporary, netcdf_file(temporary, "w", version=2) as out:
        for name, value in _dataset_attributes(campaign, trial_id).items():
            setattr(out, name, value)
        out.createDimension("time", len(track.time_s))
        for name, labels in names.items():
            out.createDimension(name, len(labels))
            _write_text_coordinate(out, name, labels)
        _write_variable(out, "time", ("time",), track.time_s)
        _write_variable(out, "position", ("time", *names), position, "m")
        unknown = np.full((len(position), len(EXPORTED_KEYPOINTS), 1), np.nan)
        _write_variable(out, "confidence", ("time", "keypoint", "individual"), unknown)
        for name, unit in EXPORTED_UNITS.items():
            for column in (name, f"{name}_std"):
                _write_variable(out, column, ("time",), getattr(track, column), unit)


def _write_variable(
    out: Any, name: str, dims: tuple[str, ...], values: Float, unit: str = ""
) -> None:
    variable = out.createVariable(name, "d", dims)
    variable[:] = values
    if unit:
        variable.units = unit


def _write_text_coordinate(out: Any, name: str, labels: Sequence[str]) -> None:
    """A coordinate of texts: characters (labels, longest), as the format has no strings."""
    import numpy as np  # noqa: PLC0415

    text = np.array(labels, dtype="S")
    out.createDimension(f"{name}_characters", text.itemsize)
    variable = out.createVariable(name, "c", (name, f"{name}_characters"))
    variable[:] = text.view("S1").reshape(len(text), text.itemsize)
    variable._Encoding = "utf-8"  # which xarray takes for texts rather than bytes


def _dataset_attributes(campaign: Campaign, trial_id: str) -> dict[str, str | float]:
    import numpy as np  # noqa: PLC0415

    trial = campaign.study.trial(trial_id)
    return {
        "ds_type": "poses",
        "source_software": "BlueKoi",
        "source_file": str(trial.source),
        "time_unit": "seconds",
        "fps": float(1 / np.median(np.diff(campaign.tracks[trial_id].time_s))),
        "trial_id": trial_id,
        "power_pct": trial.power_pct,
        "head_angle_deg": trial.head_angle_deg,
        "head_length_m": trial.head_length_m,
        "frame": "pool: origin at one corner on the water surface, x along the length, z up",
    }


def _keypoint_positions(campaign: Campaign, trial_id: str, track: Track) -> Float:
    """Rigid keypoints of the smoothed motion, (frames, 2, parts), m."""
    import numpy as np  # noqa: PLC0415

    robot, trial = campaign.study.setup.robot, campaign.study.trial(trial_id)
    centre, angles = (
        np.column_stack([track.x_m, track.y_m]),
        (track.heading_rad, track.head_angle_rad),
    )
    return robot.body_points(trial.head_length_m, centre, *angles).swapaxes(1, 2)


def _write_coefficients(content: Mapping[str, Any], path: Path) -> None:
    from ..files import write_text  # noqa: PLC0415

    lines = ["fit,coefficient,value,std,unit,determined", *_coefficient_rows(content)]
    write_text(path, "\n".join(lines) + "\n")


def _coefficient_rows(content: Mapping[str, Any]) -> Iterator[str]:
    fits = {f"paper_{power}_pct": fit for power, fit in content.get("paper_steps", {}).items()}
    for fit, found in {**fits, "joint": content.get("joint") or {}}.items():
        for name, one in (found.get("coefficients") or {}).items():
            cells = (one.get(key) for key in ("value", "std", "unit", "determined"))
            yield ",".join([fit, name, *("" if cell is None else str(cell) for cell in cells)])
