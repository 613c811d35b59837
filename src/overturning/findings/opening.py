"""Opening of the results of a study: its cube, those of its variants, and the numbers stored beside them."""

import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import xarray as xr

from overturning.errors import ResultError
from overturning.files import file_name_if_absolute_else_path
from overturning.findings.results import STUDY_KEYS_NOT_AFFECTING_CUBE, StudyResults, select_cube_of_default_element
from overturning.stored import read_json_result
from overturning.study.convergence import read_convergence_result
from overturning.study.cube import (
    COMPLETE_STUDY_FILE_NAME,
    find_study_with_title_and_figure_settings,
    open_cube_for_reading_by_record,
    study_of_cube,
)
from overturning.study.load import load_study
from overturning.study.recheck import stated_or_computed_hash_of_cube_outcomes
from overturning.study.scenes import (
    NAME_OF_STUDY_ITSELF_AMONG_VARIANTS,
    cube_covers_study_grid,
)
from overturning.study.schema import Study
from overturning.surveys.displacement_results import StoredDisplacementComparison
from overturning.surveys.population import population_outcome_rates_by_record
from overturning.surveys.posterior import read_inversion_result
from overturning.surveys.stored_comparison import read_survey_comparison


def note_on_findings_missing_without_study_file(results: StudyResults) -> str:
    """Return a line naming the parts of the findings that are empty because the cube has no study.yaml next to it.

    The line is "" if the study.yaml is there or nothing is empty. A cube stores neither the settings
    `STUDY_KEYS_NOT_AFFECTING_CUBE` nor surveys.
    """
    names = {"question": "the question", "primary": "the primary statistic"}
    names |= {"population": "the population of stones", "surveys": "surveys"}
    path, study = results.results_folder / COMPLETE_STUDY_FILE_NAME, results.study
    lacking = [text for key, text in names.items() if getattr(study, key) == type(study).model_fields[key].default]
    if not lacking or (path.is_file() and load_study(path).name == study.name):
        return ""
    why = f"is not of the study {study.name!r}" if path.is_file() else "is missing"
    return f"{path} {why}: the findings are without {', '.join(lacking)}; run the study again"


def _check_cube_is_whole_study(cube: xr.Dataset, intensity_measures_by_record: xr.Dataset, cube_path: Path) -> None:
    """Raise a ResultError if a cube is of a variant, or only a part of the cube of its study.

    The cube must have the records of the intensity measures in the same order, since the files are matched by position.
    """
    if (variant := cube.attrs["variant"]) != NAME_OF_STUDY_ITSELF_AMONG_VARIANTS:
        raise ResultError(
            f"{cube_path}: results of the variant {variant!r}; name the cube of the study, cube.nc, whose findings "
            "compare the study with its variants"
        )
    records = [one["record_id"].to_numpy().astype(str).tolist() for one in (cube, intensity_measures_by_record)]
    if records[0] != records[1] or not cube_covers_study_grid(cube, study_of_cube(cube)):
        raise ResultError(f"{cube_path}: a part of its study's cube; name the cube that the run made")


