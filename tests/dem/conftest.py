"""Fixtures shared by the tests of several kernels."""

from collections.abc import Iterator

import pytest

from verification.reference import body_cundall


@pytest.fixture
def enable_cundall_scheme_for_3d_bodies() -> Iterator[None]:
    """Let 3-D bodies use Cundall's scheme during a test, from the reference implementation in `verification`."""
    with body_cundall.allow_cundall_scheme_for_bodies():
        yield
