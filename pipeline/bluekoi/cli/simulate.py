"""`bluekoi simulate`: the model's path for a robot under commands that change over time."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from .number_types import FiniteNumber
from .outputs import refuse_outputs_over_study_files
from .parameter_types import StudyName
from .progress_notice import progress_notice
from .results_warnings import warn_of_failed_trials, warn_of_outdated_results

if TYPE_CHECKING:
    from ..design_space import FittedRobot, Schedule
    from ..model import Simulation
    from ..study import Study, StudySettings

MANOEUVRE_NAMES = ("s-turn", "underpowered-turn", "start-stop")
"""Manoeuvres that the command knows by name."""
OUTPUT_INTERVAL_S = 1 / 60
"""Interval between the rows of a simulated path."""
TESTED_RANGE_TOLERANCE_SHARE = 1e-3
"""Share by which a command may exceed what was tested without a warning."""
PICTURE_SUFFIXES = (".png", ".pdf", ".svg")
"""Kinds of picture that a path can be drawn to."""


@click.command()
@click.argument("study", type=StudyName(path_type=Path))
@click.option("--flap-hz", type=FiniteNumber(0, 100), help="Flapping frequency.")
@click.option("--power-pct", type=FiniteNumber(0, 300), help="Motor power, instead of a frequency.")
@click.option("--head-angle-deg", type=FiniteNumber(-120, 120), help="Default: 0.")
@click.option("--schedule", type=click.Path(path_type=Path),
              help="csv of commands: time_s, head_angle_deg, power_pct or flap_hz.")  # fmt: skip
@click.option("--manoeuvre", type=click.Choice(MANOEUVRE_NAMES),
              help="Standard manoeuvre, with the frequency, head angle and duration "
              "of the other options.")  # fmt: skip
@click.option("--head-length-m", type=FiniteNumber(0, 10, min_open=True),
              help="Default: the 1x (standard) head.")  # fmt: skip
@click.option("--seconds", type=FiniteNumber(0.1, 600),
              help="Default: 10, or to the end of the schedule if that is later.")  # fmt: skip
@click.option("--results", type=click.Path(path_type=Path),
              help="Results whose fit is used. Default: Table I of the paper "
              "for 100 % motor power.")  # fmt: skip
@click.option("--model", type=click.Choice(["joint", "extended"]),
              help="Default: extended by the causes found, where there are any.")  # fmt: skip
@click.option("--out", type=click.Path(path_type=Path), help="csv file for the simulated path.")
@click.option("--picture", type=click.Path(path_type=Path),
              help="png, pdf or svg file for a drawing of the path.")  # fmt: skip
def simulate(
    *, study: Path, flap_hz: float | None, power_pct: float | None, head_angle_deg: float | None,
    schedule: Path | None, manoeuvre: str | None, head_length_m: float | None, seconds: float |
    None, results: Path | None, model: str | None, out: Path | None, picture: Path | None,
) -> None:  # fmt: skip
    """Simulate the robot of STUDY from rest, under constant commands or a schedule of them."""
    from ..study import load_study  # noqa: PLC0415

    commanded = {"--flap-hz": flap_hz, "--power-pct": power_pct,
                 "--head-angle-deg": head_angle_deg, "--manoeuvre": manoeuvre}  # fmt: skip
    _refuse_unused_options(schedule, commanded, results, model)
    _refuse_conflicting_outputs(schedule, out, picture)
    refuse_outputs_over_study_files(study, (out, picture))
    loaded = load_study(study)
    with progress_notice("reading the model"):
        setup, fit = loaded.setup, _load_fit(results, model, loaded)
    length, angle = head_length_m or setup.robot.head_length_m, math.radians(head_angle_deg or 0.0)
    if schedule is not None:
        from ..design_space import read_schedule  # noqa: PLC0415

        commands = read_schedule(schedule, fit.flap_hz_at_power)
        lasts = seconds or max(10.0, float(commands.time_s[-1]))
    else:
        hz, lasts = _flapping_frequency(flap_hz, power_pct, fit), seconds or 10.0
        commands = _command_schedule(manoeuvre, hz, angle, lasts)
        if manoeuvre is None:
            _print_steady_state(fit, setup, length, hz, angle)
    with progress_notice("simulating (the first time on a machine the model is compiled)"):
        run = _simulate_path(fit, setup, length, commands, lasts)
    if schedule is not None or manoeuvre is not None:
        _print_distance_and_turn(run)
    _save_simulated_path(run, commands, setup, length, out=out, picture=picture)
    for sentence in (
        *_extrapolation_warnings(fit, run, commands, power_pct),
        *_untested_condition_sentences(
            loaded, commands, length, fit, by_power=power_pct is not None
        ),
    ):
        click.echo(f"Warning: {sentence}.", err=True)
    if results is not None:
        warn_of_failed_trials(loaded, results)
        warn_of_outdated_results(loaded, results)


def _refuse_unused_options(
    schedule: Path | None, commanded: Mapping[str, object], results: Path | None, model: str | None
) -> None:
    """Options that would have no effect are not taken in silence."""
    given = [name for name, value in commanded.items() if value is not None]
    if schedule is not None and given:
        raise click.UsageError(f"--schedule holds all commands: leave out {', '.join(given)}")
    if model is not None and results is None:
        raise click.UsageError("--model chooses between the fits of --results: give both")


def _refuse_conflicting_outputs(
    schedule: Path | None, out: Path | None, picture: Path | None
) -> None:
    """Before anything is written: a picture's format, and files that would replace one another."""
    if picture is not None and picture.suffix.lower() not in PICTURE_SUFFIXES:
        raise click.UsageError(
            f"--picture {picture}: its ending must be {', '.join(PICTURE_SUFFIXES)}"
        )
    files = [path.resolve() for path in (schedule, out, picture) if path is not None]
    if len(set(files)) < len(files):
        raise click.UsageError("--schedule, --out and --picture must be different files")