@contextmanager
def open_study_results(
    folder_or_cube_path: Path, study_with_question_and_surveys: Study | None = None
) -> Iterator[StudyResults]:
    """Open the results cubes, intensity measures, surveys and convergence check in the folder of a study.

    `folder_or_cube_path` is the folder, or the cube of the study in it. A `ResultError` is raised if a file is missing,
    or if the cube is not the whole cube of a study. If the outcomes in a cube were changed after the run, its attribute
    ``content_sha256`` becomes the hash of the changed outcomes.

    The settings `STUDY_KEYS_NOT_AFFECTING_CUBE` and the surveys are taken from `study_with_question_and_surveys`; if it
    is None, from the study that `find_study_with_title_and_figure_settings` returns for the cube.
    """
    cube_path = folder_or_cube_path / "cube.nc" if os.path.isdir(folder_or_cube_path) else folder_or_cube_path
    folder, changed = cube_path.parent, list[str]()

    def open_cube_and_note_name_if_outcomes_changed(variant_name: str) -> xr.Dataset:
        """Open the cube of the study or a variant; add its file name to `changed` if outcomes changed after the run."""
        path = cube_path if variant_name == NAME_OF_STUDY_ITSELF_AMONG_VARIANTS else folder / f"cube.{variant_name}.nc"
        outcome_hash = stated_or_computed_hash_of_cube_outcomes(path)
        cube = open_cube_for_reading_by_record(path, element_name=None, motion_amplitude_factor=None)
        stack.callback(cube.close)
        if outcome_hash != cube.attrs["content_sha256"]:
            changed.append(path.name)
            cube.attrs["content_sha256"] = outcome_hash
        return cube

    def select_recorded_amplitude(cube: xr.Dataset) -> xr.Dataset:
        """Return the cases of a cube under motions as recorded, with the amplitude factor 1."""
        return cube.sel(amplitude=1.0, drop=True) if "amplitude" in cube.dims else cube

    with ExitStack() as stack:
        # Each file is opened once: read through two handles at a time, it crashed the library below.
        nominal = open_cube_and_note_name_if_outcomes_changed(NAME_OF_STUDY_ITSELF_AMONG_VARIANTS)
        if not (measures := folder / "intensity.nc").is_file():
            raise ResultError(f"{measures}: no intensity measures; {cube_path.name} must be in its folder of results")
        intensity = stack.enter_context(xr.open_dataset(measures))
        _check_cube_is_whole_study(nominal, intensity, cube_path)
        study = study_of_cube(nominal)
        presented = find_study_with_title_and_figure_settings(nominal, study_with_question_and_surveys) or study
        named = (
            one.model_copy(update={"stones": file_name_if_absolute_else_path(one.stones)}) for one in presented.surveys
        )
        own = {name: getattr(presented, name) for name in STUDY_KEYS_NOT_AFFECTING_CUBE}
        study = study.model_copy(update=own | {"surveys": tuple(named)})
        whole = {NAME_OF_STUDY_ITSELF_AMONG_VARIANTS: nominal} | {
            name: open_cube_and_note_name_if_outcomes_changed(name) for name in study.variants
        }
        cubes = {name: select_recorded_amplitude(cube) for name, cube in whole.items()}
        stones, files = study.population, [folder / "survey" / f"{n + 1}" for n in range(len(study.surveys))]
        in_space = study.body is not None or study.is_stack
        survey_files = [file.with_suffix(".json") for file in files]
        asked = [file for file, survey in zip(files, study.surveys, strict=True) if survey.backwards]
        scaled = nominal.sel(amplitude=nominal.amplitude != 1.0) if "amplitude" in nominal.dims else None
        yield StudyResults(
            study=study,
            reference_element_cube=select_cube_of_default_element(
                study, NAME_OF_STUDY_ITSELF_AMONG_VARIANTS, cubes[NAME_OF_STUDY_ITSELF_AMONG_VARIANTS]
            ),
            cubes_by_variant=cubes,
            intensity_measures=intensity,
            convergence=read_convergence_result(folder / "convergence.json") if study.verification != "none" else None,
            survey_comparisons=tuple(read_survey_comparison(file) for file in (() if in_space else survey_files)),
            survey_displacement_comparisons=tuple(
                read_json_result(StoredDisplacementComparison, file, "comparison with a survey")
                for file in (survey_files if in_space else ())
            ),
            population_rates_by_variant={
                one: population_outcome_rates_by_record(cube, stones) for one, cube in whole.items() if stones
            },
            inferred_motions=tuple(read_inversion_result(file.with_suffix(".motion.nc")) for file in asked),
            results_folder=folder,
            names_of_cubes_changed_after_run=tuple(changed),
            other_amplitudes_cube=None
            if scaled is None
            else select_cube_of_default_element(study, NAME_OF_STUDY_ITSELF_AMONG_VARIANTS, scaled),
        )
