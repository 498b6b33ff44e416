"""The pages say what is there: effects as their files have them, commands, exit codes, links."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

import pytest

from bluekoi.cli import main

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"


def script(name: str):
    spec = importlib.util.spec_from_file_location(name, DOCS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("name", ["effects", "study_keys"])
def test_generated_pages_are_current(name):
    again = f"docs/{name}.md is not current: run python docs/{name}_page.py"
    assert (DOCS / f"{name}.md").read_text(encoding="utf-8") == script(f"{name}_page").page(), again


def test_the_page_of_effects_has_every_file():
    found = set(re.findall(r"^### `(\w+)`", (DOCS / "effects.md").read_text(), re.M))
    parts = (ROOT / "pipeline/bluekoi" / name for name in ("effects", "measurement"))
    files = {path.stem for part in parts for path in part.glob("*.py")}
    assert found == {name for name in files if not name.startswith("_")}


def test_every_command_and_its_options_are_on_the_keyboard_page():
    text = (DOCS / "keyboard.md").read_text()
    for name, command in main.commands.items():
        if command.hidden:
            continue
        assert f"`bluekoi {name}" in text, name
        for option in (o for o in command.params if o.opts[0].startswith("--")):
            assert option.opts[0] in text, (name, option.opts[0])
    for code in ("| 0 |", "| 1 |", "| 2 |", "| 3 |", "| 130 |"):
        assert code in text


def test_links_between_pages_lead_somewhere():
    pages = [*DOCS.glob("*.md"), ROOT / "README.md"]
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
