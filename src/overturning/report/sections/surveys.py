"""Surveys beside the prediction for their site, and what they say of the motion, for report and terminal."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np

from overturning.figures.style import format_short, style
from overturning.figures.write import save
from overturning.labels import azimuth_gap_label
from overturning.report.blocks import Answer, Caution, Figure, Note, Row, Said, Section, blocks_of, section, table
from overturning.report.results import Results
from overturning.report.text import counted, degrees, number, percent
from overturning.settings import Population
from overturning.surveys.comparison import SurveyComparison, SurveyResult
from overturning.surveys.inversion import MIN_FIT_P_VALUE, POWER
from overturning.surveys.posterior import LEVEL, InversionResult
from overturning.surveys.prediction import SIDES
from overturning.surveys.stones import OCTANTS, Stone
from overturning.units import CM

SIGNIFICANT: Final = 0.05
"""Below this p-value a test is said to show something."""

SHOWN: Final = 12
"""Motions in the table, the likeliest first."""

BLUNT: Final = 135.0
"""Width of the axis's arc, degrees, from which no axis is told; 162 hold nine tenths where nothing is known."""


@section("Fallen stones beside the prediction", "surveys")
def surveys(results: Results) -> Said:
    """The study's surveys; none where it has none."""
    stations = {name.id: name.station for name in results.record_names}
    for place, result in enumerate(results.surveys, 1):
        figure = results.figures / "survey" / f"{place}.svg"
        yield survey_section(result, stations[result.record], figure, azimuth_gap_label(results.cube))


def survey_section(result: SurveyResult, station: str = "", figure: Path | None = None, gaps: str = "") -> Section:
    """What is shown of a survey, with its figure where it has one.

    ``station`` is the name of its record's station, ``gaps`` what `azimuth_gap_label` says of the cube that predicts.
    """
    of_comparison = blocks_of(_of_comparison(result.comparison, figure, gaps))
    of_file = Note(f"{result.stones}, SHA-256 {result.sha256}")
    blocks = (*map(Caution, result.doubts), *of_comparison, of_file)
    return Section(f"Survey: {result.stones}, {station or result.record}", blocks)


def _of_comparison(found: SurveyComparison, figure: Path | None, gaps: str) -> Said:
    yield Answer(tuple(survey_sentences(found)))
    if gaps:
        yield Caution(f"No plane {gaps} was computed: there the prediction is made of what other planes say.")
    if found.directed:
        pairs = zip(OCTANTS, found.octant_observed, found.octant_predicted, strict=True)
        rows = [(name, number(seen, 0), expected) for name, seen, expected in pairs]
        octants = table(("fell towards", "observed", "predicted"), rows, "tn1")
        alt = "observed and predicted stones by octant"
        caption = "Fallen stones by compass octant: observed (filled) and as many as the prediction expects (outline)."
        yield Row((Figure(figure, alt, caption), octants), shares=(1.0, 1.0)) if figure else octants
        yield from _tests(found)
    if found.confusion is not None and found.confusion.sum():
        shaped = counted(int(found.confusion.sum()), "stone")
        yield (
            f"{int(found.confusion.trace())} of {shaped} of known face did what was most probable for them. Observed "
            "(rows) against most probable (columns):"
        )
        sides = [(side, *row) for side, row in zip(SIDES, found.confusion, strict=True)]
        yield table(("", *SIDES), sides, "t")
        yield Note(
            "Stones whose face azimuth and B/H are known, as seen looking the way the front face looks. A rectangular "
            "stone falls over one of its edges, so the prediction runs in the planes of its two pairs of faces, each "
            "with its own B/H; where it would fall in both, the plane in which it first passes the point of no return "
            "decides."
        )


def _p(value: float) -> str:
    return "–" if math.isnan(value) else ("< 0.001" if value < 0.001 else f"{value:.2g}")


def _p_is(value: float) -> str:
    text = _p(value)
    # The spaces do not break.
    return f"p\u00a0{text}" if text.startswith("<") else f"p\u00a0=\u00a0{text}"


_UNTESTED: Final = (
    "Stones whose face is known fall about the normals of its edges, how closely is not predicted: they are expected "
    "evenly over the 90° about each, to which their directions are no test of fit."
)


def _knows_faces(found: SurveyComparison) -> bool:
    """Return True if the directions of some falls are predicted edge by edge only."""
    return found.turned_every_way < found.directed


