"""The configuration, checked against config/schema.yaml."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml
from jsonschema import Draft202012Validator, ValidationError

from ..errors import InputError, InputIssue, did_you_mean


def check_settings(config: Mapping[str, Any], schema_path: Path) -> dict[str, Any]:
    """The configuration as a plain dict.

    Raises: InputError with every key that the schema does not know, misses, or wants otherwise.
    """
    schema = yaml.safe_load(schema_path.read_text(encoding="utf-8"))
    content = dict(config)
    errors = Draft202012Validator(schema).iter_errors(content)
    findings = [finding for error in errors for finding in _issues_of_validation_error(error)]
    if findings:
        raise InputError(findings)
    return content


def _issues_of_validation_error(error: ValidationError) -> Iterator[InputIssue]:
    place = ".".join(map(str, error.absolute_path))
    if error.validator == "additionalProperties":
        known = list(error.schema["properties"])
        for key in sorted(set(error.instance) - set(known)):
            where = f"{place}.{key}" if place else key
            remedy = did_you_mean(str(key), known)
            yield InputIssue("configuration", where, "an unknown key", "a known key", remedy)
        return
    entry = error.schema
    wanted = entry.get("enum") or entry.get("type") or "what config/schema.yaml says"
    kind = " or ".join(map(repr, wanted)) if isinstance(wanted, list) else f"a {wanted}"
    meaning = " ".join(entry.get("description", "").split())
    yield InputIssue("configuration", place, repr(error.instance), kind, meaning)
