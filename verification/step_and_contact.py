"""What softness and damping of the contact ask of the step: cases that lose their energy balance, and wrong flags.

A part of the default study with δ/B over three orders of magnitude and damping ratios from light to heavy, at four
fractions of the longest step and at the automatic one, against an eighth of the longest. Run it with
``python -m verification.step_and_contact``; it takes about a minute.
"""

from typing import Any

import numpy as np

from overturning.dem.run import run_cases
from overturning.model.contact import Contact
from overturning.model.results import Results
from verification.inputs import half_grid, near_fault
from verification.measures import difference, percent
from verification.tables import markdown, publish

PENETRATIONS = (2e-3, 2e-4, 2e-5, 2e-6, 1e-7)
DAMPING_RATIOS = (0.02, 0.1, 0.25, 1.0, 4.0)
REFERENCE = "0.125 stable"
STEPS = {"automatic": "auto"} | {f"{fraction:g}": f"{fraction} stable" for fraction in (0.25, 0.5, 0.75, 1.0)}
AZIMUTHS, EVERY_RECORD, THREADS = 4, 10, 2


def share(count: int, of: int) -> str:
    """A percentage; a dash where there is nothing to count."""
    return f"{percent(count, of):.2f}" if of else "–"


def main() -> None:
    """Measure and put the table into the docs."""
    cases = half_grid(AZIMUTHS)
    motions = dict(list(near_fault().items())[::EVERY_RECORD])

    def run(contact: Contact, step: str) -> dict[str, Results]:
        given: dict[str, Any] = {"contact": contact, "time_step": step, "threads": THREADS}
        return {name: run_cases(motion, cases, **given) for name, motion in motions.items()}

    lines = []
    for penetration in PENETRATIONS:
        for ratio in DAMPING_RATIOS:
            contact = Contact(static_penetration=penetration, damping_ratio=ratio)
            exact = run(contact, REFERENCE)
            own = difference(exact, exact)
            computed = own.moving.cases + own.moving.unanswered
            cells = [share(own.unstable, computed)]
            for step in STEPS.values():
                found = difference(run(contact, step), exact)
                cells.append(f"{share(found.unstable, computed)} / {share(found.moving.flags, found.moving.cases)}")
            lines.append((f"{penetration:g}", f"{ratio:g}", *cells))
            print(*lines[-1], flush=True)
    table = markdown(("δ/B", "ξ", "0.125", *STEPS), lines)
    about = f"Each row: the {computed} cases of {len(motions)} records and {AZIMUTHS} azimuths that can move."
    publish({"step-and-contact": f"{table}\n\n{about}"})


if __name__ == "__main__":
    np.seterr(all="raise", under="ignore")
    main()
