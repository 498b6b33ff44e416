"""`bluekoi explain`: what a model of any system leaves out of its recordings."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from .number_types import FiniteNumber
from .parameter_types import NonEmptyPath

if TYPE_CHECKING:
    from ..explain import Model, Trial


@click.command()
@click.argument("model", type=NonEmptyPath(path_type=Path))
@click.argument("data", type=NonEmptyPath(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), help="Default: results/explain/MODEL.")
@click.option(
    "--predict",
    "others",
    multiple=True,
    type=click.Path(path_type=Path),
    help="A folder of recordings to predict without fitting them (may be repeated).",
)
@click.option(
    "--left-out", is_flag=True, help="Predict each condition by models fitted to the others."
)
@click.option(
    "--known-s",
    type=FiniteNumber(min=0.001),
    default=1.0,
    show_default=True,
    help="Duration at the start of a predicted trial from which its initial state is estimated.",
)
@click.option(
    "--candidates", metavar="NAMES", help="Candidate causes to test, separated by commas."
)
@click.option(
    "--without", metavar="NAMES", help="Candidate causes to exclude, separated by commas."
)
@click.option(
    "--compare",
    "sets",
    multiple=True,
    metavar="NAMES",
    help="Also fit the model with this set of causes, separated by commas (may be repeated).",
)
@click.option("--quiet", is_flag=True, help="Do not show progress.")
def explain(
    *, model: Path, data: Path, out: Path | None, others: tuple[Path, ...], left_out: bool, known_s:
    float, candidates: str | None, without: str | None, sets: tuple[str, ...], quiet: bool,
) -> None:  # fmt: skip
    """Find what must be added to the model in MODEL.py to describe the recordings in DATA.

    MODEL.py defines a dynamic model and candidate causes. DATA is a folder of csv files with a
    data.yaml. The page "A model and recordings of your own" of the documentation describes both.

    MODEL.py is run as a program: use only files that you would run yourself. Writes
    explanation.json, explanation.md and report.html.
    """
    from .. import explain as ex  # noqa: PLC0415
    from ..files import write_json, write_text  # noqa: PLC0415
    from ..report.explanation import write_explanation  # noqa: PLC0415

    def progress(text: str) -> None:
        if not quiet:
            click.echo(f"... {text}", err=True)

    progress(f"running {model}")
    given = ex.load_model(model)
    folder = out or Path("results") / "explain" / given.name
    _refuse_file_for_folder(folder)
    progress(f"reading {data}")
    trials = ex.read_trials(given, data)
    further = [t for folder in others for t in ex.read_trials(given, folder)]
    _check_trials_to_predict(given, further, known_s)
    notes = _ineffective_option_notes(given, data, others, candidates, without)
    found = ex.explain(
        given,
        trials,
        candidates=_split_names(candidates),
        without=_split_names(without) or (),
        compare=[_split_names(one) or () for one in sets],
        progress=progress,
    )
    predicted = ex.predict(found, further, known_s=known_s) if further else None
    if left_out and predicted is None:
        predicted = ex.predict_left_out(found, known_s=known_s)
    content, text = ex.explanation_json(found), ex.summary(found)
    text += "".join(f"\n\nNote: {note}" for note in notes)
    if predicted is not None:
        content["prediction"] = ex.prediction_json(predicted)
        text += "\n\n" + ex.prediction_text(given, predicted)
    write_json(folder / "explanation.json", content)
    write_text(folder / "explanation.md", text + "\n")
    write_explanation(found, predicted, folder / "report.html")
    click.echo(text)
    click.echo(f"\nWritten: {folder}")


def _refuse_file_for_folder(folder: Path) -> None:
    """Raises: InputError where results cannot be written because a file has the folder's name."""
    from ..errors import input_error  # noqa: PLC0415

    for path in (folder, *folder.parents):
        if path.exists() and not path.is_dir():
            raise input_error(path, "", "a file", "a folder for the results",
                              "Name another one with --out.")  # fmt: skip


def _check_trials_to_predict(model: Model, trials: Sequence[Trial], known_s: float) -> None:
    """Raises: InputError, before anything is fitted, where trials cannot be predicted."""
    from ..errors import input_error  # noqa: PLC0415
    from ..explain.trials import validated_trials  # noqa: PLC0415

    if not trials:
        return
    for trial in validated_trials(model, trials):
        if (span := float(trial.times[-1] - trial.times[0])) <= known_s:
            raise input_error(trial.source or trial.name, "", f"a trial of {span:.3g} s",
                              f"one longer than --known-s, {known_s:g} s")  # fmt: skip


def _ineffective_option_notes(
    model: Model, data: Path, others: Sequence[Path], candidates: str | None, without: str | None
) -> list[str]:
    """What the options make of the result, in sentences."""
    from ..explain.cause_search import requested_causes  # noqa: PLC0415

    names = requested_causes(model, _split_names(candidates), _split_names(without) or ())
    notes = []
    if not names and model.causes:
        notes.append("No candidate cause was tested: --candidates and --without leave none.")
    if any(other.resolve() == data.resolve() for other in others):
        notes.append("--predict names the recordings of the fit: their errors are no predictions.")
    return notes


def _split_names(text: str | None) -> tuple[str, ...] | None:
    """Names joined by commas; None where none were given."""
    if text is None:
        return None
    return tuple(name.strip() for name in text.split(",") if name.strip())
