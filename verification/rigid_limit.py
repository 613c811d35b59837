"""Error and cost over the contact's stiffness and the step: what the default contact and step were read from.

Every fourth record of the default study, against the stiffest contact in an eighth of the longest step, and that reference itself
against one whose shaking is changed in its ninth digit: what differs there no computation settles. Run it with
``python -m verification.rigid_limit``; it takes about a minute.
"""

import time

import numpy as np

from overturning.dem.contact import STATIC_PENETRATION, Contact
from overturning.dem.results import Results
from overturning.dem.run import run_cases
from overturning.motion.motion import Motion
from verification.inputs import half_grid, near_fault
from verification.measures import difference, percent, wrong_sides
from verification.tables import markdown, publish

PENETRATIONS = (2e-5, 2e-6, 5e-7, STATIC_PENETRATION, 2e-8)
STEPS = ("0.125 stable", "0.25 stable", "0.5 stable", "auto")
REFERENCE = (2e-8, "0.125 stable")
AZIMUTHS, EVERY_RECORD = 18, 4
NUDGE = 1e-9
HEAD = (
    "δ/B", "step", "million block steps", "processor time, s", "wrong flags, %", "wrong sides, %",
    "median error of peak rotation", "marked",
)  # fmt: skip


def nudged(motion: Motion) -> Motion:
    """The motion, stronger by `NUDGE`."""
    return Motion((1 + NUDGE) * motion.north, (1 + NUDGE) * motion.east, sampling_interval=motion.sampling_interval)


def main() -> None:
    """Measure and put the table into the docs."""
    cases, motions = half_grid(AZIMUTHS), dict(list(near_fault().items())[::EVERY_RECORD])
    run_cases(next(iter(motions.values())), half_grid(1))

    def run(penetration: float, step: str, moved: dict[str, Motion]) -> dict[str, Results]:
        contact = Contact(static_penetration=penetration)
        return {name: run_cases(one, cases, contact=contact, time_step=step) for name, one in moved.items()}

    def row(name: str, step: str, found: dict[str, Results], seconds: float) -> tuple[str, ...]:
        far = difference(found, exact)
        return (
            name, step, f"{far.block_steps / 1e6:.1f}", f"{seconds:.2f}", f"{percent(far.counts.flags, far.counts.cases):.2f}",
            f"{percent(wrong_sides(far.counts), far.counts.cases):.2f}", f"{np.median(far.rotation):.2g}", str(far.unstable),
        )  # fmt: skip

    exact, lines = run(*REFERENCE, motions), []
    wanted = [(penetration, step) for penetration in PENETRATIONS for step in STEPS if (penetration, step) != REFERENCE]
    for penetration, step in wanted:
        begin = time.process_time()
        found = run(penetration, step, motions)
        lines.append(row(f"{penetration:g}", step.removesuffix(" stable"), found, time.process_time() - begin))
        print(*lines[-1], sep=" | ", flush=True)
    begin = time.process_time()
    found = run(*REFERENCE, {name: nudged(motion) for name, motion in motions.items()})
    lines.append(row(f"{REFERENCE[0]:g}, shaking changed by 1e-9", "0.125", found, time.process_time() - begin))
    publish({"rigid-limit": markdown(HEAD, lines)})


if __name__ == "__main__":
    main()
