"""Generated pages are current, links work, examples run, and the built site is self-contained."""

from __future__ import annotations

import doctest
import importlib.util
import inspect
import re
from pathlib import Path

import numpy as np
import pytest

import bluekoi
from bluekoi.cli import main
from bluekoi.data import TRACK_COLUMNS, Track, write_track
from small_studies import small_study

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"


def script(name: str):
    spec = importlib.util.spec_from_file_location(name, DOCS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("name", ["api", "commands", "effects", "study_keys"])
def test_generated_pages_are_current(name):
    again = f"docs/{name}.md is not current: run make pages (or python docs/{name}_page.py)"
    assert (DOCS / f"{name}.md").read_text(encoding="utf-8") == script(f"{name}_page").page(), again


def test_the_page_of_effects_has_every_file():
    found = set(re.findall(r"^### `(\w+)`", (DOCS / "effects.md").read_text(), re.M))
    parts = (ROOT / "pipeline/bluekoi" / name for name in ("effects", "measurement"))
    files = {path.stem for part in parts for path in part.glob("*.py")}
    assert found == {name for name in files if not name.startswith("_")}


def test_every_command_is_on_the_page_of_commands_and_every_exit_code_is_explained():
    text = (DOCS / "commands.md").read_text()
    shown = [name for name, command in main.commands.items() if not command.hidden]
    assert len(shown) > 8
    assert [name for name in shown if f"\n## `bluekoi {name}`" not in text] == []
    running = (DOCS / "running.md").read_text()
    assert all(f"| {code} |" in running for code in (0, 1, 2, 3, 130, 143))


def printed_commands():
    """Every command line on the pages: page, words from the program's name on."""
    for page in [*DOCS.rglob("*.md"), ROOT / "README.md"]:
        text = re.sub(r"\\\n\s*", " ", page.read_text())
        blocks = re.findall(r"^ {4}(?:\$ )?(.+(?:\n {8,}.+)*)", text, re.M)
        for line in [*blocks, *re.findall(r"`([^`]+)`", text)]:
            if found := re.match(r"(bluekoi [a-z]|python (?:benchmarks/|-m validation))", line):
                yield page.name, line[found.start() :].partition("#")[0].split()


def options_of(words):
    """Options that the program of a command line knows."""
    if words[0] == "bluekoi":
        return {o for p in main.commands[words[1]].params for o in (*p.opts, *p.secondary_opts)}
    source = ROOT / words[1] if words[1] != "-m" else ROOT / "validation/__main__.py"
    return set(re.findall(r'"(--[a-z][a-z-]*)"', source.read_text()))


def test_commands_on_the_pages_exist_with_the_options_shown():
    unknown, count = [], 0
    for page, words in printed_commands():
        own = words[: words.index("--")] if "--" in words else words
        shown = {w.strip("[]") for w in own if w.strip("[").startswith("--")}
        if words[0] == "bluekoi" and words[1] not in main.commands:
            unknown.append((page, words[1]))
            continue
        count += 1
        unknown += [(page, *words[:2], option) for option in shown - options_of(words)
                    if option not in ("--help", "--version")]  # fmt: skip
    assert unknown == []
    assert count > 60


def test_every_public_name_is_documented_and_importable():
    text = (DOCS / "api.md").read_text()
    assert [name for name in bluekoi.__all__ if f"### `{name}`" not in text] == []
    assert [name for name in bluekoi.__all__ if not inspect.getdoc(getattr(bluekoi, name))] == []
    with pytest.raises(AttributeError, match="no attribute 'simulat'"):
        _ = bluekoi.simulat


def test_examples_of_the_public_interface_run(tmp_path, monkeypatch):
    small_study(tmp_path / "lab")
    times = np.linspace(0.0, 1.0, 31)
    columns = dict.fromkeys(TRACK_COLUMNS, times) | {"speed_m_s": 0.5 * times}
    (tmp_path / "results/lab/tracks").mkdir(parents=True)
    write_track(tmp_path / "results/lab/tracks/T09.csv", Track(**columns))
    monkeypatch.chdir(tmp_path)
    names = {name: getattr(bluekoi, name) for name in bluekoi.__all__}
    runner, finder = doctest.DocTestRunner(), doctest.DocTestFinder(recurse=False)
    examples = [t for n in names for t in finder.find(names[n], n, globs=dict(names)) if t.examples]
    assert len(examples) >= 5
    assert [t.name for t in examples if runner.run(t).failed] == []


def test_links_between_pages_lead_somewhere():
    pages = [*DOCS.rglob("*.md"), ROOT / "README.md"]
    broken = [
        f"{page.name}: {target}"
        for page in pages
        for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text())
        if not (page.parent / target).exists()
    ]
    assert broken == []


def test_the_study_of_the_tutorial_is_one_that_the_tool_takes(tmp_path):
    """Its study.yaml and trials.csv, as printed, are read without complaint."""
    from bluekoi.study import load_study

    text = (DOCS / "tutorial.md").read_text()
    study = re.search(r"```yaml\n(pool:.*?)```", text, re.S)
    trials = re.search(r"```\n(trial_id,.*?)```", text, re.S)
    (tmp_path / "study.yaml").write_text(study.group(1))
    (tmp_path / "trials.csv").write_text(trials.group(1))
    loaded = load_study(tmp_path)
    assert len(loaded.trials) >= 4
    assert len({trial.condition for trial in loaded.trials}) >= 2


def test_the_site_checker_reports_broken_links_missing_anchors_and_remote_files(tmp_path):
    page = """<html><head><link rel="stylesheet" href="s.css"></head><body><h1 id="top">A</h1>
    <a href="b.html">no page</a><a href="#nowhere">no anchor</a><a href="#top">fine</a>
    <a href="https://example.org">fine</a><script src="https://example.org/x.js"></script></body>"""
    (tmp_path / "a.html").write_text(page)
    (tmp_path / "s.css").write_text("@font-face {src: url('https://example.org/f.woff')}")
    assert sorted(script("check_site").faults(tmp_path)) == [
        "a.html: loads https://example.org/x.js from another site",
        "a.html: no anchor #nowhere",
        "a.html: no file b.html",
        "s.css: loads https://example.org/f.woff",
    ]
