"""`python -m verification.both_kernels`: whether the block's kernel and the general one agree on a gravestone.

A cell is chaotic where either kernel finds another flag with the motion a 10⁻⁹ stronger or weaker or with half the
step: there no computation of this kind tells. The others have to agree.
"""

import time
from typing import Any, Final

import numpy as np

from overturning.dem.numerics import Numerics
from overturning.dem.run import run
from overturning.model.cases import Cases
from overturning.model.results import Results
from overturning.model.scene import gravestone
from verification import summary
from verification.inputs import near_field
from verification.tables import RESULTS, Figure, figures_table, publish, write_figures

RECORDS: Final = (6, 7, 8, 9, 10)
PERTURBED: Final = 1e-9
VARIED: Final[tuple[dict[str, Any], ...]] = (
    {"amplitude": 1.0 + PERTURBED},
    {"amplitude": 1.0 - PERTURBED},
    {"time_step": "0.5 stable"},
)


def grid(amplitude: float = 1.0) -> Cases:
    """Every 15°, B/H from 0.1 to 0.6, two frictions; half of the azimuths, since the others mirror them."""
    axes = np.arange(0, 180, 15.0), np.array([0.6]), np.arange(2, 13) * 0.05, np.array([0.58, 1.0])
    azimuth, height, ratio, friction = (axis.ravel() for axis in np.meshgrid(*axes, indexing="ij"))
    return Cases(azimuth, height, ratio, friction, amplitude)


def answers(number: int, general: bool, amplitude: float = 1.0, time_step: str = "auto") -> Results:
    """All cases of a record, nothing left out, in one of the kernels."""
    numerics = Numerics(general=general, time_step=time_step, leave_out=False)
    return run(gravestone(), near_field(number), grid(amplitude), numerics)


def figures() -> list[Figure]:
    """How often flags, sides and rotations differ, in all cells and in those that are not chaotic."""
    flags: dict[bool, list[np.ndarray]] = {False: [], True: []}
    rotation: dict[bool, list[np.ndarray]] = {False: [], True: []}
    chaotic, seconds = [], {False: 0.0, True: 0.0}
    for number in RECORDS:
        moved = np.zeros(grid().size, np.bool_)
        for general in (False, True):
            start = time.process_time()
            found = answers(number, general)
            seconds[general] += time.process_time() - start
            side = found.overturned.reshape(-1)
            for change in VARIED:
                moved |= (answers(number, general, **change).overturned.reshape(-1) != 0) != (side != 0)
            flags[general].append(side)
            rotation[general].append(found.peak_rotation.reshape(-1))
        chaotic.append(moved)
    chaos = np.concatenate(chaotic)
    own, other = (np.concatenate(flags[general]) for general in (False, True))
    turned, rocked = (np.concatenate(rotation[general]) for general in (False, True))
    apart, stands = (own != 0) != (other != 0), (own == 0) & (other == 0) & ~chaos
    return [
        Figure("a gravestone in both kernels: cells", own.size),
        Figure("a gravestone in both kernels: that fall", 100 * float((own != 0).mean()), "%"),
        Figure("a gravestone in both kernels: chaotic cells", int(chaos.sum())),
        Figure("a gravestone in both kernels: other flags, of all cells", int(apart.sum())),
        Figure("a gravestone in both kernels: other flags, chaotic cells left out", int((apart & ~chaos).sum())),
        Figure(
            "a gravestone in both kernels: same flag, chaotic cells left out",
            100 * float((~apart)[~chaos].mean()), "%", ">= 99.9",
        ),
        Figure(
            "a gravestone in both kernels: same side, chaotic cells left out",
            100 * float((own == other)[~chaos].mean()), "%",
        ),
        Figure(
            "a gravestone in both kernels: peak rotation apart, median",
            float(np.median(np.abs(turned[stands] / np.maximum(rocked[stands], 1e-12) - 1))),
        ),
        Figure("a gravestone in both kernels: time in the general one over that in its own",
        seconds[True] / seconds[False], "x"),
    ]  # fmt: skip


def main() -> None:
    """Measure, and put the figures where they belong."""
    found = write_figures(figures(), RESULTS / "both-kernels.csv")
    publish({"both-kernels": figures_table(found)} | summary.bodies())


if __name__ == "__main__":
    main()
