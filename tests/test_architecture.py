"""Architecture: list of modules, Snakemake rules, layers and stages agree in names and order."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

import bluekoi
from bluekoi.workflow.provenance import PACKAGE_FOLDER, source_files, source_fingerprint
from bluekoi.workflow.stage_call import stage_names

ROOT = PACKAGE_FOLDER.parents[1]
SNAKEFILE = (ROOT / "Snakefile").read_text(encoding="utf-8")
MODULES = {
    path.stem if path.is_file() else path.name
    for path in PACKAGE_FOLDER.iterdir()
    if (path.suffix == ".py" or (path / "__init__.py").is_file()) and path.stem[:2] != "__"
}


def contents() -> list[str]:
    """Modules as the package's table of contents lists them, in its order."""
    flow, rest = bluekoi.__doc__.split("data, files, errors")
    top = re.findall(r"stages|workflow|cli", rest.splitlines()[2])
    return [
        *re.findall(r"^    (\w+) ", flow, re.M),
        "data",
        "files",
        "errors",
        "numba_settings",
        *top,
    ]


def rules() -> dict[str, str]:
    """Text of each rule by name, in the order of the Snakefile."""
    parts = re.split(r"^ *rule (\w+):\n", SNAKEFILE, flags=re.M)[1:]
    bodies = [re.split(r"^\S", body, maxsplit=1, flags=re.M)[0] for body in parts[1::2]]
    return dict(zip(parts[::2], bodies, strict=True))


def test_the_table_of_contents_lists_every_module_once():
    listed = contents()
    assert len(listed) == len(set(listed))
    assert set(listed) == MODULES


def test_contents_follow_the_layers_of_the_import_contract():
    contract = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]
    layers = [re.findall(r"\w+", line) for line in contract["contracts"][0]["layers"]]
    rank = {name: -i for i, names in enumerate(layers) for name in names}
    flow = [name for name in contents() if name in rank and name not in ("synthetic",)]
    flow = flow[: flow.index("data")]
    assert [rank[name] for name in flow] == sorted(rank[name] for name in flow)


def test_every_rule_is_a_stage_of_its_name_and_short():
    found = rules()
    for name, body in found.items():
        lines = [line for line in body.splitlines() if line.strip()]
        assert len(lines) < 15, f"rule {name} has {len(lines) + 1} lines"
        if name != "all":
            assert f"bluekoi stage {name} " in body
            assert "run:" not in body
            assert "log:" in body
    assert set(found) - {"all"} == set(stage_names())


def test_rules_stand_in_the_order_of_the_flow():
    names = [name for name in rules() if name in contents()]
    order = [contents().index(name) for name in names]
    assert order == sorted(order)


def test_stages_have_one_function_named_like_their_file():
    for name in stage_names():
        tree = ast.parse((PACKAGE_FOLDER / "stages" / f"{name}.py").read_text())
        functions = [node.name for node in tree.body if isinstance(node, ast.FunctionDef)]
        assert name in functions


def test_every_configuration_key_has_a_sentence_a_type_and_a_default():
    schema = yaml.safe_load((ROOT / "config/schema.yaml").read_text())
    default = yaml.safe_load((ROOT / "config/default.yaml").read_text())
    assert schema["additionalProperties"] is False
    assert list(schema["properties"]) == list(default) == schema["required"]
    for key, entry in schema["properties"].items():
        assert entry["description"].endswith("."), key
        assert "type" in entry, key


def test_a_fingerprint_follows_imports_inside_functions_and_whole_registries():
    found = source_files("stages.keypoints")
    assert "footage/frame_reading.py" in found  # imported in a function
    assert "keypoints/silhouette.py" in found  # a source: the folder is the registry
    assert "smoothing/linear_gaussian.py" not in found
    assert "camera/pool_projection.py" in source_files("stages.tracks")


