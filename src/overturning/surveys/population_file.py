"""The fall rates of a study's population under all its records, as a file."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.errors import ConfigError, ResultError
from overturning.files import atomic_write
from overturning.records.record import Record
from overturning.statistics.fragility import Fragility, fragility
from overturning.study.config import Study
from overturning.study.scenes import motion_of, numerics_of, scene_of
from overturning.surveys.population import Stones, draw_stones, rates, stone_outcomes
from overturning.units import CM, STANDARD_GRAVITY

_ABOUT: Final = {
    "fall_rate": "share of the stones not fixed that fell",
    "shift_rate": "share of the stones not fixed that stood and were shifted",
    "unknown": "share of stones without an answer",
    "fall_octant": "share of the stones not fixed that fell towards the octant",
    "class_rate": "share of the stones of a class that fell",
}
MEASURES: Final = (("PGA", "g"), ("PGV", "cm/s"), ("PGV/PGA", "s"))
"""Intensity measures of the fragility curves, with their units."""


def population_outcomes(
    study: Study, records: Sequence[Record], threads: int = 1, tell: Callable[[str], None] | None = None
) -> xr.Dataset:
    """Rates of a study's population under each of its records.

    Parameters
    ----------
    study : Study
        With a population.
    records : sequence of Record
        Processed records, in the study's order.
    threads : int
        Threads.
    tell : callable, optional
        Takes a line for each record.

    Returns
    -------
    Dataset
        Over ``record`` and ``amplitude``: ``fall_rate``, ``shift_rate``, ``unknown``; ``fall_octant(…, octant)``; and
        ``class_rate(…, stones)`` for quarters of the population by B/H and size, whose bounds its coordinate tells.

    Raises
    ------
    ConfigError
        If the study has no population.
    """
    population = study.population
    if population is None:
        raise ConfigError(f"{study.name}: no population; add the key population to the study")
    stones, amplitude = draw_stones(population), np.asarray(population.amplitude, dtype=np.float64)
    classes = stone_classes(stones)
    found: dict[str, list[FloatArray]] = {name: [] for name in _ABOUT}
    for record in records:
        outcome, azimuth = stone_outcomes(
            motion_of(study, record),
            stones,
            amplitude,
            shifted=population.shifted,
            scene=scene_of(study),
            numerics=numerics_of(study, threads),
        )
        of_class = [rates(outcome[:, own], azimuth[:, own])["fall_rate"] for own in classes.values()]
        for name, values in (rates(outcome, azimuth) | {"class_rate": np.stack(of_class, axis=1)}).items():
            found[name].append(values)
        if tell is not None:
            tell(f"population: {record.record_id}")
    last = {"fall_octant": ("octant",), "class_rate": ("stones",)}
    data = {
        name: (
            ("record", "amplitude", *last.get(name, ())),
            np.stack(values),
            {"long_name": _ABOUT[name], "units": "1"},
        )
        for name, values in found.items()
    }
    coordinates = {
        "record_id": ("record", [record.record_id for record in records]),
        "event": ("record", [record.event for record in records]),
        "amplitude": ("amplitude", amplitude, {"long_name": "factor on the record", "units": "1"}),
        "octant": ("octant", 45.0 * np.arange(8), {"long_name": "azimuth of the octant's middle", "units": "degree"}),
        "stones": ("stones", list(classes)),
    }
    return xr.Dataset(
        data, coordinates, {"Conventions": "CF-1.11", "title": f"{study.title or study.name}: fall rates"}
    )


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


def write_population(found: xr.Dataset, path: Path) -> None:
    """Write what `population_outcomes` made (NetCDF)."""
    with atomic_write(path) as part:
        found.to_netcdf(part, engine="netcdf4")


def read_population(path: Path) -> xr.Dataset:
    """Read what `write_population` wrote; a ResultError where it is missing or of another kind."""
    try:
        with xr.open_dataset(path, engine="netcdf4") as stored:
            found = stored.load()
    except (OSError, ValueError) as error:
        raise ResultError(f"{path}: cannot be read ({error}); run the study again") from None
    missing = [name for name in _ABOUT if name not in found]
    if missing:
        raise ResultError(f"{path}: no variable {missing[0]!r}; run the study again")
    return found


def intensities(found: xr.Dataset, intensity: xr.Dataset) -> dict[str, FloatArray]:
    """Intensity of each record at each amplitude, shape (record, amplitude), by the names of `MEASURES`.

    PGA and PGV are RotD50, the median over azimuths.
    """
    amplitude = found["amplitude"].to_numpy()
    pga, pgv = (intensity[f"{name}_rotd"].sel(percentile=50).to_numpy()[:, None] * amplitude for name in ("pga", "pgv"))
    return {"PGA": pga / STANDARD_GRAVITY, "PGV": pgv / CM, "PGV/PGA": pgv / pga}


def jma_intensities(found: xr.Dataset, intensity: xr.Dataset) -> FloatArray:
    """JMA instrumental intensity, shape (record, amplitude): it grows by 2 log₁₀ of the amplitude; NaN where not known."""
    measured = intensity["jma_intensity"].to_numpy()[:, None]
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
