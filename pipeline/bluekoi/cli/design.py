"""`bluekoi design`: what the fitted robot could do beyond what was tested."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from .number_types import FiniteNumber, NumberList
from .outputs import refuse_outputs_over_study_files
from .parameter_types import StudyName
from .progress_notice import progress_notice
from .results_warnings import warn_of_failed_trials, warn_of_outdated_results

if TYPE_CHECKING:
    from ..design_space import RobotDesign


@click.command()
@click.argument("study", type=StudyName(path_type=Path))
@click.option("--results", type=click.Path(path_type=Path), help="Default: results/STUDY.")
@click.option("--model", type=click.Choice(["joint", "extended"]),
              help="Default: extended by the causes found, where there are any.")  # fmt: skip
@click.option(
    "--powers",
    type=NumberList(0, 300),
    default="50:150:25",
    show_default=True,
    help="Motor powers in %: a list, or start:stop:step.",
)
@click.option("--angles-deg", type=NumberList(-120, 120), default="10:60:5",
              show_default=True, help="Head angles.")  # fmt: skip
@click.option("--lengths-m", type=NumberList(0.001, 10), default="0.04:0.24:0.02",
              show_default=True,
              help="Head lengths.")  # fmt: skip
@click.option("--robot", "other", multiple=True, metavar="KEY=NUMBERS",
              help="Values of another key of `robot`, e.g. mass_kg=0.5,0.7.")  # fmt: skip
@click.option("--speed-m-s", type=FiniteNumber(min=0), default=0.0, show_default=True,
              help="Lowest speed of the turn.")  # fmt: skip
@click.option(
    "--tested-only",
    is_flag=True,
    help="Consider only powers, head angles and head lengths within the range of the trials.",
)
@click.option("--out", type=click.Path(path_type=Path), help="Folder; default: RESULTS/design.")
def design(
    *, study: Path, results: Path | None, model: str | None, powers: tuple[float, ...], angles_deg:
    tuple[float, ...], lengths_m: tuple[float, ...], other: tuple[str, ...], speed_m_s: float,
    tested_only: bool, out: Path | None,
) -> None:  # fmt: skip
    """Compute speed and turn radius of designs of STUDY's robot, and print the tightest turn.

    A design is a combination of motor power, head angle and head length. The command writes
    designs.csv and designs.png, which also mark the Pareto front. It consists of the designs that
    no other design surpasses in both speed and radius.
    """
    from ..data import write_columns  # noqa: PLC0415
    from ..design_space import (  # noqa: PLC0415
        designs_csv_columns,
        evaluate_designs,
        load_fitted_robot,
        tested_range,
        tightest_turn_design,
    )
    from ..design_space.picture import designs_figure, save_figure  # noqa: PLC0415
    from ..study import load_study  # noqa: PLC0415

    loaded = load_study(study)
    home = results or Path("results") / study.resolve().name
    fit = load_fitted_robot(home, model=model, study=loaded)
    further = _parse_robot_options(other)
    folder = out or home / "design"
    refuse_outputs_over_study_files(study, (folder / "designs.csv", folder / "designs.png"))
    with progress_notice("trying designs"):
        found = evaluate_designs(
            fit,
            loaded.setup,
            tested_range(loaded),
            powers=powers,
            angles_deg=angles_deg,
            lengths_m=lengths_m,
            other=further,
        )
    write_columns(folder / "designs.csv", designs_csv_columns(found))
    save_figure(designs_figure(found, min_speed_m_s=speed_m_s), folder / "designs.png")
    best = tightest_turn_design(found, min_speed_m_s=speed_m_s, tested_only=tested_only)
    click.echo(f"{len(found)} designs, {fit.model} model; written: {folder}")
    click.echo(
        _best_design_text(best, speed_m_s)
        if best
        else _no_design_message(found, speed_m_s, tested_only)
    )
    for sentence in fit.warnings:
        click.echo(f"Warning: {sentence}.", err=True)
    warn_of_failed_trials(loaded, home)
    warn_of_outdated_results(loaded, home)


def _parse_robot_options(given: tuple[str, ...]) -> dict[str, tuple[float, ...]]:
    """Values by key of `--robot KEY=NUMBERS`, which may be repeated."""
    out: dict[str, tuple[float, ...]] = {}
    for text in given:
        key, sign, values = text.partition("=")
        if not sign or not key or key in out:
            twice = " a second time: give its values in one" if key in out else ""
            raise click.UsageError(f"--robot '{text}'{twice}: write mass_kg=0.5,0.7")
        out[key] = NumberList().convert(values, None, None)
    return out


def _no_design_message(found: list[RobotDesign], speed_m_s: float, tested_only: bool) -> str:
    """Why there is no answer: what the designs can do at most."""
    turns = [
        d for d in found if math.isfinite(d.radius_m[0]) and not (tested_only and d.extrapolated)
    ]
    where = " within the tested range" if tested_only else ""
    if not turns:
        return f"no design{where} settles into a turn"
    fastest = max(d.speed_m_s[0] for d in turns)
    return (
        f"no design{where} turns at {speed_m_s:g} m/s or more: the fastest does {fastest:.3f} m/s"
    )


def _best_design_text(best: RobotDesign, speed_m_s: float) -> str:
    radius, low, high = best.radius_m
    more = "".join(f", {k} {v:g}" for k, v in best.other.items())
    warning = f" - extrapolated in {' and '.join(best.extrapolated)}" if best.extrapolated else ""
    return (
        f"tightest turn at {speed_m_s:g} m/s or more: radius {radius:.3f} m ({low:.3f} to "
        f"{high:.3f}), {best.speed_m_s[0]:.3f} m/s, at {best.power_pct:g} % power, head angle "
        f"{best.head_angle_deg:g} degrees, head {best.head_length_m:g} m{more}{warning}"
    )
