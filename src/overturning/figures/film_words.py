"""All sentences of films: titles, headings, outcomes, and the texts of the player, in one place for translation.

The functions compose the texts from numbers; they take lengths in m and angles in degrees.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from overturning.figures.style import compass_bearing_text
from overturning.model.status import CaseStatus

if TYPE_CHECKING:
    import xarray as xr

PLAYER_TEXTS: Final = {
    "play": "Play",
    "pause": "Pause",
    "again": "Again",
    "time": "time",
    "speed": "Speed",
    "ground": "show the ground moving",
    "groundTip": "The camera stays with the earth: the ground moves below it. Otherwise it moves with the ground.",
    "forces": "contact forces",
    "forcesTip": "Forces divided by the stones' weight, averaged over a sampling interval; the longest arrow is 3.",
    "animation": "animation. Space plays and pauses, arrow keys step.",
    "scene": "the stone on its base",
    "peak": "peak",
}
"""Texts of the player, by their key in its script."""

PLAYBACK_SPEED_LABELS: Final = {0.2: "1/5", 0.5: "1/2", 1.0: "1"}
"""Speeds of the player, as a share of real time; the first is that at which a film starts."""

KEYBOARD_HELP_TEXT: Final = (
    "Keys: space plays and pauses, ← and → step by one frame (with shift by half a second), Home and End go to the "
    "first and last frame, s changes the speed, g shows the ground moving"
)

ACCELERATION_TRACE_LABELS: Final = {
    "along": "ground acceleration along the motion",
    "level": "ground acceleration towards north (blue) and east (green)",
    "up": "vertical ground acceleration",
    "no_up": "vertical ground acceleration: left out",
}
"""Labels of the traces below a scene."""

_STONE_DESCRIPTION_TEMPLATES: Final = {
    "stone": "A stone {width} wide and {height} high",
    "square": "A square stone {width} wide and {height} high",
    "oblong": "A stone {width} wide, {depth} deep and {height} high",
    "round": "A round stone {width} across and {height} high",
    "prism": "A stone of {sides} sides, {width} across and {height} high",
    "solid": "A stone {height} high",
    "scene": "{scene} ({element} {width} wide and {height} high)",
}


@dataclass(frozen=True, kw_only=True)
class FilmTitleFacts:
    """Entries of a film title: kind, size (m) and friction of the stone, and the motion.

    Attributes
    ----------
    stone_kind : str
        Key of the sentence about the stone: stone (in a vertical plane), square, oblong, round, prism or solid (3-D),
        or scene (several elements; the size is that of the reference element).
    width, height, depth : float
        Size of the stone, m; depth only if oblong.
    friction : float or None
        Friction coefficient; None if the scene sets it.
    station_and_event : str
        Station or id of the record, with the earthquake.
    motion_azimuth_or_orientation_deg : float or None
        Azimuth of the motion (2-D) or orientation of the body (3-D), degrees; None if the panels differ.
    amplitude_factor : float
        Factor on the recorded motion.
    is_simulated_without_vertical_motion : bool
        True if the vertical motion of the record is left out in all panels.
    """

    stone_kind: str
    width: float
    height: float
    friction: float | None
    station_and_event: str
    motion_azimuth_or_orientation_deg: float | None = None
    is_3d: bool = False
    depth: float = 0.0
    prism_side_count: int = 0
    scene_name: str = ""
    size_reference_element_name: str = ""
    amplitude_factor: float = 1.0
    is_simulated_without_vertical_motion: bool = False


def length_with_unit(length_m: float) -> str:
    """Return a length, given in m, as text with its unit: "18 cm", "1.2 m"."""
    return f"{length_m:.3g} m" if round(100.0 * length_m, 9) >= 100.0 else f"{100.0 * length_m:.3g} cm"


def station_and_event_text(station: str, event: str) -> str:
    """Return the station (or record id) and the earthquake as one text: "station, event"."""
    return f"{station}, {event}" if event else station


def station_and_event_text_of_cube(record_cube: "xr.Dataset") -> str:
    """Return the station and the earthquake of a cube's only record as text.

    The record's id replaces a missing station name, so that synthetic pulses, which have no station, have different
    names.
    """
    record_id, station, event = (
        str(record_cube[name].item()) if name in record_cube.variables else ""
        for name in ("record_id", "station", "event")
    )
    return station_and_event_text(station or record_id, event) if station or record_id else event


def film_title_text(title_facts: FilmTitleFacts) -> str:
    """Return the title of a film in words: "A square stone 18 cm wide and 60 cm high, friction 0.7, under …"."""
    sizes = {name: length_with_unit(getattr(title_facts, name)) for name in ("width", "height", "depth")}
    parts = [
        _STONE_DESCRIPTION_TEMPLATES[title_facts.stone_kind].format(
            **sizes,
            scene=title_facts.scene_name,
            element=title_facts.size_reference_element_name,
            sides=title_facts.prism_side_count,
        )
    ]
    if title_facts.friction is not None:
        parts.append(f"friction {title_facts.friction:g}")
    if title_facts.is_3d and title_facts.motion_azimuth_or_orientation_deg is not None:
        parts.append(f"facing {compass_bearing_text(title_facts.motion_azimuth_or_orientation_deg)}")
    turned = (
        ""
        if title_facts.is_3d or title_facts.motion_azimuth_or_orientation_deg is None
        else f", turned to {compass_bearing_text(title_facts.motion_azimuth_or_orientation_deg)}"
    )
    factor = "" if title_facts.amplitude_factor == 1.0 else f" times {title_facts.amplitude_factor:g}"
    parts.append(f"under the record of {title_facts.station_and_event}{turned}{factor}")
    return ", ".join(
        [*parts, *(["without its vertical motion"] if title_facts.is_simulated_without_vertical_motion else [])]
    )


def movie_title_with_speed(film_title: str, speed_label: str) -> str:
    """Return the title of a film with the speed at which its movie plays, such as "1/5" of real time."""
    return f"{film_title} (at {speed_label} of its speed)"


def panel_heading_with_motion_or_front_azimuth(azimuth_or_orientation_deg: float, *, is_3d: bool) -> str:
    """Return the heading of a film panel: azimuth of the motion (2-D), or azimuth that the body's front faces (3-D)."""
    return f"{'facing' if is_3d else 'motion along'} {compass_bearing_text(azimuth_or_orientation_deg)}"


