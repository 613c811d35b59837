"""Outcomes of 3-D stones under candidate motions: simulated on a grid of sizes, cached, smoothed to probabilities."""

import hashlib
import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Final

import numpy as np
import platformdirs
import scipy
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.numerics import NumericalOptions
from overturning.dem.run import simulate_cases
from overturning.errors import REASON_SEPARATOR, ArgumentError
from overturning.files import atomic_write
from overturning.model.cases import Cases
from overturning.settings import StonePopulation
from overturning.study.sources import package_source_hash
from overturning.surveys.library import CandidateMotion
from overturning.surveys.stones import Stone

LEVELS: Final[FloatArray] = np.asarray(np.geomspace(0.2, 3.2, 13), np.float64)
"""Peak velocities to which motions are scaled, m/s."""

HEIGHTS: Final[FloatArray] = np.asarray(0.3 * 1.5 ** np.arange(10), np.float64)
"""Simulated heights, m; outcomes are interpolated between them."""

SHAPES: Final[FloatArray] = np.asarray(np.geomspace(0.08, 0.8, 14), np.float64)
"""Simulated B/H."""

ASPECTS: Final = (1.0, 1.4, 2.0, 2.8, 4.0)
"""Simulated D/B of rectangular stones, D the broader side; the nearest value is used."""

FRICTIONS: Final = (0.45, 0.65, 0.9)
"""Simulated friction coefficients, with equal probability, as friction is not known."""

ORIENTATION_STEP_DEG: Final = 15
"""Step of the face azimuth of rectangular stones relative to the motion, degrees; the nearest value is used."""

BIN_WIDTH_DEG: Final = 5
"""Width of a direction bin of falls, degrees."""

DIRECTION_BINS: Final = 360 // BIN_WIDTH_DEG
STOOD: Final = DIRECTION_BINS
"""Index of standing, after the direction bins."""
UNKNOWN: Final = DIRECTION_BINS + 1

LN_SHAPE_DEVIATION: Final = 0.15
"""Standard deviation of ln B/H among stones with equal measured sizes (worn edges, footings, restitution)."""

LN_PGV_DEVIATION: Final = 0.15
"""Standard deviation of ln PGV over the site of one survey."""

CONCENTRATION, UNIFORM_SHARE = 8.0, 0.2
"""Scatter of falls about the simulated direction: concentration (von Mises), and share with uniform directions."""

CASE_S: Final = 3e-5
"""Processor time of a case per second of motion, s; order of magnitude, measured with columns and prisms."""

DRAWS: Final = 64
"""Number of random draws for unknown sizes."""


@dataclass(frozen=True)
class StoneKind:
    """Height and shape (B/H, D/B) for which stones of a survey are simulated; None if unknown.

    Attributes
    ----------
    height, b_over_h : float or None
        Height, m, and the smaller B/H of its two planes; None if unknown.
    aspect : float
        D/B, broader over narrower side, of a rectangular stone; 0 for a round stone.
    """

    height: float | None = None
    b_over_h: float | None = None
    aspect: float = 1.0

    @classmethod
    def from_stone(cls, stone: Stone) -> "StoneKind":
        """Return height and shape of a survey's stone; an `ArgumentError` if outside the simulated range."""
        front, side = stone.slenderness_in_both_planes
        for name, value, grid in (("height_m", stone.height, HEIGHTS), ("b_over_h", min(front, side), SHAPES)):
            if not (math.isnan(value) or 0.8 * grid[0] <= value <= 1.25 * grid[-1]):
                where = f"line {stone.line}: {name} {value:g}"
                raise ArgumentError(
                    f"{where}; stones of {grid[0]:g} to {grid[-1]:.3g} are computed: leave out the stone"
                )
        height = None if math.isnan(stone.height) else stone.height
        if math.isnan(front):
            return cls(height, None, 0.0 if stone.round else 1.0)
        aspect = max(front, side) / min(front, side)
        nearest = min(ASPECTS, key=lambda one: abs(math.log(one / aspect)))
        return cls(height, front if stone.round else min(front, side), 0.0 if stone.round else nearest)

    @property
    def orientations_deg(self) -> FloatArray:
        """Face azimuths to simulate, degrees from the motion's north, without those equal by symmetry."""
        turn = 1 if self.aspect == 0.0 else 90 if self.aspect == 1.0 else 180
        return np.arange(0.0, turn, ORIENTATION_STEP_DEG)

    def size_grid_weights(self, size_population: StonePopulation) -> FloatArray:
        """Return the weights of the simulated `HEIGHTS` and `SHAPES` (B/H) for stones of this kind; their sum is 1.

        The shape is (heights, shapes).

        The weights sum to 1. Unknown sizes are distributed as in `size_population`.
        """
        generator = np.random.Generator(np.random.PCG64(size_population.seed))
        unit = scipy.stats.qmc.Sobol(2, scramble=True, rng=generator).random(DRAWS).T
        height, width = (
            one.low + (one.high - one.low) * u
            for one, u in zip((size_population.height, size_population.width), unit, strict=True)
        )
        height = height if self.height is None else np.full(DRAWS, self.height)
        shape = width / height if self.b_over_h is None else np.full(DRAWS, self.b_over_h)
        place = np.interp(np.log(height), np.log(HEIGHTS), np.arange(HEIGHTS.size))
        of_height = np.maximum(0.0, 1 - np.abs(place[:, None] - np.arange(HEIGHTS.size)))
        apart = np.abs(np.log(SHAPES / np.clip(shape, SHAPES[0], SHAPES[-1])[:, None])) / LN_SHAPE_DEVIATION
        of_shape = np.where(apart <= 2.0, np.exp(-0.5 * apart**2), 0.0)
        return np.asarray(of_height.T @ (of_shape / of_shape.sum(axis=1, keepdims=True)) / DRAWS)


