"""Names of the columns of a survey table: accepted names, probable misspellings, and columns that are not used."""

import difflib
import itertools
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import Final

_COLUMN_BY_ACCEPTED_NAME: Final = {
    **dict.fromkeys(("azimuth", "direction", "fall_azimuth", "azimuth_of_fall", "fall_azimuth_deg"), "azimuth_deg"),
    **dict.fromkeys(("fall_direction", "direction_of_fall", "fall_bearing", "fell_towards", "fell_to"), "azimuth_deg"),
    **dict.fromkeys(("magnetic_azimuth", "azimuth_magnetic", "mag_azimuth", "azimuth_mag"), "azimuth_deg"),
    **dict.fromkeys(("true_azimuth", "azimuth_true"), "azimuth_deg"),
    **dict.fromkeys(("declination", "declination_deg", "magnetic_declination"), "magnetic_declination_deg"),
    **dict.fromkeys(("face_azimuth", "azimuth_of_face"), "face_azimuth_deg"),
    **dict.fromkeys(("cemetery", "graveyard", "site_name", "cemetery_name"), "site"),
    **dict.fromkeys(("stone_id", "stone_name", "stone_no", "stone_number", "id"), "stone"),
    **dict.fromkeys(("type", "stone_type", "stone_kind"), "kind"),
    **dict.fromkeys(("notes", "remark", "remarks", "comment", "comments"), "note"),
    **dict.fromkeys(("photos", "photograph", "photographs", "picture"), "photo"),
    **dict.fromkeys(("latitude", "lat_deg"), "lat"),
    **dict.fromkeys(("longitude", "long", "lng", "lon_deg"), "lon"),
    "easting": "x",
    "x_m": "x",
    "northing": "y",
    "y_m": "y",
    "shift_in_cm": "shift_cm",
    "shift_in_mm": "shift_mm",
}
"""Other names of columns that leave no doubt about the meaning, each with the name of the column."""

_PROBABLE_COLUMN_BY_REFUSED_NAME: Final = {
    **dict.fromkeys(("az", "azi", "azm", "azimut", "bearing", "heading", "trend", "dir", "fall_dir"), "azimuth_deg"),
    **dict.fromkeys(("fall_az", "fell_from", "fall_from", "toward", "towards"), "azimuth_deg"),
    **dict.fromkeys(("b/h", "bh", "b_h", "slenderness", "aspect"), "b_over_h"),
    **dict.fromkeys(("h", "height"), "height_m"),
    **dict.fromkeys(("fallen", "overturned", "toppled", "fall"), "fell"),
    **dict.fromkeys(("state", "status", "result", "damage"), "outcome"),
    **dict.fromkeys(("face", "facing"), "face_azimuth_deg"),
    **dict.fromkeys(("twist", "twisted", "rotation", "rotation_deg"), "twist_deg"),
    **dict.fromkeys(("shift", "shifted", "displacement", "shift_m"), "shift_cm"),
    **dict.fromkeys(("column", "cylinder", "shape"), "round"),
}
"""Names that may mean a column of another unit or sense, each with the column that is probably meant."""

_AZIMUTH_CONVERSION_ADVICE: Final = {
    **dict.fromkeys(("gon", "grad", "grads"), "Multiply the azimuths in gon by 0.9"),
    **dict.fromkeys(("rad", "radians"), "Multiply the azimuths in radians by 57.29578"),
}
_CONVERSION_ADVICE_BY_COLUMN: Final = {
    "height_m": {"cm": "Divide the heights by 100", "mm": "Divide the heights by 1000", "ft": "Multiply by 0.3048"},
    "shift_cm": {"m": "Multiply the shifts by 100"},
    "azimuth_deg": _AZIMUTH_CONVERSION_ADVICE,
    "face_azimuth_deg": _AZIMUTH_CONVERSION_ADVICE,
}
"""Remedies for values in another unit, by the column that is meant and the unit in its name."""

_COLUMN_NAMES_SUGGESTING_STONE_COUNTS: Final = (
    "total", "totals", "sum", "all", "out_of", "n", "number", "no_of_stones", "number_of_stones", "stones",
    "stone_count", "not_fell", "not_fallen", "did_not_fall", "remained", "remaining", "number_standing",
)  # fmt: skip
"""Names of a column that may contain numbers of stones, in a table whose column fell has 1 and 0."""

_STANDING_COUNT_COLUMN_NAMES: Final = ("stood", "stands", "standing", "number_standing")
"""Names of a column with the number of standing stones, beside one with the number that fell."""

_MAX_SHORT_COLUMN_NAME_LENGTH: Final = 5
"""Largest number of letters of a short column name; short names resemble many other words."""

_MIN_NAME_SIMILARITY: Final = 0.75
"""Smallest similarity (of `difflib`) of a misspelt column name and the known name."""

DESCRIPTIVE_COLUMNS: Final = ("site", "stone", "kind", "lat", "lon", "x", "y", "note", "photo")
"""Columns that only describe a stone, so a misspelt one is no fault; if named twice, the further ones are not used."""

