"""Scores of criteria against counts made by hand."""

import numpy as np
import pytest
import xarray as xr

from overturning.statistics.criteria import criteria_scores, score
from overturning.statistics.limits import CRITERIA
from overturning.units import STANDARD_GRAVITY


def test_score_by_hand() -> None:
    found = score([1, 1, 0, 0, 1], [1, 0, 1, 0, 1])
    assert (found.hits, found.misses, found.false_alarms, found.rejections) == (2, 1, 1, 1)
    assert found.hit_rate == pytest.approx(2 / 3)
    assert found.skill == pytest.approx(2 / 3 - 1 / 2)
    assert found.right == pytest.approx(3 / 5)


def test_what_falls_by_wests_formula_is_foretold_by_it() -> None:
    azimuth, slender = np.arange(0, 180, 20), np.array([0.1, 0.2, 0.3, 0.4])
    pga = STANDARD_GRAVITY * np.linspace(0.05, 0.45, azimuth.size)
    falls = pga[:, None] >= STANDARD_GRAVITY * slender
    events = list("abcdefgh")
    cube = xr.Dataset(
        {
            "overturned": (
                ("record", "azimuth", "height", "b_over_h", "friction"),
                np.tile(falls.astype(float)[None, :, None, :, None], (8, 1, 2, 1, 1)),
            ),
            "event": ("record", events),
        },
        {"azimuth": azimuth, "height": [0.6, 1.2], "b_over_h": slender, "friction": [1.0]},
    )
    peaks = {
        name: (("record", "azimuth"), np.tile(values, (8, 1))) for name, values in (("pga", pga), ("pgv", pga / 30))
    }
    found = criteria_scores(cube, xr.Dataset(peaks, {"azimuth": azimuth}))
    assert found is not None
    names = [one.name for one in CRITERIA]
    assert found.overall[names.index("West")].skill == pytest.approx(1.0)
    assert found.interval[names.index("West")] == pytest.approx((1.0, 1.0))
    assert all(one.skill < 1 for one in found.overall[1:])
    assert found.falls[0.6, 0.1] == pytest.approx(falls[:, 0].mean())
    assert len(found.blocks) == 8
