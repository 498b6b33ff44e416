"""Tests of the generators take minutes of compilation and do not concern the product."""

from __future__ import annotations

import pytest


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests of the generators as long: they run by `make test-long`."""
    for item in items:
        if item.path.name.startswith("test_generator_"):
            item.add_marker(pytest.mark.long)
