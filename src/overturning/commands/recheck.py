"""`overturning recheck`: compute a random sample of a cube's cells again."""

from pathlib import Path
from typing import Annotated

import typer


def recheck(
    cube: Annotated[Path, typer.Argument(help="the cube (NetCDF)")],
    motions: Annotated[
        Path | None, typer.Option(help="folder of the motions (default: motion beside the cube)")
    ] = None,
    cells: Annotated[int, typer.Option(min=1, help="cells to compute again")] = 200,
    seed: Annotated[int, typer.Option(min=0, help="seed of the sample")] = 1,
) -> None:
    """Compute a random sample of cells again and say whether they are the same, bit for bit, on this machine."""
    from overturning.study.recheck import recheck as compute_again

    result = compute_again(cube, motions, cells=cells, seed=seed)
    if not result.content_as_stated:
        print(f"{cube}: its numbers do not have the hash that it states; the file was changed after it was made")
    for line in result.differences[:10]:
        print(line)
    if len(result.differences) > 10:
        print(f"… and {len(result.differences) - 10} more")
    with_ensemble = f", {result.ensemble_cells} of them with their ensemble" if result.ensemble_cells else ""
    print(
        f"{result.cells} of {result.of} cells computed again{with_ensemble}: "
        + ("all the same, bit for bit" if not result.differences else f"{len(result.differences)} values differ")
    )
    if not result.same:
        raise typer.Exit(1)
