"""Texts of the report that the page and the paper share."""

from typing import Any

from overturning.report.sentences import percent

AXES_CAPTION = (
    "Fall axis of each earthquake relative to its fault normal, over all blocks of the study; the point grows with how "
    "strongly the axes agree. Below, the mean over earthquakes with its bootstrap interval. Which side of the fault normal "
    "counts as positive is arbitrary, so only axes are compared."
)
SUMMARY_NOTE = (
    "Alignment is the mean of cos 2Δ over earthquakes, Δ the angle between fall axis and fault normal: 1 normal to the "
    "fault, −1 along it, 0 neither. Intervals: 95 %, bootstrap over earthquakes. Rayleigh: any preferred axis; V: the fault "
    "normal, stated beforehand; both on doubled angles."
)
ROSE_CAPTION = "Azimuths towards which blocks fall, over all cases. Each plane of motion counts once; the area of a sector is its share."
METHOD = (
    "A rigid block on a base that moves with the record, computed by the distinct element method in the vertical plane of "
    "each azimuth. Angle in the polar maps: the azimuth towards which the block falls."
)
RECORD_NOTE = (
    "Azimuths in degrees clockwise from north. Peaks are the largest over the azimuths of the study, each with the azimuth "
    "along which it is reached. Overturned: share of the record's cases."
)
DIRECTION_NOTE = (
    "Over all cases of a record, each plane once. A direction has a head (towards 60°), an axis has none (60° and 240° are "
    "the same); a resultant of 1 means all falls alike, of 0 falls to every side alike. Easiest axis: along it the lowest block "
    "at the highest friction overturns up to the largest B/H; easier by: that B/H over the one of the hardest azimuth."
)

SCENE_CAPTION = "To scale; crosses are centres of mass, grey moves with the record."
SCENE_HEADS = ("scene", "element", "cases", "falls", "share", "falls first in", "median time, s")
SCENE_NOTE = (
    "A fall is a rotation of 90°, or what the scene file sets. Cases without an outcome are not counted. Elsewhere in this "
    "report “the block” is the reference element of the study's own scene."
)
SCENE_ROSES_CAPTION = "Azimuths towards which each stone falls, over all cases."
MAP_CAPTION = (
    "Stations and epicentres as the records or the record table state them; a fault whose strike is known is drawn through "
    "the epicentre."
)


def _s(count: int) -> str:
    return "" if count == 1 else "s"


def counted(records: int, earthquakes: int, with_vertical: int) -> str:
    """How many records and earthquakes, and what their number means."""
    text = (
        f"{records} record{_s(records)} of {earthquakes} earthquake{_s(earthquakes)}. Records of one earthquake are not "
        "independent, so earthquakes are counted, not records; azimuths of one record are the same motion seen from many "
        "sides, so they are no samples at all."
    )
    if with_vertical == 0:
        return f"{text} None of these records has vertical motion; what it would change is not in these numbers."
    if with_vertical < records:
        return f"{text} {with_vertical} records have vertical motion, the others none."
    return text


def case_note(cases: int, computed: int, fallen: float, missing: dict[str, int]) -> str:
    """Of how many cases the report speaks, and how many have no outcome."""
    share = "" if fallen != fallen else f" {percent(fallen)} of them overturn."
    others = (
        "all were computed" if computed == cases else f"{computed:,} were computed, the others are their mirror images"
    )
    absent = ", ".join(f"{number:,} {name.replace('_', ' ')}" for name, number in missing.items())
    return f"The study has {cases:,} cases (record × azimuth × height × B/H × friction); {others}.{share} " + (
        f"Without an outcome: {absent}." if absent else "No outcome is missing."
    )


def ensemble_text(ensemble: dict[str, Any] | None) -> str:
    """What the ensemble shows; empty without one."""
    if ensemble is None:
        return ""
    if ensemble["run"] == "0":
        return "No cell lies near a change of flag, so the ensemble had nothing to run."
    return (
        f"Each cell near a change of flag ({ensemble['run']} of all) was run {ensemble['members']} more times with slightly "
        f"different amplitude, shape, friction, damping and azimuth. In {ensemble['divided']} of them some runs fall and "
        f"others stand; in {ensemble['other_side']} most runs fall, but not all to the same side. Where runs are divided, the "
        f"two halves of the ensemble differ by {ensemble['scrambles']} in probability on average: that well "
        f"{ensemble['members']} runs know it. This is the spread over the neighbourhood stated in the study, not a "
        "probability of what happened."
    )


def fit_note(fit: dict[str, Any]) -> str:
    """What the logistic fit is."""
    return (
        f"Logistic fit of the probability of overturning to {fit['cases']:,} planes and cases of {fit['earthquakes']} "
        f"earthquake{_s(fit['earthquakes'])}; intervals clustered by earthquake. PGV/PGA in s, H in m. It says nothing "
        "outside the range of the data."
    )


def limits(records: int, earthquakes: int, with_vertical: int, chosen_for_pulses: bool) -> list[str]:
    """What the study does not say."""
    vertical = (
        "No vertical motion was given; it makes blocks lighter and heavier in turn."
        if with_vertical == 0
        else f"Vertical motion is in {with_vertical} of {records} records."
    )
    chosen = ": those with a velocity pulse were chosen for it" if chosen_for_pulses else ""
    sample = "1 earthquake is" if earthquakes == 1 else f"{earthquakes} earthquakes are"
    return [
        "The model is plane: a real stone may stand oblique to the motion, twist, or be a stack of several.",
        vertical,
        f"The records were not drawn at random{chosen}. {sample} a small sample.",
        "Blocks of every shape of the study count the same; a cemetery has shapes of its own.",
    ]
