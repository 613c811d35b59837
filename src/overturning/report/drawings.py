"""Figures of a report: those of the study by name, and those that the report draws from its findings and cubes."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.figures.answer import (
    PlottedEstimate,
    fall_alignment_with_reference_axes_figure,
)
from overturning.figures.fall_rate import fragility_curves_figure, overturned_fraction_by_intensity_figure
from overturning.figures.film_words import station_and_event_text
from overturning.figures.maps import fall_map_figure
from overturning.figures.observed_rose import ObservedFallRoseCounts, observed_fall_roses_figure
from overturning.figures.polar_map import fall_map_by_azimuth_figure
from overturning.figures.record import second_title_line_with_scene_and_element
from overturning.figures.scene import draw_scenes_side_by_side
from overturning.figures.site_map import figures_with_several_earthquake_maps, mappable_earthquakes
from overturning.figures.study import all_records_non_map_figure_functions_by_name
from overturning.figures.style import arrange_panels_for_phone, use_package_matplotlib_settings
from overturning.figures.survey import SurveyFigureData, survey_falls_figure
from overturning.figures.svg_translation import translate_svg
from overturning.figures.write import save_figure_files
from overturning.files import write_text
from overturning.findings.collect import Findings, findings_from_results
from overturning.findings.observed import ObservedFallsFinding
from overturning.findings.opening import open_study_results
from overturning.findings.results import StudyResults
from overturning.findings.surveys import SurveyPredictionFindings
from overturning.report.share_drawings import (
    convert_to_plotted_estimate,
    draw_overturned_shares_of_study_and_variant,
    legend_names_of_study_and_variant,
)
from overturning.statistics.circular import MIN_RESULTANT_WITH_MEAN_DIRECTION
from overturning.study.cube import default_height_and_friction_of_figures
from overturning.study.scenes import NAME_OF_STUDY_ITSELF_AMONG_VARIANTS, variant_scene
from overturning.surveys.population import jma_intensities_of_scaled_motions, motion_intensities_by_measure
from overturning.surveys.posterior import SurveyInversionResult
from overturning.surveys.stones import OCTANTS
from overturning.translation.texts import ENGLISH

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FALL_RATE_FIGURE_INTENSITY_MEASURE: Final = "PGV"
"""Intensity measure of the figure of fall rates."""

PHONE_FIGURE_PREFIX: Final = "narrow/"
"""Start of the names of figures that are drawn for a phone."""

RECORD_CHAPTER_FIGURE_FOLDERS: Final = ("polar", "intensity")
"""Folders with a figure of each record, in the order of its chapter."""


def svg_path_by_study_figure_name(figures_folder: Path) -> dict[str, Path]:
    """Return paths of the SVG files in a study's folder of figures, by name such as ``rose`` or ``polar/rinaldi``."""
    return {
        str(path.relative_to(figures_folder).with_suffix("")): path for path in sorted(figures_folder.rglob("*.svg"))
    }


def write_translated_figures(
    figure_path_by_name: dict[str, Path], output_folder: Path, language: str
) -> dict[str, Path]:
    """Write copies of SVG figures with their English texts translated, into a folder; return their paths by name.

    For English nothing is written, and `figure_path_by_name` is returned.
    """
    if language == ENGLISH:
        return figure_path_by_name
    translated = {name: output_folder / f"{name}.svg" for name in figure_path_by_name}
    for name, path in figure_path_by_name.items():
        write_text(translated[name], translate_svg(path.read_text(encoding="utf-8"), language))
    return translated


def names_of_shown_figures_by_record(
    figure_path_by_name: dict[str, Path], record_ids: list[str]
) -> dict[str, tuple[str, ...]]:
    """Return, by record id, the names of the figures that the report shows for each record, as far as they exist."""
    named = {record: tuple(f"{part}/{record}" for part in RECORD_CHAPTER_FIGURE_FOLDERS) for record in record_ids}
    return {record: tuple(name for name in names if name in figure_path_by_name) for record, names in named.items()}


