"""What softness and damping of the contact ask of the step: cases that lose their energy balance, and wrong flags.

A part of the default study with δ/B over three orders of magnitude and damping ratios from light to heavy, at four
fractions of the longest step and at the automatic one, against an eighth of the longest. Run it with
``python -m benchmarks.step_and_contact``; it takes about a minute.
"""

import numpy as np

from benchmarks.bench import insert
from benchmarks.study_records import ROOT, half_grid, near_fault
from overturning.dem.contact import Contact
from overturning.dem.results import Results
from overturning.dem.run import run_cases
from overturning.dem.status import Status

PENETRATIONS = (2e-3, 2e-4, 2e-5, 2e-6)
DAMPING_RATIOS = (0.02, 0.1, 0.25, 1.0, 4.0)
REFERENCE = "0.125 stable"
STEPS = {"automatic": "auto"} | {f"{fraction:g}": f"{fraction} stable" for fraction in (0.25, 0.5, 0.75, 1.0)}
AZIMUTHS, EVERY_RECORD, THREADS = 4, 10, 2


def share(count: int, of: int) -> str:
    """A percentage; a dash where there is nothing to count."""
    return f"{100 * count / of:.2f}" if of else "–"


def main() -> None:
    """Measure, print and put the table into the docs."""
    cases, motions = half_grid(AZIMUTHS), list(near_fault().values())[::EVERY_RECORD]

    def run(contact: Contact, step: str) -> list[Results]:
        return [run_cases(motion, cases, contact=contact, time_step=step, threads=THREADS) for motion in motions]

    lines = ["| δ/B | ξ | 0.125 | " + " | ".join(STEPS) + " |", "|---" * (len(STEPS) + 3) + "|"]
    for penetration in PENETRATIONS:
        for ratio in DAMPING_RATIOS:
            contact = Contact(static_penetration=penetration, damping_ratio=ratio)
            fine = run(contact, REFERENCE)
            computed = sum(int((one.status != Status.AT_REST).sum()) for one in fine)
            cells = [share(sum(int((one.status == Status.UNSTABLE).sum()) for one in fine), computed)]
            for step in STEPS.values():
                marked = wrong = compared = 0
                for found, exact in zip(run(contact, step), fine, strict=True):
                    known = (found.overturned > -128) & (exact.overturned > -128) & (exact.status != Status.AT_REST)
                    marked += int((found.status == Status.UNSTABLE).sum())
                    wrong += int(((found.overturned != 0) != (exact.overturned != 0))[known].sum())
                    compared += int(known.sum())
                cells.append(f"{share(marked, computed)} / {share(wrong, compared)}")
            lines.append(f"| {penetration:g} | {ratio:g} | " + " | ".join(cells) + " |")
            print(lines[-1], flush=True)
    lines += ["", f"Each row: the {computed} cases of {len(motions)} records and {AZIMUTHS} azimuths that can move."]
    insert(ROOT / "docs" / "method.md", "step-and-contact", "\n".join(lines))


if __name__ == "__main__":
    np.seterr(all="raise", under="ignore")
    main()
