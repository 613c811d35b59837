"""`overturning figure`, `recheck` and `cube`: draw a cube, simulate some of its cases again, write it as tables."""

from pathlib import Path
from typing import Annotated, Final

import typer

from overturning.plot import CUBE_FIGURE_FUNCTIONS, MOTION_FIGURE_KINDS

FIGURE_KINDS_FROM_WHOLE_STUDY_RESULTS: Final = (
    "references",
    "contrast",
    "maps",
    "scene",
    "fall-rate",
    "surveys",
    "backwards",
    "fragility",
)
"""Kinds of figures that are drawn from all results of a study: those of `overturning.report.drawings.STUDY_FIGURES`."""

CubePathArgument = Annotated[Path, typer.Argument(help="cube of a study (NetCDF)")]

app = typer.Typer(no_args_is_help=True, help="Write a cube in another form.")


def draw_figure(
    kind: Annotated[
        str, typer.Argument(help=", ".join((*CUBE_FIGURE_FUNCTIONS, *FIGURE_KINDS_FROM_WHOLE_STUDY_RESULTS)))
    ],
    cube: CubePathArgument,
    output: Annotated[Path, typer.Option("--output", "-o", help="figure to draw: .svg, .png or .pdf")],
    record: Annotated[str | None, typer.Option(help="id of the record; optional if the cube has only one")] = None,
    height: Annotated[
        list[float] | None, typer.Option(help="show only this height, m; may be given several times")
    ] = None,
    friction: Annotated[
        list[float] | None, typer.Option(help="show only this friction; may be given several times")
    ] = None,
    width: Annotated[str, typer.Option(help="width of the figure, such as 80mm or 17cm; default: its own width")] = "",
    font: Annotated[
        str,
        typer.Option(
            help="font: a size in pt, a family or .ttf file, or both: 8, 'Liberation Serif 8'; default: that of the "
            "figure, scaled to the width"
        ),
    ] = "",
    title: Annotated[str | None, typer.Option(help="title of the figure; none: no title, for a paper")] = None,
    dpi: Annotated[int, typer.Option(min=50, max=1200, help="dots per inch of PNG files and of map cells")] = 200,
    language: Annotated[str | None, typer.Option(help="language: en or ja; not given: that of the study")] = None,
) -> None:
    """Draw one figure of a study's report, chosen by its name, from the results cube and the files next to it."""
    import inspect

    from overturning.errors import ArgumentError, closest_name_hint
    from overturning.figures.write import (
        parse_figure_width_inches,
        parse_font_family_and_size,
        save_figure_and_return_text_layout_warning,
        set_figure_title,
    )
    from overturning.files import check_output_path
    from overturning.study.cube import (
        find_study_with_title_and_figure_settings,
        open_cube,
        select_heights_and_frictions,
    )
    from overturning.translation.texts import ENGLISH, check_language_is_known, use_translation_language

    kinds = (*CUBE_FIGURE_FUNCTIONS, *FIGURE_KINDS_FROM_WHOLE_STUDY_RESULTS)
    if kind not in kinds:
        known = f"known are {', '.join(kinds)}"
        raise ArgumentError(f"{kind}: no such figure; {closest_name_hint(kind, kinds, known)}")
    check_output_path(output, "--output", ".svg", ".png", ".pdf")
    inches = parse_figure_width_inches(width)
    draw = CUBE_FIGURE_FUNCTIONS.get(kind)
    of_one = draw is not None and "record" in inspect.signature(draw).parameters
    if record is not None and not of_one:
        raise ArgumentError(f"--record: {kind} shows all records; leave it out")
    if draw is None and (height or friction):
        raise ArgumentError(f"--height, --friction: {kind} shows the whole study; leave them out")
    if kind in MOTION_FIGURE_KINDS and (height or friction):
        raise ArgumentError(f"--height, --friction: {kind} shows the ground motion; leave them out")
    if kind == "polar" and (height or friction):
        draw = CUBE_FIGURE_FUNCTIONS["blocks"]
    check_language_is_known(language or ENGLISH)
    if font:  # a font that cannot be used is refused before drawing, which takes seconds
        parse_font_family_and_size(font)
    with open_cube(cube, chunks={"record": 1}, amplitude=None) as data:
        study = find_study_with_title_and_figure_settings(data)
        if draw is not None:
            chosen = select_heights_and_frictions(
                data, cube, height, friction, choose_default_if_only_one_dimension_given=kind == "polar"
            )
            drawn = draw(chosen, record) if of_one else draw(chosen)
    if draw is None:
        from overturning.report.drawings import draw_study_figure

        drawn = draw_study_figure(kind, cube)
    set_figure_title(drawn, title)
    with use_translation_language(language or (study.language if study else None)):
        warning = save_figure_and_return_text_layout_warning(
            drawn, output, dpi=dpi, width_inches=inches, requested_font_family_or_size_text=font
        )
    print(output)
    if warning:
        print(f"warning: {warning}")


