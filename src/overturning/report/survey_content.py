"""What a survey says beside the prediction for its site, as sentences and rows, for the report and for the terminal."""

import math
from typing import Any

from overturning.figures.style import short
from overturning.report.sentences import percent, signed
from overturning.statistics.circular import TestResult
from overturning.surveys.comparison import SurveyComparison
from overturning.surveys.prediction import SIDES
from overturning.surveys.result import SurveyResult
from overturning.surveys.stones import OCTANTS

SIGNIFICANT = 0.05
"""Below this p-value a test is said to show something."""

OCTANT_HEADS = ("fell towards", "observed", "predicted")
TEST_HEADS = ("question", "test", "stones", "statistic", "p")
CAPTION = "Fallen stones by compass octant: observed (filled) and as many as the prediction expects (outline)."
TEST_NOTE = (
    "p: how often chance alone would give a statistic at least as large if the answer were yes; a small p says no. Octants are "
    "grouped, so their tests are too, with p simulated for counts as small as these; exact azimuths need no groups."
)
CONFUSION_NOTE = (
    "Stones whose face azimuth and B/H are known: what they did (rows) against what is most probable for them (columns), as "
    "seen looking the way the front face looks. A rectangular stone falls over one of its edges, so the prediction runs in the "
    "planes of its two pairs of faces, each with its own B/H; where it would fall in both, the plane in which it first passes "
    "the point of no return decides."
)


def _stones(count: int) -> str:
    return f"{count} stone{'' if count == 1 else 's'}"


def _p(value: float) -> str:
    return "–" if math.isnan(value) else ("< 0.001" if value < 0.001 else f"{value:.2g}")


def _p_is(value: float) -> str:
    text = _p(value)
    # The spaces do not break.
    return f"p\u00a0{text}" if text.startswith("<") else f"p\u00a0=\u00a0{text}"


def survey_sentences(found: SurveyComparison) -> list[str]:
    """What was seen, and whether the prediction does better than "any way"; the answer first.

    Parameters
    ----------
    found : SurveyComparison
        The comparison.

    Returns
    -------
    list of str
    """
    counted = f"{_stones(found.fallen)} fell, {found.stood} stood."
    if found.fallen == 0:
        return [f"{counted} Without a fall there is no direction to compare."]
    p, few = found.likelihood_ratio_p, "fewer than 0.1\u00a0%"
    if found.log_likelihood_ratio <= 0:
        said = "The prediction does no better than the guess that stones fall any way"
    elif p < SIGNIFICANT:
        said = "The prediction does better than the guess that stones fall any way"
    else:
        said = "That the prediction does better than the guess that stones fall any way is not shown"
    sentences = [
        f"{said}: log likelihood ratio {signed(found.log_likelihood_ratio, 2)} ({percent(p, 1) if p >= 0.001 else few} of "
        "surveys of stones that fall any way reach as much).",
        counted
        if math.isnan(found.mean_direction_deg)
        else f"{counted} Mean fall direction {round(found.mean_direction_deg) % 360}° (resultant {found.resultant:.2f}).",
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


def octant_rows(found: SurveyComparison) -> list[list[str]]:
    """Stones by octant: name, observed, predicted."""
    pairs = zip(OCTANTS, found.octant_observed, found.octant_predicted, strict=True)
    return [[name, f"{seen:.0f}", f"{expected:.1f}"] for name, seen, expected in pairs]


def fit_rows(found: SurveyComparison) -> list[list[str]]:
    """Tests: question, name, stones, statistic, p; dashes where no stone has what a test needs."""
    tests: list[tuple[str, TestResult]] = [
        ("Does the prediction fit the octants?", found.fit_octants),
        ("Does it fit them in their order?", found.fit_octants_watson),
        ("Does it fit the exact azimuths?", found.fit_exact),
        ("Do stones fall any way?", found.uniform_octants),
    ]
    return [
        [
            question, test.name, str(test.n), *(["–", "–"] if test.n == 0 else [short(test.statistic), _p(test.p_value)]),
        ]
        for question, test in tests
    ]  # fmt: skip


def confusion_rows(found: SurveyComparison) -> list[list[str]]:
    """Observed side and the stones by most probable side; empty without stones of known face."""
    if found.confusion is None:
        return []
    return [[side, *(str(count) for count in row)] for side, row in zip(SIDES, found.confusion, strict=True)]


def survey_content(result: SurveyResult, station: str = "") -> dict[str, Any]:
    """Everything that is shown of a survey.

    Parameters
    ----------
    result : SurveyResult
        The comparison with its file and record.
    station : str
        Name of the record's station.

    Returns
    -------
    dict
        Plain data.
    """
    found = result.comparison
    agree = 0 if found.confusion is None else int(found.confusion.trace())
    shaped = 0 if found.confusion is None else int(found.confusion.sum())
    return {
        "title": f"{result.stones}, {station or result.record}",
        "sentences": survey_sentences(found),
        "fallen": found.fallen,
        "octants": octant_rows(found) if found.fallen else [],
        "tests": fit_rows(found) if found.fallen else [],
        "sides": list(SIDES),
        "confusion": confusion_rows(found),
        "agreement": f"{agree} of {_stones(shaped)} of known face did what was most probable for them."
        if shaped
        else "",
        "source": f"{result.stones}, SHA-256 {result.sha256}",
    }
