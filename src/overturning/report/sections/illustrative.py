"""Cases to watch: films, and the motion and response behind them."""

from overturning.report.blocks import Block, Bullets, Disclosure, Figure, Film, Note, Section
from overturning.report.results import Results


def illustrative(results: Results) -> Section | None:
    """The illustrative cases as films; none where there is none."""
    if not results.illustrative:
        return None
    cases: list[Block] = [Note("The page report.html shows them as films.", medium="paper")]
    for case in results.illustrative:
        behind = tuple(
            Figure(results.figures / "illustrative" / file, **about) for file, about in case["figures"].items()
        )
        rule = Note(f"Chosen by rule: {case['rule']}.")
        film = Film(case["film"], case["block"])
        shown = (film, Bullets(tuple(case["outcomes"])), rule, Disclosure("Motion and response", behind))
        cases.append(Section(case["title"], shown))
    keys = f"Keys: space plays and pauses, ← and → step, Home and End, s changes the speed, {case['keys']}."
    return Section("Cases to watch", (*cases, Note(keys, medium="page")), anchor="illustrative")
