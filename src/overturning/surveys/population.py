"""Fraction overturned in a population of stones: each random stone takes the outcome of a neighbouring grid cell."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy
import xarray as xr
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.model.falls import default_model_of_same_kind_as_results_cube
from overturning.model.model import StoneOutcomesByAmplitudeFactor
from overturning.settings import RELATIVE_TOLERANCE_OUTSIDE_GRID, StonePopulation, UniformRange
from overturning.statistics.by_record import load_results_of_records
from overturning.statistics.circular import mean_angle_deg_and_mean_resultant_length, sector_index
from overturning.statistics.fragility import FittedFragilityCurve, fit_fragility_curve
from overturning.study.ensemble import wilson_95_percent_interval
from overturning.surveys.stones import OCTANTS
from overturning.units import CM, STANDARD_GRAVITY

_GRID_DIMENSIONS_OF_SAMPLED_STONES: Final = ("height", "b_over_h", "friction")

_STONE_GROUP_DESCRIPTIONS: Final = {
    "fall": "stones that fell",
    "shift": "stones that stood and were shifted; missing in planes, which cannot tell",
    "rotation": "stones that stood and were rotated; missing in planes, which cannot tell",
}
_OUTCOME_RATE_EXTRA_DIMENSIONS_AND_LONG_NAMES: Final = {
    **{f"{name}_rate": ((), f"share of the {text}") for name, text in _STONE_GROUP_DESCRIPTIONS.items()},
    **{f"{name}_interval": (("end",), f"95 % interval of {name}_rate") for name in _STONE_GROUP_DESCRIPTIONS},
    "free_fall_rate": ((), "share of the stones not fixed to their base that fell"),
    "unknown": ((), "share of stones without an answer"),
    "fall_octant": (("octant",), "share of the stones that fell towards the octant"),
    "octant_interval": (("octant", "end"), "95 % interval of fall_octant"),
    "fall_axis": ((), "axis of the falls, degrees"),
    "fall_resultant": ((), "mean resultant length of that axis"),
    "class_rate": (("stones",), "share of the stones of a class that are not fixed to their base and fell"),
    "class_unknown": (("stones",), "share of the stones of a class without an answer"),
}
"""Variables of `population_outcome_rates_by_record`: dimensions in addition to record and amplitude, and long name."""

INTENSITY_MEASURES_AND_UNITS: Final = (("PGA", "g"), ("PGV", "cm/s"), ("PGV/PGA", "s"))
"""Intensity measures of every population's fragility curves; `motion_intensities_by_measure` adds SA."""


@dataclass(frozen=True)
class SampledStones:
    """Random stones of a population: height, B/H, friction and face azimuth of n stones.

    Attributes
    ----------
    height, b_over_h, friction : ndarray
        Height, m; B/H; friction coefficient µ.
    face_azimuth_deg : ndarray
        Azimuth of the normal of the front face, degrees.
    random_numbers_for_grid_neighbour_choice : ndarray, shape (3, n)
        Random numbers, 0 to 1; they choose between the two simulated values next to a stone's height, B/H and friction.
    """

    height: FloatArray
    b_over_h: FloatArray
    friction: FloatArray
    face_azimuth_deg: FloatArray
    random_numbers_for_grid_neighbour_choice: FloatArray

    def masks_by_slenderness_and_height_class(self) -> dict[str, NDArray[np.bool_]]:
        """Return masks, shape (n,), of the stones in each of four classes: slender or stout, and low or tall.

        Heights are compared with the median height of the slender, or of the stout stones. A class without stones is
        left out.
        """
        shape, classes = float(np.median(self.b_over_h)), {}
        for own, text in ((self.b_over_h <= shape, "up to"), (self.b_over_h > shape, "above")):
            size = float(np.median(self.height[own])) if own.any() else 0.0
            classes[f"B/H {text} {shape:.2f}, H up to {size:.2f} m"] = own & (self.height <= size)
            classes[f"B/H {text} {shape:.2f}, H above {size:.2f} m"] = own & (self.height > size)
        return {name: own for name, own in classes.items() if own.any()}


