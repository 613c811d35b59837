"""`python -m verification.stability blocks|scenes|stacks --output MAP.nc`: run and check extreme cases."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from verification.stability.cases import (
    PARALLEL_CASE_COUNT_PER_SCENE,
    cases_under_adversarial_motions,
    sample_parameters_of_scene_cases,
    space_filling_cases,
)
from verification.stability.maps import (
    BLOCK_COLUMN_LONG_NAMES_AND_UNITS,
    MAX_BLOCK_STEPS_PER_MAP_CASE,
    MAX_STEPS_OF_ADVERSARIAL_SCENE_CASE,
    MAX_STEPS_OF_SCENE_CASE,
    SCENE_COLUMN_LONG_NAMES_AND_UNITS,
    collect_stability_map_rows,
    simulate_block_case_and_check_outcome,
    simulate_scene_cases_and_check_outcomes,
)
from verification.stability.stacks import (
    MAX_STEPS_OF_STACK_CASE,
    STACK_COLUMN_LONG_NAMES_AND_UNITS,
    generate_random_parameters_of_stack_cases,
    simulate_stack_cases_and_check_outcomes,
)
from verification.tables import write_table_as_netcdf_and_csv

app = typer.Typer(rich_markup_mode=None, no_args_is_help=True, help="The map of stability.")

MapPathOption = Annotated[Path, typer.Option(help="map to write (NetCDF; also as CSV)")]
SampleSeedOption = Annotated[int, typer.Option(min=0, help="seed of the sample")]
ThreadCountOption = Annotated[int, typer.Option(min=1, help="number of threads")]


def print_progress(finished_case_count: int, total_case_count: int) -> None:
    """Print how many cases of a map of numerical stability are finished."""
    print(f"stability: {finished_case_count} of {total_case_count}", file=sys.stderr, flush=True)


@app.command("blocks")
def simulate_blocks_and_write_stability_map(
    output: MapPathOption,
    count: Annotated[int, typer.Option(min=2, help="cases of the space-filling sample")] = 20_480,
    adversarial: Annotated[int, typer.Option(min=1, help="cases of each adversarial motion")] = 64,
    seed: SampleSeedOption = 1,
    threads: ThreadCountOption = 1,
) -> None:
    """Simulate and check single blocks with extreme parameters; write the map of stability."""
    cases = [*space_filling_cases(count, seed), *cases_under_adversarial_motions(adversarial, seed)]
    about = {"space_filling": count, "adversarial": adversarial, "seed": seed, "budget": MAX_BLOCK_STEPS_PER_MAP_CASE}
    rows = collect_stability_map_rows(
        simulate_block_case_and_check_outcome, cases, threads=threads, report_finished_and_total_count=print_progress
    )
    write_table_as_netcdf_and_csv(
        rows,
        output,
        long_name_and_unit_by_column=BLOCK_COLUMN_LONG_NAMES_AND_UNITS,
        global_attributes=about,
        dimension_name="case",
    )


@app.command("scenes")
def simulate_scenes_and_write_stability_map(
    output: MapPathOption,
    settings: Annotated[int, typer.Option(min=2, help="settings of each scene, of eight cases each")] = 160,
    adversarial: Annotated[int, typer.Option(min=1, help="settings of each scene under each adversarial motion")] = 2,
    seed: SampleSeedOption = 1,
    threads: ThreadCountOption = 1,
) -> None:
    """Simulate the shipped scenes with extreme parameters, check the outcomes, and write the map of stability."""
    rows = collect_stability_map_rows(
        simulate_scene_cases_and_check_outcomes,
        sample_parameters_of_scene_cases(settings, adversarial, seed),
        threads=threads,
        report_finished_and_total_count=print_progress,
    )
    about = {"settings": settings, "adversarial": adversarial, "together": PARALLEL_CASE_COUNT_PER_SCENE, "seed": seed}
    about |= {"budget": MAX_STEPS_OF_SCENE_CASE, "adversarial_budget": MAX_STEPS_OF_ADVERSARIAL_SCENE_CASE}
    write_table_as_netcdf_and_csv(
        rows,
        output,
        long_name_and_unit_by_column=SCENE_COLUMN_LONG_NAMES_AND_UNITS,
        global_attributes=about,
        dimension_name="case",
    )


@app.command("stacks")
def simulate_stacks_and_write_stability_map(
    output: MapPathOption,
    settings: Annotated[int, typer.Option(min=2, help="number of stacks, of eight cases each")] = 400,
    seed: SampleSeedOption = 1,
    threads: ThreadCountOption = 1,
) -> None:
    """Simulate and check 3-D stacks of two to five stones with extreme parameters; write the map of stability."""
    rows = collect_stability_map_rows(
        simulate_stack_cases_and_check_outcomes,
        generate_random_parameters_of_stack_cases(settings, seed),
        threads=threads,
        report_finished_and_total_count=print_progress,
    )
    about = {
        "settings": settings,
        "together": PARALLEL_CASE_COUNT_PER_SCENE,
        "seed": seed,
        "budget": MAX_STEPS_OF_STACK_CASE,
    }
    write_table_as_netcdf_and_csv(
        rows,
        output,
        long_name_and_unit_by_column=STACK_COLUMN_LONG_NAMES_AND_UNITS,
        global_attributes=about,
        dimension_name="case",
    )


if __name__ == "__main__":
    app()
