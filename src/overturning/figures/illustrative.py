"""Films and figures of a study's illustrative cases."""

import shutil
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from overturning.dem.trajectory import trajectory
from overturning.figures.boundary import overturning_boundary_figure
from overturning.figures.drawn_case import IllustrativeCaseWithFigures, write_illustrative_case_list
from overturning.figures.film_case import film_title_facts
from overturning.figures.film_of_trajectory import SIMULATED_TIME_AFTER_OUTCOME_S, film_of_trajectories
from overturning.figures.film_strip import film_strip_figure
from overturning.figures.film_words import (
    film_title_text,
    panel_heading_of_compared_setting,
    station_and_event_text_of_cube,
)
from overturning.figures.ground import fourier_and_response_spectra_figure, hodograph_figure
from overturning.figures.response import rotation_slip_and_uplift_figure, tilt_path_and_hodographs_figure
from overturning.figures.style import use_package_matplotlib_settings
from overturning.figures.write import empty_folder_then_write_list_of_new_files, save_figure_files
from overturning.labels import friction_label
from overturning.model.falls import default_model_of_same_kind_as_results_cube
from overturning.model.planes import PlanarModel
from overturning.motion.motion import Motion
from overturning.records.store import read_record_from_motion_file
from overturning.statistics.boundary import overturning_boundary_b_over_h_by_azimuth
from overturning.statistics.differing_cases import clearest_case_with_differing_outcomes
from overturning.statistics.illustrative import (
    ANY_ELEMENT_FALLS_VARIABLE,
    IllustrativeCase,
    find_best_case_for_each_behaviour,
)
from overturning.study.cube import element_name_to_show, open_cube_for_reading_by_record, study_of_cube
from overturning.study.scenes import (
    NAME_OF_STUDY_ITSELF_AMONG_VARIANTS,
    StudyToSceneSizeConversion,
    compared_element_names_of_study_and_variant,
    numerical_options_of_study,
    record_motion_with_up_only_if_variant_uses_it,
    select_outcomes_of_element,
    settings_changed_by_variant,
    variant_model,
    variant_scene,
    variant_uses_vertical_motion,
)
from overturning.study.schema import Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def choose_simulate_and_draw_illustrative_cases(
    cube_path: Path,
    motion_folder: Path,
    output_folder: Path,
    compared_variant_cube_path: Path | None = None,
    candidate_record_ids: Sequence[str] = (),
) -> None:
    """Choose illustrative cases of a study, simulate them again, and write their films and figures.

    Writes into `output_folder`: ``cases.json`` (title, rule, outcomes, film and figures of each case), and for case K,
    counted from 1, the film strip ``K-strip.svg`` and the figures ``K-response.svg``, ``K-boundary.svg``,
    ``K-spectra.svg`` and ``K-hodograph.svg`` (2-D), or ``K-axis.svg`` and, for a second panel, ``K-axis-2.svg`` (3-D).

    Parameters
    ----------
    cube_path, motion_folder, output_folder : Path
        Cube of the study, folder of its motions, and folder for the results.
    compared_variant_cube_path : Path, optional
        Cube of the variant with which the study is compared. If outcomes of the two differ, the first case shows the
        clearest difference: a block that falls in only one of them, or to opposite sides.
    candidate_record_ids : sequence of str, optional
        Records among which the cases are chosen, such as those of surveys; by default all records.
    """
    with (
        empty_folder_then_write_list_of_new_files(output_folder),
        open_cube_for_reading_by_record(cube_path, element_name=None) as elements,
        use_package_matplotlib_settings(),
    ):
        chosen = (
            np.isin(elements["record_id"].to_numpy().astype(str), candidate_record_ids)
            if candidate_record_ids
            else slice(None)
        )
        elements = elements.isel(record=chosen)
        cube = _select_default_element_and_add_any_fall_variable(elements)
        cases = find_best_case_for_each_behaviour(cube)
        if compared_variant_cube_path is not None:
            with open_cube_for_reading_by_record(compared_variant_cube_path, element_name=None) as other_cube:
                variant = str(other_cube.attrs["variant"])
                here, there = compared_element_names_of_study_and_variant(study_of_cube(elements), variant)
                answer = clearest_case_with_differing_outcomes(
                    select_outcomes_of_element(elements, here),
                    select_outcomes_of_element(other_cube.isel(record=chosen), there),
                    (NAME_OF_STUDY_ITSELF_AMONG_VARIANTS, variant),
                )
            cases = cases if answer is None else [answer, *cases]
        drawn_files = dict[tuple[str, ...], Path]()
        rows = [
            _simulate_and_draw_illustrative_case(cube, case, motion_folder, output_folder / str(number), drawn_files)
            for number, case in enumerate(cases, 1)
        ]
        write_illustrative_case_list(rows, output_folder)


def _select_default_element_and_add_any_fall_variable(cube: "xr.Dataset") -> "xr.Dataset":
    """Select a scene's default element from a cube, and add a variable that is True if any element falls."""
    if "element" not in cube.dims:
        return cube
    falls = (abs(cube["overturned"]) == 1).any("element")
    return select_outcomes_of_element(cube, element_name_to_show(cube)).assign({ANY_ELEMENT_FALLS_VARIABLE: falls})