def survey_sentences(found: SurveyComparison) -> list[str]:
    """What was seen, and whether the prediction does better than "any way"; the answer first."""
    seen = f"{counted(found.fallen, 'stone')} fell, {found.stood} stood."
    if found.fallen == 0:
        return [f"{seen} Without a fall there is no direction to compare."]
    if found.directed == 0:
        return [f"{seen} The direction of no fall is known, so there is none to compare."]
    if found.without_direction:
        seen += f" The direction of {counted(found.without_direction, 'fall')} is not known and not compared."
    p = found.likelihood_ratio_p
    if found.log_likelihood_ratio <= 0:
        better = "The prediction does no better than the guess that stones fall any way"
    elif p < SIGNIFICANT:
        better = "The prediction does better than the guess that stones fall any way"
    else:
        better = "That the prediction does better than the guess that stones fall any way is not shown"
    reach = percent(p, 1) if p >= 0.001 else "fewer than 0.1\u00a0%"
    if not math.isnan(found.mean_direction_deg):
        mean = f"{round(found.mean_direction_deg) % 360}° (resultant {found.resultant:.2f})"
        seen += f" Mean fall direction {mean}."
    if found.never:
        they = "it" if found.never == 1 else "them"
        some = they if found.never == found.directed else f"{found.never} of them"
        seen += f" No stone like {some} falls in the study, so the prediction has {they} fall any way."
    fits = [test for test in (found.fit_octants, found.fit_octants_watson, found.fit_exact) if test.n]
    against = ", ".join(f"{test.name} {_p_is(test.p_value)}" for test in fits if test.p_value < SIGNIFICANT)
    fit = "the directions do not differ from it by more than chance would have it"
    if against:
        proven = found.log_likelihood_ratio > 0 and p < SIGNIFICANT
        fit = f"{'all the same ' if proven else ''}the directions differ from it by more than chance ({against})"
    fit = "" if _knows_faces(found) else f"; {fit}"
    sentences = [
        f"{better} (log likelihood ratio {number(found.log_likelihood_ratio)}, which {reach} of surveys of stones that "
        f"fall any way reach){fit}.",
        seen,
    ]
    sentences += [_turned_every_way(found)] if found.turned_every_way else []
    if found.beyond:
        are = "is" if found.beyond == 1 else "are"
        sentences.append(
            f"{counted(found.beyond, 'stone')} of B/H beyond the study's {are} taken to be of its nearest."
        )
    background = percent(found.background)
    return [*sentences, f"{background} of the stones are taken to fall any way, pushed or on a bad footing."]


def _turned_every_way(found: SurveyComparison) -> str:
    """State for how many falls face or B/H is missing, which of the two, and what the prediction assumes instead."""
    of = found.turned_every_way
    if found.without_face and not found.without_b_over_h:
        missing = "face azimuth"
    elif found.without_b_over_h and not found.without_face:
        missing = "B/H"
    else:
        missing = (
            "face azimuth and B/H" if of == found.without_face == found.without_b_over_h else "face azimuth or B/H"
        )
    whose = "For the stones that fell" if of == found.directed else f"For {of} of them"
    are = "are" if " and " in missing else "is"
    shapes = ", of every B/H of the study where none is given" if found.without_b_over_h else ""
    return f"{whose} {missing} {are} not given, so the prediction assumes stones turned every way{shapes}."


def _tests(found: SurveyComparison) -> Said:
    """Tests: question, name, stones, statistic, p; dashes where no stone has what a test needs.

    Of a survey with known faces there is no test of fit, which would find that falls keep to the normals.
    """
    fits = {
        "Does the prediction fit the octants?": found.fit_octants,
        "Does it fit them in their order?": found.fit_octants_watson,
        "Does it fit the exact azimuths?": found.fit_exact,
    }
    tests = ({} if _knows_faces(found) else fits) | {"Do stones fall any way?": found.uniform_octants}
    rows = [
        (question, test.name, test.n, *((format_short(test.statistic), _p(test.p_value)) if test.n else "––"))
        for question, test in tests.items()
    ]
    yield table(("question", "test", "stones", "statistic", "p"), rows, "tt")
    yield Note(
        "p: how often chance alone would give a statistic at least as large if the answer were yes; a small p says "
        "no. Octants are grouped, so their tests are too, with p simulated for counts as small as these; exact "
        f"azimuths need no groups. {_UNTESTED if _knows_faces(found) else ''}".rstrip()
    )


@section("From the stones back to the motion", "backwards")
def backwards(results: Results) -> Said:
    """What each survey of the study says of the motion; none where it has none."""
    for place, found in enumerate(results.inferred_motions, 1):
        yield backwards_section(found, draw_posterior(found, results.drawings / f"backwards-{place}.svg"))


def draw_posterior(found: InversionResult, path: Path) -> Path:
    """Draw a posterior into a file."""
    from overturning.figures.backwards import motion_posterior_figure

    one, curves = found.posterior, {}
    for name, values in found.strengths.items():
        order = np.argsort(values.ravel(), kind="stable")
        below = [each.sum(axis=2).ravel()[order].cumsum() for each in (one.probability, one.prior)]
        curves[name] = (values.ravel()[order], *below, one.credible_interval(values))
    shares = dict(zip(one.sources, one.source_probabilities().tolist(), strict=True))
    with style():
        save(motion_posterior_figure(found.name, one.axis_probabilities(), found.axis_arc, shares, curves), path)
    return path


_POPULATION: Final = Population()
_HEIGHT, _WIDTH = (f"{one.low:g} to {one.high:g} m" for one in (_POPULATION.height, _POPULATION.width))
_DRAWN: Final = f"A stone without a height is taken to be {_HEIGHT} high, one without B/H {_WIDTH} wide."


