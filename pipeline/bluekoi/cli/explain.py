"""`bluekoi explain`: what a model of any system leaves out of its recordings."""

from __future__ import annotations

from pathlib import Path

import click

from .number_types import FiniteNumber
from .parameter_types import NonEmptyPath


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
    help="A set of causes, separated by commas, to fit in addition (may be repeated).",
)
@click.option("--quiet", is_flag=True, help="Do not show progress.")
def explain(
    *, model: Path, data: Path, out: Path | None, others: tuple[Path, ...], left_out: bool, known_s:
    float, candidates: str | None, without: str | None, sets: tuple[str, ...], quiet: bool,
) -> None:  # fmt: skip
    """Find what must be added to the model in MODEL.py to describe the recordings in DATA.

    MODEL.py defines a dynamic model and candidate causes, DATA is a csv file or a folder of them
    (page "A model and recordings of your own" of the documentation).

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


def _split_names(text: str | None) -> tuple[str, ...] | None:
    """Names joined by commas; None where none were given."""
    if text is None:
        return None
    return tuple(name.strip() for name in text.split(",") if name.strip())
