"""Ground below the stones of a survey, as stored in the cube of the motion at its surface."""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from overturning.records.site import STRAIN_BEYOND_CURVE_PHRASE, SoilSite
from overturning.study.cube import index_of_record, record_sources_and_processing_by_id, study_of_cube
from overturning.study.scenes import settings_changed_by_variant


@dataclass(frozen=True)
class SoilBelowSurveySite:
    """Soil layers below a survey site, and the PGA of the record before and after propagation through them.

    Attributes
    ----------
    thickness_m : float
        Thickness of all layers, m.
    mean_shear_wave_velocity_m_s : float
        Mean shear-wave velocity of the layers at small strain: their thickness over the travel time, m/s.
    equivalent_linear : bool
        True if a layer softens with strain.
    converged : bool
        False if the equivalent-linear computation did not converge.
    strain_exceeds_soil_curve : bool
        True if the effective strain of a layer exceeds the largest strain of its curve.
    rock_pga, surface_pga : float
        Peak acceleration of the larger horizontal component in the rock and at the surface, m/s².
    """

    thickness_m: float
    mean_shear_wave_velocity_m_s: float
    equivalent_linear: bool
    converged: bool
    strain_exceeds_soil_curve: bool
    rock_pga: float
    surface_pga: float


def soil_below_survey_site_of_cube(cube: xr.Dataset, record_id: str | None) -> SoilBelowSurveySite | None:
    """Return the soil layers on which the motion of a results cube was computed; None without soil layers.

    The layers are those of the variant of the cube, or of its study; peaks are those of the record `record_id`, which
    may be None for a cube with one record.
    """
    study = study_of_cube(cube)
    soil = settings_changed_by_variant(study, str(cube.attrs["variant"])).site or study.site
    if soil is None:
        return None
    name = str(np.atleast_1d(cube["record_id"].to_numpy())[index_of_record(cube, record_id)])
    step = next(
        one
        for one in reversed(record_sources_and_processing_by_id(cube)[name]["steps"])
        if one["step"] == SoilSite.step
    )
    before, after = step["effect"]["pga"]
    thickness = sum(layer.thickness_m for layer in soil.layers)
    return SoilBelowSurveySite(
        thickness_m=thickness,
        mean_shear_wave_velocity_m_s=thickness / sum(layer.thickness_m / layer.velocity_m_s for layer in soil.layers),
        equivalent_linear=any(layer.curve is not None for layer in soil.layers),
        converged="not converged" not in step.get("chosen", ""),
        strain_exceeds_soil_curve=STRAIN_BEYOND_CURVE_PHRASE in step.get("chosen", ""),
        rock_pga=float(before),
        surface_pga=float(after),
    )
