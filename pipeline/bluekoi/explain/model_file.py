"""A model from a python file. The file is run: load only models that you would run yourself."""

from __future__ import annotations

import hashlib
import importlib.util
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

from ..errors import InputError, input_error
from .checks import refuse_invalid_model
from .model import Model

MODEL_VARIABLE = "MODEL"
"""Variable of a model file that holds the model."""


def load_model(path: Path) -> Model:
    """The `MODEL` of a python file, checked; modules beside the file may be imported by it.

    Raises: InputError where the file cannot be run or holds no usable model.
    """
    if not path.is_file() or path.suffix != ".py":
        what = "no such file" if not path.is_file() else f"a {path.suffix or 'suffix-less'} file"
        raise input_error(path, "", what, "a python file that defines MODEL")
    module = _import_file(path.resolve())
    found = getattr(module, MODEL_VARIABLE, None)
    if not isinstance(found, Model):
        what = type(found).__name__ if hasattr(module, MODEL_VARIABLE) else "no such name"
        remedy = "See docs/own_models.md for an example."
        raise input_error(path, MODEL_VARIABLE, what, "MODEL = Model(...)", remedy)
    refuse_invalid_model(found)
    return found


def _import_file(path: Path) -> ModuleType:
    """The module of a file; as part of its package where its folder is one."""
    root = path.parent
    while (root / "__init__.py").exists():
        root = root.parent
    if root != path.parent:
        return _import_from_package(path, root)
    digest = hashlib.sha256(str(path).encode()).hexdigest()[:12]
    name = f"bluekoi_model_{''.join(c if c.isalnum() else '_' for c in path.stem)}_{digest}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise input_error(path, "", "a file that python cannot load", "a python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    with _folder_on_import_path(path, path.parent):
        spec.loader.exec_module(module)
    return module


def _import_from_package(path: Path, root: Path) -> ModuleType:
    """A module of a package whose parent folder is `root`."""
    name = ".".join(path.relative_to(root).with_suffix("").parts)
    with _folder_on_import_path(path, root):
        module = importlib.import_module(name)
    if Path(str(module.__file__)).resolve() != path:
        raise input_error(path, "", f"another module of the name {name}: {module.__file__}",
                          "a package of a name of its own")  # fmt: skip
    return module


@contextmanager
def _folder_on_import_path(path: Path, root: Path) -> Iterator[None]:
    """With a folder on the import path; an error in the file names the file and its line."""
    sys.path.insert(0, str(root))
    try:
        yield
    except InputError:
        raise
    except (Exception, SystemExit) as error:  # sys.exit would end the command without a word
        raise input_error(path, _error_line(error, path), f"{type(error).__name__}: {error}",
                          "a file that runs") from None  # fmt: skip
    finally:
        sys.path.remove(str(root))


def _error_line(error: BaseException, path: Path) -> str:
    """Where in the file an error was raised."""
    if isinstance(error, SyntaxError) and error.lineno:
        return f"line {error.lineno}"
    own = [f for f in traceback.extract_tb(error.__traceback__) if f.filename == str(path)]
    return f"line {own[-1].lineno}" if own else ""
