"""Findings on soil below the stones: fall rates on each soil profile, fall axes, and notes on the soil analyses."""

import numpy as np
import xarray as xr

from overturning.arrays import FloatArray
from overturning.findings.results import StudyResults
from overturning.findings.values import FindingBaseClass, OptionalNumberOrInfinity
from overturning.records.site import STRAIN_BEYOND_CURVE_PHRASE, SoilSite
from overturning.statistics.circular import MIN_RESULTANT_WITH_MEAN_DIRECTION, wrap_axis_difference_to_90_deg
from overturning.study.cube import record_sources_and_processing_by_id
from overturning.study.scenes import (
    NAME_OF_STUDY_ITSELF_AMONG_VARIANTS,
    settings_changed_by_variant,
)


class SoilLayerSummary(FindingBaseClass):
    """Thickness and shear-wave velocity of one layer of the soil under the stones."""

    thickness_m: float
    """Thickness, m."""
    shear_wave_velocity_m_s: float
    """Shear-wave velocity, m/s."""


class SoilProfileFallRatesAtAmplitude(FindingBaseClass):
    """Share of a stone population that falls at a site with one soil profile, at one amplitude factor."""

    variant: str
    """Name of the variant that sets the soil; "nominal" for the study itself."""
    layers: list[SoilLayerSummary]
    """Layers from the surface down; empty for the records without soil."""
    has_equivalent_linear_layer: bool
    """True if a layer softens with strain (equivalent-linear computation), False if all layers are linear."""
    amplitude_factor: float
    """Factor on the motion."""
    median_pga_m_s2: OptionalNumberOrInfinity
    """Median of the largest horizontal acceleration over records, m/s²."""
    mean_fall_rate: OptionalNumberOrInfinity
    """Mean over records of the share of the stones that fall."""
    median_angle_to_fall_axis_without_soil_deg: OptionalNumberOrInfinity
    """Median angle, over records, between the fall axes on this ground and on the ground as recorded; None if the
    planes of the study impose the axis."""
    records_with_fall_axis_with_and_without_soil: int
    """Number of records with an axis on both grounds."""
    median_fall_rate: OptionalNumberOrInfinity
    """Median over records of the share of the stones that fall."""
    records_with_at_least_half_fallen: int
    """Number of records under which at least half of the stones fall."""


FALL_RATE_DESCRIPTION = "share of the stones of a cemetery that fall under the records as they are"


def population_fall_rates_by_soil_and_amplitude(results: StudyResults) -> list[SoilProfileFallRatesAtAmplitude]:
    """Compute a population's fall rates by soil profile and amplitude factor; [] without soil variant or population."""
    sites: dict[str, SoilSite | None] = {NAME_OF_STUDY_ITSELF_AMONG_VARIANTS: None}
    sites |= {name: settings_changed_by_variant(results.study, name).site for name in results.study.variants}
    sites = {
        name: site for name, site in sites.items() if site is not None or name == NAME_OF_STUDY_ITSELF_AMONG_VARIANTS
    }
    if len(sites) == 1 or not (rates_by_variant := results.population_rates_by_variant):
        return []
    found = []
    for factor in map(float, rates_by_variant[NAME_OF_STUDY_ITSELF_AMONG_VARIANTS]["amplitude"].to_numpy()):
        for name, site in sites.items():
            rates = [
                rates_by_variant[each].sel(amplitude=factor) for each in (name, NAME_OF_STUDY_ITSELF_AMONG_VARIANTS)
            ]
            rate = rates[0]["fall_rate"]
            accounts = record_sources_and_processing_by_id(results.cubes_by_variant[name]).values()
            has_two_axes = site is not None and not results.simulated_azimuths_impose_fall_axis
            angles = angles_between_soil_and_rock_fall_axes_deg(*rates) if has_two_axes else np.empty(0)
            layers = site.layers if site is not None else ()
            found.append(
                SoilProfileFallRatesAtAmplitude(
                    variant=name,
                    layers=[
                        SoilLayerSummary(thickness_m=one.thickness_m, shear_wave_velocity_m_s=one.velocity_m_s)
                        for one in layers
                    ],
                    has_equivalent_linear_layer=any(layer.curve for layer in layers),
                    amplitude_factor=factor,
                    median_pga_m_s2=float(np.median([one["peaks"]["pga"][1] for one in accounts])) * factor,
                    mean_fall_rate=float(rate.mean()),
                    median_angle_to_fall_axis_without_soil_deg=float(np.median(angles) if angles.size else np.nan),
                    records_with_fall_axis_with_and_without_soil=int(angles.size),
                    median_fall_rate=float(rate.median()),
                    records_with_at_least_half_fallen=int((rate >= 0.5).sum()),
                )
            )
    return found


MIN_FALL_RATE_FOR_FALL_AXIS_COMPARISON = 0.05
"""Smallest fall rate under a record for which the axis of the falls is compared."""


def angles_between_soil_and_rock_fall_axes_deg(
    outcome_rates_on_soil: xr.Dataset, population_outcomes_on_rock_by_record: xr.Dataset
) -> FloatArray:
    """Return the angles, degrees, between the mean fall axes on soil and on rock, for records with both axes.

    Both arguments are results of `population_outcome_rates_by_record` at one amplitude.
    """
    soil_axis, rock_axis = (
        one["fall_axis"].to_numpy() for one in (outcome_rates_on_soil, population_outcomes_on_rock_by_record)
    )
    apart = np.abs(wrap_axis_difference_to_90_deg(soil_axis - rock_axis))
    for found in (outcome_rates_on_soil, population_outcomes_on_rock_by_record):
        clear = (found["fall_rate"] >= MIN_FALL_RATE_FOR_FALL_AXIS_COMPARISON) & (
            found["fall_resultant"] >= MIN_RESULTANT_WITH_MEAN_DIRECTION
        )
        apart = np.where(clear, apart, np.nan)
    return np.asarray(apart[np.isfinite(apart)])


def notes_on_unconverged_soil_analyses(results: StudyResults) -> list[str]:
    """Return a note, "variant, record: components", on each soil-response analysis that did not converge."""
    return _soil_analysis_notes_that_contain(results, "not converged")


def notes_on_soil_strain_beyond_curves(results: StudyResults) -> list[str]:
    """Return a note, "variant, record: components", on each soil-response analysis with strain beyond a soil curve."""
    return _soil_analysis_notes_that_contain(results, STRAIN_BEYOND_CURVE_PHRASE)


def _soil_analysis_notes_that_contain(results: StudyResults, note_text: str) -> list[str]:
    """Return "variant, record: notes" for each soil-response analysis that has notes containing the text."""
    found = []
    for variant in results.study.variants:
        if settings_changed_by_variant(results.study, variant).site is None:
            continue
        for record, account in record_sources_and_processing_by_id(results.cubes_by_variant[variant]).items():
            text = (account["steps"] or [{}])[-1].get("chosen", "")
            parts = [part for part in text.split("; ") if note_text in part]
            found += [f"{variant}, {record}: {'; '.join(parts)}"] if parts else []
    return found
