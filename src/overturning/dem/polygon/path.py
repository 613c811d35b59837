"""The path of a scene's elements, from the rows of the general kernel."""

import numpy as np

from overturning.arrays import FloatArray
from overturning.dem.path import PlanePath
from overturning.dem.polygon import tables as t
from overturning.dem.polygon.prepare import Prepared


def scene_path(prepared: Prepared, rows: FloatArray) -> PlanePath:
    """The path of a case, from rows with the columns of `overturning.dem.polygon.tables`."""
    placed, ends = prepared.placed, 2 * len(prepared.pairs)
    poses_end = 2 + 6 * len(placed)
    forces = rows[:, poses_end:].reshape(len(rows), ends, t.FORCE_COLUMNS)
    force, load = forces[:, :, [t.T_FX, t.T_FZ]], forces[:, :, [t.T_LOAD]]
    contacts: list[tuple[str, str]] = []
    for index, (first, second) in enumerate(prepared.pairs):
        # On the later element, which stands on the earlier one, unless forces do not move it.
        on, by = sorted((first, second), key=lambda k: (placed[k].fixed, -k))
        if on == second:
            force[:, 2 * index : 2 * index + 2] *= -1.0
        contacts += 2 * [(placed[on].element.name, placed[by].element.name)]
    return PlanePath(
        scene=prepared.scene,
        placed=placed,
        critical=prepared.alpha,
        time=rows[:, t.T_TIME],
        ground=rows[:, t.T_GROUND],
        poses=rows[:, 2:poses_end].reshape(len(rows), len(placed), 6),
        force=force,
        place=forces[:, :, [t.T_LOAD_X, t.T_LOAD_Z]] / np.where(load > 0.0, load, np.nan),
        contacts=contacts,
    )


def path_columns(prepared: Prepared) -> int:
    """Numbers in a row of a path."""
    return 2 + 6 * len(prepared.placed) + 2 * t.FORCE_COLUMNS * len(prepared.pairs)
