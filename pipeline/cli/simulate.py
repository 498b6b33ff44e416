"""`bluekoi simulate`: the model's path for a robot, a power, a head."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from ..model import Simulation


@click.command()
@click.argument("study", type=click.Path(path_type=Path))
@click.option("--flap-hz", required=True, type=click.FloatRange(min=0), help="Flapping frequency.")
@click.option("--head-angle-deg", default=0.0, show_default=True)
@click.option("--head-length-m", type=click.FloatRange(min=0, min_open=True), help="Default: 1x.")
@click.option("--seconds", default=10.0, show_default=True, type=click.FloatRange(0.1, 600))
@click.option(
    "--results",
    type=click.Path(path_type=Path),
    help="Results folder whose joint fit is used; else Table I of the paper at 100 %.",
)
@click.option("--out", type=click.Path(path_type=Path), help="csv to write the path to.")
def simulate(
    *,
    study: Path,
    flap_hz: float,
    head_angle_deg: float,
    head_length_m: float | None,
    seconds: float,
    results: Path | None,
    out: Path | None,
) -> None:
    """Simulate the robot of STUDY from rest; say its steady speed and turn radius."""
    from ..model import simulate as run  # noqa: PLC0415
    from ..model import steady_turn  # noqa: PLC0415
    from ..study import load_study  # noqa: PLC0415

    setup, coefficients = load_study(study).setup, _coefficients(results)
    how: dict[str, Any] = {
        "head_length_m": head_length_m or setup.robot.head_length_m,
        "head_angle_rad": math.radians(head_angle_deg),
        "flap_hz": flap_hz,
    }
    speed, radius = steady_turn(coefficients, setup=setup, **how)
    turn = f"radius {radius:.3f} m" if math.isfinite(radius) else "straight"
    click.echo(f"steady: {speed:.3f} m/s, {turn}")
    if out is not None:
        _write(out, run(coefficients, setup=setup, duration_s=seconds, **how))
        click.echo(f"Written: {out}")


def _coefficients(results: Path | None) -> Mapping[str, float]:
    from ..files import read_json  # noqa: PLC0415
    from ..model import TABLE_1  # noqa: PLC0415

    if results is None:
        return TABLE_1[100]
    joint = read_json(results / "coefficients.json")["joint"]["coefficients"]
    return {name: float(joint[name]["value"]) for name in TABLE_1[100]}


def _write(out: Path, path: Simulation) -> None:
    from ..data import write_columns  # noqa: PLC0415

    names = ("x_m", "y_m", "theta_rad", "vx_m_s", "vy_m_s", "yaw_rate_rad_s")
    columns = {name: path.state[:, i] for i, name in enumerate(names)}
    write_columns(out, {"time_s": path.time_s, **columns, "heading_rad": path.heading_rad})