FIGURES_DRAWN_WITH_REPORT: "Final[dict[str, Callable[[StudyResults, Findings], Sequence[Callable[[], Figure]]]]]" = {
    "references": lambda _, findings: (
        [partial(_draw_fall_alignment_with_reference_axes, findings)] if findings.reference_alignments else []
    ),
    "contrast": lambda _, findings: [
        partial(draw_overturned_shares_of_study_and_variant, one, legend_names_of_study_and_variant(findings, one))
        for one in findings.contrasts
        if one.is_primary_comparison
    ][-1:],
    "maps": lambda results, findings: (
        [partial(_draw_polar_fall_maps, results, findings)] if findings.maps.records and results.model.is_planar else []
    ),
    "scene": lambda results, findings: (
        [partial(draw_scenes_side_by_side, [variant_scene(results.study, name) for name in results.cubes_by_variant])]
        if findings.element_outcomes
        else []
    ),
    "fall-rate": lambda results, findings: (
        [partial(_draw_population_fall_rates, results)] if findings.population is not None else []
    ),
    "surveys": lambda _, findings: (
        [partial(_draw_observed_and_computed_falls, findings.surveys)] if findings.surveys else []
    ),
    "backwards": lambda results, _: [
        partial(draw_ground_motion_posterior, inferred) for inferred in results.inferred_motions
    ],
}
"""Functions that return the functions drawing a figure that is written with the report, by its name; [] if none.

Of ``backwards`` there is one for each inferred motion, named ``backwards-1`` and so on.
"""

STUDY_FIGURES: "Final[dict[str, Callable[[StudyResults, Findings], Sequence[Callable[[], Figure]]]]]" = (
    FIGURES_DRAWN_WITH_REPORT
    | {
        "fragility": lambda results, findings: (
            [partial(_draw_fragility_curves, results)] if findings.population is not None else []
        )
    }
)
"""`FIGURES_DRAWN_WITH_REPORT`, and figures that need all results of a study but are not in its report."""


def draw_study_figure(figure_name: str, results_folder_or_cube_path: Path) -> "Figure":
    """Draw a figure of `STUDY_FIGURES` for a study; raise an `ArgumentError` if the study has no such figure."""
    with open_study_results(results_folder_or_cube_path) as results:
        draw = STUDY_FIGURES[figure_name](results, findings_from_results(results))
        if not draw:
            raise ArgumentError(
                f"{figure_name}: the study {results.study.name} has no such figure; "
                f"{_REQUIREMENT_BY_FIGURE[figure_name]}"
            )
        with use_package_matplotlib_settings():
            return draw[0]()


_REQUIREMENT_BY_FIGURE: Final = {
    "references": "it needs a 3-D study of a `body`",
    "contrast": "it needs a study with `variants`, and `primary` with `against` one of them",
    "maps": "it needs a 2-D study in which stones fall",
    "scene": "it needs a study of a `scene`",
    "fall-rate": "it needs the key `population`",
    "fragility": "it needs the key `population`",
    "surveys": "it needs a 2-D study with `surveys`",
    "backwards": "it needs `surveys` without `backwards: false`",
}
"""Settings of a study without which it lacks a figure of `STUDY_FIGURES`."""


def write_report_only_figures(results: StudyResults, findings: Findings, output_folder: Path) -> dict[str, Path]:
    """Write figures that only the report shows, and figures for phones, into a folder; return their paths by name."""
    draw: dict[str, Callable[[], Figure]] = {}
    for kind, functions in FIGURES_DRAWN_WITH_REPORT.items():
        for number, function in enumerate(functions(results, findings), 1):
            draw[f"{kind}-{number}" if kind == "backwards" else kind] = function
    paths = {name: output_folder / f"{name}.svg" for name in draw}
    narrow = {}
    with use_package_matplotlib_settings():
        for name, figure in draw.items():
            save_figure_files(figure(), paths[name])
        with arrange_panels_for_phone():
            own = ((name, figure()) for name, figure in draw.items())
            for name, drawn in chain(own, _draw_always_shown_figures_for_phone(results, findings)):
                narrow[f"{PHONE_FIGURE_PREFIX}{name}"] = output_folder / PHONE_FIGURE_PREFIX / f"{name}.svg"
                save_figure_files(drawn, narrow[f"{PHONE_FIGURE_PREFIX}{name}"])
    return paths | narrow


