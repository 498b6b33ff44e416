"""What a run is about: the study at hand, its results folder, and what each job depends on.

The Snakefile asks a `Plan` for inputs and for the fingerprints that make a job run again: of the
code that it runs through, of its row in trials.csv, of the parts of study.yaml that it reads.
"""

from __future__ import annotations

import hashlib
import json
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from ..faults import fault
from ..study import Study, Trial, load_study
from ..study.seal import seal_files
from .contents import state_of, words_of
from .provenance import PACKAGE, fingerprint

RESULTS = (
    "geometry.json", "steady.csv", "coefficients.json", "table1.csv", "table2.csv",
    "mismatch.json", "report.html",
)  # fmt: skip
FOLDERS = (
    "benchmarks", "extended", "figures", "keypoints", "logs", "overlays", "poses", "simulations",
    "status", "steady", "tracks",
)  # fmt: skip
DETECTION_COLUMNS = ("trial_id", "source", "fps", "start_s", "end_s")


@dataclass(frozen=True)
class Plan:
    """One run; folders as given, so that logs and reports show what the person wrote."""

    folder: Path
    results: Path
    study: Study
    is_demo: bool
    overlaid: str
    lock: IO[str] | None = None

    @property
    def trials(self) -> list[str]:
        """Ids of all trials, in the order of trials.csv."""
        return [trial.trial_id for trial in self.study.trials]

    def overlays(self) -> list[str]:
        """How the overlays went, of the trials that are to have one."""
        wanted = {
            "all": self.trials,
            "filmed": [t.trial_id for t in self.study.trials if not t.reads_keypoints],
            "none": [],
        }[self.overlaid]
        return [str(self.results / f"status/overlays/{trial}.json") for trial in wanted]

    @property
    def options(self) -> str:
        """What every stage is told on its command line: where the study and the results are."""
        return f"--study {shlex.quote(str(self.folder))} --results {shlex.quote(str(self.results))}"

    def goals(self) -> list[str]:
        """Files that a run is made for.

        Each trial's status is among them, or else one that was taken away would not be missed as
        long as the files made from it stand.
        """
        kinds = ("status/keypoints", "status")
        statuses = [f"{kind}/{trial}.json" for trial in self.trials for kind in kinds]
        return [
            *(str(self.results / name) for name in (*statuses, *RESULTS)),
            *self.figures(),
            *self.overlays(),
        ]

    def memory_mb(self, base: int, each: int) -> int:
        """Memory to ask a cluster for, of a stage that holds all trials at once."""
        return base + each * len(self.trials)

    def figures(self) -> list[str]:
        """Pictures of all figures."""
        return [str(self.results / f"figures/{name}.png") for name in figure_names()]

    def sources(self, wildcards: Any) -> list[str]:
        """Files of a trial to detect in; one that is missing is left to the stage to tell."""
        trial = self.study.trial(wildcards.trial)
        return [self._named(name) for name in trial.sources if self._comes(name)]

    def motor(self, wildcards: Any) -> list[str]:
        """Motor log of a trial, where it has one."""
        name = self.study.trial(wildcards.trial).motor_log
        return [self._named(name)] if name and self._comes(name) else []

    def depth(self) -> list[str]:
        """What tells the depth of the keypoints, where study.yaml does not."""
        return [] if self.study.setup.robot.depth_given else [str(self.results / "geometry.json")]

    def drawn_from(self, wildcards: Any) -> list[str]:
        """What a figure is drawn from beside the fits and the search."""
        return [str(self.results / "geometry.json")] if wildcards.figure == "geometry" else []

    def _states(self, paths: list[str]) -> list[str]:
        """What tells whether files of the study are the same; the demo's own are made by the run.

        Snakemake looks whether a source is newer than what was made of it, so a file put in its
        place with an older date (from an archive, by `cp -p`) would go unnoticed.
        """
        return [] if self.is_demo else [state_of(Path(path)) for path in paths]

    def _named(self, name: str) -> str:
        return str(self.folder / name)

    def _comes(self, name: str) -> bool:
        return self.is_demo or (self.study.root / name).is_file()

    def seal(self) -> list[str]:
        """Files of the study's seal, if it has one; the page is made anew when they change."""
        return [str(path) for path in seal_files(self.folder)]

    def code(self, stage: str) -> str:
        """Fingerprint of all source files that a stage runs through."""
        return fingerprint(f"stages.{stage}")

    def figure_code(self, wildcards: Any) -> str:
        """Fingerprint of one figure's own file and of what it draws with."""
        return fingerprint("stages.figure", f"figures.{wildcards.figure}")

    def figure_words(self, wildcards: Any) -> dict[str, str]:
        """Title and caption of a figure, read from its file without running it."""
        return words_of(PACKAGE / f"figures/{wildcards.figure}.py")

    def detection(self, wildcards: Any) -> str:
        """Fingerprint of what the detection of a trial depends on beside its source."""
        trial, setup = self.study.trial(wildcards.trial), self.study.setup
        files = self._states(self.sources(wildcards))
        if not trial.reads_keypoints:
            return _hash(_without(_row(trial), "role"), setup.model_dump(mode="json"), files)
        row = {name: getattr(trial, name) for name in DETECTION_COLUMNS}
        return _hash(row, setup.bodyparts, files)

    def motion(self, wildcards: Any) -> str:
        """Fingerprint of what the pose and the track of a trial depend on beside detections."""
        setup = self.study.setup.model_dump(mode="json")
        row = _without(_row(self.study.trial(wildcards.trial)), "role")
        log = self._states(self.motor(wildcards))
        return _hash(row, _without(setup, "detection"), self.study.setup.robot.depth_given, log)

    def distances(self) -> str:
        """Fingerprint of what the check of the rigid distances depends on beside keypoints."""
        heads = [(trial.trial_id, trial.head_length_m) for trial in self.study.trials]
        setup = self.study.setup.model_dump(mode="json")
        return _hash(heads, _without(setup, "detection"), self.study.setup.robot.depth_given)

    def fit(self) -> str:
        """Fingerprint of what the fits depend on beside tracks: setup, conditions, roles."""
        rows = [_row(trial) for trial in self.study.trials]
        return _hash(rows, _without(self.study.setup.model_dump(mode="json"), "detection"))