_ACCEPTED_TEXTS_IN_PARENTHESES: Final = ("", "deg", "degrees", "°", "º", "˚", "true", "mag", "magnetic")
"""Texts in parentheses that may follow an accepted name."""


@dataclass
class RecognisedColumns:
    """Meaning of each column of a survey table, with notes on unusual columns and errors on refused ones.

    Attributes
    ----------
    standard_name_by_column : list of str
        Known name of each column, in order; "" for a column that is not used.
    notes : list of str
        Notes on columns that are accepted under another than the known name, and on columns that are not used.
    error_messages : list of str
        Error messages on columns that are refused.
    """

    standard_name_by_column: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    error_messages: list[str] = field(default_factory=list)


def recognise_columns(
    column_names_in_file: Sequence[str], accepted_standard_column_names: Sequence[str]
) -> RecognisedColumns:
    """Recognise the columns in the header of a survey table by their names; return meanings, notes and errors.

    Parameters
    ----------
    column_names_in_file : sequence of str
        Names as they are in the file.
    accepted_standard_column_names : sequence of str
        Columns that a survey may have.
    """
    plan, unused = RecognisedColumns(), list[str]()
    exact = [name.lower() for name in column_names_in_file]
    found = [
        _standard_column_name_and_refusal_reason(name, accepted_standard_column_names) for name in column_names_in_file
    ]
    accepted = [meaning for meaning, refusal in found if meaning and not refusal]
    # A row of a stone may have a cell that reads like the name of a column: fell.
    is_row_of_stone = 2 * len(accepted) < len(column_names_in_file) or set(accepted) <= {"fell"}
    for name, (meaning, refusal) in zip(column_names_in_file, found, strict=True):
        if "fell" in exact and _simplified_column_name(name) in _STANDING_COUNT_COLUMN_NAMES:
            plan.error_messages.append(
                f"column {name!r} beside fell: fell is yes or no for the stones of a row; write the numbers of fallen "
                "and of standing stones into the column count, each in a row of its own"
            )
            plan.standard_name_by_column.append("")
            continue
        if is_row_of_stone and re.fullmatch(r"[+-]?\d+([.,]\d*)?", name):
            plan.error_messages.append(
                f"column {name!r} is a number; the first line without # names the columns: write the names above the "
                "first stone"
            )
            plan.standard_name_by_column.append("")
            continue
        if (
            meaning in DESCRIPTIVE_COLUMNS
            and name.lower() != meaning
            and (meaning in exact or meaning in plan.standard_name_by_column)
        ):
            meaning = ""
        if refusal and meaning in DESCRIPTIVE_COLUMNS:
            unused.append(f"{name.lower()} (did you mean {meaning}?)")
            meaning = ""
        elif refusal:
            plan.error_messages.append(f"column {name.lower()!r} is not known; {refusal}")
        elif meaning and meaning in plan.standard_name_by_column:
            plan.error_messages.append(f"column {name!r}: {meaning} is named twice; name each column once")
            meaning = ""
        elif meaning and name.lower() not in (meaning, "declination"):
            plan.notes.append(f"column {name!r} is read as {meaning}")
        elif not meaning:
            unused.append(name.lower() or "without a name")
        # The cells of a misspelt column are checked as well, so that all faults are reported at once.
        plan.standard_name_by_column.append(meaning)
    if unused:
        plan.notes.append(f"not used: column{'s' * (len(unused) > 1)} {', '.join(unused)}")
    return plan


def errors_if_fell_column_may_hold_counts(
    column_names_in_file: Sequence[str],
    standard_name_of_each_column: Sequence[str],
    cell_texts_by_row: Sequence[Sequence[str]],
) -> list[str]:
    """Return error messages on columns that hold numbers of stones, in a table whose column ``fell`` has only 1 and 0.

    In such a table, 1 and 0 may be numbers of fallen stones instead of yes and no.

    Parameters
    ----------
    column_names_in_file, standard_name_of_each_column : sequence of str
        Names of the columns in the file, and their known names ("" for a column that is not used).
    cell_texts_by_row : sequence of sequence of str
        Cells of each row.
    """
    if "fell" not in standard_name_of_each_column:
        return []
    columns = list(itertools.zip_longest(*cell_texts_by_row, fillvalue=""))[: len(column_names_in_file)]
    fell = {cell for cell in columns[standard_name_of_each_column.index("fell")] if cell} if columns else set()
    if not fell or not fell <= {"0", "1"}:
        return []
    return [
        f"column {name!r} next to fell: if 1 and 0 of fell are numbers of stones, write fallen and standing stones in "
        "rows of their own, with their number in the column count; if they are yes and no, write yes and no"
        for name, meaning, cells in zip(column_names_in_file, standard_name_of_each_column, columns, strict=False)
        if not meaning
        and _simplified_column_name(name) in _COLUMN_NAMES_SUGGESTING_STONE_COUNTS
        and all(re.fullmatch(r"\d*", cell) for cell in cells)
        and any(int(cell or 0) > 1 for cell in cells)
    ]


