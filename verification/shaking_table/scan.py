"""Prediction of the shaking-table tests from the scan of the boulder: one fitted number, its orientation on the table.

The design is fixed before any score is known: two largest heights of bearing points, 24 orientations, one friction.
"""

import hashlib
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.numerics import NumericalOptions
from overturning.dem.run import simulate_cases
from overturning.errors import ResultError
from overturning.files import atomic_write
from overturning.model.body import Body
from overturning.model.cases import Cases
from overturning.model.contact import VertexContact
from overturning.model.mesh import read_mesh_surface
from overturning.model.scan import ScannedStone, stone_in_nearest_stable_pose_from_surface
from overturning.model.surface import repair_surface_and_close_base
from verification.shaking_table.data import ShakingTableTests
from verification.shaking_table.models import TestIndices

BOULDER_SCAN_FILE_NAME: Final = "SP1.ply"
"""Closed scan of the boulder. The scan of its second placement has no faces, and shows the same stone and face."""

BOULDER_ORIENTATIONS_DEG: Final = np.arange(0.0, 360.0, 15.0)
"""Orientations on the table, degrees."""

SIMULATED_BASE_RELIEFS_M: Final = (0.0033, 0.002236)
"""Reliefs under the base, m: the upper quartile and the middle of the range of 1 to 5 mm on a logarithmic scale.

Smaller ones take ten times as many steps; they were left out for that reason, before any score was computed.
"""

EXTRA_BASE_RELIEF_OUTSIDE_PREDICTION_M: Final = 0.001
"""Relief that is compared with the others, m, but is not part of the prediction: it was run after the scores."""

BOULDER_FRICTION: Final = 0.7
"""Middle of the range of the other models."""

STATIC_PENETRATION_TO_WIDTH_RATIO: Final = 1e-5
"""δ/B of the contact; that of the package's default takes four times as many steps."""

HULL_TOLERANCE_TO_SIZE_RATIO: Final = 0.016
"""Simplification of the outline above the footprint, as a share of the size: about 20 points can touch."""

WEIGHT_BY_ORIENTATION_INDEX_OFFSET: Final = {-1: 0.25, 0: 0.5, 1: 0.25}
"""Weights of neighbouring orientations: the boulder's own lies anywhere between two of them."""


def read_scanned_boulder(folder: Path) -> ScannedStone:
    """Read the scan of the boulder; raise a `ResultError` if the file is missing."""
    path = folder / BOULDER_SCAN_FILE_NAME
    if not path.is_file():
        raise ResultError(f"{folder}: no {BOULDER_SCAN_FILE_NAME}; for its source see docs/shaking-table.md")
    scan = stone_in_nearest_stable_pose_from_surface(
        *repair_surface_and_close_base(read_mesh_surface(path, "m")), "boulder", SIMULATED_BASE_RELIEFS_M[0]
    )
    assert isinstance(scan.shape, ScannedStone)
    tilt_deg = scan.rotation_to_stable_pose.scan_tilt_from_stable_pose_deg
    print(f"{path.name}: {scan.volume_m3:.4f} m³, tilted by {tilt_deg:.2f}° into its nearest stable pose")
    return scan.shape


def boulder_with_max_bearing_point_height(stone: ScannedStone, max_bearing_point_height_m: float) -> ScannedStone:
    """Return the boulder with a limit to the height of its bearing points, and with the hull tolerance of this study.

    Points of the base up to `max_bearing_point_height_m` (m) above its lowest points bear load.
    """
    return ScannedStone(
        stone.vertices,
        stone.centre_of_mass,
        stone.inertia_moments_and_products_per_mass,
        max_bearing_point_height_m,
        stone.name,
        HULL_TOLERANCE_TO_SIZE_RATIO,
    )


