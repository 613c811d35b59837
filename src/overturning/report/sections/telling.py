"""Cases to watch: films, and the motion and response behind them."""

from overturning.report.blocks import Block, Bullets, Disclosure, Figure, Film, Note, Row, Section
from overturning.report.results import Results, has_scene


def telling(results: Results) -> Section | None:
    """The telling cases as films; none where nothing falls."""
    if not results.telling:
        return None
    folder = results.figures / "telling"
    cases: list[Block] = []
    for number, case in enumerate(results.telling, 1):
        behind = (
            Figure(folder / f"{number}-response.svg", "rotation, slip and uplift against time", most_height=11),
            Row(
                (
                    Figure(folder / f"{number}-boundary.svg", "largest B/H that falls, by azimuth"),
                    Figure(folder / f"{number}-spectra.svg", "Fourier and response spectra"),
                )
            ),
            Figure(folder / f"{number}-hodograph.svg", "acceleration, velocity and displacement seen from above"),
        )
        shown = (
            Film(case["film"], case["block"]),
            Bullets(tuple(case["outcomes"])),
            Note(f"Chosen by rule: {case['rule']}."),
            Disclosure("Motion and response", behind),
        )
        cases.append(Section(case["title"], shown))
    # The film of a scene does not show its contact forces.
    keys = "Keys: space plays and pauses, ← and → step, Home and End, s changes the speed"
    keys += "." if has_scene(results.study) else ", f shows contact forces."
    on_paper = Note("The page report.html shows them as films.", medium="paper")
    return Section("Cases to watch", (on_paper, *cases, Note(keys, medium="page")), anchor="telling")
