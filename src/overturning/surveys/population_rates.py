"""The fall rates of a study's population under all its records, over amplitude, JMA intensity, and as fragility."""

from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.model.falls import model_of
from overturning.statistics.by_record import one_record
from overturning.statistics.fragility import Fragility, fragility
from overturning.study.sections import Population
from overturning.surveys.population import (
    Stones,
    draw_stones,
    outside_grid,
    rates,
    stone_outcomes,
)
from overturning.surveys.stones import OCTANTS
from overturning.units import CM, STANDARD_GRAVITY

_ABOUT: Final = {
    "fall_rate": "share of the stones not fixed that fell",
    "shift_rate": "share of the stones not fixed that stood and were shifted",
    "rotation_rate": "share of the stones not fixed that stood and were rotated; missing in planes, which cannot tell",
    "fall_interval": "95 % interval of fall_rate",
    "shift_interval": "95 % interval of shift_rate",
    "rotation_interval": "95 % interval of rotation_rate",
    "unknown": "share of stones without an answer",
    "fall_octant": "share of the stones not fixed that fell towards the octant",
    "octant_interval": "95 % interval of fall_octant",
    "fall_axis": "axis of the falls, degrees",
    "fall_resultant": "mean resultant length of that axis",
    "class_rate": "share of the stones of a class that fell",
}
_MORE: Final = {
    "fall_octant": ("octant",), "octant_interval": ("octant", "end"), "class_rate": ("stones",),
    **{f"{name}_interval": ("end",) for name in ("fall", "shift", "rotation")},
}  # fmt: skip
MEASURES: Final = (("PGA", "g"), ("PGV", "cm/s"), ("PGV/PGA", "s"))
"""Intensity measures of the fragility curves, with their units."""


def population_rates(cube: xr.Dataset, population: Population) -> xr.Dataset:
    """Rates of a population under each record of a cube.

    Parameters
    ----------
    cube : Dataset
        In planes or in space, as `open_cube` reads it, with or without the dimension of amplitudes.
    population : Population
        The cemetery.

    Returns
    -------
    Dataset
        Over ``record`` and ``amplitude``, what `rates` finds, and ``class_rate(…, stones)`` for quarters of the
        population by B/H and size, whose bounds its coordinate tells. The attribute ``outside`` is the share of stones
        beyond the cube's grid, which take its nearest value.
    """
    stones = draw_stones(population)
    classes, reads = stone_classes(stones), model_of(cube).reads_outcomes
    found: dict[str, list[FloatArray]] = {name: [] for name in _ABOUT}
    for record in range(cube.sizes["record"]):
        outcomes = stone_outcomes(one_record(cube, record, reads), stones)
        of_class = [rates(outcomes.some(own), population)["fall_rate"] for own in classes.values()]
        for name, values in (rates(outcomes, population) | {"class_rate": np.stack(of_class, axis=1)}).items():
            found[name].append(values)
    data = {
        name: (("record", "amplitude", *_MORE.get(name, ())), np.stack(values), {"long_name": _ABOUT[name]})
        for name, values in found.items()
    }
    amplitude = cube["amplitude"].to_numpy() if "amplitude" in cube.dims else np.ones(1)
    coordinates = {
        "record_id": ("record", cube["record_id"].to_numpy().astype(str)),
        "event": ("record", cube["event"].to_numpy().astype(str)),
        "amplitude": ("amplitude", amplitude, {"long_name": "factor on the record", "units": "1"}),
        "octant": (
            "octant",
            360.0 / len(OCTANTS) * np.arange(len(OCTANTS)),
            {"long_name": "azimuth of the octant's middle"},
        ),
        "stones": ("stones", list(classes)),
        "end": ("end", ["low", "high"]),
    }
    return xr.Dataset(data, coordinates, {"outside": outside_grid(cube, stones)})


def stone_classes(stones: Stones) -> dict[str, NDArray[np.bool_]]:
    """Quarters of a population: its slenderer and stouter half, each in its smaller and taller half."""
    shape, classes = float(np.median(stones.b_over_h)), {}
    for slender, text in (
        (stones.b_over_h <= shape, f"B/H up to {shape:.2f}"),
        (stones.b_over_h > shape, f"B/H above {shape:.2f}"),
    ):
        size = float(np.median(stones.height[slender])) if slender.any() else 0.0
        classes[f"{text}, H up to {size:.2f} m"] = slender & (stones.height <= size)
        classes[f"{text}, H above {size:.2f} m"] = slender & (stones.height > size)
    return {name: own for name, own in classes.items() if own.any()}


def intensities(found: xr.Dataset, intensity: xr.Dataset) -> dict[str, FloatArray]:
    """Intensity of each record at each amplitude, shape (record, amplitude), by the names of `MEASURES`.

    PGA and PGV are RotD50, the median over azimuths.
    """
    amplitude = found["amplitude"].to_numpy()
    pga, pgv = (intensity[f"{name}_rotd"].sel(percentile=50).to_numpy()[:, None] * amplitude for name in ("pga", "pgv"))
    return {"PGA": pga / STANDARD_GRAVITY, "PGV": pgv / CM, "PGV/PGA": pgv / pga}


def jma_intensities(found: xr.Dataset, intensity: xr.Dataset) -> FloatArray:
    """JMA instrumental intensity, shape (record, amplitude): it grows by 2 log₁₀ of the amplitude.

    Of the horizontal components alone where a record has no vertical one; NaN where not known.
    """
    whole, horizontal = (intensity[name].to_numpy() for name in ("jma_intensity", "jma_intensity_horizontal"))
    measured = np.where(np.isfinite(whole), whole, horizontal)[:, None]
    return np.asarray(measured + 2 * np.log10(found["amplitude"].to_numpy()))


def fragility_curves(found: xr.Dataset, intensity: xr.Dataset) -> list[Fragility]:
    """Curves of the whole population and of each class, over each of `MEASURES`."""
    shares = {"all stones": found["fall_rate"].to_numpy()}
    shares |= {str(name): found["class_rate"].sel(stones=name).to_numpy() for name in found["stones"].to_numpy()}
    levels = intensities(found, intensity)
    events = np.repeat(found["event"].to_numpy().astype(str), found.sizes["amplitude"])
    return [
        fragility(name, measure, levels[measure[0]].ravel(), share.ravel(), events)
        for measure in MEASURES
        for name, share in shares.items()
    ]
