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
    alignment_with_references_figure,
    overturned_share_contrast_figure,
)
from overturning.figures.fall_rate import fragility_curves_figure, overturned_fraction_figure
from overturning.figures.film_words import station_and_event_text
from overturning.figures.maps import fall_map_figure
from overturning.figures.observed_rose import ObservedRose, observed_roses_figure
from overturning.figures.polar_map import azimuth_map_figure
from overturning.figures.record import scene_and_element_title_line
from overturning.figures.scene import scenes_figure
from overturning.figures.site_map import earthquake_map_figures, earthquakes_on_map
from overturning.figures.study import study_figure_functions
from overturning.figures.style import figures_for_phone, project_style
from overturning.figures.survey import SurveyFigureData, survey_falls_figure
from overturning.figures.svg_translation import translate_svg
from overturning.figures.write import save_figure_files
from overturning.files import write_text
from overturning.findings.collect import Findings, findings_from_results
from overturning.findings.contrast import VariantContrast
from overturning.findings.observed import ObservedFallsFinding
from overturning.findings.results import StudyResults, open_study_results
from overturning.findings.surveys import SurveyFindings
from overturning.findings.values import Estimate
from overturning.statistics.circular import LEAST_RESULTANT
from overturning.study.cube import first_shown_height_and_friction
from overturning.study.scenes import NOMINAL, variant_scene
from overturning.surveys.population import intensities_by_measure, jma_intensities_of_motions
from overturning.surveys.posterior import SurveyInversionResult
from overturning.surveys.stones import OCTANTS
from overturning.translation.texts import ENGLISH

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MEASURE: Final = "PGV"
"""Intensity measure of the figure of fall rates."""

NARROW: Final = "narrow/"
"""Start of the names of figures that are drawn for a phone."""

CHAPTER: Final = ("polar", "intensity")
"""Folders with a figure of each record, in the order of its chapter."""


def study_figures(folder: Path) -> dict[str, Path]:
    """Return the figures of a study's folder of figures by name, such as ``rose`` or ``polar/rinaldi``."""
    return {str(path.relative_to(folder).with_suffix("")): path for path in sorted(folder.rglob("*.svg"))}


def translate_figures(figures: dict[str, Path], folder: Path, language: str) -> dict[str, Path]:
    """Return figures with English texts translated into a language, as copies in a folder.

    For English, return the files themselves, whatever their language.
    """
    if language == ENGLISH:
        return figures
    translated = {name: folder / f"{name}.svg" for name in figures}
    for name, path in figures.items():
        write_text(translated[name], translate_svg(path.read_text(encoding="utf-8"), language))
    return translated


def chapters(figures: dict[str, Path], records: list[str]) -> dict[str, tuple[str, ...]]:
    """Return the names of the figures in the chapter of each record."""
    named = {record: tuple(f"{part}/{record}" for part in CHAPTER) for record in records}
    return {record: tuple(name for name in names if name in figures) for record, names in named.items()}


REPORT_FIGURES: "Final[dict[str, Callable[[StudyResults, Findings], Sequence[Callable[[], Figure]]]]]" = {
    "references": lambda _, found: [partial(_references, found)] if found.reference_alignments else [],
    "contrast": lambda _, found: [
        partial(_contrast, one, settings_of(found, one)) for one in found.contrasts if one.primary
    ][-1:],
    "maps": lambda results, found: (
        [partial(_maps, results, found)] if found.maps.records and results.model.one_component else []
    ),
    "scene": lambda results, found: (
        [partial(scenes_figure, [variant_scene(results.study, name) for name in results.cubes])]
        if found.element_outcomes
        else []
    ),
    "fall-rate": lambda results, found: [partial(_fall_rate, results)] if found.population is not None else [],
    "surveys": lambda _, found: [partial(_surveys, found.surveys)] if found.surveys else [],
    "backwards": lambda results, _: [partial(posterior, inferred) for inferred in results.inferred_motions],
}
"""Functions that return the functions drawing a figure of the report alone, by its name; [] if a study has none.

Of ``backwards`` there is one for each inferred motion, named ``backwards-1`` and so on.
"""

STUDY_FIGURES: "Final[dict[str, Callable[[StudyResults, Findings], Sequence[Callable[[], Figure]]]]]" = (
    REPORT_FIGURES
    | {"fragility": lambda results, found: [partial(_fragility, results)] if found.population is not None else []}
)
"""`REPORT_FIGURES`, and figures that need all results of a study but are not in its report."""


def draw_study_figure(kind: str, results_path: Path) -> "Figure":
    """Draw the figure `kind` of `STUDY_FIGURES` from the results of a study; an `ArgumentError` if it has none."""
    with open_study_results(results_path) as results:
        draw = STUDY_FIGURES[kind](results, findings_from_results(results))
        if not draw:
            raise ArgumentError(f"{kind}: the study {results.study.name} has no such figure; {_NEEDED_KEYS[kind]}")
        with project_style():
            return draw[0]()