def _save_simulated_path(
    run: Simulation, commands: Schedule, setup: StudySettings, length: float, *, out: Path | None,
    picture: Path | None,
) -> None:  # fmt: skip
    if out is not None:
        _write_path_csv(out, run, commands)
        click.echo(f"Written: {out}")
    if picture is not None:
        from ..design_space.picture import save_figure, simulated_path_figure  # noqa: PLC0415

        save_figure(simulated_path_figure(run, commands, setup, length), picture)
        click.echo(f"Drawn: {picture}")


def _extrapolation_warnings(
    fit: FittedRobot, run: Simulation, commands: Schedule, power_pct: float | None
) -> list[str]:
    """Sentences on what the answer does not hold for."""
    import numpy as np  # noqa: PLC0415

    out = list(fit.warnings)
    low, high = min(fit.flap_hz), max(fit.flap_hz)
    if power_pct is not None and not low <= power_pct <= high:
        out.append(f"{power_pct:g} % power lies outside the tested {low:g} to {high:g} %, its "
                   "flapping frequency is extrapolated")  # fmt: skip
    if commands.time_s[-1] > run.time_s[-1] + OUTPUT_INTERVAL_S:
        out.append(f"the schedule goes on to {commands.time_s[-1]:g} s, the simulation ends at "
                   f"{run.time_s[-1]:g} s")  # fmt: skip
    lost = np.flatnonzero(~np.isfinite(run.state).all(axis=1))
    if len(lost):
        out.append(f"the model runs away: no numbers after {run.time_s[lost[0]]:.2f} s")
    return out


def _untested_condition_sentences(
    study: Study, commands: Schedule, head_length_m: float, fit: FittedRobot, *, by_power: bool
) -> list[str]:
    """Sentences on commands and a head beyond those of the trials; a power has its own."""
    angles = [abs(math.degrees(angle)) for angle in commands.head_angle_rad]
    frequencies = [hz for hz in commands.flap_hz if hz > 0]
    tested = [
        ("head angle", angles, [0.0, *(abs(t.head_angle_deg) for t in study.trials)], "degrees"),
        ("head", [head_length_m], [t.head_length_m for t in study.trials], "m"),
    ]
    if not by_power:
        tested.append(("flapping frequency", frequencies, list(fit.flap_hz.values()), "Hz"))
    out = []
    for name, asked, known, unit in tested:
        low, high = min(known), max(known)
        beyond = [
            v
            for v in asked
            if not low - TESTED_RANGE_TOLERANCE_SHARE * high
            <= v
            <= high + TESTED_RANGE_TOLERANCE_SHARE * high
        ]
        if beyond:
            out.append(f"a {name} of {max(beyond):.4g} {unit} lies outside the tested {low:.4g} to "
                       f"{high:.4g} {unit}: the model is extrapolated")  # fmt: skip
    return out


