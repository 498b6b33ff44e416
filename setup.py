"""Takes the Snakefile and config/ along into the installed package; all else: pyproject.toml."""

import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

ROOT = Path(__file__).resolve().parent


class BuildWithWorkflow(build_py):
    """The package's files, and the workflow beside them, where `bluekoi run` finds it."""

    def run(self) -> None:
        """Copy after the package's own files; an editable install uses those of the checkout."""
        super().run()
        if not self.editable_mode:
            home = Path(self.build_lib) / "bluekoi" / "workflow" / "files"
            shutil.copytree(ROOT / "config", home / "config", dirs_exist_ok=True)
            shutil.copy2(ROOT / "Snakefile", home / "Snakefile")


setup(cmdclass={"build_py": BuildWithWorkflow})