def _draw_always_shown_figures_for_phone(results: StudyResults, findings: Findings) -> Iterator[tuple[str, "Figure"]]:
    """Draw phone versions of study figures that the report always shows (not collapsed); yield names and figures."""
    groups = results.fall_axes_from_fault_normal_by_record_group
    draw = all_records_non_map_figure_functions_by_name(
        results.reference_element_cube, results.intensity_measures, results.logistic_fit, groups
    )
    if any(bool(data["cosine"].notnull().any()) for data in groups.values()):
        yield "axes", draw["axes"]()
    for number, figure in enumerate(
        figures_with_several_earthquake_maps(mappable_earthquakes(results.reference_element_cube)), 1
    ):
        yield f"maps/{number}", figure
    if not findings.direction.has_fall_axis_comparable_with_fault:
        yield "rose", draw["rose"]()
    if results.model.is_planar:
        yield "plane", draw["plane"]()
        return
    ids = [name.id for name in results.record_ids_and_names]
    for record in findings.maps.records:
        one = results.reference_element_cube.isel(record=ids.index(record.record)).load()
        title = station_and_event_text(record.station or record.record, record.event)
        yield (
            f"polar/{record.record}",
            fall_map_figure(
                one.sel(default_height_and_friction_of_figures(one)),
                f"{title}{second_title_line_with_scene_and_element(one)}",
            ),
        )


def _draw_fall_alignment_with_reference_axes(findings: Findings) -> "Figure":
    """Draw the alignment of the falls with the axis of each reference direction, such as the fault normal."""
    groups = {}
    for group in findings.reference_alignments:
        axes = [one for one in group.references if one.axis_or_direction == "axis"]
        groups[group.record_group] = {
            one.reference: convert_to_plotted_estimate(one.alignment_over_all_b_over_h) for one in axes
        }
    return fall_alignment_with_reference_axes_figure(groups)


def _draw_observed_and_computed_falls(survey_findings: Sequence[SurveyPredictionFindings]) -> "Figure":
    """Draw observed next to computed falls of surveys: directions as roses, and shares of fallen stones."""

    def mean_direction_unless_scattered(
        mean_direction_deg: float | None, resultant_length: float | None
    ) -> float | None:
        """Return a mean direction, degrees; None if the directions are too scattered to have one."""
        return mean_direction_deg if (resultant_length or 0.0) >= MIN_RESULTANT_WITH_MEAN_DIRECTION else None

    def counts_in_octant_order(stone_count_by_octant: dict[str, float | None]) -> FloatArray:
        """Convert numbers of stones by name of the compass octant to an array in the order of `OCTANTS`."""
        return np.array([stone_count_by_octant.get(octant) or 0.0 for octant in OCTANTS])

    def convert_share_to_plotted_estimate(share: Any) -> PlottedEstimate:
        """Convert a share of fallen stones to the form that figures draw."""
        return PlottedEstimate(None) if share is None else PlottedEstimate(share.value, share.low, share.high)

    return survey_falls_figure(
        [
            SurveyFigureData(
                name=f"{one.survey_file_name}, {one.record}",
                observed_falls_by_octant=counts_in_octant_order(one.observed_falls_by_octant),
                computed_fall_count_by_octant=counts_in_octant_order(one.predicted_falls_by_octant),
                observed_mean_fall_direction_deg=mean_direction_unless_scattered(
                    one.observed_mean_direction_deg, one.observed_fall_direction_resultant_length
                ),
                computed_mean_fall_direction_deg=mean_direction_unless_scattered(
                    one.predicted_mean_direction_deg, one.predicted_fall_direction_resultant_length
                ),
                observed_fallen_share=convert_share_to_plotted_estimate(one.observed_fall_share),
                computed_fallen_share=convert_share_to_plotted_estimate(one.computed_fall_share),
            )
            for one in survey_findings
        ]
    )


def write_survey_falls_figure(survey_findings: Sequence[SurveyPredictionFindings], path: Path) -> None:
    """Write the figure of observed next to computed falls of surveys to a file."""
    with use_package_matplotlib_settings():
        save_figure_files(_draw_observed_and_computed_falls(survey_findings), path)