def sample_stones(population: StonePopulation) -> SampledStones:
    """Draw random stones of a population: sizes, friction coefficients and face azimuths.

    The random numbers are scrambled Sobol points (Owen 1998, ACM TOMACS 8).
    """
    generator = np.random.Generator(np.random.PCG64(population.seed))
    unit = scipy.stats.qmc.Sobol(7, scramble=True, rng=generator).random(population.stones).T

    def scale_to_range(target_range: UniformRange, numbers_from_0_to_1: FloatArray) -> FloatArray:
        """Map numbers between 0 and 1 linearly to a range of values."""
        return target_range.low + (target_range.high - target_range.low) * numbers_from_0_to_1

    width, height = scale_to_range(population.width, unit[0]), scale_to_range(population.height, unit[1])
    about = population.face_spread * (2 * unit[3] - 1)
    face = 360 * unit[3] if population.face is None else population.face + about
    return SampledStones(height, width / height, scale_to_range(population.friction, unit[2]), face % 360, unit[4:])


def choose_neighbouring_grid_indices_at_random(
    grid_values_of_dimension: FloatArray,
    value_of_each_stone: FloatArray,
    random_number_0_to_1_of_each_stone: FloatArray,
) -> NDArray[np.intp]:
    """Choose for each stone's value, at random, one of the two neighbouring grid values; return its index.

    `grid_values_of_dimension` are ascending, shape (grid,); `value_of_each_stone` and
    `random_number_0_to_1_of_each_stone`, which decides the choice, have shape (stones,). The probability of a
    neighbour decreases linearly with its distance, so that means over stones are interpolated linearly. A stone
    outside the grid takes the value at the end of the grid.
    """
    where = np.interp(value_of_each_stone, grid_values_of_dimension, np.arange(grid_values_of_dimension.size))
    below = np.floor(where)
    return (below + (random_number_0_to_1_of_each_stone < where - below)).astype(np.intp)


def share_of_stones_outside_grid(cube: xr.Dataset, stones: SampledStones) -> float:
    """Return the share of stones with height, B/H or friction outside the simulated range by more than rounding."""
    beyond = np.zeros(stones.height.size, np.bool_)
    for name in _GRID_DIMENSIONS_OF_SAMPLED_STONES:
        grid, values = cube[name].to_numpy(), getattr(stones, name)
        beyond |= (values < (1 - RELATIVE_TOLERANCE_OUTSIDE_GRID) * grid.min()) | (
            values > (1 + RELATIVE_TOLERANCE_OUTSIDE_GRID) * grid.max()
        )
    return float(beyond.mean())


def take_stone_outcomes_from_neighbouring_cases(
    cube_of_one_record: xr.Dataset, stones: SampledStones
) -> StoneOutcomesByAmplitudeFactor:
    """Return the outcomes of random stones under one record, each taken from a neighbouring simulated case.

    `cube_of_one_record` is the results cube of this record, with or without a dimension of amplitudes.

    A block with µ below B/H slides and does not rock. So if only one of the two neighbouring friction values gives a
    case on the same side of µ = B/H as the stone, this value is taken.
    """
    cells = {
        name: choose_neighbouring_grid_indices_at_random(
            cube_of_one_record[name].to_numpy(), getattr(stones, name), numbers
        )
        for name, numbers in zip(
            _GRID_DIMENSIONS_OF_SAMPLED_STONES, stones.random_numbers_for_grid_neighbour_choice, strict=True
        )
    }
    grid, ratio = (
        cube_of_one_record["friction"].to_numpy(),
        cube_of_one_record["b_over_h"].to_numpy()[cells["b_over_h"]],
    )
    rocks = stones.friction > stones.b_over_h
    below = np.clip(np.searchsorted(grid, stones.friction, side="right") - 1, 0, grid.size - 1)
    above = np.minimum(below + 1, grid.size - 1)
    lower, upper = ((grid[place] > ratio) == rocks for place in (below, above))
    cells["friction"] = np.where(lower & ~upper, below, np.where(upper & ~lower, above, cells["friction"]))
    return default_model_of_same_kind_as_results_cube(cube_of_one_record).look_up_square_stone_outcomes(
        cube_of_one_record, stones.face_azimuth_deg, cells
    )


