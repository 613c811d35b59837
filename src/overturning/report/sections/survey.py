"""What a survey says beside the prediction for its site, for the report and for the terminal."""

import math
from pathlib import Path

from overturning.figures.style import short
from overturning.report.blocks import Answer, Block, Figure, Note, Paragraph, Row, Section, Table
from overturning.report.results import Results
from overturning.report.text import counted, number, percent
from overturning.surveys.comparison import SurveyComparison, SurveyResult
from overturning.surveys.prediction import SIDES
from overturning.surveys.stones import OCTANTS

SIGNIFICANT = 0.05
"""Below this p-value a test is said to show something."""


def surveys(results: Results) -> Section | None:
    """The study's surveys; none where it has none."""
    stations = {name.id: name.station for name in results.names}
    sections = tuple(
        survey_section(result, stations[result.record], results.figures / "survey" / f"{number}.svg")
        for number, result in enumerate(results.surveys, 1)
    )
    return Section("Fallen stones beside the prediction", sections, anchor="surveys") if sections else None


def survey_section(result: SurveyResult, station: str = "", figure: Path | None = None) -> Section:
    """What is shown of a survey, with its figure where it has one; ``station`` is the name of its record's station."""
    found = result.comparison
    blocks: list[Block] = [Answer(tuple(survey_sentences(found)))]
    if found.fallen:
        octants, alt = _octants(found), "observed and predicted stones by octant"
        caption = "Fallen stones by compass octant: observed (filled) and as many as the prediction expects (outline)."
        about_tests = Note(
            "p: how often chance alone would give a statistic at least as large if the answer were yes; a small p says "
            "no. "
            "Octants are grouped, so their tests are too, with p simulated for counts as small as these; exact "
            "azimuths need "
            "no groups."
        )
        blocks += [Row((Figure(figure, alt, caption), octants)) if figure else octants, _tests(found), about_tests]
    if found.confusion is not None and found.confusion.sum():
        agree, shaped = int(found.confusion.trace()), counted(int(found.confusion.sum()), "stone")
        sides = tuple((side, *map(str, row)) for side, row in zip(SIDES, found.confusion, strict=True))
        agreement = (
            f"{agree} of {shaped} of known face did what was most probable for them. Observed (rows) against most "
            "probable "
            "(columns):"
        )
        about_sides = Note(
            "Stones whose face azimuth and B/H are known, as seen looking the way the front face looks. A rectangular "
            "stone "
            "falls over one of its edges, so the prediction runs in the planes of its two pairs of faces, each with "
            "its own "
            "B/H; where it would fall in both, the plane in which it first passes the point of no return decides."
        )
        blocks += [Paragraph(agreement), Table(("", *SIDES), sides), about_sides]
    blocks.append(Note(f"{result.stones}, SHA-256 {result.sha256}"))
    return Section(f"Survey: {result.stones}, {station or result.record}", tuple(blocks))


def _p(value: float) -> str:
    return "–" if math.isnan(value) else ("< 0.001" if value < 0.001 else f"{value:.2g}")


def _p_is(value: float) -> str:
    text = _p(value)
    # The spaces do not break.
    return f"p\u00a0{text}" if text.startswith("<") else f"p\u00a0=\u00a0{text}"


def survey_sentences(found: SurveyComparison) -> list[str]:
    """What was seen, and whether the prediction does better than "any way"; the answer first."""
    seen = f"{counted(found.fallen, 'stone')} fell, {found.stood} stood."
    if found.fallen == 0:
        return [f"{seen} Without a fall there is no direction to compare."]
    p, few = found.likelihood_ratio_p, "fewer than 0.1\u00a0%"
    if found.log_likelihood_ratio <= 0:
        better = "The prediction does no better than the guess that stones fall any way"
    elif p < SIGNIFICANT:
        better = "The prediction does better than the guess that stones fall any way"
    else:
        better = "That the prediction does better than the guess that stones fall any way is not shown"
    sentences = [
        f"{better}: log likelihood ratio {number(found.log_likelihood_ratio)} ({percent(p, 1) if p >= 0.001 else few} "
        "of "
        "surveys of stones that fall any way reach as much).",
        seen
        if math.isnan(found.mean_direction_deg)
        else f"{seen} Mean fall direction {round(found.mean_direction_deg) % 360}° (resultant {found.resultant:.2f}).",
    ]
    fits = [test for test in (found.fit_octants, found.fit_octants_watson, found.fit_exact) if test.n]
    against = [test for test in fits if test.p_value < SIGNIFICANT]
    sentences.append(
        f"The directions differ from the predicted ones ({', '.join(f'{t.name} {_p_is(t.p_value)}' for t in against)})."
        if against
        else "The directions do not differ from the predicted ones by more than chance would have it."
    )
    if found.turned_every_way:
        known = "Their" if found.turned_every_way == found.fallen else f"For {found.turned_every_way} of them the"
        sentences.append(
            f"{known} faces or B/H are not given, so the prediction assumes stones turned every way"
            + (", of every B/H of the study where none is given." if known == "Their" else ".")
        )
    sentences.append(
        f"{percent(found.background)} of the stones are taken to fall any way, pushed or on a bad footing."
    )
    return sentences


def _octants(found: SurveyComparison) -> Table:
    """Stones by octant: name, observed, predicted."""
    pairs = zip(OCTANTS, found.octant_observed, found.octant_predicted, strict=True)
    rows = tuple((name, f"{seen:.0f}", f"{expected:.1f}") for name, seen, expected in pairs)
    return Table(("fell towards", "observed", "predicted"), rows)


def _tests(found: SurveyComparison) -> Table:
    """Tests: question, name, stones, statistic, p; dashes where no stone has what a test needs."""
    tests = {
        "Does the prediction fit the octants?": found.fit_octants,
        "Does it fit them in their order?": found.fit_octants_watson,
        "Does it fit the exact azimuths?": found.fit_exact,
        "Do stones fall any way?": found.uniform_octants,
    }
    rows = tuple(
        (question, test.name, str(test.n), *((short(test.statistic), _p(test.p_value)) if test.n else ("–", "–")))
        for question, test in tests.items()
    )
    return Table(("question", "test", "stones", "statistic", "p"), rows, "tt")
