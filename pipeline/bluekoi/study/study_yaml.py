"""study.yaml as a checked `StudySettings`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml
from pydantic import TypeAdapter, ValidationError

from ..data.strict_yaml import load_yaml_without_duplicates
from ..errors import InputIssue, input_error, unreadable_reason
from ..files import read_text
from .setup import ImageSize, StudySettings
from .validation_messages import issues_of_refused_values, shortened_repr

MAX_YAML_BYTES = 250_000
READ_ERRORS = (OSError, UnicodeDecodeError, yaml.YAMLError, ValueError, RecursionError)


def read_study_settings(path: Path, findings: list[InputIssue]) -> StudySettings | None:
    """The setup in a study.yaml; None if something is wrong, with the errors in `findings`."""
    content = _yaml_content(path, findings)
    if content is None:
        return None
    try:
        return StudySettings.model_validate(content)
    except ValidationError as error:
        findings.extend(issues_of_refused_values(str(path), error, StudySettings))
    except RecursionError:
        findings.append(InputIssue(str(path), "", "values nested without end", "plain yaml"))
    return None


def lacks_pool_corners(path: Path) -> bool:
    """Whether a study.yaml that can be read says nothing yet of where the pool's corners are."""
    content = _yaml_content(path, [])
    camera = content.get("camera") if content is not None else None
    given = camera if isinstance(camera, dict) else {}
    known = ("pool_corners_px", "homography")
    return content is not None and all(given.get(name) is None for name in known)


def stated_image_size_px(path: Path) -> tuple[int, int] | None:
    """The image_size_px of a study.yaml that may be incomplete; None where it says nothing.

    Raises: InputError where it is no size.
    """
    content = _yaml_content(path, []) or {}
    camera = content.get("camera")
    given = camera.get("image_size_px") if isinstance(camera, dict) else None
    try:
        return TypeAdapter(ImageSize | None).validate_python(given)
    except ValidationError as error:
        raise input_error(
            path, "camera.image_size_px", shortened_repr(given), "width and height in pixels"
        ) from error


def _yaml_content(path: Path, findings: list[InputIssue]) -> dict[str, Any] | None:
    try:
        content = load_yaml_without_duplicates(read_text(path, MAX_YAML_BYTES))
    except FileNotFoundError:
        other = path.with_suffix(".yml")
        remedy = f"Rename {other.name} to {path.name}." if other.is_file() else ""
        findings.append(
            InputIssue(str(path), "", "no such file", "a study.yaml in the study folder", remedy)
        )
        return None
    except READ_ERRORS as error:
        found = f"no readable yaml ({unreadable_reason(error)})"
        findings.append(InputIssue(str(path), "", found, "yaml in UTF-8"))
        return None
    if not isinstance(content, dict):
        found = "an empty file" if content is None else shortened_repr(content)
        findings.append(InputIssue(str(path), "", found, "keys pool, robot, camera and others"))
        return None
    return content
