"""What tests of several kernels share."""

from collections.abc import Iterator

import pytest

from verification.reference import body_cundall


@pytest.fixture
def both_schemes_in_space() -> Iterator[None]:
    with body_cundall.in_use():
        yield