FileSuffixDrawingAltTextAndOptions = tuple[str, "Callable[[], Figure]", str, dict[str, float]]
"""A figure that accompanies a film: suffix of the file name, function that draws it, alternative text, options for the
report."""

FIGURE_NAMES_SHARED_BY_CASES_OF_MOTION = ("boundary", "hodograph")
"""Figures that are the same for all cases of a 2-D study under one motion."""


def _simulate_and_draw_illustrative_case(
    cube: "xr.Dataset",
    case: IllustrativeCase,
    motion_folder: Path,
    figure_path_before_kind_and_extension: Path,
    file_by_figure_and_motion: dict[tuple[str, ...], Path],
) -> IllustrativeCaseWithFigures:
    """Simulate one illustrative case again, and draw its film and figures.

    `figure_path_before_kind_and_extension` is the path of the figures without ``-strip.svg`` and so on.
    `file_by_figure_and_motion` maps (figure name, record id, variant) to the first file of a figure in
    `FIGURE_NAMES_SHARED_BY_CASES_OF_MOTION`; a later case copies this file. New files are added to the mapping.
    """
    study, one = study_of_cube(cube), cube.isel(record=case.record_index).load()
    record = str(one["record_id"].item())
    settings = case.variant_name_by_panel or (NAME_OF_STUDY_ITSELF_AMONG_VARIANTS,) * len(case.panel_azimuths_deg)
    every = [_read_motion_for_variant(study, motion_folder, record, name) for name in settings]
    paths = [
        simulate_block_trajectories(study, motion, case.block_coordinates, [angle], name)[0]
        for motion, angle, name in zip(every, case.panel_azimuths_deg, settings, strict=True)
    ]
    motion = every[0]
    headings = [
        panel_heading_of_variant(study, *pair)
        for pair in zip(case.variant_name_by_panel, reversed(case.variant_name_by_panel), strict=True)
    ]
    film = film_of_trajectories(paths, every, _film_title(study, one, case, paths), headings=headings)
    place = station_and_event_text_of_cube(one)
    title = f"{place}: {block_label(study, case.block_coordinates)}"
    strip_figure = partial(film_strip_figure, film, has_title=False)
    drawn: list[FileSuffixDrawingAltTextAndOptions] = [("strip", strip_figure, "four frames of the film", {})]
    if default_model_of_same_kind_as_results_cube(one).is_planar:
        drawn += _figure_functions_for_planar_film(one, paths, motion, (title, place))
    else:
        about = "tilt of the axis towards north and east, and hodographs of the ground"
        several = enumerate(zip(paths, every, strict=True), 1)
        drawn += [
            ("axis" if n == 1 else f"axis-{n}", partial(tilt_path_and_hodographs_figure, path, own, title), about, {})
            for n, (path, own) in several
        ]
    figures = {}
    for name, draw, alt, options in drawn:
        path = figure_path_before_kind_and_extension.with_name(
            f"{figure_path_before_kind_and_extension.name}-{name}.svg"
        )
        same = (
            file_by_figure_and_motion.setdefault((name, record, settings[0]), path)
            if name in FIGURE_NAMES_SHARED_BY_CASES_OF_MOTION
            else path
        )
        if same == path:
            save_figure_files(draw(), path)
        else:
            shutil.copyfile(same, path)
        figures[path.name] = {"alt": alt, **options}
    strip = f"{figure_path_before_kind_and_extension.name}-strip.svg"
    return IllustrativeCaseWithFigures(
        title=case.title,
        selection_rule=case.selection_rule_text,
        block_and_motion_description=film.title,
        block_parameters_text=block_label(study, case.block_coordinates),
        record=record,
        variant_name_by_panel=settings,
        panel_headings=tuple(panel.title for panel in film.panels),
        panel_outcomes=tuple(panel.outcome_sentence for panel in film.panels),
        film=film.player_data(),
        film_strip_file_name=strip,
        strip_alt=str(figures.pop(strip)["alt"]),
        keyboard_help=film.panels[0].keyboard_help_specific_to_2d_or_3d,
        figure_texts_and_options_by_file=figures,
    )


def _read_motion_for_variant(study: Study, motion_folder: Path, record_id: str, variant: str) -> Motion:
    """Read the motion of a record as a study variant uses it: on soil or rock, with or without vertical component."""
    folder = motion_folder / variant if settings_changed_by_variant(study, variant).site else motion_folder
    return record_motion_with_up_only_if_variant_uses_it(
        study, read_record_from_motion_file(folder / f"{record_id}.nc"), variant
    )


def _film_title(
    study: Study, record_cube: "xr.Dataset", case: IllustrativeCase, trajectories: Sequence["xr.Dataset"]
) -> str:
    """Return the title of the film of an illustrative case: stone, friction, azimuth and record."""
    single = len(set(case.panel_azimuths_deg)) == 1
    sizes = {name: float(trajectories[0].attrs[name]) for name in ("height", "b_over_h", "friction")}
    place = station_and_event_text_of_cube(record_cube)
    direction = case.panel_azimuths_deg[0] if single else None
    aspect = {"aspect": case.block_coordinates["aspect"]} if "aspect" in case.block_coordinates else {}
    return film_title_text(
        film_title_facts(variant_model(study), sizes | aspect, place, motion_azimuth_or_orientation_deg=direction)
    )