def print_findings(
    cube: Annotated[Path, typer.Argument(help="cube of a study in its folder of results, or this folder")],
    json: Annotated[bool, typer.Option("--json", help="print JSON (docs/findings.schema.json)")] = False,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="file for the JSON (.json)")] = None,
    study: Annotated[
        str | None, typer.Option(hidden=True, help="study with title, question and surveys, as JSON or a file")
    ] = None,
) -> None:
    """Print every number of the report of a study, with its confidence interval and number of earthquakes."""
    import sys
    import warnings

    from overturning.files import check_output_path
    from overturning.findings.collect import findings as collect
    from overturning.findings.collect import write_findings
    from overturning.findings.lines import finding_text_lines
    from overturning.study.load import load_study_from_file_or_json

    if output is not None:
        check_output_path(output, "--output", ".json")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", UserWarning)
        found = collect(cube, load_study_from_file_or_json(study) if study else None)
    for warning in caught:
        print(f"warning: {warning.message}", file=sys.stderr)
    if output is not None:
        write_findings(found, output)
        print(output)
    elif json:
        print(found.model_dump_json(indent=1))
    else:
        for line in finding_text_lines(found):
            print(line)


def recheck_random_cases_of_cube(
    cube: Annotated[Path, typer.Argument(help="the cube (NetCDF)")],
    motions: Annotated[
        Path | None, typer.Option(help="folder of the motions (default: motion, next to the cube)")
    ] = None,
    cells: Annotated[int, typer.Option(min=1, help="number of cells to compute again")] = 200,
    seed: Annotated[int, typer.Option(min=0, help="seed of the sample")] = 1,
) -> None:
    """Simulate a random sample of the cases of a results cube again; report whether every value is identical."""
    from overturning.study.recheck import recompute_and_compare_random_cases as compute_again

    result = compute_again(cube, motions, max_random_case_count=cells, seed=seed)
    if not result.stored_values_match_content_hash:
        print(f"{cube}: its numbers do not match its content hash; the file was changed after it was written")
    for line in result.difference_messages[:10]:
        print(line)
    if len(result.difference_messages) > 10:
        print(f"… and {len(result.difference_messages) - 10} more")
    with_ensemble = (
        f", {result.cell_count_with_recomputed_ensemble} of them with their ensemble"
        if result.cell_count_with_recomputed_ensemble
        else ""
    )
    different = (
        "1 value differs"
        if len(result.difference_messages) == 1
        else f"{len(result.difference_messages)} values differ"
    )
    print(
        f"{result.recomputed_cell_count} of {result.cube_cell_count} cell{'' if result.cube_cell_count == 1 else 's'} "
        f"computed again{with_ensemble}: " + (different if result.difference_messages else "all identical, bit for bit")
    )
    if not result.values_are_identical_and_hash_is_correct:
        raise typer.Exit(1)


@app.command("export")
def write_case_table(
    cube: CubePathArgument,
    output: Annotated[Path, typer.Argument(help="table to write: .parquet (needs pyarrow) or .csv")],
) -> None:
    """Write the outcomes of all cases as a table: one row per case, for every element and amplitude factor."""
    from overturning.files import check_output_path
    from overturning.labels import variant_label_in_list_if_not_nominal
    from overturning.study.cube import open_cube
    from overturning.study.small import write_table_of_cases

    check_output_path(output, "output", ".parquet", ".csv")
    with open_cube(cube, chunks={"record": 1}, element=None, amplitude=None) as data:
        count = write_table_of_cases(data, output)
        print(
            ", ".join(
                [f"{output}: {count} case{'' if count == 1 else 's'}", *variant_label_in_list_if_not_nominal(data)]
            )
        )