def test_the_fingerprint_of_one_figure_leaves_the_others_out():
    others = {path.stem for path in (PACKAGE_FOLDER / "figures").glob("*.py")} - {
        "__init__",
        "fig3",
    }
    found = source_files("stages.figure", "figures.fig3")
    assert "figures/fig3.py" in found
    assert "figures/drawing/style.py" in found
    assert not [name for name in others if f"figures/{name}.py" in found]


@pytest.mark.parametrize("stage", stage_names())
def test_a_fingerprint_changes_with_a_file_it_covers(stage, tmp_path, monkeypatch):
    import shutil

    from bluekoi.workflow import provenance

    copy = tmp_path / "bluekoi"
    shutil.copytree(PACKAGE_FOLDER, copy, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(provenance, "PACKAGE_FOLDER", copy)
    assert source_fingerprint(f"stages.{stage}") == (
        before := source_fingerprint(f"stages.{stage}")
    )
    covered = copy / source_files(f"stages.{stage}")[-1]
    covered.write_text(covered.read_text() + "\n# changed\n")
    provenance._hash_and_imports.cache_clear()
    assert source_fingerprint(f"stages.{stage}") != before


def test_files_are_short_enough_to_read_in_one_go():
    long = {
        str(path.relative_to(ROOT)): len(path.read_text().splitlines())
        for path in PACKAGE_FOLDER.rglob("*.py")
        if len(path.read_text().splitlines()) > 300
    }
    assert long == {}


def test_compiled_functions_are_declared_by_the_njit_that_knows_the_vectors():
    direct = re.compile(r"^(?:import numba|from numba import .*\bnjit\b)", re.M)
    found = {path.name for path in PACKAGE_FOLDER.rglob("*.py") if direct.search(path.read_text())}
    assert found == {"numba_settings.py"}


def test_all_modules_compile_for_the_same_vectors():
    """Else what one stage has compiled is compiled again for the next."""
    program = (
        "import importlib, sys; importlib.import_module('bluekoi.' + sys.argv[1]);"
        "from numba.core.registry import cpu_target as t;"
        "print(t.target_context.codegen().magic_tuple())"
    )
    said = {
        subprocess.run([sys.executable, "-c", program, module], capture_output=True, text=True,
                       check=True).stdout
        for module in ("synthetic.raster", "keypoints.silhouette", "smoothing", "mismatch")
    }  # fmt: skip
    assert len(said) == 1


def test_every_file_of_the_package_is_installed_with_it():
    """`pip install .` takes what package-data names; a template left out breaks the first fit."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    patterns = project["package-data"]["bluekoi"]
    named = {path for pattern in patterns for path in PACKAGE_FOLDER.glob(pattern)}
    other = {
        path
        for path in PACKAGE_FOLDER.rglob("*")
        if path.is_file() and path.suffix != ".py" and "__pycache__" not in path.parts
    }
    assert other - named == set()
    assert all((path.parent / "__init__.py").is_file() for path in PACKAGE_FOLDER.rglob("*.py"))


def test_tests_assert():
    silent = [
        f"{path.name}::{node.name}"
        for path in Path(__file__).parent.glob("test_*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.FunctionDef)
        and node.name.startswith("test_")
        and not re.search(r"\bassert|raises\(|assert_", ast.unparse(node))
    ]
    assert silent == []


@pytest.mark.parametrize("writable", [True, False])
def test_compiled_code_of_a_read_only_installation_is_kept_in_the_named_cache(tmp_path, writable):
    code = (
        f"import os; os.access = lambda *_: {writable};"
        "from bluekoi.fitting.recursion import fill_log_likelihoods as f; print(f.stats.cache_path)"
    )
    env = {k: v for k, v in os.environ.items() if not k.startswith("NUMBA_")}
    found = subprocess.run(
        [sys.executable, "-P", "-c", code], env=env | {"BLUEKOI_CACHE": str(tmp_path)},
        capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    assert found.startswith(str(tmp_path / "numba")) is not writable
