"""Cases to watch: films, and the motion and response behind them."""

from overturning.report.blocks import Block, Bullets, Disclosure, Figure, Film, Note, Section
from overturning.report.results import Results


def telling(results: Results) -> Section | None:
    """The telling cases as films; none where there is none."""
    if not results.telling:
        return None
    cases: list[Block] = [Note("The page report.html shows them as films.", medium="paper")]
    for number, case in enumerate(results.telling, 1):
        folder = results.figures / "telling"
        axis = "tilt of the axis towards north and east, and hodographs of the ground"
        behind = (
            (Figure(folder / f"{number}-axis.svg", axis),)
            if results.in_space
            else (
                Figure(folder / f"{number}-response.svg", "rotation, slip and uplift against time", most_height=14),
                Figure(folder / f"{number}-boundary.svg", "largest B/H that falls, by azimuth", most_height=11),
                Figure(folder / f"{number}-spectra.svg", "Fourier and response spectra"),
                Figure(folder / f"{number}-hodograph.svg", "acceleration, velocity and displacement seen from above"),
            )
        )
        rule = Note(f"Chosen by rule: {case['rule']}.")
        film = Film(case["film"], case["block"])
        shown = (film, Bullets(tuple(case["outcomes"])), rule, Disclosure("Motion and response", behind))
        cases.append(Section(case["title"], shown))
    last = "a and d turn the view, as dragging it does" if results.in_space else "f shows contact forces"
    keys = f"Keys: space plays and pauses, ← and → step, Home and End, s changes the speed, {last}."
    return Section("Cases to watch", (*cases, Note(keys, medium="page")), anchor="telling")
