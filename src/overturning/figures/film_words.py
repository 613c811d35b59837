"""All sentences of films: titles, headings, outcomes, and the texts of the player, in one place for translation.

The functions compose the texts from numbers; they take lengths in m and angles in degrees.
"""

from dataclasses import dataclass
from typing import Final

from overturning.figures.style import compass_name

PLAYER: Final = {
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

SPEEDS: Final = {0.2: "1/5", 0.5: "1/2", 1.0: "1"}
"""Speeds of the player, as a share of real time; the first is that at which a film starts."""

KEYS: Final = (
    "Keys: space plays and pauses, ← and → step by one frame (with shift by half a second), Home and End go to the "
    "first and last frame, s changes the speed, g shows the ground moving"
)

COMPONENTS: Final = {
    "along": "ground acceleration along the motion",
    "level": "ground acceleration towards north (blue) and east (green)",
    "up": "vertical ground acceleration",
    "no_up": "vertical ground acceleration: left out",
}
"""Labels of the traces below a scene."""

_SHAPES: Final = {
    "stone": "A stone {width} wide and {height} high",
    "square": "A square stone {width} wide and {height} high",
    "oblong": "A stone {width} wide, {depth} deep and {height} high",
    "round": "A round stone {width} across and {height} high",
    "prism": "A stone of {sides} sides, {width} across and {height} high",
    "solid": "A stone {height} high",
    "scene": "{scene} ({element} {width} wide and {height} high)",
}


@dataclass(frozen=True, kw_only=True)
class FilmedCase:
    """Facts of a film's title: the stone, its friction, and the motion; lengths in m.

    Attributes
    ----------
    kind : str
        Key of the sentence about the stone: stone (in a vertical plane), square, oblong, round, prism or solid (3-D),
        or scene (several elements; the size is that of the reference element).
    width, height, depth : float
        Size of the stone, m; depth only if oblong.
    friction : float or None
        Friction coefficient; None if the scene sets it.
    place : str
        Station or id of the record, with the earthquake.
    direction : float or None
        Azimuth of the motion (2-D) or orientation of the body (3-D), degrees; None if the panels differ.
    amplitude : float
        Factor on the recorded motion.
    level : bool
        True if the vertical motion of the record is left out in all panels.
    """

    kind: str
    width: float
    height: float
    friction: float | None
    place: str
    direction: float | None = None
    in_space: bool = False
    depth: float = 0.0
    sides: int = 0
    scene: str = ""
    element: str = ""
    amplitude: float = 1.0
    level: bool = False


def length_text(length: float) -> str:
    """Return a length, m, with its unit: "18 cm", "1.2 m"."""
    return f"{length:.3g} m" if round(100.0 * length, 9) >= 100.0 else f"{100.0 * length:.3g} cm"


def place_text(station: str, event: str) -> str:
    """Return the name of a record: its station or id, and the earthquake."""
    return f"{station}, {event}" if event else station


def case_title(case: FilmedCase) -> str:
    """Return the title of a film in words: "A square stone 18 cm wide and 60 cm high, friction 0.7, under …"."""
    sizes = {name: length_text(getattr(case, name)) for name in ("width", "height", "depth")}
    parts = [_SHAPES[case.kind].format(**sizes, scene=case.scene, element=case.element, sides=case.sides)]
    if case.friction is not None:
        parts.append(f"friction {case.friction:g}")
    if case.in_space and case.direction is not None:
        parts.append(f"facing {compass_name(case.direction)}")
    turned = "" if case.in_space or case.direction is None else f", turned to {compass_name(case.direction)}"
    factor = "" if case.amplitude == 1.0 else f" times {case.amplitude:g}"
    parts.append(f"under the record of {case.place}{turned}{factor}")
    return ", ".join([*parts, *(["without its vertical motion"] if case.level else [])])


def movie_title(title: str, speed: str) -> str:
    """Return the title of a movie that plays at a fixed speed, such as "1/5" of real time."""
    return f"{title} (at {speed} of its speed)"


def direction_heading(direction_deg: float, *, in_space: bool) -> str:
    """Return the heading of a panel: the azimuth of the motion (2-D), or the direction that a body faces (3-D)."""
    return f"{'facing' if in_space else 'motion along'} {compass_name(direction_deg)}"


_SETTINGS: Final = {
    "vertical": "with vertical motion",
    "level": "without vertical motion",
    "scene": "{name}",
    "site": "on {name}",
    "recorded": "on the ground as recorded",
    "study": "as in the study",
    "variant": "{name}",
}


def setting_heading(kind: str, name: str = "") -> str:
    """Return the heading of a panel of a comparison of two settings.

    Parameters
    ----------
    kind : str
        vertical or level (with and without vertical motion), scene, site or recorded (with and without soil), study or
        variant (any other setting).
    name : str
        Title of the scene, or name of the variant.
    """
    return _SETTINGS[kind].format(name=name.replace("-", " ") if kind == "site" else name)


def fall_text(towards_deg: float, time: float, name: str = "") -> str:
    """Return that a stone falls towards an azimuth, degrees, at a time, s; with its name if there are several."""
    return f"{name + ' ' if name else ''}falls towards {compass_name(towards_deg)} at {time:.2f} s"


def falls_text(fall_sentences: list[str], stone_count: int) -> str:
    """Return the falls of a scene, of `stone_count` free stones."""
    return (f"{len(fall_sentences)} of {stone_count} fall: " if stone_count > 1 else "") + "; ".join(fall_sentences)


def lean_text(toppling_share: float | None, rotation_deg: float | None, *, several: bool) -> str:
    """Return that nothing falls, and how far the stones lean.

    Parameters
    ----------
    toppling_share : float or None
        Largest rotation over the angle at which the stone topples; None if no stone has such an angle.
    rotation_deg : float or None
        Largest rotation of the stones without such an angle, degrees; None if all have one.
    several : bool
        True if there are several free stones.
    """
    leans = (
        [f"leans to {100.0 * toppling_share:.0f} % of the angle at which it would topple"]
        if toppling_share is not None
        else []
    )
    leans = leans if toppling_share is None or toppling_share >= 0.005 else ["does not lean"]
    leans += [] if rotation_deg is None else [f"rotates by up to {rotation_deg:.2g}°"]
    if several:
        return f"everything stands; the stone that leans most {', another '.join(leans)}"
    return f"stands; {leans[0]}"


def tilt_text(tilt_deg: float, twist_deg: float, slip_m: float, *, still_moves: bool) -> str:
    """Return that a 3-D body stands: largest tilt and final turn, degrees, slip, m, and whether it still moves."""
    side = "clockwise" if twist_deg >= 0 else "anticlockwise"
    still = ", where it still rocks or rolls" if still_moves else ""
    turned = f"turned {abs(twist_deg):.1f}° {side}, slipped {100.0 * slip_m:.1f} cm by the end{still}"
    return f"stands; largest tilt {tilt_deg:.1f}°; {turned}"


NO_OUTCOME: Final = "no outcome: the simulation is not valid"

FRAME_NOTE: Final = "The picture moves with the ground unless the box is ticked."

SPACE_NOTE: Final = "Drag to turn the view."

STRIP: Final = ("start", "first uplift", "near the fall", "lying")
"""Captions of the four frames of a strip, of a stone that falls."""

STRIP_MIXED: Final = (*STRIP[:3], "end")
"""Captions of the four frames of a strip in which some stones fall and others stand."""

STRIP_STANDING: Final = ("start", "first uplift", "largest lean", "end")
"""Captions of the four frames of a strip if nothing falls."""
