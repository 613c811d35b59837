"""`overturning survey`: compare a survey of fallen stones with the cube of its site."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from overturning.statistics.circular import TestResult
    from overturning.statistics.survey_comparison import SurveyComparison

app = typer.Typer(rich_markup_mode=None)


@app.command()
def survey(
    stones: Annotated[Path, typer.Argument(help="the survey (CSV): azimuth_deg or octant, count, …")],
    cube: Annotated[Path, typer.Option(help="cube of a study that holds the site's record (NetCDF)")],
    record: Annotated[
        str | None, typer.Option(help="id of the site's record; not needed where the cube has one")
    ] = None,
    background: Annotated[float, typer.Option(help="share of stones taken to fall any way")] = 0.05,
    figure: Annotated[Path | None, typer.Option(help="figure to draw: .svg or .png")] = None,
) -> None:
    """Compare the directions in which stones fell with those that the cube predicts."""
    from overturning.errors import ArgumentError
    from overturning.statistics.survey import read_survey
    from overturning.statistics.survey_comparison import compare_survey
    from overturning.study.cube import open_cube

    if figure is not None and figure.suffix.lower() not in {".svg", ".png"}:
        raise ArgumentError(f"{figure.name}: unknown kind of figure; end it in .svg or .png")
    rows = read_survey(stones)
    with open_cube(cube, chunks={"record": 1}) as data:
        names = [str(name) for name in data["record_id"].to_numpy()]
        if record is None and len(names) > 1:
            raise ArgumentError(
                f"{cube.name}: {len(names)} records; name the site's with --record ({', '.join(names[:4])} …)"
            )
        if record is not None and record not in names:
            raise ArgumentError(f"{cube.name}: no record {record!r}; it has {', '.join(names)}")
        name = record or names[0]
        found = compare_survey(rows, data.isel(record=[names.index(name)]).load(), background=background)
    _print(found, stones.name, name)
    if figure is not None:
        from overturning.figures.style import save, style
        from overturning.figures.survey_rose import survey_figure

        with style():
            save(survey_figure(found, f"{stones.name}, {name}"), figure)
        print(f"figure: {figure}")


def _test(result: "TestResult", what: str) -> str:
    if result.n == 0:
        return f"  {what}: not possible, no stone has what it needs"
    return f"  {what}: {result.name} {result.statistic:.3g}, n = {result.n}, p = {result.p_value:.2g}"


def _print(found: "SurveyComparison", name: str, record: str) -> None:
    from overturning.statistics.survey import OCTANTS
    from overturning.statistics.survey_prediction import SIDES

    print(f"{name} against {record}: {found.fallen} stones fell, {found.stood} stood")
    if found.fallen:
        print(f"mean fall direction {found.mean_direction_deg:.0f}°, resultant {found.resultant:.2f}")
        print("  octant   observed  predicted")
        for octant, seen, expected in zip(OCTANTS, found.octant_observed, found.octant_predicted, strict=True):
            print(f"  {octant:<8} {seen:8.0f} {expected:10.1f}")
        better = "better" if found.log_likelihood_ratio > 0 else "worse"
        print(
            f"log likelihood ratio against falls any way: {found.log_likelihood_ratio:.2f}, p = "
            f"{found.likelihood_ratio_p:.2g}; the prediction is {better} than none"
        )
        print("does the prediction fit? (a small p says no)")
        print(_test(found.fit_octants, "octants"))
        print(_test(found.fit_octants_watson, "octants in their order"))
        print(_test(found.fit_exact, "exact azimuths"))
        print("do stones fall any way? (a small p says no)")
        print(_test(found.uniform_octants, "octants in their order"))
    if found.turned_every_way:
        print(
            f"{found.turned_every_way} stones have no face azimuth or B/H: for them stones turned every way were assumed"
        )
    print(f"{found.background:.0%} of the stones are taken to fall any way")
    if found.confusion is not None:
        print("stones of known face: observed (rows) against most probable (columns)")
        print("  " + " " * 14 + "".join(f"{side:>14}" for side in SIDES))
        for side, row in zip(SIDES, found.confusion, strict=True):
            print(f"  {side:<14}" + "".join(f"{count:>14}" for count in row))