def sizes_taken(stones: Sequence[Stone]) -> str:
    """How many stones of a survey have no height or no B/H, and what they are taken to be; empty where all have."""
    high = sum(one.count for one in stones if math.isnan(one.height))
    wide = sum(one.count for one in stones if math.isnan(one.slenderness[0]))
    parts = [f"{counted(high, 'stone')} without a height taken to be {_HEIGHT} high"] if high else []
    parts += [f"{counted(wide, 'stone')} without B/H {_WIDTH} wide"] if wide else []
    return f"The strength hangs on sizes that the survey does not give: {', '.join(parts)}." if parts else ""


def backwards_section(found: InversionResult, figure: Path | None = None) -> Section:
    """What a survey says of the motion, with its figure where it has one."""
    return Section(f"What moved the ground: {found.name}", blocks_of(_of_motion(found, figure)))


def _of_motion(found: InversionResult, figure: Path | None) -> Said:
    one = found.posterior
    yield Answer(tuple(backwards_sentences(found)))
    yield from map(Caution, cautions(found))
    if figure is not None:
        caption = (
            "Axis of the largest velocity with the arc of 90 %, the likeliest motions, and how strong they were, "
            "before and after the survey; the band is the stated interval, an arrow stands where the library ends "
            "before it."
        )
        yield Figure(figure, "posterior of axis, motion, PGV and PGA", caption)
    shares, before = one.source_probabilities(), one.prior.sum(axis=(1, 2))
    rows = [(one.sources[i], float(shares[i]), float(before[i])) for i in np.argsort(-shares)[:SHOWN]]
    yield table(("motion", "probability", "before"), rows, "t%%")
    yield Note(
        f"Every motion, scaled to peak velocities of {one.level[0] / CM:.0f} to {one.level[-1] / CM:.0f} cm/s and "
        "turned every way, was equally likely before. Peaks are the largest over all azimuths. No motion of the "
        "library is taken to be the true one: stones that are written down alike differ, the motion differs over the "
        f"site, and directions count to the power {POWER:g}, so that such intervals hold the truth of simulated "
        f"surveys under records that are left out (docs/surveys.md). {_DRAWN} {percent(found.fixed)} of the stones are "
        "taken to be fixed. Whether fallen bodies tell the intensity at all is doubted (Aslam et al. 1980, J. Struct. "
        "Div. ASCE 106(2), 377)."
    )


def backwards_sentences(found: InversionResult) -> list[str]:
    """Bounds on PGV and PGA, and the axis of the motion."""
    one, parts = found.posterior, []
    for name, values in found.strengths.items():
        (low, high), (least, most) = one.credible_interval(values), one.credible_interval(values, use_prior=True)
        measure, unit = name.split(", ")
        parts.append(f"{measure} {_between(low, high, unit)} (before the survey {_between(least, most, unit)})")
    seen = f"From {counted(found.fell, 'stone')} that fell and {found.stood} that stood"
    middle, width = found.axis_arc
    arc = f"{degrees(middle, 180)} ± {degrees(width / 2)}"
    axis = f"The motion's axis, that of its largest velocity, is {arc}, with {percent(LEVEL)} probability."
    if width >= BLUNT:
        part = f"{percent(LEVEL)} of the probability takes {degrees(width)} of the 180°"
        axis = f"No axis of the motion can be told: {part}."
    if found.everything_fell:
        axis = (
            "No axis of the motion can be told: every stone fell, and axes found from simulated surveys in which every "
            "stone fell held the truth no more often than axes laid at random (docs/surveys.md)."
        )
    return [f"{seen}, with {percent(LEVEL)} probability: {'; '.join(parts)}.", axis]


def cautions(found: InversionResult) -> list[str]:
    """What is to be said where the library ends before the answer, or does not fit the survey."""
    weakest, strongest = found.posterior.outer_level_probabilities()
    tail, levels = (1 - LEVEL) / 2, found.posterior.level
    said = [
        f"The motion may have been {more} than any motion here: {percent(share)} of the probability lies on the {end} "
        f"level, {level / CM:.0f} cm/s. No {bound} bound is given."
        for share, more, end, level, bound in (
            (strongest, "stronger", "strongest", levels[-1], "upper"),
            (weakest, "weaker", "weakest", levels[0], "lower"),
        )
        if share > tail
    ]
    if found.fit < MIN_FIT_P_VALUE:
        said.append(
            "No motion here fits this survey: of surveys drawn from the answer, so few fit as badly that p is "
            f"{found.fit:.2g} (posterior predictive check). The bounds above do not hold; look for stones that were "
            "pushed or moved, or for sizes or directions that were mistaken."
        )
    return said


def _between(low: float, high: float, unit: str) -> str:
    """An interval in words, of which an end may be missing."""
    if math.isinf(high):
        return f"at least {format_short(low)} {unit}" if low > 0 else "of any size"
    return f"{format_short(low)} to {format_short(high)} {unit}" if low > 0 else f"at most {format_short(high)} {unit}"
