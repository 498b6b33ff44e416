"""Figures of a run, their titles and fingerprints, from their source files without running them."""

from __future__ import annotations

import ast

from .provenance import PACKAGE_FOLDER, source_fingerprint


def figure_names() -> list[str]:
    """Names of the figures: the modules of pipeline/bluekoi/figures."""
    names = (path.stem for path in (PACKAGE_FOLDER / "figures").glob("*.py"))
    return sorted(name for name in names if not name.startswith("_"))


def figure_fingerprint(name: str) -> str:
    """Fingerprint of one figure's own file and of what it draws with."""
    return source_fingerprint("stages.figure", f"figures.{name}")


def figure_title_and_caption(name: str) -> dict[str, str]:
    """Title and caption of a figure, read from its file without running it."""
    texts = {
        node.targets[0].id: node.value
        for node in ast.parse((PACKAGE_FOLDER / f"figures/{name}.py").read_bytes()).body
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name)
    }
    return {
        name: ast.literal_eval(texts[f"FIGURE_{name.upper()}"]) for name in ("title", "caption")
    }
