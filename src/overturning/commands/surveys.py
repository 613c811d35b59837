"""`overturning survey`, `backwards` and `stood`: inference from stones that fell or still stand."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from overturning.errors import ArgumentError

if TYPE_CHECKING:
    from pydantic import BaseModel
    from xarray import Dataset

    from overturning.surveys.ground import SoilBelowSurveySite
    from overturning.surveys.stones import SurveyTable


def summarise_or_compare_survey(
    stones: Annotated[
        Path, typer.Argument(help="the survey (CSV), or the word template, which prints an empty survey")
    ],
    cube: Annotated[
        Path | None, typer.Option(help="cube of a study that holds the site's record (NetCDF), to compare with")
    ] = None,
    site_cubes: Annotated[
        list[str] | None,
        typer.Option(
            "--site-cube",
            help="NAME=FILE: cube for the stones of one site, with the motion at the surface of its soil; may be given "
            "several times",
        ),
    ] = None,
    record: Annotated[
        str | None, typer.Option(help="id of the site's record; optional if the cube has only one")
    ] = None,
    background: Annotated[
        float, typer.Option(min=0, max=0.99, help="share of stones assumed to fall in a random direction")
    ] = 0.05,
    declination: Annotated[
        float | None,
        typer.Option(help="magnetic declination of all directions, degrees, east positive; not with a column of it"),
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option(help="figure to draw (.svg, .png or .pdf): roses by site, or with --cube the comparison"),
    ] = None,
    rose: Annotated[
        Path | None, typer.Option(help="rose of all observed falls to draw, for a paper (.svg, .png or .pdf)")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="file for the comparison (JSON), used by the report")
    ] = None,
) -> None:
    """Summarise a survey by site; compare its fall directions with those that a study's results predict.

    Without --cube the numbers of stones, the mean direction and axis of the falls, and a test are printed.
    `overturning survey template > stones.csv` writes an empty survey with comments on all columns.
    """
    if str(stones) == "template":
        from overturning.surveys.template import survey_table_template_text

        print(survey_table_template_text(), end="")
        return
    from overturning.files import check_output_path, check_outputs_are_separate_files
    from overturning.findings.observed import observed_survey_findings
    from overturning.findings.survey_commands import ResultsPrintedBySurveyCommands
    from overturning.report.drawings import write_roses_of_observed_falls
    from overturning.surveys.observed import summarise_survey
    from overturning.surveys.stones import read_survey_table

    if cube is None:
        given = {"--record": record, "--output": output, "--site-cube": site_cubes or None}
        for name in (name for name, value in given.items() if value is not None):
            raise ArgumentError(f"{name}: only with --cube; give the cube of a study that holds the site's record")
    for option, path in (("--figure", figure), ("--rose", rose)):
        check_output_path(path, option, ".svg", ".png", ".pdf")
    check_output_path(output, "--output", ".json")
    cubes = {} if cube is None else {"": cube} | _parse_cube_path_by_site(site_cubes or ())
    check_outputs_are_separate_files(
        {"--figure": figure, "--rose": rose, "--output": output}, [stones, *cubes.values()]
    )
    table = read_survey_table(stones, declination)
    _check_stones_to_compare_and_site_cube_names(table, stones, cubes)
    for note in table.notes:
        print(note)
    observed = observed_survey_findings(summarise_survey(table))
    _print_results_with_template(ResultsPrintedBySurveyCommands(observed_surveys=[observed]), "survey_summary")
    if cube is not None:
        print()
        _compare_survey_with_cubes_and_write_results(stones, table, (cubes, record), background, figure, output)
    elif figure is not None:
        write_roses_of_observed_falls([observed.all_sites, *observed.sites], figure)
        print(f"figure: {figure}")
    if rose is not None:
        write_roses_of_observed_falls([observed.all_sites], rose)
        print(f"rose: {rose}")


def _parse_cube_path_by_site(site_cube_option_texts: Sequence[str]) -> dict[str, Path]:
    """Parse the option --site-cube: return the path of the results cube for each named survey site."""
    found: dict[str, Path] = {}
    for one in site_cube_option_texts:
        site, equals, path = one.rpartition("=")
        if not (site and equals and path):
            raise ArgumentError(f"--site-cube {one}: write NAME=FILE, such as River=results/mine/cube.clay.nc")
        if site in found:
            raise ArgumentError(f"--site-cube {site}: given twice; keep one cube for each site")
        found[site] = Path(path)
    return found


def _check_stones_to_compare_and_site_cube_names(
    survey_table: "SurveyTable", survey_path: Path, cube_path_by_site: Mapping[str, Path]
) -> None:
    """Raise an error if a survey has no stone to compare, or the option --site-cube names a site that no stone has.

    Nothing is checked if no results cube is given, since nothing is compared then.
    """
    from overturning.errors import closest_name_hint
    from overturning.surveys.counted_stones import check_survey_has_counted_stone

    if cube_path_by_site:
        check_survey_has_counted_stone(survey_table, survey_path)
    for site in filter(None, cube_path_by_site):
        if site not in survey_table.site_names:
            names = ", ".join(filter(None, survey_table.site_names)) or "–"
            hint = closest_name_hint(site, survey_table.site_names, f"its sites are {names}")
            raise ArgumentError(f"--site-cube {site}: no stone of the survey has this site; {hint}")


def _compare_survey_with_cubes_and_write_results(
    survey_path: Path,
    survey_table: "SurveyTable",
    pair_of_cube_path_by_site_and_record_id: tuple[dict[str, Path], str | None],
    random_outcome_stone_share: float,
    figure_path: Path | None,
    comparison_json_path: Path | None,
) -> None:
    """Compare a survey with the falls that results cubes predict; print, draw and store the comparison.

    The pair holds the results cube of each site, where the key "" stands for all other sites, and the record id.
    """
    from overturning.findings.survey_commands import ResultsPrintedBySurveyCommands
    from overturning.findings.surveys import survey_prediction_findings
    from overturning.labels import unsimulated_azimuth_ranges_text, variant_label_in_list_if_not_nominal
    from overturning.stored import write_result_as_json
    from overturning.study.cube import index_of_record, open_cube
    from overturning.surveys.comparison import compare_survey_with_prediction
    from overturning.surveys.ground import soil_below_survey_site_of_cube
    from overturning.surveys.stored_comparison import make_stored_survey_comparison

    paths, record = pair_of_cube_path_by_site_and_record_id
    cubes, grounds = {}, {}
    for site, cube in paths.items():
        with open_cube(cube, chunks={"record": 1}) as data:
            cubes[site] = data.isel(record=[index_of_record(data, record)]).load()
            grounds[site] = soil_below_survey_site_of_cube(data, record)
    default = cubes.pop("")
    name = str(default["record_id"].item())
    on_soil = {site: one for site, one in grounds.items() if one is not None}
    print(f"{survey_path.name} against {', '.join([name, *variant_label_in_list_if_not_nominal(default)])}")
    if "residual_twist" in default:
        _compare_falls_shifts_and_twists_and_write_results(
            survey_path,
            survey_table,
            (default, cubes),
            (name, on_soil),
            random_outcome_stone_share,
            figure_path,
            comparison_json_path,
        )
        return
    comparison = compare_survey_with_prediction(
        survey_table.fallen_and_standing_stones,
        default,
        results_cube_by_site=cubes,
        random_outcome_stone_share=random_outcome_stone_share,
    )
    parts = {
        one: survey_table.select_site(one).fallen_and_standing_stones
        for one in survey_table.site_names
        if len(survey_table.site_names) > 1
    }
    by_site = {
        one: compare_survey_with_prediction(
            part, cubes.get(one, default), random_outcome_stone_share=random_outcome_stone_share
        )
        for one, part in parts.items()
        if part
    }
    result = make_stored_survey_comparison(survey_path, name, comparison, survey_table.warnings, by_site, on_soil)
    if gaps := unsimulated_azimuth_ranges_text(default):
        print(f"no plane {gaps} was computed: the prediction for these directions comes from other planes")
    found = survey_prediction_findings(result)
    # The summary has printed the doubts.
    _print_results_with_template(
        ResultsPrintedBySurveyCommands(surveys=[found.model_copy(update={"survey_file_warnings": []})]), "survey"
    )
    if comparison_json_path is not None:
        write_result_as_json(result, comparison_json_path)
    if figure_path is not None:
        from overturning.report.drawings import write_survey_falls_figure

        write_survey_falls_figure([found], figure_path)
        print(f"figure: {figure_path}")


def _compare_falls_shifts_and_twists_and_write_results(
    survey_path: Path,
    survey_table: "SurveyTable",
    pair_of_default_cube_and_cube_by_site: "tuple[Dataset, dict[str, Dataset]]",
    pair_of_record_id_and_soil_by_site: "tuple[str, dict[str, SoilBelowSurveySite]]",
    random_outcome_stone_share: float,
    figure_path: Path | None,
    comparison_json_path: Path | None,
) -> None:
    """Compare falls, shifts and twists of a survey with those of a 3-D study.

    Print and store the comparison, and draw the observed falls.

    The default cube is the results cube for all sites without a cube of their own.
    """
    from overturning.findings.observed import observed_survey_findings
    from overturning.findings.survey_commands import ResultsPrintedBySurveyCommands
    from overturning.findings.survey_displacements import survey_displacement_findings
    from overturning.report.drawings import write_roses_of_observed_falls
    from overturning.stored import write_result_as_json
    from overturning.surveys.displacement_results import StoredDisplacementComparison
    from overturning.surveys.displacements import compare_falls_shifts_and_twists
    from overturning.surveys.observed import summarise_survey
    from overturning.surveys.stored_comparison import survey_file_hash_and_user_comments

    default, by_site = pair_of_default_cube_and_cube_by_site
    record, grounds = pair_of_record_id_and_soil_by_site
    parts = {one: survey_table.select_site(one) for one in survey_table.site_names if len(survey_table.site_names) > 1}
    sha256, remarks = survey_file_hash_and_user_comments(survey_path)
    result = StoredDisplacementComparison(
        survey_file_name=survey_path.name,
        sha256=sha256,
        record=record,
        all_sites_comparison=compare_falls_shifts_and_twists(
            survey_table, default, by_site, random_fall_direction_share=random_outcome_stone_share
        ),
        survey_warnings=survey_table.warnings,
        survey_file_comments=remarks,
        comparisons_by_site=tuple(
            (
                site,
                compare_falls_shifts_and_twists(
                    part, by_site.get(site, default), random_fall_direction_share=random_outcome_stone_share
                ),
            )
            for site, part in parts.items()
            if part.fallen_and_standing_stones
        ),
        soil_by_site=tuple(grounds.items()),
    )
    found = survey_displacement_findings(result)
    shown = found.model_copy(update={"survey_file_warnings": []})
    _print_results_with_template(ResultsPrintedBySurveyCommands(survey_displacements=[shown]), "displacements")
    if comparison_json_path is not None:
        write_result_as_json(result, comparison_json_path)
    if figure_path is not None:
        observed = observed_survey_findings(summarise_survey(survey_table))
        write_roses_of_observed_falls([observed.all_sites, *observed.sites], figure_path)
        print(f"figure: {figure_path}")


def _print_results_with_template(results: "BaseModel", report_template_name: str) -> None:
    """Print results as plain text, formatted by one of the templates of the report."""
    from overturning.report.render import parse_markdown_and_number_figures_and_tables, render_template_as_markdown
    from overturning.report.terminal import terminal_lines_of_markdown

    print(
        *terminal_lines_of_markdown(
            parse_markdown_and_number_figures_and_tables(
                render_template_as_markdown(results, template_name=report_template_name)
            )
        ),
        sep="\n",
    )


def infer_motion_from_survey(
    stones: Annotated[
        Path, typer.Argument(help="the survey (CSV): azimuth_deg or octant, b_over_h, height_m, round, …")
    ],
    motion_files: Annotated[
        list[Path] | None,
        typer.Option(
            "--motion", help="motion of a study (NetCDF), in addition to the built-in ones; may be given several times"
        ),
    ] = None,
    only_given_motions: Annotated[bool, typer.Option("--alone", help="use only the motions given by --motion")] = False,
    fixed_share: Annotated[
        float, typer.Option("--fixed", min=0, max=0.99, help="share of stones fixed to their base")
    ] = 0.0,
    background_share: Annotated[
        float, typer.Option("--background", min=0, max=0.99, help="share of stones with a random outcome")
    ] = 0.05,
    figure: Annotated[Path | None, typer.Option(help="figure to draw: .svg or .png")] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="file for the posterior (NetCDF), used by the report")
    ] = None,
    threads: Annotated[int, typer.Option(min=1, help="number of threads")] = 2,
) -> None:
    """Infer strength and axis of the motion that overturned stones, and the probability of each candidate motion.

    The motion is inferred from all stones together and, if the survey has several sites, from each site by itself. The
    outcomes of most gravestones under the built-in motions come with the program; those of other sizes and motions are
    computed once and stored in the user's cache folder.
    """
    import sys
    import time

    from overturning.files import check_output_path, check_outputs_are_separate_files
    from overturning.findings.inferred_motion import inferred_motion_findings
    from overturning.findings.survey_commands import ResultsPrintedBySurveyCommands
    from overturning.report.drawings import write_ground_motion_posterior_figure
    from overturning.report.filters import format_count_with_noun
    from overturning.study.preflight import format_duration
    from overturning.surveys.counted_stones import read_fallen_and_standing_stones_notes_and_warnings
    from overturning.surveys.inversion import SurveyInversion
    from overturning.surveys.library import candidate_motions, read_records_with_paths_as_duplicate_ids
    from overturning.surveys.posterior import write_inversion_result
    from overturning.surveys.responses import (
        StoneOutcomeProbabilities,
        count_cases_to_simulate_and_estimate_time_s,
        dimensions_of_survey_stones,
        note_on_stones_simulated_with_smaller_d_over_b,
    )

    check_output_path(figure, "--figure", ".svg", ".png")
    check_output_path(output, "--output", ".nc")
    check_outputs_are_separate_files({"--figure": figure, "--output": output}, [stones, *(motion_files or ())])
    rows, notes, doubts = read_fallen_and_standing_stones_notes_and_warnings(stones)
    kinds = dimensions_of_survey_stones(rows, str(stones))
    for note in (*notes, *doubts, *note_on_stones_simulated_with_smaller_d_over_b(rows)):
        print(note)
    library = candidate_motions(
        read_records_with_paths_as_duplicate_ids(motion_files or ()), only_user_records=only_given_motions
    )
    cases, seconds = count_cases_to_simulate_and_estimate_time_s(library, kinds)
    if cases:
        under, expected = format_count_with_noun(len(library), "motion"), format_duration(seconds / threads)
        print(
            f"{cases:,} cases under {under} to compute, "
            f"about {expected} on {format_count_with_noun(threads, 'thread')}",
            file=sys.stderr,
            flush=True,
        )
    began = said = time.monotonic()

    def print_progress(computed_motion_count: int, total_motion_count: int) -> None:
        """Print the number of computed motions and the remaining time, at most every two seconds."""
        nonlocal said
        now = time.monotonic()
        if 0 < computed_motion_count < total_motion_count and now - said > 2:
            said, left = now, (now - began) * (total_motion_count - computed_motion_count) / computed_motion_count
            percentage = f"{100 * computed_motion_count // total_motion_count}%"  # a run reads it
            computed = f"{computed_motion_count} of {total_motion_count} motions computed, {percentage}"
            print(f"{computed}, about {left:.0f} s remaining", file=sys.stderr, flush=True)

    responses = StoneOutcomeProbabilities(
        library, kinds, thread_count=threads, report_count_of_finished_and_all_motions=print_progress
    )
    result = SurveyInversion(responses, background_share, fixed_share).invert_survey(stones.name, rows)
    _print_results_with_template(
        ResultsPrintedBySurveyCommands(inferred_motions=[inferred_motion_findings(result, rows)]), "motions"
    )
    if output is not None:
        write_inversion_result(result, output)
    if figure is not None:
        write_ground_motion_posterior_figure(result, figure)
        print(f"figure: {figure}")