def looks_like_header(
    cell_texts: Sequence[str],
    accepted_standard_column_names: Sequence[str],
    standard_names_of_which_one_is_needed: Collection[str],
) -> bool:
    """True if a line looks like a table header: each cell names an accepted column, and one cell a needed column."""
    found = [
        _standard_column_name_and_refusal_reason(cell.strip(' "'), accepted_standard_column_names)
        for cell in cell_texts
    ]
    accepted = all(meaning and not refusal for meaning, refusal in found)
    return len(found) > 1 and accepted and any(meaning in standard_names_of_which_one_is_needed for meaning, _ in found)


def column_name_states_magnetic_north(column_name: str) -> bool:
    """True if a column name states that the column's azimuths are measured from magnetic north."""
    return re.search(r"\bmag(netic)?\b", column_name.lower().replace("_", " ")) is not None


def column_name_states_true_north(column_name: str) -> bool:
    """True if a column name states that the column's azimuths are measured from true north."""
    return re.search(r"\btrue\b", column_name.lower().replace("_", " ")) is not None


def _standard_column_name_and_refusal_reason(
    column_name_in_file: str, accepted_standard_column_names: Sequence[str]
) -> tuple[str, str]:
    """Return the standard name that a column name means ("" if unused), and why it is refused ("" if accepted)."""
    if column_name_in_file.lower() in accepted_standard_column_names:
        return column_name_in_file.lower(), ""
    plain = _simplified_column_name(column_name_in_file)
    aside = re.findall(r"[(\[](.*?)[)\]]", column_name_in_file.lower())
    if all(word.strip() in _ACCEPTED_TEXTS_IN_PARENTHESES for word in aside):
        if plain in _COLUMN_BY_ACCEPTED_NAME:
            return _COLUMN_BY_ACCEPTED_NAME[plain], ""
        if aside and plain in accepted_standard_column_names:
            return plain, ""
    if len(aside) == 1 and f"{plain}_{aside[0].strip()}" in accepted_standard_column_names:  # "Height (m)"
        return f"{plain}_{aside[0].strip()}", ""
    meant = _closest_standard_column_name(plain, accepted_standard_column_names)
    if meant:
        return meant, f"did you mean {meant}? {_advice_on_converting_refused_column(meant, column_name_in_file)}"
    return "", ""


def _advice_on_converting_refused_column(probably_meant_standard_column_name: str, refused_column_name: str) -> str:
    """Return advice on how to convert a refused column to the one that is probably meant, or else to rename it."""
    words = re.findall(r"[a-z]+", refused_column_name.lower())
    found = [
        remedy
        for unit, remedy in _CONVERSION_ADVICE_BY_COLUMN.get(probably_meant_standard_column_name, {}).items()
        if unit in words
    ]
    if probably_meant_standard_column_name == "b_over_h" and re.match(
        r"h.*b", _simplified_column_name(refused_column_name)
    ):
        found = ["Give B/H, the reciprocal of H/B"]
    return found[0] if found else "A column for something else needs a name that is less like it"


def _simplified_column_name(column_name: str) -> str:
    """Return a column name in lower case, with underscores for blanks, without parentheses and degree signs."""
    return re.sub(r"[\s-]+", "_", re.sub(r"[(\[].*?[)\]]|[°º˚]", "", column_name.lower()).strip()).strip("_?.")


def _is_misspelling(column_name: str, standard_column_name: str) -> bool:
    """True if `column_name` is a misspelling of the short column name `standard_column_name`.

    Letters may be in another order, one letter omitted or doubled, or s or ed added. Larger differences do not count,
    since other short words would match, such as county for count and ground for round.
    """
    if len(standard_column_name) < 3 or not column_name:
        return False
    swapped = sorted(column_name) == sorted(standard_column_name)
    lacks_one = any(
        column_name == standard_column_name[:at] + standard_column_name[at + 1 :]
        for at in range(len(standard_column_name))
    )
    doubled = any(
        column_name == standard_column_name[: at + 1] + standard_column_name[at:]
        for at in range(len(standard_column_name))
    )
    return swapped or lacks_one or doubled or column_name in (f"{standard_column_name}s", f"{standard_column_name}ed")


def _closest_standard_column_name(simplified_column_name: str, accepted_standard_column_names: Sequence[str]) -> str:
    """Return the standard column name that an unknown name probably means; "" if it resembles none."""
    synonyms = _COLUMN_BY_ACCEPTED_NAME | _PROBABLE_COLUMN_BY_REFUSED_NAME
    long = [one for one in (*accepted_standard_column_names, *synonyms) if len(one) > _MAX_SHORT_COLUMN_NAME_LENGTH]
    near = [
        one
        for one in accepted_standard_column_names
        if len(one) <= _MAX_SHORT_COLUMN_NAME_LENGTH and _is_misspelling(simplified_column_name, one)
    ]
    near = near or difflib.get_close_matches(simplified_column_name, long, 1, _MIN_NAME_SIMILARITY)
    found = synonyms.get(simplified_column_name) or (near[0] if near else "")
    return synonyms.get(found, found)