def kinds_of_survey_stones(stones: Sequence[Stone], file_name: str) -> list[StoneKind]:
    """Return height and shape of each stone of a survey as a `StoneKind`.

    An ArgumentError lists all stones outside the simulated range.
    """
    kinds, faults = [], []
    for stone in stones:
        try:
            kinds.append(StoneKind.from_stone(stone))
        except ArgumentError as error:
            faults.append(f"{file_name} {error}")
    if faults:
        raise ArgumentError(REASON_SEPARATOR.join(faults))
    return kinds


class StoneOutcomeProbabilities:
    """Probabilities of outcomes of stones under candidate motions scaled to several peak velocities.

    Simulated outcomes are cached in files.

    Parameters
    ----------
    motions, kinds : sequence of CandidateMotion, sequence of StoneKind
        Motions and kinds of stones; raise an `ArgumentError` if there is none of either.
    population : StonePopulation, optional
        Distribution of unknown heights and B/H.
    folder : Path, optional
        Cache folder; default: in the cache of the user.
    threads : int
        Number of threads.
    progress : callable, optional
        Called with the number of finished motions and of all motions.
    """

    def __init__(
        self,
        motions: Sequence[CandidateMotion],
        stone_kinds: Sequence[StoneKind],
        population: StonePopulation | None = None,
        *,
        folder: Path | None = None,
        threads: int = 1,
        progress: Callable[[int, int], None] | None = None,
    ) -> None:
        if not motions or not stone_kinds:
            raise ArgumentError(
                f"{len(motions)} motions, {len(stone_kinds)} kinds of stones; at least one of each is needed"
            )
        self.motions = tuple(motions)
        folder = folder or response_cache_folder()
        self._weights = size_grid_weights_by_kind(stone_kinds, population)
        needed = needed_size_grid_masks(self._weights)
        self._ways: dict[float, list[dict[str, NDArray[np.int8]]]] = {aspect: [] for aspect in needed}
        for done, one in enumerate(motions):
            if progress:
                progress(done, len(motions))
            for aspect, nodes in needed.items():
                self._ways[aspect].append(load_or_compute_outcomes(one, aspect, nodes, folder, threads))
        if progress:
            progress(len(motions), len(motions))
        self.table = lru_cache(64)(self._outcome_probability_table)

    def _outcome_probability_table(self, stone_kind: StoneKind) -> NDArray[np.float32]:
        """Return probabilities of each fall direction, relative to the motion's north, and of standing.

        Shape (motions, levels, orientations, bins + 1).
        """
        return np.stack(
            [_outcome_probabilities(one, self._weights[stone_kind]) for one in self._ways[stone_kind.aspect]]
        )


def response_cache_folder() -> Path:
    """Return the user's cache folder for simulated outcomes of stones."""
    return Path(platformdirs.user_cache_dir("overturning")) / "responses"


