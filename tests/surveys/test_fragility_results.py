"""Fragility curves in a file: read only if they were fitted to the same numbers."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from overturning.statistics.bootstrap import ConfidenceInterval
from overturning.statistics.fragility import FittedFragilityCurve
from overturning.surveys import fragility_results
from overturning.surveys.fragility_results import fit_or_read_fragility_curves, write_fragility_curves

STORED_CURVES = [
    FittedFragilityCurve(
        "all stones", "PGA", "g", 1 / 3, 0.1 + 0.2, ConfidenceInterval(1e-300, math.inf), 0.1, 2.0, 0.7
    ),
    FittedFragilityCurve("B/H up to 0.4", "PGV", "cm/s", math.nan, math.nan, ConfidenceInterval(), 1.0, 99.0),
]


@pytest.fixture
def fall_rates_and_intensities_with_stub_fit(monkeypatch: pytest.MonkeyPatch) -> tuple[xr.Dataset, xr.Dataset]:
    """Return fall rates and intensities of two records, and replace the fitting of curves by a stub.

    The stub returns no curves, so that a test notices if curves are fitted again.
    """
    monkeypatch.setattr(fragility_results, "fit_population_fragility_curves", lambda *_: [])
    rates = xr.Dataset(
        {
            "free_fall_rate": (("record", "amplitude"), [[0.2], [math.nan]]),
            "class_rate": (("record", "amplitude", "stones"), np.full((2, 1, 1), 0.3)),
            "unknown": (("record", "amplitude"), [[0.0], [1.0]]),
            "class_unknown": (("record", "amplitude", "stones"), np.zeros((2, 1, 1))),
            "members": ("stones", [64]),
        },
        {"stones": ["B/H up to 0.4"], "event": ("record", ["a 1995", "b 1999"]), "amplitude": [1.0]},
        {"members": 64, "period": (1.0,)},
    )
    measures = {name: (("record", "percentile"), [[3.0], [4.0]]) for name in ("pga_rotd", "pgv_rotd", "psa_rotd")}
    return rates, xr.Dataset(measures)


def test_stored_fragility_curves_are_read_back_bit_for_bit(
    fall_rates_and_intensities_with_stub_fit: tuple[xr.Dataset, xr.Dataset], tmp_path: Path
) -> None:
    path = tmp_path / "curves.json"
    write_fragility_curves(STORED_CURVES, *fall_rates_and_intensities_with_stub_fit, path)
    read = fit_or_read_fragility_curves(*fall_rates_and_intensities_with_stub_fit, path)
    assert repr(read) == repr(STORED_CURVES), "NaN and infinity, too"
    assert read[0].median_interval.high == math.inf


@pytest.mark.parametrize("change", ["fall rate", "event", "period", "intensity", "sources", "damaged", "gone"])
def test_fragility_curves_are_fitted_again_if_their_input_changed(
    fall_rates_and_intensities_with_stub_fit: tuple[xr.Dataset, xr.Dataset],
    tmp_path: Path,
    change: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path = tmp_path / "curves.json"
    write_fragility_curves(STORED_CURVES, *fall_rates_and_intensities_with_stub_fit, path)
    rates, measures = (one.copy(deep=True) for one in fall_rates_and_intensities_with_stub_fit)
    if change == "fall rate":
        rates["free_fall_rate"][0, 0] = np.nextafter(0.2, 1.0)
    elif change == "event":
        rates["event"][0] = "b 1999"
    elif change == "period":
        rates.attrs["period"] = (2.0,)
    elif change == "intensity":
        measures["pgv_rotd"][1, 0] = 4.5
    elif change == "sources":
        monkeypatch.setattr(fragility_results, "package_source_hash", lambda *_: "another version")
    elif change == "damaged":
        path.write_text(json.dumps({"curves": []}), encoding="utf-8")
    else:
        path.unlink()
    assert fit_or_read_fragility_curves(rates, measures, path) == []
