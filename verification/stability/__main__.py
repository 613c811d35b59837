"""`python -m verification.stability blocks|scenes --output MAP.nc`: run extreme cases and check how each ends."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from verification.stability.cases import TOGETHER, adversarial_cases, scene_settings, space_filling
from verification.stability.maps import (
    ADVERSARIAL_BUDGET,
    BUDGET,
    MEANINGS,
    SCENE_BUDGET,
    SCENE_MEANINGS,
    run_case,
    run_map,
    run_setting,
)
from verification.tables import write_table

app = typer.Typer(rich_markup_mode=None, no_args_is_help=True, help="The map of stability.")

Map = Annotated[Path, typer.Option(help="map to make (NetCDF, CSV beside it)")]
Seed = Annotated[int, typer.Option(min=0, help="seed of the sample")]
Threads = Annotated[int, typer.Option(min=1, help="number of threads")]


def say(done: int, total: int) -> None:
    """Tell how far a map is."""
    print(f"stability: {done} of {total}", file=sys.stderr, flush=True)


@app.command()
def blocks(
    output: Map,
    count: Annotated[int, typer.Option(min=2, help="cases of the space-filling sample")] = 20_480,
    adversarial: Annotated[int, typer.Option(min=1, help="cases of each adversarial motion")] = 64,
    seed: Seed = 1,
    threads: Threads = 1,
) -> None:
    """Run stiff and extreme blocks."""
    cases = [*space_filling(count, seed), *adversarial_cases(adversarial, seed)]
    about = {"space_filling": count, "adversarial": adversarial, "seed": seed, "budget": BUDGET}
    rows = run_map(run_case, cases, threads=threads, progress=say)
    write_table(rows, output, meanings=MEANINGS, attributes=about, dimension="case")


@app.command()
def scenes(
    output: Map,
    settings: Annotated[int, typer.Option(min=2, help="settings of each scene, of eight cases each")] = 160,
    adversarial: Annotated[int, typer.Option(min=1, help="settings of each scene under each adversarial motion")] = 2,
    seed: Seed = 1,
    threads: Threads = 1,
) -> None:
    """Run the shipped scenes under the map's extremes."""
    rows = run_map(run_setting, scene_settings(settings, adversarial, seed), threads=threads, progress=say)
    about = {"settings": settings, "adversarial": adversarial, "together": TOGETHER, "seed": seed}
    about |= {"budget": SCENE_BUDGET, "adversarial_budget": ADVERSARIAL_BUDGET}
    write_table(rows, output, meanings=SCENE_MEANINGS, attributes=about, dimension="case")


if __name__ == "__main__":
    app()