def size_grid_weights_by_kind(
    stone_kinds: Sequence[StoneKind], size_population: StonePopulation | None = None
) -> dict[StoneKind, FloatArray]:
    """Return, for each kind of stone, the weight of each simulated height and B/H, shape (heights, shapes).

    See `StoneKind.size_grid_weights`.
    """
    return {kind: kind.size_grid_weights(size_population or StonePopulation()) for kind in dict.fromkeys(stone_kinds)}


def needed_size_grid_masks(weights_by_kind: dict[StoneKind, FloatArray]) -> dict[float, NDArray[np.bool_]]:
    """Return, by D/B, a mask of the heights and B/H that must be simulated, shape (heights, shapes).

    A pair is needed if its weight for some kind of stone with this D/B is positive.
    """
    needed: dict[float, NDArray[np.bool_]] = {}
    for kind, weight in weights_by_kind.items():
        needed[kind.aspect] = needed.get(kind.aspect, np.zeros(weight.shape, np.bool_)) | (weight > 0)
    return needed


def uncached_case_count_and_time(
    motions: Sequence[CandidateMotion], stone_kinds: Sequence[StoneKind], folder: Path | None = None
) -> tuple[int, float]:
    """Return the number of cases still to simulate because the cache lacks them, and the estimated time, s.

    The cases are those that `StoneOutcomeProbabilities` would simulate.

    Returns
    -------
    cases : int
        Cases of all motions.
    processor_s : float
        Processor time, s; of the order of magnitude.
    """
    cases, seconds = 0, 0.0
    for aspect, nodes in needed_size_grid_masks(size_grid_weights_by_kind(stone_kinds)).items():
        names = [f"{h}-{b}" for h, b in np.argwhere(nodes).tolist()]
        each = len(FRICTIONS) * LEVELS.size * StoneKind(aspect=aspect).orientations_deg.size
        for one in motions:
            kept: list[str] = []
            with (
                suppress(Exception),
                np.load(_response_cache_path(one, aspect, folder or response_cache_folder())) as stored,
            ):
                kept = stored.files  # a torn archive holds nothing
            count = each * len(set(names) - set(kept))
            cases += count
            seconds += CASE_S * count * one.motion.north.size * one.motion.sampling_interval
    return cases, seconds


def _response_cache_path(candidate_motion: CandidateMotion, aspect: float, folder: Path) -> Path:
    """Return the path of the cache file for stones with one D/B (`aspect`) under one motion.

    The file name is a hash of all inputs.
    """
    grid = repr(
        (
            candidate_motion.pgv,
            BIN_WIDTH_DEG,
            LEVELS.tolist(),
            FRICTIONS,
            HEIGHTS.tolist(),
            SHAPES.tolist(),
            ORIENTATION_STEP_DEG,
            aspect,
        )
    )
    key = hashlib.sha256(f"{_response_source_hash()} {candidate_motion.samples_sha256} {grid}".encode()).hexdigest()[
        :24
    ]
    return folder / f"{key}.npz"


def load_or_compute_outcomes(
    candidate_motion: CandidateMotion, aspect: float, needed_sizes_mask: NDArray[np.bool_], folder: Path, threads: int
) -> dict[str, NDArray[np.int8]]:
    """Return the outcomes of stones with one D/B (`aspect`) under a motion, from the cache or by simulation.

    Missing outcomes are simulated and stored in the cache.

    Returns by key ``height-shape``, for the nodes that are True, shape (heights, shapes): direction bin of the fall,
    `STOOD` or `UNKNOWN`, shape (frictions, levels, orientations).
    """
    path, known = _response_cache_path(candidate_motion, aspect, folder), dict[str, NDArray[np.int8]]()
    try:
        with np.load(path) as stored:
            known = {name: stored[name] for name in stored.files}
    except FileNotFoundError:
        pass
    except Exception:  # a damaged archive raises various exceptions; its content is simulated again
        path.unlink(missing_ok=True)
    missing = [(h, b) for h, b in np.argwhere(needed_sizes_mask).tolist() if f"{h}-{b}" not in known]
    if missing:
        known |= dict(
            zip(
                (f"{h}-{b}" for h, b in missing),
                simulate_outcomes_of_sizes(candidate_motion, aspect, missing, threads),
                strict=True,
            )
        )
        # A cache that cannot be written costs time only.
        with suppress(OSError), atomic_write(path) as part, part.open("wb") as file:
            np.savez_compressed(file, allow_pickle=False, **known)
    return known


@cache
def _response_source_hash() -> str:
    """Return a hash of the source files that affect simulated outcomes; it makes an outdated cache invalid."""
    return package_source_hash("dem", "model", "motion", "surveys/responses.py")


