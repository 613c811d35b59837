"""Outcomes of 3-D stones under a candidate motion, on a grid of sizes: simulated, stored, or shipped."""

import hashlib
from collections.abc import Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Final

import numpy as np
import platformdirs
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.numerics import NumericalOptions
from overturning.dem.run import simulate_cases
from overturning.files import atomic_write
from overturning.model.cases import Cases
from overturning.study.sources import package_source_hash
from overturning.surveys.library import CandidateMotion

# Written out: the last digit of NumPy's geomspace differs between processors, and `SHIPPED_OUTCOMES_FILE` holds exact
# values.
SIMULATED_PGV_M_S: Final[FloatArray] = np.array([
    0.2, 0.25198420997897464, 0.3174802103936399, 0.4, 0.5039684199579493, 0.6349604207872799, 0.8000000000000002,
    1.0079368399158986, 1.2699208415745598, 1.6, 2.0158736798317975, 2.539841683149119, 3.2,
])  # fmt: skip
"""Peak velocities to which motions are scaled, in equal ratios, m/s."""

SIMULATED_HEIGHTS_M: Final[FloatArray] = np.array([0.3 * 1.5**step for step in range(10)])
"""Simulated heights, m; outcomes are interpolated between them."""

SIMULATED_B_OVER_H: Final[FloatArray] = np.array([
    0.08, 0.09550213133715489, 0.11400821362423984, 0.13610034238820712, 0.16247340967237883, 0.19395696136658624,
    0.23154128997734005, 0.2764085835673776, 0.3299701106321081, 0.3939106105365391, 0.47024128578199303,
    0.5613630629363063, 0.6701421120546335, 0.8,
])  # fmt: skip
"""Simulated B/H, in equal ratios."""

SIMULATED_D_OVER_B: Final = (1.0, 1.4, 2.0, 2.8, 4.0)
"""Simulated D/B of rectangular stones, D the broader side; the nearest value is used."""

SIMULATED_FRICTIONS: Final = (0.45, 0.65, 0.9)
"""Simulated friction coefficients, with equal probability, as friction is not known."""

ORIENTATION_STEP_DEG: Final = 15
"""Step of the face azimuth of rectangular stones relative to the motion, degrees; the nearest value is used."""

DIRECTION_BIN_WIDTH_DEG: Final = 5
"""Width of a direction bin of falls, degrees."""

DIRECTION_BIN_COUNT: Final = 360 // DIRECTION_BIN_WIDTH_DEG
STANDING_OUTCOME_INDEX: Final = DIRECTION_BIN_COUNT
"""Index of standing, after the direction bins."""
UNKNOWN_OUTCOME_INDEX: Final = DIRECTION_BIN_COUNT + 1

SHIPPED_OUTCOMES_FILE: Final = Path(__file__).with_name("library-outcomes.npz")
"""Outcomes under the motions of the package, for stones of the heights of gravestones.

`verification/library_outcomes.py` computes the file. `grid` is the text of
`simulated_grid_text_to_detect_outdated_files`, `motions` has a row of `identifying_numbers_of_motion` for each motion.
For each D/B, written as ``:g``, ``sizes D/B`` has indices into `SIMULATED_HEIGHTS_M` and `SIMULATED_B_OVER_H`, shape
(sizes, 2), and ``outcomes D/B`` the outcomes, shape (motions, sizes, frictions, levels, orientations).
"""


def simulated_grid_text_to_detect_outdated_files() -> str:
    """Return the grid of simulated sizes, frictions, levels and orientations as text, to detect outdated files."""
    grid = (
        DIRECTION_BIN_WIDTH_DEG,
        SIMULATED_PGV_M_S.tolist(),
        SIMULATED_FRICTIONS,
        SIMULATED_HEIGHTS_M.tolist(),
        SIMULATED_B_OVER_H.tolist(),
        ORIENTATION_STEP_DEG,
    )
    return repr(grid)


def face_azimuths_to_simulate_for_d_over_b(d_over_b_or_0_if_round: float) -> FloatArray:
    """Return the face azimuths to simulate for a D/B, degrees from the motion's north, without symmetric repetitions.

    A round stone has the D/B 0.
    """
    return np.arange(
        0.0, 1 if d_over_b_or_0_if_round == 0.0 else 90 if d_over_b_or_0_if_round == 1.0 else 180, ORIENTATION_STEP_DEG
    )


