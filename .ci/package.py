"""Build sdist and wheel, check what is in them, and install the wheel into an empty environment.

    python .ci/package.py [--out dist] [--install] [--demo]

The wheel is built from the sdist, as an index's users would. --install: into a new environment with
the locked versions of all dependencies, where the command and the import are tried. --demo: there,
the demo study from rendered footage to the report as well.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
import venv
import zipfile
from email import message_from_string
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
NEEDED = (
    "bluekoi/py.typed", "bluekoi/report/page.html", "bluekoi/report/page.css",
    "bluekoi/report/explorer.js", "bluekoi/report/charts.js", "bluekoi/preparation/page/index.html",
    "bluekoi/preparation/page/main.js", "bluekoi/integrate/kernel_template.txt",
    "bluekoi/workflow/files/Snakefile",
    "bluekoi/workflow/files/config/schema.yaml",
    "bluekoi/workflow/files/config/profiles/default/config.yaml",
)  # fmt: skip
SOURCES = ("pyproject.toml", "setup.py", "README.md", "LICENSE", "Snakefile", "config/schema.yaml")
FOREIGN = ("tests", "validation", "benchmarks", "examples", "docs", ".github", "results", "studies")
BUILD = "import sys, setuptools.build_meta as b; print(getattr(b, sys.argv[1])(sys.argv[2]))"


def built(out: Path) -> tuple[Path, Path]:
    """The sdist of the checkout, and the wheel that is built from it."""
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "checkout"
        names = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True,
                               capture_output=True, text=True).stdout.split("\0")  # fmt: skip
        for name in filter(None, names):
            if (ROOT / name).is_file():
                (copy / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(ROOT / name, copy / name)
        sdist = out / _build(copy, "build_sdist", out)
        with tarfile.open(sdist) as archive:
            archive.extractall(folder, filter="data")
        unpacked = next(Path(folder).glob("bluekoi-*"))
        return sdist, out / _build(unpacked, "build_wheel", out)


def _build(source: Path, what: str, out: Path) -> str:
    words = [sys.executable, "-P", "-c", BUILD, what, str(out.resolve())]
    done = subprocess.run(words, cwd=source, check=True, capture_output=True, text=True)
    return done.stdout.split()[-1]


def faults(sdist: Path, wheel: Path) -> list[str]:
    """What is wrong with the two files; empty where all is well."""
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
        info = next(name for name in names if name.endswith(".dist-info/METADATA"))
        metadata = message_from_string(archive.read(info).decode())
        points = archive.read(info.replace("METADATA", "entry_points.txt")).decode()
    with tarfile.open(sdist) as archive:
        inside = {name.partition("/")[2] for name in archive.getnames()}
    tops = {name.split("/")[0] for name in names}
    found = [f"wheel: {name} is missing" for name in NEEDED if name not in names]
    found += [f"wheel: {top} does not belong there" for top in tops
              if top != "bluekoi" and not top.endswith(".dist-info")]  # fmt: skip
    found += [f"wheel: {name}" for name in names if name.endswith((".pyc", ".nbi", ".nbc"))]
    package = {path.relative_to(ROOT / "pipeline").as_posix()
               for path in (ROOT / "pipeline/bluekoi").rglob("*.py")}  # fmt: skip
    found += [f"wheel: {name} is missing" for name in sorted(package - names)]
    found += [f"sdist: {name} is missing" for name in SOURCES if name not in inside]
    found += [f"sdist: {name}/ does not belong there" for name in FOREIGN if name in inside]
    for key in ("Name", "Version", "Summary", "License-Expression", "Requires-Python"):
        found += [] if metadata[key] else [f"metadata: no {key}"]
    if metadata["Description-Content-Type"] != "text/markdown" or not metadata.get_payload():
        found.append("metadata: no description in markdown")
    if not metadata.get_all("Requires-Dist"):
        found.append("metadata: no dependencies")
    if "bluekoi = bluekoi.cli:main" not in points:
        found.append("metadata: no command bluekoi")
    return found


def installed(wheel: Path, folder: Path) -> Path:
    """The command `bluekoi` in a new environment with this wheel and what it depends on, in the
    locked versions.
    """
    venv.create(folder, with_pip=True)
    pip = [str(folder / "bin/python"), "-m", "pip", "--quiet", "--disable-pip-version-check"]
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    pins = [
        line.rstrip(" \\") for line in lock.splitlines() if "==" in line[:80] and line[0] != " "
    ]
    (folder / "constraints.txt").write_text("\n".join(pins) + "\n", encoding="utf-8")
    limits = ["--constraint", str(folder / "constraints.txt")]
    subprocess.run([*pip, "install", *limits, str(wheel.resolve())], check=True)
    subprocess.run([*pip, "check"], check=True)
    return folder / "bin/bluekoi"


def tried(command: Path, folder: Path, *, demo: bool) -> None:
    """Import and command from a folder without the checkout; the demo where it is asked for."""
    folder.mkdir()
    away = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    code = "import bluekoi, sys; assert 'site-packages' in bluekoi.__file__, bluekoi.__file__"
    for words in ([command.with_name("python"), "-c", code], [command, "--version"],
                  [command, "check", "--explain", "mass_kg"]):  # fmt: skip
        subprocess.run(list(map(str, words)), cwd=folder, env=away, check=True)
    if demo:
        subprocess.run([str(command), "run", "demo"], cwd=folder, env=away, check=True)
        page = folder / "results/demo/report.html"
        print(f"{page}: {page.stat().st_size} bytes")


def main() -> int:
    """Exit code: 1 where something is wrong with the files."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "dist")
    parser.add_argument("--install", action="store_true")
    parser.add_argument("--demo", action="store_true")
    options = parser.parse_args()
    shutil.rmtree(options.out, ignore_errors=True)
    sdist, wheel = built(options.out)
    wrong = faults(sdist, wheel)
    for path in (sdist, wheel):
        print(f"{path.name}: {path.stat().st_size} bytes")
    print("\n".join(wrong) or "Contents and metadata are as they should be.")
    if not wrong and (options.install or options.demo):
        with tempfile.TemporaryDirectory() as folder:
            command = installed(wheel, Path(folder) / "env")
            tried(command, Path(folder) / "empty", demo=options.demo)
            print("Installed into an empty environment and tried.")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
