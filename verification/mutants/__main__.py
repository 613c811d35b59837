"""`python -m verification.mutants`: put mutants to the tests, and list those that no test noticed."""

import csv
import time
from pathlib import Path
from typing import Annotated, Final

import typer

from overturning.files import atomic_write
from verification.mutants.drawing import LAYERS, PACKAGE, Mutant, draw
from verification.mutants.trial import Trial
from verification.stale import measuring
from verification.tables import RESULTS, ROOT, markdown, publish

SEED: Final = 1126
COUNT: Final = 200
KEPT: Final = RESULTS / "mutants.csv"

Outcomes = dict[Mutant, tuple[str, str]]
"""Outcome of each mutant, "noticed" or "lived", and a word on it."""


def read_outcomes(path: Path = KEPT) -> Outcomes:
    """What became of mutants so far; a word may be written into the file by hand."""
    if not path.is_file():
        return {}
    with path.open(encoding="utf-8", newline="") as file:
        _, *rows = csv.reader(file)
    return {
        Mutant(name, text, int(turn), int(column), old, new): (outcome, word)
        for name, text, turn, column, old, new, outcome, word in rows
    }


def write_outcomes(outcomes: Outcomes, path: Path = KEPT) -> None:
    """Write them, in the order of the draw."""
    with atomic_write(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow((*Mutant._fields, "outcome", "word"))
        table.writerows((*mutant, *outcome) for mutant, outcome in outcomes.items())


def bodies(outcomes: Outcomes) -> dict[str, str]:
    """The outcome by layer, and every mutant that lived, for the page of the docs."""
    rows = []
    for layer in (*LAYERS, ""):
        these = [outcome for mutant, (outcome, _) in outcomes.items() if mutant.file.startswith(layer)]
        noticed = these.count("noticed")
        rows.append((layer or "all", len(these), noticed, f"{noticed / len(these):.0%}" if these else "–"))
    lived = []
    for mutant, (outcome, word) in outcomes.items():
        if outcome == "lived":
            change = f"`{mutant.old}` → `{mutant.new}` in `{mutant.text}`".replace("|", "\\|")
            lived.append((f"`{mutant.file}`", change, word or "a hole: no test notices it"))
    table = f"Of {COUNT} drawn with the seed {SEED}, {len(outcomes)} have been put to the tests so far.\n\n"
    table += markdown(("layer", "mutants", "noticed", "share"), rows)
    return {"mutants": table + "\n\n" + markdown(("file", "lived", "why"), lived) if lived else table}


def main(
    count: Annotated[int, typer.Option(min=1, help="mutants to draw")] = COUNT,
    seed: Annotated[int, typer.Option(help="seed of the draw")] = SEED,
    minutes: Annotated[float, typer.Option(help="begin none after so many; the same command goes on")] = 600.0,
    again: Annotated[bool, typer.Option(help="put those that lived without a word to the tests once more")] = False,
    folder: Annotated[Path, typer.Option(help="where to work")] = ROOT / "results" / "mutants",
) -> None:
    """Put the mutants of the draw to the tests that have not been yet."""
    end = time.monotonic() + 60 * minutes
    drawn, known = draw(count, seed), read_outcomes()
    outcomes = {
        mutant: known[mutant] for mutant in drawn if mutant in known and not (again and known[mutant] == ("lived", ""))
    }
    waiting = [mutant for mutant in drawn if mutant not in outcomes]
    if waiting and minutes > 0:
        folder.mkdir(parents=True, exist_ok=True)
        trial = Trial(folder)
        trial.baseline()
        for mutant in waiting:
            if time.monotonic() > end:
                break
            begin = time.monotonic()
            outcomes[mutant] = ("noticed" if trial.notices(mutant) else "lived", "")
            write_outcomes({each: outcomes.get(each) or known[each] for each in drawn if each in {**known, **outcomes}})
            print(mutant.file, mutant.text, mutant.old, mutant.new, outcomes[mutant][0], end=" ")
            print(f"{time.monotonic() - begin:.0f} s", flush=True)
    lived = [mutant for mutant, (outcome, _) in outcomes.items() if outcome == "lived"]
    print(f"{len(outcomes) - len(lived)} of {len(outcomes)} mutants noticed; {len(drawn) - len(outcomes)} to go")
    for mutant in lived:
        line = (mutant.line((PACKAGE / mutant.file).read_text(encoding="utf-8").splitlines()) or 0) + 1
        print(f"lived: {mutant.file}:{line}: {mutant.old} -> {mutant.new}: {outcomes[mutant][1]}")
    with measuring("mutants.__main__"):
        publish(bodies({each: outcomes[each] for each in drawn if each in outcomes}))


if __name__ == "__main__":
    typer.run(main)
