"""`python -m verification.summary`: the summary table of the docs, of the measured figures that say most."""

from pathlib import Path
from typing import Final

from verification.tables import RESULTS, markdown, publish, read_figures, said

FILES: Final[dict[str, tuple[str, tuple[str, ...]]]] = {
    "exactness.csv": ("make verify", ()),
    "*-cores.csv": (
        "make bench",
        (
            "peak memory at 10^6 cases",
            "agreement with the exact rigid block",
            "compilation, cold",
            "default study: kernel time on two threads",
            "default study: wrong flags where the neighbours agree",
            "default study: wrong sides where the neighbours agree",
            "default study: wrong flags of all cells, against an eighth of the step",
            "flags changed by leaving out",
            "sides changed by leaving out",
            "default study, whole run: time on two cores",
        ),
    ),
    "scenes.csv": (
        "make bench",
        (
            "default: time per case, as a user runs it",
            "default: shaft's side right, peers' cases",
            "Box2D: shaft's side right",
            "pymunk: shaft's side right",
            "three pillars under real records: flags changed by leaving out",
        ),
    ),
    "both-kernels.csv": (
        "make bench",
        (
            "a gravestone in both kernels: same flag, chaotic cells left out",
            "a gravestone in both kernels: same side, chaotic cells left out",
        ),
    ),
}
"""Figures kept in the repository, what measures them, and which of them are shown: all where none is named."""


def bodies(results: Path = RESULTS) -> dict[str, str]:
    """The summary by its mark: measured, and where the figure and all beside it stand."""
    lines = []
    for pattern, (command, shown) in FILES.items():
        for path in sorted(results.glob(pattern)):
            where = f"[{path.name}](../verification/results/{path.name}), `{command}`"
            lines += [
                (one.quantity, said(one), where) for one in read_figures(path) if not shown or one.quantity in shown
            ]
    return {"summary": markdown(("", "measured", "where"), lines)}


if __name__ == "__main__":
    publish(bodies())
