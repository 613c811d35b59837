"""Share of the ensemble's spread that the relief explains, against simulated runs with known shares."""

import numpy as np
import pytest

from overturning.findings.relief import variance_between_halves


@pytest.mark.parametrize(("low", "high"), [(0.9, 0.1), (0.5, 0.5), (0.7, 0.4)])
def test_variance_components_are_unbiased(low: float, high: float) -> None:
    """24 runs of many cells: between (p₁ − p₀)²/4, in total p (1 − p)."""
    generator = np.random.default_rng(5)
    shares = [generator.binomial(12, share, 40_000) / 12 for share in (low, high)]
    between, total = variance_between_halves(*shares, np.full(40_000, 24.0))
    mean = 0.5 * (low + high)
    assert between.mean() == pytest.approx(0.25 * (low - high) ** 2, abs=1e-3)
    assert total.mean() == pytest.approx(mean * (1.0 - mean), abs=2e-3)