def outcome_rates_at_each_amplitude_factor(
    stone_outcomes_by_amplitude: StoneOutcomesByAmplitudeFactor, population: StonePopulation
) -> dict[str, FloatArray]:
    """Compute the shares of stones that fall, shift and rotate at each amplitude factor of the motion, by name.

    Stones with an unknown outcome do not count. A share `population.fixed` of the stones is fixed to its base and
    neither falls, shifts nor rotates; all shares include these stones except ``free_fall_rate``.

    Returns
    -------
    dict of ndarray
        For a amplitude factors: ``fall_rate``, ``free_fall_rate``, ``shift_rate`` and ``rotation_rate`` (NaN if the
        model does not compute them) and ``unknown``, the share of unknown outcomes, shape (a,); ``fall_interval``,
        ``shift_interval`` and ``rotation_interval``, 95 % intervals by Wilson for as many stones, shape (a, 2);
        ``fall_octant``, shape (a, 8), the share that fell towards each compass octant, with ``octant_interval``, shape
        (a, 8, 2); and ``fall_axis`` with ``fall_resultant``, the axis of the falls, degrees, and its mean resultant
        length, shape (a,). Rates and shares are NaN if no outcome is known.
    """
    stands, answered = (
        stone_outcomes_by_amplitude.trajectory_has_known_outcome & ~stone_outcomes_by_amplitude.fell,
        stone_outcomes_by_amplitude.trajectory_has_known_outcome.sum(axis=1),
    )
    share_of = np.where(answered > 0, answered, np.nan)
    which = {
        "fall": stone_outcomes_by_amplitude.fell,
        "shift": stands & (stone_outcomes_by_amplitude.residual_slip_m >= population.shifted),
        "rotation": stands & (np.abs(stone_outcomes_by_amplitude.residual_twist_deg) >= population.rotated),
    }
    made, free = {}, 1.0 - population.fixed
    for name, members in which.items():
        counted = free * members.sum(axis=1)
        made[f"{name}_rate"] = counted / share_of
        made[f"{name}_interval"] = np.stack(wilson_95_percent_interval(counted, answered), axis=-1)
    for name, values in (
        ("shift", stone_outcomes_by_amplitude.residual_slip_m),
        ("rotation", stone_outcomes_by_amplitude.residual_twist_deg),
    ):
        untold = ~np.isfinite(np.where(stands, values, 0.0)).all(axis=1)
        made[f"{name}_rate"][untold] = made[f"{name}_interval"][untold] = np.nan
    octant = np.where(
        np.isfinite(stone_outcomes_by_amplitude.fall_azimuth_deg),
        sector_index(np.nan_to_num(stone_outcomes_by_amplitude.fall_azimuth_deg), len(OCTANTS)),
        -1,
    )
    towards = free * np.stack([(octant == one).sum(axis=1) for one in range(len(OCTANTS))], axis=1)
    axes = [
        mean_angle_deg_and_mean_resultant_length(azimuth[fell], axial=True)
        for azimuth, fell in zip(
            stone_outcomes_by_amplitude.fall_azimuth_deg, stone_outcomes_by_amplitude.fell, strict=True
        )
    ]
    return made | {
        "free_fall_rate": stone_outcomes_by_amplitude.fell.sum(axis=1) / share_of,
        "unknown": 1.0 - stone_outcomes_by_amplitude.trajectory_has_known_outcome.mean(axis=1),
        "fall_octant": towards / share_of[:, None],
        "octant_interval": np.stack(wilson_95_percent_interval(towards, answered[:, None]), axis=-1),
        **dict(zip(("fall_axis", "fall_resultant"), np.array(axes).T, strict=True)),
    }