_PANEL_HEADING_TEMPLATE_BY_COMPARED_SETTING: Final = {
    "vertical": "with vertical motion",
    "level": "without vertical motion",
    "scene": "{name}",
    "site": "on {name}",
    "recorded": "on the ground as recorded",
    "study": "as in the study",
    "variant": "{name}",
}


def panel_heading_of_compared_setting(compared_setting_kind: str, scene_or_variant_name: str = "") -> str:
    """Return the heading of a film panel for one of two compared study settings, such as "with vertical motion".

    Parameters
    ----------
    compared_setting_kind : str
        "vertical" or "level" (with or without vertical motion), "site" or "recorded" (with soil or as recorded),
        "scene" (two scenes differ), "study" or "variant" (any other difference between study and variant).
    scene_or_variant_name : str
        Name in the heading, for the kinds "scene", "site" and "variant".
    """
    return _PANEL_HEADING_TEMPLATE_BY_COMPARED_SETTING[compared_setting_kind].format(
        name=scene_or_variant_name.replace("-", " ") if compared_setting_kind == "site" else scene_or_variant_name
    )


def fall_sentence(fall_azimuth_deg: float, fall_time: float, stone_name: str = "") -> str:
    """Return a sentence: the stone falls towards an azimuth (degrees) at a time (s); its name can be left out."""
    towards = compass_bearing_text(fall_azimuth_deg)
    return f"{stone_name + ' ' if stone_name else ''}falls towards {towards} at {fall_time:.2f} s"


def join_fall_sentences(fall_sentences: list[str], free_stone_count: int) -> str:
    """Join the sentences on the falls in a scene; for several stones the text begins with "2 of 3 fall"."""
    fall = "falls" if len(fall_sentences) == 1 else "fall"
    counts = f"{len(fall_sentences)} of {free_stone_count} {fall}: " if free_stone_count > 1 else ""
    return counts + "; ".join(fall_sentences)