def simulate_falls_of_boulder_by_orientation(
    stone: ScannedStone,
    tests: ShakingTableTests,
    cache_folder: Path,
    threads: int = 1,
    max_bearing_point_heights_m: tuple[float, ...] = SIMULATED_BASE_RELIEFS_M,
) -> NDArray[np.bool_]:
    """Simulate the scanned boulder in every test and orientation, with each choice of bearing points of its base.

    Points bear load up to a height above the lowest points of the base (`max_bearing_point_heights_m`, m). The outcomes
    for each height are stored in `cache_folder`. They are read again if stone, orientations, motions, friction and
    contact are the same.

    Returns
    -------
    ndarray of bool, shape (heights, tests, orientations)
        True where the boulder falls; False where it stands or its outcome is unknown.
    """
    made = []
    for relief in max_bearing_point_heights_m:
        own = boulder_with_max_bearing_point_height(stone, relief)
        key = hashlib.sha256(
            own.unscaled_solid.contact_points_from_centre_of_mass.tobytes()
            + own.unscaled_solid.inertia_per_mass.tobytes()
        )
        key.update(
            repr((BOULDER_ORIENTATIONS_DEG.tolist(), BOULDER_FRICTION, STATIC_PENETRATION_TO_WIDTH_RATIO)).encode()
        )
        key.update(b"".join(one.tobytes() for one in tests.accelerations))
        path = cache_folder / f"scan-{1000 * relief:g}-mm-{key.hexdigest()[:16]}.npy"
        if not path.is_file():
            fell = _fall_outcomes_by_test_and_orientation(own, tests, threads)
            with atomic_write(path) as part, part.open("wb") as file:
                np.save(file, fell)
        made.append(np.load(path))
    return np.array(made) == 1


def _fall_outcomes_by_test_and_orientation(
    stone: ScannedStone, tests: ShakingTableTests, threads: int
) -> NDArray[np.int8]:
    """Return the outcomes of a boulder, shape (tests, orientations): 1 fell, 0 stood, −128 unknown."""
    body = Body(stone, VertexContact(static_penetration=STATIC_PENETRATION_TO_WIDTH_RATIO))
    cases = Cases(BOULDER_ORIENTATIONS_DEG, stone.unscaled_height, 0.1, BOULDER_FRICTION)

    def fall_outcomes_by_orientation(test_index: int) -> NDArray[np.int8]:
        """Return the outcome of one test for each orientation: 1 fell, 0 stood, −128 unknown."""
        return np.asarray(
            simulate_cases(body, tests.measured_motion(test_index), cases, NumericalOptions()).overturned, np.int8
        )

    begin, rows = time.monotonic(), []
    with ThreadPoolExecutor(threads) as pool:
        for index, row in enumerate(pool.map(fall_outcomes_by_orientation, range(len(tests.accelerations)))):
            rows.append(row)
            if (index + 1) % 49 == 0:
                spent = time.monotonic() - begin
                print(
                    f"relief {1000 * stone.max_load_bearing_base_point_height_m:g} mm: {index + 1} tests, {spent:.0f} "
                    f"s",
                    flush=True,
                )
    return np.array(rows)


def smoothed_fall_probability_by_orientation_and_test(
    fell_by_load_bearing_height_test_orientation: NDArray[np.bool_],
) -> FloatArray:
    """Return the probability of a fall in each test for each orientation, shape (orientations, tests).

    The probability is the share of falls over all heights of bearing points, averaged with weights over the orientation
    and its two neighbours. Half a fall and half a stand are added, so that all likelihoods are finite.
    """
    count = len(fell_by_load_bearing_height_test_orientation)
    falls = np.sum(
        [
            weight * np.roll(fell_by_load_bearing_height_test_orientation, -step, axis=2).sum(axis=0)
            for step, weight in WEIGHT_BY_ORIENTATION_INDEX_OFFSET.items()
        ],
        axis=0,
    )
    return np.asarray((falls.T + 0.5) / (count + 1.0))


def index_of_most_likely_orientation(
    smoothed_fall_probability_by_orientation_and_test: FloatArray,
    fell_by_test: NDArray[np.bool_],
    learning_tests: TestIndices,
) -> int:
    """Return the index of the orientation that best predicts the outcomes of the tests to learn from."""
    p, y = smoothed_fall_probability_by_orientation_and_test[:, learning_tests], fell_by_test[learning_tests]
    return int(np.argmax(np.where(y, np.log(p), np.log1p(-p)).sum(axis=1)))


def splits_into_halves_of_motions(tests: ShakingTableTests) -> Iterator[tuple[TestIndices, TestIndices]]:
    """Yield two splits of the tests into halves: learn from one half and predict the other, and the reverse.

    Motions, sorted by name, alternate between the halves; all tests of a motion are in the same half.
    """
    names, member = np.unique(tests.played_record_names, return_inverse=True)
    first = np.arange(names.size)[member] % 2 == 0
    yield np.flatnonzero(first), np.flatnonzero(~first)
    yield np.flatnonzero(~first), np.flatnonzero(first)
