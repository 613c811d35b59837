"""`overturning survey`: compare a survey of fallen stones with the cube of its site."""

from pathlib import Path
from typing import Annotated

import typer


def survey(
    stones: Annotated[Path, typer.Argument(help="the survey (CSV): azimuth_deg or octant, count, …")],
    cube: Annotated[Path, typer.Option(help="cube of a study that holds the site's record (NetCDF)")],
    record: Annotated[
        str | None, typer.Option(help="id of the site's record; not needed where the cube has one")
    ] = None,
    background: Annotated[float, typer.Option(help="share of stones taken to fall any way")] = 0.05,
    figure: Annotated[Path | None, typer.Option(help="figure to draw: .svg, .png or .pdf")] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="the comparison as a file (JSON), for a report")
    ] = None,
) -> None:
    """Compare the directions in which stones fell with those that the cube predicts."""
    from overturning.files import check_output
    from overturning.report.plain import plain_lines
    from overturning.report.results import gaps_said
    from overturning.report.sections.surveys import survey_section
    from overturning.study.cube import open_cube, record_number, variant_said
    from overturning.surveys.comparison import compare_survey, survey_result, write_survey
    from overturning.surveys.stones import read_survey

    check_output(figure, "--figure", ".svg", ".png", ".pdf")
    check_output(output, "--output")
    rows = read_survey(stones)
    with open_cube(cube, chunks={"record": 1}) as data:
        site = data.isel(record=[record_number(data, record)]).load()
        name = str(site["record_id"].item())
        comparison, gaps = compare_survey(rows, site, background=background), gaps_said(site)
        against = ", ".join([name, *variant_said(site)])
    result = survey_result(stones, name, comparison)
    print(f"{result.stones} against {against}")
    print(*plain_lines(survey_section(result, gaps=gaps)), sep="\n")
    if output is not None:
        write_survey(result, output)
    if figure is not None:
        from overturning.figures.style import style
        from overturning.figures.write import save
        from overturning.surveys.rose import survey_figure

        with style():
            save(survey_figure(comparison, f"{stones.name}, {against}"), figure)
        print(f"figure: {figure}")
