"""`python -m verification.summary`: the summary table of the docs, of measured figures with a target."""

from pathlib import Path
from typing import Final

from verification.tables import RESULTS, markdown, publish, read_figures, said

FILES: Final = {
    "exactness.csv": "make verify",
    "*-cores.csv": "make bench",
    "scenes.csv": "make bench",
    "both-kernels.csv": "make bench",
}
"""Figures kept in the repository, and what measures them."""

ALSO: Final = (
    "wrong flags against a far finer step, records, rocking",
    "wrong flags against a far finer step, records, sliding",
    "wrong flags against rigid rocking, records, no sliding",
    "largest error of peak slip against exact sliding",
    "agreement with the rocking solution",
)
"""Figures without a target that stand in the summary too."""


def bodies(results: Path = RESULTS) -> dict[str, str]:
    """The summary by its mark: target, measured, and where the figure and all beside it stand."""
    lines = []
    for pattern, command in FILES.items():
        for path in sorted(results.glob(pattern)):
            where = f"[{path.name}](../verification/results/{path.name}), `{command}`"
            lines += [
                (one.quantity, one.target, said(one), where)
                for one in read_figures(path)
                if one.target or one.quantity in ALSO
            ]
    return {"summary": markdown(("", "target", "measured", "where"), lines)}


if __name__ == "__main__":
    publish(bodies())