def identifying_numbers_of_motion(candidate_motion: CandidateMotion) -> FloatArray:
    """Return six numbers of a motion: samples, sampling interval, PGA, PGV, azimuth of PGV, vertical PGA; shape (6,).

    Units are s, m/s², m/s and degrees. Unlike a hash, the numbers are nearly the same if a processor rounds
    differently.
    """
    one, motion = candidate_motion, candidate_motion.motion
    vertical = 0.0 if motion.up is None else float(np.abs(motion.up).max())
    return np.array(
        [
            motion.north.size,
            motion.sampling_interval,
            one.pga_m_s2,
            one.pgv_m_s,
            one.peak_velocity_azimuth_deg,
            vertical,
        ],
        np.float64,
    )


@cache
def _shipped_outcome_array(array_name_in_shipped_file: str) -> NDArray[np.generic]:
    """Return an array of `SHIPPED_OUTCOMES_FILE`, the file with simulated outcomes of stones in the package."""
    with np.load(SHIPPED_OUTCOMES_FILE) as stored:
        return np.asarray(stored[array_name_in_shipped_file])


@cache
def _d_over_b_texts_with_shipped_outcomes() -> frozenset[str]:
    """Return, as text, each D/B with simulated outcomes in the package; empty if their grid is an outdated one."""
    with np.load(SHIPPED_OUTCOMES_FILE) as stored:
        if str(stored["grid"]) != simulated_grid_text_to_detect_outdated_files():
            return frozenset()
        return frozenset(name.partition(" ")[2] for name in stored.files if name.startswith("sizes "))


def shipped_stone_outcomes_of_motion(
    candidate_motion: CandidateMotion, d_over_b_or_0_if_round: float
) -> dict[str, NDArray[np.int8]]:
    """Return the outcomes of stones with one D/B under a motion that are in the package; empty if there are none.

    The keys are ``height-B/H``, as indices into `SIMULATED_HEIGHTS_M` and `SIMULATED_B_OVER_H`.
    """
    if f"{d_over_b_or_0_if_round:g}" not in _d_over_b_texts_with_shipped_outcomes():
        return {}
    own, every = identifying_numbers_of_motion(candidate_motion), _shipped_outcome_array("motions")
    same = np.flatnonzero(np.isclose(every, own, rtol=1e-6, atol=0.0).all(axis=1))
    if same.size != 1:
        return {}
    outcomes = _shipped_outcome_array(f"outcomes {d_over_b_or_0_if_round:g}")[same[0]]
    sizes = _shipped_outcome_array(f"sizes {d_over_b_or_0_if_round:g}")
    return {f"{h}-{b}": one for (h, b), one in zip(sizes.tolist(), outcomes, strict=True)}


def stone_outcome_cache_folder() -> Path:
    """Return the user's cache folder for simulated outcomes of stones."""
    return Path(platformdirs.user_cache_dir("overturning")) / "responses"


def _stone_outcome_cache_path(
    candidate_motion: CandidateMotion, d_over_b_or_0_if_round: float, outcome_cache_folder: Path
) -> Path:
    """Return the path of the cache file for stones with one D/B under one motion.

    The file name is a hash of all inputs.
    """
    motion_text = f"{candidate_motion.samples_sha256} {candidate_motion.pgv_m_s}"
    inputs = f"{_source_hash_of_stone_outcomes()} {motion_text} {d_over_b_or_0_if_round}"
    key = hashlib.sha256(f"{inputs} {simulated_grid_text_to_detect_outdated_files()}".encode()).hexdigest()[:24]
    return outcome_cache_folder / f"{key}.npz"


def outcomes_of_needed_sizes(
    candidate_motion: CandidateMotion,
    d_over_b_or_0_if_round: float,
    mask_of_needed_heights_and_b_over_h: NDArray[np.bool_],
    outcome_cache_folder: Path,
    thread_count: int,
) -> dict[str, NDArray[np.int8]]:
    """Return the outcomes of stones with one D/B under a motion: from the package, from the cache, or simulated.

    The result has at least the sizes that are True in `mask_of_needed_heights_and_b_over_h`, shape (heights, B/H). Each
    key is ``height-B/H``, as indices of the mask. Each value is an array of outcomes, shape (frictions, peak velocities
    to which the motion is scaled, orientations of the stone): the direction bin of the fall, `STANDING_OUTCOME_INDEX`
    or `UNKNOWN_OUTCOME_INDEX`.
    """
    shipped = shipped_stone_outcomes_of_motion(candidate_motion, d_over_b_or_0_if_round)
    needed = [(h, b) for h, b in np.argwhere(mask_of_needed_heights_and_b_over_h).tolist() if f"{h}-{b}" not in shipped]
    return shipped | (
        load_or_simulate_outcomes(candidate_motion, d_over_b_or_0_if_round, needed, outcome_cache_folder, thread_count)
        if needed
        else {}
    )