_NEEDED_KEYS: Final = {
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


def draw_report_figures(results: StudyResults, found: Findings, folder: Path) -> dict[str, Path]:
    """Draw the figures that belong to the report alone into a folder; return them by name."""
    draw: dict[str, Callable[[], Figure]] = {}
    for kind, functions in REPORT_FIGURES.items():
        for number, function in enumerate(functions(results, found), 1):
            draw[f"{kind}-{number}" if kind == "backwards" else kind] = function
    paths = {name: folder / f"{name}.svg" for name in draw}
    narrow = {}
    with project_style():
        for name, figure in draw.items():
            save_figure_files(figure(), paths[name])
        with figures_for_phone():
            own = ((name, figure()) for name, figure in draw.items())
            for name, drawn in chain(own, _narrow_study_figures(results, found)):
                narrow[f"{NARROW}{name}"] = folder / NARROW / f"{name}.svg"
                save_figure_files(drawn, narrow[f"{NARROW}{name}"])
    return paths | narrow


def _narrow_study_figures(results: StudyResults, found: Findings) -> Iterator[tuple[str, "Figure"]]:
    """Yield name and figure for a phone of those figures of the study that the report shows outside folds."""
    groups = results.fall_axes_by_group
    draw = study_figure_functions(results.cube, results.intensity, results.logistic_fit, groups)
    if any(bool(data["cosine"].notnull().any()) for data in groups.values()):
        yield "axes", draw["axes"]()
    for number, figure in enumerate(earthquake_map_figures(earthquakes_on_map(results.cube)), 1):
        yield f"maps/{number}", figure
    if not found.direction.has_comparable_axis:
        yield "rose", draw["rose"]()
    if results.model.one_component:
        yield "plane", draw["plane"]()
        return
    ids = [name.id for name in results.record_names]
    for record in found.maps.records:
        one = results.cube.isel(record=ids.index(record.record)).load()
        title = station_and_event_text(record.station or record.record, record.event)
        yield (
            f"polar/{record.record}",
            fall_map_figure(
                one.sel(first_shown_height_and_friction(one)), f"{title}{scene_and_element_title_line(one)}"
            ),
        )


def settings_of(found: Findings, one: VariantContrast) -> tuple[str, str]:
    """Return the names of the two settings of a contrast for the legend of its figure."""
    if one.differs_in == ["vertical"]:
        names = ("with vertical motion", "without vertical motion")
        return names if found.study.vertical_motion else names[::-1]
    if one.differs_in == ["scene"]:
        return one.scene_here, one.scene_there
    if one.differs_in == ["site"]:
        soil = f"soil of {one.variant}" if one.soil_thickness_m is None else f"{one.soil_thickness_m:g} m of soil"
        return "ground as recorded", soil
    return "this study", f"variant {one.variant}"


def drawn_estimate(one: Estimate) -> PlottedEstimate:
    """Return an estimate in the form in which figures draw it."""
    return PlottedEstimate(one.value, one.low, one.high, one.earthquakes)


def _references(found: Findings) -> "Figure":
    """Draw the alignment of the falls with the axis of each reference."""
    groups = {}
    for group in found.reference_alignments:
        axes = [one for one in group.references if one.alignment_kind == "axis"]
        groups[group.group] = {one.reference: drawn_estimate(one.all_b_over_h) for one in axes}
    return alignment_with_references_figure(groups)


def _contrast(one: VariantContrast, settings: tuple[str, str]) -> "Figure":
    """Draw the shares of the cases that fall under both settings, over all cases and by B/H, and their difference."""
    shapes = one.by_b_over_h if len(one.by_b_over_h) > 1 else []
    rows = ["all cases", *(f"B/H {each.b_over_h:.3g}" for each in shapes)]
    here = [
        drawn_estimate(one.share_overturned_study),
        *(drawn_estimate(each.share_overturned_study) for each in shapes),
    ]
    there = [
        drawn_estimate(one.share_overturned_variant),
        *(drawn_estimate(each.share_overturned_variant) for each in shapes),
    ]
    differences = [
        drawn_estimate(one.share_difference),
        *(drawn_estimate(each.share_difference) for each in shapes),
    ]
    if one.rate_here is not None and one.rate_there is not None and one.primary_difference != one.share_difference:
        rows = ["stones of a cemetery", "all blocks", *rows[1:]]
        here, there = [drawn_estimate(one.rate_here), *here], [drawn_estimate(one.rate_there), *there]
        differences = [drawn_estimate(one.primary_difference), *differences]
    return overturned_share_contrast_figure(rows, dict(zip(settings, (here, there), strict=True)), differences)


def _surveys(surveys: Sequence[SurveyFindings]) -> "Figure":
    def mean(direction: float | None, resultant: float | None) -> float | None:
        return direction if resultant is not None and resultant >= LEAST_RESULTANT else None

    def counts(by_octant: dict[str, float | None]) -> FloatArray:
        return np.array([by_octant.get(octant) or 0.0 for octant in OCTANTS])

    def share(one: Any) -> PlottedEstimate:
        return PlottedEstimate(None) if one is None else PlottedEstimate(one.value, one.low, one.high)

    return survey_falls_figure(
        [
            SurveyFigureData(
                name=f"{one.stones}, {one.record}",
                observed=counts(one.observed_by_octant),
                computed=counts(one.predicted_by_octant),
                observed_mean_deg=mean(one.mean_direction_deg, one.resultant),
                computed_mean_deg=mean(one.predicted_mean_direction_deg, one.predicted_resultant),
                observed_share=share(one.observed_fall_share),
                computed_share=share(one.computed_fall_share),
            )
            for one in surveys
        ]
    )


def draw_surveys(surveys: Sequence[SurveyFindings], path: Path) -> None:
    """Draw observed next to computed falls of surveys into a file."""
    with project_style():
        save_figure_files(_surveys(surveys), path)


def draw_observed_roses(observed: Sequence[ObservedFallsFinding], path: Path) -> None:
    """Draw roses of the observed falls of a survey into a file, with names only if there are several roses."""
    roses = [
        ObservedRose(
            name="" if len(observed) == 1 else one.site or ("all sites" if number == 0 else "no site"),
            falls_by_sector=np.array([count or 0.0 for count in one.falls_by_sector]),
            direction_deg=one.direction.mean_deg,
            direction_half_width_deg=one.direction.half_width_deg,
            axis_deg=one.axis.mean_deg,
            axis_half_width_deg=one.axis.half_width_deg,
        )
        for number, one in enumerate(observed)
    ]
    with project_style():
        save_figure_files(observed_roses_figure(roses), path)


def _maps(results: StudyResults, found: Findings) -> "Figure":
    """Draw the polar maps of the chosen records on one radial scale."""
    ids = [name.id for name in results.record_names]
    places = [ids.index(one.record) for one in found.maps.records]
    block = results.cube.sel(first_shown_height_and_friction(results.cube, results.study))
    cubes = [block.isel(record=place).load() for place in places]
    peaks = [results.intensity["pgv"].isel(record=place) for place in places]
    return azimuth_map_figure(cubes, "", peaks)


def _fall_rate(results: StudyResults) -> "Figure":
    """Draw the fall rates of the study's population by peak velocity and by JMA intensity."""
    found = results.populations[NOMINAL]
    curve = next(one for one in results.fragility_curves if one.name == "all stones" and one.measure == MEASURE)
    rates, jma = found["free_fall_rate"].to_numpy(), jma_intensities_of_motions(found, results.intensity)
    return overturned_fraction_figure(rates, intensities_by_measure(found, results.intensity)[MEASURE], curve, jma)


def _fragility(results: StudyResults) -> "Figure":
    """Draw the fragility curves of the study's population by PGA, PGV and SA(T), with the fall rates."""
    found = results.populations[NOMINAL]
    curves = [one for one in results.fragility_curves if one.name == "all stones" and one.measure != "PGV/PGA"]
    levels = intensities_by_measure(found, results.intensity)
    return fragility_curves_figure(found["free_fall_rate"].to_numpy(), levels, curves)


def posterior(found: SurveyInversionResult) -> "Figure":
    """Draw the posterior of a motion that was inferred from a survey."""
    from overturning.figures.backwards import motion_posterior_figure

    one, curves = found.posterior, {}
    for name, values in found.pgv_and_pga_by_motion_and_level.items():
        order = np.argsort(values.ravel(), kind="stable")
        posterior_mass, prior_mass = (each.sum(axis=2).ravel()[order].cumsum() for each in (one.probability, one.prior))
        curves[name] = (values.ravel()[order], posterior_mass, prior_mass, one.credible_interval(values))
    shares = dict(zip(one.sources, one.motion_probabilities().tolist(), strict=True))
    return motion_posterior_figure(
        found.name, one.velocity_axis_probabilities(), found.credible_axis_arc_deg, shares, curves
    )


def draw_posterior(found: SurveyInversionResult, path: Path) -> None:
    """Draw the posterior of a motion that was inferred from a survey into a file."""
    with project_style():
        save_figure_files(posterior(found), path)


def draw_fall_rates(results: StudyResults, path: Path) -> None:
    """Draw the fall rates of the study's population into a file."""
    with project_style():
        save_figure_files(_fall_rate(results), path)
