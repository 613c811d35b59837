"""``python -m verification.scene_peers``: fall directions of a stacked grave in other engines, for the tests.

The script needs pymunk and Box2D (dependency group `peers`). The tests do not: they compare the general kernel with the
table that this script writes. Both engines run at 1/960 s with 30 iterations (at 1/240 s one in ten results differs),
for a sample of slendernesses, frictions and azimuths under five of the default records.
"""

from typing import Final

import numpy as np
import pandas as pd

from overturning.errors import ArgumentError
from overturning.model.cases import Cases
from overturning.model.geometry import reference_element_height_and_b_over_h
from overturning.model.scene import load_scene
from verification.engines import SCENE_ENGINES, installed_engines
from verification.inputs import CaseGroup, read_strong_part_of_pulse_record
from verification.scenes import fall_sides_of_shaft
from verification.tables import RESULT_TABLE_FOLDER, ROOT, write_csv

ENGINE_OUTCOMES_FILE: Final = RESULT_TABLE_FOLDER / "three-tier-peers.csv"
PULSE_RECORD_NUMBERS: Final = (6, 7, 8, 9, 10)
CASE_COUNT_PER_RECORD: Final = 24
ENGINE_TIME_STEP_S: Final = 1.0 / 960.0


def choose_random_three_tier_cases() -> pd.DataFrame:
    """Return record, azimuth (degrees), B/H of the shaft and µ of random cases, with a fixed seed."""
    generator = np.random.Generator(np.random.PCG64(3))
    rows = [
        (
            number,
            float(generator.integers(0, 360)),
            float(generator.choice([0.2, 0.25, 0.3, 0.35])),
            float(generator.choice([0.5, 0.7, 1.0])),
        )
        for number in PULSE_RECORD_NUMBERS
        for _ in range(CASE_COUNT_PER_RECORD)
    ]
    return pd.DataFrame(rows, columns=["record", "azimuth_deg", "b_over_h", "friction"])


def fall_sides_of_shaft_by_engine(cases: pd.DataFrame) -> dict[str, np.ndarray]:
    """Return the sides to which the shaft falls in each case, by installed engine."""
    scene = load_scene("three-tier", ROOT)
    height, _ = reference_element_height_and_b_over_h(scene)
    groups = [
        CaseGroup(
            read_strong_part_of_pulse_record(number),
            Cases(rows["azimuth_deg"], height, rows["b_over_h"], rows["friction"]),
        )
        for number in PULSE_RECORD_NUMBERS
        if (rows := cases[cases["record"] == number]).size
    ]
    return {
        name.lower(): np.concatenate(
            [fall_sides_of_shaft(engine, scene, group, ENGINE_TIME_STEP_S) for group in groups]
        )
        for name, engine in installed_engines(SCENE_ENGINES).items()
    }


def main() -> None:
    """Write the table of the sides to which the shaft of the three-tier grave falls in pymunk and Box2D."""
    cases = choose_random_three_tier_cases()
    found = fall_sides_of_shaft_by_engine(cases)
    if len(found) < 2:
        raise ArgumentError("both engines are needed: make peers")
    write_csv(cases.assign(pymunk=found["pymunk"], box2d=found["box2d"]), ENGINE_OUTCOMES_FILE)


if __name__ == "__main__":
    main()
