"""The longest tests first: with two processes, whole studies at the end would leave one of them idle."""

import pytest


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=lambda item: "workflow" not in item.path.parts)