def load_or_simulate_outcomes(
    candidate_motion: CandidateMotion,
    d_over_b_or_0_if_round: float,
    height_and_b_over_h_index_pairs: Sequence[tuple[int, int]],
    outcome_cache_folder: Path,
    thread_count: int,
) -> dict[str, NDArray[np.int8]]:
    """Load the outcomes of stones with one D/B under a motion from the cache folder, or simulate missing ones.

    Simulated outcomes are stored in the cache folder. Keys and shapes are those of `outcomes_of_needed_sizes`.
    """
    path, known = (
        _stone_outcome_cache_path(candidate_motion, d_over_b_or_0_if_round, outcome_cache_folder),
        dict[str, NDArray[np.int8]](),
    )
    try:
        with np.load(path) as stored:
            known = {name: stored[name] for name in stored.files}
    except FileNotFoundError:
        pass
    except Exception:  # a damaged archive raises various exceptions; its content is simulated again
        path.unlink(missing_ok=True)
    missing = [(h, b) for h, b in height_and_b_over_h_index_pairs if f"{h}-{b}" not in known]
    if missing:
        found = simulate_outcomes_of_sizes(candidate_motion, d_over_b_or_0_if_round, missing, thread_count)
        known |= {f"{h}-{b}": one for (h, b), one in zip(missing, found, strict=True)}
        # A cache that cannot be written costs time only.
        with suppress(OSError), atomic_write(path) as part, part.open("wb") as file:
            np.savez_compressed(file, allow_pickle=False, **known)
    return known


def size_keys_with_stored_outcomes(
    candidate_motion: CandidateMotion, d_over_b_or_0_if_round: float, outcome_cache_folder: Path
) -> set[str]:
    """Return the keys ``height-B/H`` (indices) of stone sizes with outcomes in the package or in the cache folder."""
    stored_names: list[str] = []
    # A damaged archive holds nothing.
    with (
        suppress(Exception),
        np.load(_stone_outcome_cache_path(candidate_motion, d_over_b_or_0_if_round, outcome_cache_folder)) as stored,
    ):
        stored_names = stored.files
    return {*stored_names, *shipped_stone_outcomes_of_motion(candidate_motion, d_over_b_or_0_if_round)}


@cache
def _source_hash_of_stone_outcomes() -> str:
    """Return a hash of the source files that affect simulated outcomes, so that an outdated cache is not used."""
    return package_source_hash("dem", "model", "motion", "surveys/stone_outcomes.py")


def simulate_outcomes_of_sizes(
    candidate_motion: CandidateMotion,
    d_over_b_or_0_if_round: float,
    height_and_b_over_h_index_pairs: Sequence[tuple[int, int]],
    thread_count: int,
) -> NDArray[np.int8]:
    """Simulate stones with one D/B at given pairs of height and B/H; return their outcomes.

    `height_and_b_over_h_index_pairs` are pairs of indices into `SIMULATED_HEIGHTS_M` and `SIMULATED_B_OVER_H`. Outcomes
    have shape (pairs, frictions, levels of the peak velocity, orientations of the stone).

    An outcome is the direction bin of the fall, `STANDING_OUTCOME_INDEX` or `UNKNOWN_OUTCOME_INDEX`.
    """
    axes = (
        np.arange(len(height_and_b_over_h_index_pairs)),
        np.array(SIMULATED_FRICTIONS),
        SIMULATED_PGV_M_S / candidate_motion.pgv_m_s,
        face_azimuths_to_simulate_for_d_over_b(d_over_b_or_0_if_round),
    )
    node, friction, amplitude, orientation = (values.ravel() for values in np.meshgrid(*axes, indexing="ij"))
    height, shape = (
        grid[np.array(height_and_b_over_h_index_pairs)[:, at]]
        for at, grid in enumerate((SIMULATED_HEIGHTS_M, SIMULATED_B_OVER_H))
    )
    node = node.astype(np.intp)
    cases = Cases(orientation, height[node], shape[node], friction, amplitude, aspect=max(d_over_b_or_0_if_round, 1.0))
    found = simulate_cases(
        "rectangle" if d_over_b_or_0_if_round else "circle",
        candidate_motion.motion,
        cases,
        NumericalOptions(threads=thread_count),
    )
    way = np.round(np.nan_to_num(found.fall_azimuth) / DIRECTION_BIN_WIDTH_DEG).astype(np.int8) % DIRECTION_BIN_COUNT
    outcome = np.where(
        found.overturned == 1, way, np.where(found.overturned == 0, STANDING_OUTCOME_INDEX, UNKNOWN_OUTCOME_INDEX)
    )
    return outcome.astype(np.int8).reshape([axis.size for axis in axes])