def _load_fit(results: Path | None, model: str | None, study: Study) -> FittedRobot:
    from ..design_space import FittedRobot, load_fitted_robot  # noqa: PLC0415
    from ..model import PUBLISHED_FLAP_HZ, TABLE_1, two_plate_system  # noqa: PLC0415

    if results is not None:
        return load_fitted_robot(results, model=model, study=study)
    hz = {float(power): value for power, value in PUBLISHED_FLAP_HZ.items()}
    text = "without --results the coefficients are those of the paper (Table I at 100 %)"
    return FittedRobot(
        two_plate_system().parameter_vector(TABLE_1[100])[None],
        hz,
        "Table I at 100 %",
        (text,),
    )


def _flapping_frequency(flap_hz: float | None, power_pct: float | None, fit: FittedRobot) -> float:
    if (flap_hz is None) == (power_pct is None):
        raise click.UsageError("give --flap-hz or --power-pct, one of them (or --schedule)")
    return fit.flap_hz_at_power(power_pct) if power_pct is not None else float(flap_hz or 0.0)


def _command_schedule(
    manoeuvre: str | None, hz: float, angle_rad: float, seconds: float
) -> Schedule:
    import numpy as np  # noqa: PLC0415

    from ..design_space import MANOEUVRES, Schedule  # noqa: PLC0415

    if manoeuvre is not None:
        return MANOEUVRES[manoeuvre](hz, angle_rad, seconds)
    return Schedule(np.zeros(1), np.full(1, hz), np.full(1, angle_rad))


def _print_steady_state(
    fit: FittedRobot, setup: StudySettings, length: float, hz: float, angle_rad: float
) -> None:
    from ..design_space import OperatingCondition, steady_states  # noqa: PLC0415

    with progress_notice(
        "looking for the steady state (the first time the model is compiled)", 20.0
    ):
        found = steady_states([OperatingCondition(hz, angle_rad, length, setup)], fit.values[:1])
    speed, radius = float(found.speed_m_s[0, 0]), float(found.radius_m[0, 0])
    turn = f"radius {radius:.3f} m" if math.isfinite(radius) else "straight"
    settled = f"steady: {speed:.3f} m/s, {turn}"
    click.echo(settled if math.isfinite(speed) else "it does not settle within half a minute")


def _simulate_path(
    fit: FittedRobot, setup: StudySettings, length: float, commands: Schedule, seconds: float
) -> Simulation:
    import numpy as np  # noqa: PLC0415

    from ..model import constants_of_robot_trial, simulate_at_times  # noqa: PLC0415

    times = np.arange(round(seconds / OUTPUT_INTERVAL_S) + 1, dtype=np.float64) * OUTPUT_INTERVAL_S
    hz, angle = commands.at(times)
    start = np.array([0.5 * setup.pool.length_m, 0.5 * setup.pool.width_m, 0.0, 0.0, 0.0, 0.0])
    inputs = np.column_stack([angle, hz])
    constants = constants_of_robot_trial(setup, length, place_m=(start[0], start[1]))
    return simulate_at_times(fit.values[0], times, inputs, constants, start)


def _print_distance_and_turn(run: Simulation) -> None:
    import numpy as np  # noqa: PLC0415

    moved = np.hypot(*(run.state[-1, :2] - run.state[0, :2]))
    turned = math.degrees(run.heading_rad[-1] - run.heading_rad[0])
    click.echo(
        f"after {run.time_s[-1]:g} s: {moved:.2f} m from the start, turned by {turned:.0f} degrees,"
        f" {run.speed_m_s[-1]:.3f} m/s (fastest {run.speed_m_s.max():.3f})"
    )


def _write_path_csv(out: Path, run: Simulation, commands: Schedule) -> None:
    import numpy as np  # noqa: PLC0415

    from ..data import write_columns  # noqa: PLC0415

    hz, angle = commands.at(run.time_s)
    names = ("x_m", "y_m", "theta_rad", "vx_m_s", "vy_m_s", "yaw_rate_rad_s")
    columns = {name: run.state[:, i] for i, name in enumerate(names)}
    write_columns(
        out,
        {"time_s": run.time_s, **columns, "heading_rad": run.heading_rad, "flap_hz": hz,
         "head_angle_deg": np.degrees(angle)},
    )  # fmt: skip