def standing_elements_sentence(
    peak_share_of_toppling_angle: float | None, peak_rotation_deg: float | None, *, has_several_free_stones: bool
) -> str:
    """Return a sentence that no stone of a 2-D scene falls, with the largest rotation as share of the toppling angle.

    Parameters
    ----------
    peak_share_of_toppling_angle : float or None
        Largest rotation over the angle at which the stone topples; None if no stone has such an angle.
    peak_rotation_deg : float or None
        Largest rotation of the stones without such an angle, degrees; None if all have one.
    has_several_free_stones : bool
        True if there are several free stones.
    """
    leans = (
        [f"leans to {100.0 * peak_share_of_toppling_angle:.0f} % of the angle at which it would topple at rest"]
        if peak_share_of_toppling_angle is not None
        else []
    )
    leans = (
        leans if peak_share_of_toppling_angle is None or peak_share_of_toppling_angle >= 0.005 else ["does not lean"]
    )
    leans += [] if peak_rotation_deg is None else [f"rotates by up to {peak_rotation_deg:.2g}°"]
    if has_several_free_stones:
        return f"everything stands; the stone that leans most {', another '.join(leans)}"
    return f"stands; {leans[0]}"


def standing_body_sentence(
    peak_tilt_deg_and_stone: tuple[float, str],
    final_twist_deg_and_stone: tuple[float, str],
    final_slip_m_and_stone: tuple[float, str],
    *,
    still_moves: bool,
) -> str:
    """Return a sentence that a 3-D body or stack stands, with its largest tilt, final twist and slip.

    Each argument is a value and, in a stack, the name of the stone that has it ("" for a single body). The sentence
    omits the name if the value is printed as 0.0.
    """

    def format_value_and_stone_name(value: float, stone_name: str) -> tuple[str, str]:
        """Return a magnitude with one decimal, and " (stone_name)", or "" without a name or if the value is 0.0."""
        number = f"{abs(value):.1f}"
        return number, f" ({stone_name})" if stone_name and number != "0.0" else ""

    tilt, of_tilt = format_value_and_stone_name(*peak_tilt_deg_and_stone)
    twist, of_twist = format_value_and_stone_name(*final_twist_deg_and_stone)
    slip, of_slip = format_value_and_stone_name(100.0 * final_slip_m_and_stone[0], final_slip_m_and_stone[1])
    stands = "everything stands" if peak_tilt_deg_and_stone[1] else "stands"
    side = "clockwise" if final_twist_deg_and_stone[0] >= 0 else "anticlockwise"
    still = ", where it still rocks or rolls" if still_moves else ""
    turned = f"turned {twist}° {side}{of_twist}, slipped {slip} cm by the end{of_slip}{still}"
    return f"{stands}; largest tilt {tilt}°{of_tilt}; {turned}"


NO_OUTCOME_SENTENCE_BY_STATUS: Final = {
    CaseStatus.UNDECIDED: "no outcome: still moving long after the record",
    CaseStatus.UNSTABLE: "no outcome: the energy balance, a rotation or a contact became invalid",
    CaseStatus.FAILED: "no outcome: the simulation failed",
    CaseStatus.OVER_BUDGET: "no outcome: needs more steps than a case may take",
}
"""Sentence about a case without outcome, by its status."""

REFERENCE_FRAME_NOTE: Final = "The picture moves with the ground unless the box is ticked."

VIEW_ROTATION_HINT: Final = "Drag to turn the view."

STRIP_CAPTIONS_ALL_FALL: Final = ("start", "first uplift", "near the fall", "lying")
"""Captions of the four frames of a strip, of a stone that falls."""

STRIP_CAPTIONS_SOME_FALL: Final = (*STRIP_CAPTIONS_ALL_FALL[:3], "end")
"""Captions of the four frames of a strip in which some stones fall and others stand."""

STRIP_CAPTIONS_NONE_FALL: Final = ("start", "first uplift", "largest lean", "end")
"""Captions of the four frames of a strip if nothing falls."""