def population_outcome_rates_by_record(cube: xr.Dataset, population: StonePopulation) -> xr.Dataset:
    """Compute the shares of a stone population that fall, shift and rotate under each record of a results cube.

    Parameters
    ----------
    cube : Dataset
        Cube of a 2-D or 3-D model from `open_cube`, with or without the dimension of amplitudes.
    population : StonePopulation
        The cemetery.

    Returns
    -------
    Dataset
        Results of `outcome_rates_at_each_amplitude_factor` over ``record`` and ``amplitude``; and for the classes of
        `SampledStones.masks_by_slenderness_and_height_class`, along ``stones``, ``class_rate`` (of stones not fixed to
        their base) and ``class_unknown``. The attribute ``outside`` is the share of stones outside the simulated grid,
        which take its nearest value; ``members`` is the number of stones: coordinate by class, attribute of all.
    """
    stones = sample_stones(population)
    classes, reads = (
        stones.masks_by_slenderness_and_height_class(),
        default_model_of_same_kind_as_results_cube(cube).variable_names_read_for_square_stones,
    )
    found: dict[str, list[FloatArray]] = {name: [] for name in _OUTCOME_RATE_EXTRA_DIMENSIONS_AND_LONG_NAMES}
    for record in range(cube.sizes["record"]):
        outcomes = take_stone_outcomes_from_neighbouring_cases(load_results_of_records(cube, record, reads), stones)
        of_class = [
            outcome_rates_at_each_amplitude_factor(outcomes.select_stones(own), population) for own in classes.values()
        ]
        by_class = {
            name: np.stack([one[of] for one in of_class], axis=1)
            for name, of in (("class_rate", "free_fall_rate"), ("class_unknown", "unknown"))
        }
        for name, values in (outcome_rates_at_each_amplitude_factor(outcomes, population) | by_class).items():
            found[name].append(values)
    data = {
        name: (("record", "amplitude", *dims), np.stack(found[name]), {"long_name": text})
        for name, (dims, text) in _OUTCOME_RATE_EXTRA_DIMENSIONS_AND_LONG_NAMES.items()
    }
    amplitude = cube["amplitude"].to_numpy() if "amplitude" in cube.dims else np.ones(1)
    middles = 360.0 / len(OCTANTS) * np.arange(len(OCTANTS))
    coordinates = {
        **{name: ("record", cube[name].to_numpy().astype(str)) for name in ("record_id", "event")},
        "amplitude": ("amplitude", amplitude, {"long_name": "factor on the record", "units": "1"}),
        "octant": ("octant", middles, {"long_name": "azimuth of the octant's middle"}),
        "stones": ("stones", list(classes)),
        "members": ("stones", [int(own.sum()) for own in classes.values()]),
        "end": ("end", ["low", "high"]),
    }
    about = {
        "outside": share_of_stones_outside_grid(cube, stones),
        "members": stones.height.size,
        "period": list(population.period),
    }
    return xr.Dataset(data, coordinates, about)


def fall_rates_of_stones_with_outcome_in_both_cubes(
    cube: xr.Dataset, other_cube: xr.Dataset, population: StonePopulation
) -> tuple[FloatArray, FloatArray]:
    """Compute for each of two cubes the share of a stone population that falls under each record, shape (records,).

    Only stones with a known outcome in both cubes count; NaN if there are none. The share `population.fixed` of the
    stones never falls. The two cubes have the same records, one amplitude, and the same kind of model (2-D or 3-D).
    If all outcomes are known, the shares equal those of `population_outcome_rates_by_record`.
    """
    stones, reads, rates = (
        sample_stones(population),
        default_model_of_same_kind_as_results_cube(cube).variable_names_read_for_square_stones,
        [],
    )
    for record in range(cube.sizes["record"]):
        outcomes = [
            take_stone_outcomes_from_neighbouring_cases(load_results_of_records(one, record, reads), stones)
            for one in (cube, other_cube)
        ]
        known = outcomes[0].trajectory_has_known_outcome & outcomes[1].trajectory_has_known_outcome
        fallen = np.array([(1.0 - population.fixed) * (one.fell & known).sum() for one in outcomes])
        rates.append(fallen / (known.sum() or np.nan))
    here, there = np.array(rates).reshape(-1, 2).T
    return here, there


