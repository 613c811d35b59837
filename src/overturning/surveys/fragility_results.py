"""Fragility curves of a study's population of stones in a file, so that a run fits them only once."""

import hashlib
from pathlib import Path
from typing import Final

import xarray as xr
from pydantic import BaseModel, ConfigDict

from overturning.errors import ResultError
from overturning.statistics.fragility import FittedFragilityCurve
from overturning.stored import read_json_result, write_result_as_json
from overturning.study.sources import package_source_hash
from overturning.surveys.population import fit_population_fragility_curves

FRAGILITY_CURVES_PATH: Final = Path("fragility", "curves.json")
"""File of the curves in a folder of results."""


class StoredFragilityCurves(BaseModel):
    """Stored fragility curves, with a hash of the data and the program from which they were fitted."""

    model_config = ConfigDict(ser_json_inf_nan="constants")  # a median can be infinite

    input_sha256: str
    curves: list[FittedFragilityCurve]


def _digest_of_fit_input_and_source_files(
    population_outcome_rates: xr.Dataset, intensity_measures_by_record: xr.Dataset
) -> str:
    """Return a hash of the data to which fragility curves are fitted, and of the program's source files."""
    digest = hashlib.sha256(package_source_hash("statistics", "surveys").encode())
    for name in ("free_fall_rate", "class_rate", "unknown", "class_unknown", "members", "stones", "event", "amplitude"):
        digest.update(f"{name} {population_outcome_rates[name].to_numpy().tolist()}\n".encode())
    for name in ("pga_rotd", "pgv_rotd", "psa_rotd"):
        digest.update(f"{name} {intensity_measures_by_record[name].to_numpy().tolist()}\n".encode())
    digest.update(f"{sorted(population_outcome_rates.attrs.items())}".encode())
    return digest.hexdigest()


def write_fragility_curves(
    fragility_curves: list[FittedFragilityCurve],
    population_outcome_rates: xr.Dataset,
    intensity_measures_by_record: xr.Dataset,
    path: Path,
) -> None:
    """Write fitted fragility curves, with a hash of the data, so that they need not be fitted again."""
    write_result_as_json(
        StoredFragilityCurves(
            input_sha256=_digest_of_fit_input_and_source_files(population_outcome_rates, intensity_measures_by_record),
            curves=fragility_curves,
        ),
        path,
    )


def fit_or_read_fragility_curves(
    population_outcome_rates: xr.Dataset, intensity_measures_by_record: xr.Dataset, path: Path
) -> list[FittedFragilityCurve]:
    """Return stored fragility curves if they were fitted to the same data; otherwise fit the curves."""
    try:
        stored = read_json_result(StoredFragilityCurves, path, "fragility curves")
    except ResultError:
        stored = None
    if stored is not None and stored.input_sha256 == _digest_of_fit_input_and_source_files(
        population_outcome_rates, intensity_measures_by_record
    ):
        return stored.curves
    return fit_population_fragility_curves(population_outcome_rates, intensity_measures_by_record)