def write_roses_of_observed_falls(observed_falls: Sequence[ObservedFallsFinding], path: Path) -> None:
    """Write roses of the observed falls of a survey to a file; sites are named only if there are several roses."""
    roses = [
        ObservedFallRoseCounts(
            name="" if len(observed_falls) == 1 else one.site or ("all sites" if number == 0 else "no site"),
            falls_by_sector=np.array([count or 0.0 for count in one.falls_by_sector]),
            mean_direction_deg=one.direction.mean_deg,
            mean_direction_interval_half_width_deg=one.direction.interval_half_width_deg,
            mean_axis_deg=one.axis.mean_deg,
            mean_axis_interval_half_width_deg=one.axis.interval_half_width_deg,
        )
        for number, one in enumerate(observed_falls)
    ]
    with use_package_matplotlib_settings():
        save_figure_files(observed_fall_roses_figure(roses), path)


def _draw_polar_fall_maps(results: StudyResults, findings: Findings) -> "Figure":
    """Draw the polar maps of falls for the records that the report shows, on one radial scale."""
    ids = [name.id for name in results.record_ids_and_names]
    places = [ids.index(one.record) for one in findings.maps.records]
    block = results.reference_element_cube.sel(
        default_height_and_friction_of_figures(results.reference_element_cube, results.study)
    )
    cubes = [block.isel(record=place).load() for place in places]
    peaks = [results.intensity_measures["pgv"].isel(record=place) for place in places]
    return fall_map_by_azimuth_figure(cubes, "", peaks)


def _draw_population_fall_rates(results: StudyResults) -> "Figure":
    """Draw the fraction of a study's stone population that falls, by peak velocity and by JMA intensity."""
    fall_rates = results.population_rates_by_variant[NAME_OF_STUDY_ITSELF_AMONG_VARIANTS]
    curve = next(
        one
        for one in results.fragility_curves
        if one.stone_class == "all stones" and one.measure == FALL_RATE_FIGURE_INTENSITY_MEASURE
    )
    rates, jma = (
        fall_rates["free_fall_rate"].to_numpy(),
        jma_intensities_of_scaled_motions(fall_rates, results.intensity_measures),
    )
    return overturned_fraction_by_intensity_figure(
        rates,
        motion_intensities_by_measure(fall_rates, results.intensity_measures)[FALL_RATE_FIGURE_INTENSITY_MEASURE],
        curve,
        jma,
    )


def _draw_fragility_curves(results: StudyResults) -> "Figure":
    """Draw the fragility curves of a study's stone population by PGA, PGV and SA(T), with the fall rates."""
    fall_rates = results.population_rates_by_variant[NAME_OF_STUDY_ITSELF_AMONG_VARIANTS]
    curves = [one for one in results.fragility_curves if one.stone_class == "all stones" and one.measure != "PGV/PGA"]
    levels = motion_intensities_by_measure(fall_rates, results.intensity_measures)
    return fragility_curves_figure(fall_rates["free_fall_rate"].to_numpy(), levels, curves)


def draw_ground_motion_posterior(inversion_result: SurveyInversionResult) -> "Figure":
    """Draw the posterior probabilities of the ground motion that was inferred from a survey."""
    from overturning.figures.backwards import inferred_motion_posterior_figure

    one, curves = inversion_result.posterior, {}
    for name, values in inversion_result.pgv_and_pga_by_motion_and_level.items():
        order = np.argsort(values.ravel(), kind="stable")
        posterior_mass, prior_mass = (
            each.sum(axis=2).ravel()[order].cumsum() for each in (one.posterior_probability, one.prior_probability)
        )
        curves[name] = (values.ravel()[order], posterior_mass, prior_mass, one.credible_interval(values))
    shares = dict(zip(one.motion_names, one.posterior_probability_of_each_motion().tolist(), strict=True))
    return inferred_motion_posterior_figure(
        inversion_result.survey_or_site_name,
        one.posterior_probabilities_of_velocity_axis(),
        inversion_result.credible_axis_arc_middle_and_width_deg,
        shares,
        curves,
    )


def write_ground_motion_posterior_figure(inversion_result: SurveyInversionResult, path: Path) -> None:
    """Write the figure with the posterior probabilities of the ground motion inferred from a survey to a file."""
    with use_package_matplotlib_settings():
        save_figure_files(draw_ground_motion_posterior(inversion_result), path)


def write_population_fall_rates_figure(results: StudyResults, path: Path) -> None:
    """Write the figure of the fall rates of a study's population of stones to a file."""
    with use_package_matplotlib_settings():
        save_figure_files(_draw_population_fall_rates(results), path)
