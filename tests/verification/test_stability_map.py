"""The map of stability: small enough for a page, however many its cases, and the same bytes each time."""

from pathlib import Path

import numpy as np
import pandas as pd

from verification.stability.checks import Ending
from verification.stability.figures import draw_map
from verification.stability.maps import GROUPS


def test_a_map_of_twenty_thousand_cases_stays_small(tmp_path: Path) -> None:
    random = np.random.Generator(np.random.PCG64(3))
    rows = {group: 10.0 ** random.uniform(-3.0, 0.0, 20_000) for group in GROUPS}
    rows["ending"] = random.choice([Ending.RIGHT, Ending.AT_REST, Ending.UNSTABLE, Ending.OVER_BUDGET], 20_000)
    rows["damping"][:5] = np.nan
    for name in ("one", "two"):
        draw_map(pd.DataFrame(rows), tmp_path / f"{name}.svg")
    made = (tmp_path / "one.svg").read_bytes()
    assert made == (tmp_path / "two.svg").read_bytes()
    assert len(made) < 400_000, "the worst that the map can be: four colours without any order"