def motion_intensities_by_measure(
    population_outcome_rates: xr.Dataset, intensity_measures_by_record: xr.Dataset
) -> dict[str, FloatArray]:
    """Return PGA (g), PGV (cm/s), PGV/PGA (s) and SA(T) (g) of each motion, by name, shape (records, amplitudes).

    A motion is a record times an amplitude factor of `population_outcome_rates`. PGA, PGV and the pseudo-acceleration
    SA at the periods T of the population (damping ratio 0.05) are RotD50, the median over azimuths.
    """
    amplitude = population_outcome_rates["amplitude"].to_numpy()
    pga, pgv = (
        intensity_measures_by_record[f"{name}_rotd"].sel(percentile=50).to_numpy()[:, None] * amplitude
        for name in ("pga", "pgv")
    )
    spectra = {
        f"SA({period})": intensity_measures_by_record["psa_rotd"].sel(percentile=50, period=period).to_numpy()[:, None]
        * amplitude
        for period in population_outcome_rates.attrs.get("period", ())
    }
    found_levels = {"PGA": pga / STANDARD_GRAVITY, "PGV": pgv / CM, "PGV/PGA": pgv / pga}
    return found_levels | {name: values / STANDARD_GRAVITY for name, values in spectra.items()}


def jma_intensities_of_scaled_motions(
    population_outcome_rates: xr.Dataset, intensity_measures_by_record: xr.Dataset
) -> FloatArray:
    """Return the JMA instrumental intensity of each record and amplitude factor, shape (records, amplitudes).

    The amplitude factors are those of `population_outcome_rates`; they increase the intensity of the record by
    2 log₁₀ of the factor. For a record without a vertical component only the horizontal ones count; NaN if unknown.
    """
    whole, horizontal = (
        intensity_measures_by_record[name].to_numpy() for name in ("jma_intensity", "jma_intensity_horizontal")
    )
    measured = np.where(np.isfinite(whole), whole, horizontal)[:, None]
    return np.asarray(measured + 2 * np.log10(population_outcome_rates["amplitude"].to_numpy()))


def fit_population_fragility_curves(
    population_outcome_rates: xr.Dataset, intensity_measures_by_record: xr.Dataset
) -> list[FittedFragilityCurve]:
    """Fit a fragility curve for each intensity measure, for all stones and for each class of stones.

    `population_outcome_rates` is a result of `population_outcome_rates_by_record`. Measures are
    `INTENSITY_MEASURES_AND_UNITS` and SA(T). Stones fixed to their base are left out: a lognormal curve tends to 1,
    but they never fall.
    """
    known = int(population_outcome_rates.attrs["members"]) * (1.0 - population_outcome_rates["unknown"].to_numpy())
    shares = {"all stones": (population_outcome_rates["free_fall_rate"].to_numpy(), np.rint(known))}
    for name, members in zip(
        population_outcome_rates["stones"].to_numpy(), population_outcome_rates["members"].to_numpy(), strict=True
    ):
        own = population_outcome_rates.sel(stones=name)
        known = int(members) * (1.0 - own["class_unknown"].to_numpy())
        shares[str(name)] = own["class_rate"].to_numpy(), np.rint(known)
    events, record = (
        np.repeat(one, population_outcome_rates.sizes["amplitude"])
        for one in (
            population_outcome_rates["event"].to_numpy().astype(str),
            np.arange(population_outcome_rates.sizes["record"]),
        )
    )
    units = dict(INTENSITY_MEASURES_AND_UNITS)
    return [
        fit_fragility_curve(
            name,
            (measure, units.get(measure, "g")),
            level.ravel(),
            share.ravel(),
            events,
            record_label_by_motion=record,
            stone_count_by_motion=stones.ravel(),
        )
        for measure, level in motion_intensities_by_measure(
            population_outcome_rates, intensity_measures_by_record
        ).items()
        for name, (share, stones) in shares.items()
    ]