def figure_names() -> list[str]:
    """Names of the figures: the modules of pipeline/figures."""
    names = (path.stem for path in (PACKAGE / "figures").glob("*.py"))
    return sorted(name for name in names if not name.startswith("_"))


def make_plan(settings: Mapping[str, Any]) -> Plan:
    """Plan of a run by its checked settings; the demo's study files are laid out if need be.

    Raises: Fault with all that is wrong with the study, or where the results cannot be written.
    """
    is_demo = settings["study"] == "demo" and not Path("demo/study.yaml").is_file()
    folder = Path(settings["demo_folder"] if is_demo else settings["study"])
    if is_demo:
        _lay_out_demo(folder)
    study = load_study(folder)
    results = Path(settings["results"] or Path("results") / folder.resolve().name)
    _check_apart(study, results)
    _prepare(results)
    return Plan(folder, results, study, is_demo=is_demo, overlaid=settings["overlays"])


def _check_apart(study: Study, results: Path) -> None:
    """Raises: Fault where results would be written among, or over, files of the study."""
    logs = (study.motor_path(trial) for trial in study.trials)
    own = [study.root / "study.yaml", *(p for t in study.trials for p in study.paths(t)),
           *(log for log in logs if log)]  # fmt: skip
    here = results.resolve()
    for path in own:
        for at in (path.absolute(), path.resolve()):
            if at.is_relative_to(here) and at.relative_to(here).parts[0] in (*FOLDERS, at.name):
                raise fault(
                    results, "", f"a folder that holds {path.name}, a file of the study",
                    "a folder of its own for the results", "Name another one with --results.",
                )  # fmt: skip


def _lay_out_demo(folder: Path) -> None:
    """Study files of the demo; skipped where they stand and were written by this very code."""
    stamp, code = folder / ".laid-out-by", fingerprint("stages.demo")
    files = [folder / "study.yaml", folder / "trials.csv", stamp, *seal_files(folder)]
    whole = len(files) == 5 and all(path.is_file() for path in files)
    if whole and stamp.read_text(encoding="utf-8") == code:
        return
    from ..files import write_text  # noqa: PLC0415
    from ..stages.demo import lay_out  # noqa: PLC0415  heavy, and only once

    lay_out(folder)
    write_text(stamp, code)


def _prepare(results: Path) -> None:
    if results.is_file():
        raise fault(results, "", "a file", "a folder for the results")
    try:
        results.mkdir(parents=True, exist_ok=True)
        (probe := results / ".writable").touch()
        probe.unlink()
    except OSError as error:
        found = f"'{error.strerror}'"
        raise fault(results, "", found, "a results folder that can be written to") from error


def _row(trial: Trial) -> dict[str, Any]:
    return trial.model_dump(mode="json")


def _without(content: Mapping[str, Any], *names: str) -> dict[str, Any]:
    return {key: value for key, value in content.items() if key not in names}


def _hash(*content: Any) -> str:
    text = json.dumps(content, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:12]