def panel_heading_of_variant(study: Study, variant: str, variant_of_other_panel: str) -> str:
    """Return the heading of a film panel for a variant: the setting in which it differs from another variant."""
    own, other = (settings_changed_by_variant(study, name) for name in (variant, variant_of_other_panel))
    if variant_uses_vertical_motion(study, variant) != variant_uses_vertical_motion(study, variant_of_other_panel):
        kind = "vertical" if variant_uses_vertical_motion(study, variant) else "level"
        return panel_heading_of_compared_setting(kind)
    if (own.scene or study.scene) != (other.scene or study.scene):
        return panel_heading_of_compared_setting("scene", variant_scene(study, variant).name)
    if own.site != other.site:
        return panel_heading_of_compared_setting("site" if own.site else "recorded", variant)
    return panel_heading_of_compared_setting(
        "study" if variant == NAME_OF_STUDY_ITSELF_AMONG_VARIANTS else "variant", variant
    )


def block_label(study: Study, block_parameters: dict[str, float]) -> str:
    """Return B/H, height (m) and friction of a block as text for a title."""
    oblong = f", D/B = {block_parameters['aspect']:g}" if variant_model(study).depth_over_width_is_parameter else ""
    coefficient = friction_label(study, block_parameters["friction"])
    return f"B/H = {block_parameters['b_over_h']:.3g}{oblong}, H = {block_parameters['height']:.3g} m, {coefficient}"


def _figure_functions_for_planar_film(
    record_cube: "xr.Dataset",
    trajectories: list["xr.Dataset"],
    motion: Motion,
    film_title_and_station_event: tuple[str, str],
) -> list[FileSuffixDrawingAltTextAndOptions]:
    """Return the figures of a 2-D film: response over time, overturning boundary, spectra and hodograph.

    Each is a tuple of file suffix, drawing function, alternative text and options. `film_title_and_station_event` has
    the title of the film, and station and earthquake as one text.
    """
    (title, place), normal = film_title_and_station_event, float(record_cube["fault_normal"])
    azimuths = list(dict.fromkeys(float(path.attrs["azimuth_deg"]) for path in trajectories))
    if len(azimuths) == 1:
        azimuths.append((azimuths[0] + 90.0) % 360.0)

    def draw_overturning_boundary() -> "Figure":
        edge = overturning_boundary_b_over_h_by_azimuth(record_cube).assign_attrs(record_cube.attrs)
        return overturning_boundary_figure(edge, float(record_cube["b_over_h"].max()), normal, place)

    seen = "acceleration, velocity and displacement seen from above"
    return [
        (
            "response",
            partial(rotation_slip_and_uplift_figure, trajectories, title),
            "rotation, slip and uplift against time",
            {"most_height": 14},
        ),
        ("boundary", draw_overturning_boundary, "largest B/H that falls, by azimuth", {"most_height": 11}),
        (
            "spectra",
            partial(fourier_and_response_spectra_figure, motion, azimuths, place),
            "Fourier and response spectra",
            {},
        ),
        ("hodograph", partial(hodograph_figure, motion, normal, place), seen, {}),
    ]


def simulate_block_trajectories(
    study: Study,
    motion: Motion,
    block_parameters: dict[str, float],
    azimuths_or_orientations_deg: Sequence[float],
    variant: str = NAME_OF_STUDY_ITSELF_AMONG_VARIANTS,
) -> list["xr.Dataset"]:
    """Simulate one block of a study's variant for each direction, degrees; return one trajectory per direction.

    The trajectories of a scene go on until fallen stones lie. Height (m) and B/H of the block are those of the study;
    they are converted to the sizes of the variant's reference stone if the variant has another scene.
    """
    model, sizes = variant_model(study, variant), StudyToSceneSizeConversion.for_variant(study, variant)
    height, ratio = (np.array([block_parameters[name]]) for name in ("height", "b_over_h"))
    scaled = block_parameters | {
        "height": float(sizes.to_variant_reference_stone_heights(height)[0]),
        "b_over_h": float(sizes.to_variant_reference_stone_b_over_h(ratio, ratio)[0]),
    }
    own = {
        "b_over_h": not model.slenderness_is_parameter,
        "friction": isinstance(model, PlanarModel) and not model.scene.has_contact_with_unset_friction,
    }
    given = {name: value for name, value in scaled.items() if not own.get(name)}
    options: dict[str, Any] = {
        **given,
        **vars(numerical_options_of_study(study)),
        "aftermath": SIMULATED_TIME_AFTER_OUTCOME_S,
    }
    return [
        trajectory(motion, model, **options, **{f"{model.direction_dimension_name}_deg": angle})
        for angle in azimuths_or_orientations_deg
    ]