def simulate_outcomes_of_sizes(
    candidate_motion: CandidateMotion, aspect: float, size_grid_indices: Sequence[tuple[int, int]], threads: int
) -> NDArray[np.int8]:
    """Simulate stones with one D/B at given pairs of height and B/H; return their outcomes.

    `size_grid_indices` are pairs of indices into `HEIGHTS` and `SHAPES`. Outcomes have shape (nodes, frictions, levels,
    orientations).

    An outcome is the direction bin of the fall, `STOOD` or `UNKNOWN`.
    """
    kind = StoneKind(aspect=aspect)
    axes = (
        np.arange(len(size_grid_indices)),
        np.array(FRICTIONS),
        LEVELS / candidate_motion.pgv,
        kind.orientations_deg,
    )
    node, friction, amplitude, orientation = (values.ravel() for values in np.meshgrid(*axes, indexing="ij"))
    height, shape = (grid[np.array(size_grid_indices)[:, at]] for at, grid in enumerate((HEIGHTS, SHAPES)))
    node = node.astype(np.intp)
    cases = Cases(orientation, height[node], shape[node], friction, amplitude, aspect=max(aspect, 1.0))
    found = simulate_cases(
        "rectangle" if aspect else "circle", candidate_motion.motion, cases, NumericalOptions(threads=threads)
    )
    way = np.round(np.nan_to_num(found.fall_azimuth) / BIN_WIDTH_DEG).astype(np.int8) % DIRECTION_BINS
    outcome = np.where(found.overturned == 1, way, np.where(found.overturned == 0, STOOD, UNKNOWN))
    return outcome.astype(np.int8).reshape([axis.size for axis in axes])


def _outcome_probabilities(
    outcomes_by_node: dict[str, NDArray[np.int8]], size_grid_weights: FloatArray
) -> NDArray[np.float32]:
    """Return the probabilities of standing and of each fall direction, for one kind of stone under one motion.

    The shape is (levels, orientations, bins + 1).

    The outcomes under one motion (see `load_or_compute_outcomes`) are averaged over stones, with weights of
    `StoneKind.size_grid_weights`, and over the peak velocities at the site.
    """
    nodes = np.argwhere(size_grid_weights > 0).tolist()
    outcome = np.stack([outcomes_by_node[f"{h}-{b}"] for h, b in nodes])
    _, frictions, levels, orientations = outcome.shape
    place = np.arange(levels * orientations).reshape(levels, orientations) * (UNKNOWN + 1) + outcome
    mass = np.broadcast_to(size_grid_weights[size_grid_weights > 0][:, None, None, None] / frictions, outcome.shape)
    counts = np.bincount(place.ravel(), mass.ravel(), levels * orientations * (UNKNOWN + 1)).reshape(levels, -1)
    near = np.exp(-0.5 * (np.log(LEVELS[:, None] / LEVELS) / LN_PGV_DEVIATION) ** 2)
    shares = (near / near.sum(axis=1, keepdims=True) @ counts).reshape(levels, orientations, UNKNOWN + 1)[..., :UNKNOWN]
    # Without known outcomes the probabilities are uninformative.
    shares += 1e-6 * uninformed_outcome_probabilities()
    shares /= shares.sum(axis=-1, keepdims=True)
    shares[..., :DIRECTION_BINS] = shares[..., :DIRECTION_BINS] @ observed_direction_probabilities_by_simulated()
    return shares.astype(np.float32)


def uninformed_outcome_probabilities() -> FloatArray:
    """Return outcome probabilities if nothing is known: ½ for standing, the rest equal for all fall directions.

    The shape is (bins + 1,).
    """
    return np.append(np.full(DIRECTION_BINS, 0.5 / DIRECTION_BINS), 0.5)


@cache
def observed_direction_probabilities_by_simulated() -> FloatArray:
    """Return the probabilities of observed fall directions (columns) given the simulated one (rows).

    A bin is a direction bin of a fall.
    """
    angle = np.radians(BIN_WIDTH_DEG * np.arange(DIRECTION_BINS))
    density = scipy.stats.vonmises.pdf(angle, CONCENTRATION)
    row = (1 - UNIFORM_SHARE) * density / density.sum() + UNIFORM_SHARE / DIRECTION_BINS
    return np.asarray(row[(np.arange(DIRECTION_BINS) - np.arange(DIRECTION_BINS)[:, None]) % DIRECTION_BINS])
