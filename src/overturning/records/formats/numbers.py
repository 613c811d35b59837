"""Numbers in text headers and columns, read strictly: what is not one is an error that names file and line."""

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from overturning.errors import RecordError

FLOAT = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eEdD][+-]?[0-9]+)?"
_NUMBER = re.compile(rf"\s*({FLOAT})\s*")


def number(text: str, file: str, line: int, what: str) -> float:
    """A finite number that fills the text.

    Raises
    ------
    RecordError
        If the text is anything else (blank, ``nan``, ``******``, two numbers that touch).
    """
    match = _NUMBER.fullmatch(text)
    if match is None:
        raise RecordError(
            f"{file} line {line}: {what} is {text.strip()!r}, not a number; correct it or get the file again"
        )
    return float(match[1].replace("D", "E").replace("d", "e"))


def resolution(text: str) -> float:
    """Unit of the last printed digit of a number: 0.001 for ``927.174``, 10 for ``1.23E3``."""
    mantissa, _, exponent = text.strip().upper().replace("D", "E").partition("E")
    decimals = len(mantissa.partition(".")[2])
    return float(10.0 ** (int(exponent or 0) - decimals))


def column(lines: Sequence[str], file: str, first_line: int) -> NDArray[np.float64]:
    """All numbers of free-format lines, in reading order.

    Parameters
    ----------
    lines : sequence of str
        Lines that hold nothing but numbers and blanks.
    file : str
        What an error names.
    first_line : int
        Number of the first of the lines in the file, counted from 1.

    Raises
    ------
    RecordError
        At the first line that holds something else.
    """
    words = " ".join(lines).split()
    try:
        # "nan", "inf" and "1_000" are numbers to Python but not to any of the formats.
        if any(set(word) - _ALLOWED for word in words):
            raise ValueError
        return np.array(words, dtype=np.float64)
    except ValueError:
        pass
    values: list[float] = []
    for index, line in enumerate(lines):
        values += [number(word, file, first_line + index, "a sample") for word in line.split()]
    return np.array(values, dtype=np.float64)


_ALLOWED = set("0123456789+-.eE")


def check_last_number(text: str, file: str, line: int) -> None:
    """Refuse a last number that was cut off: fewer decimals than the one before it, and no line end behind it.

    Parameters
    ----------
    text : str
        The end of the file, at least two numbers.
    file : str
    line : int
        Number of the last line.

    Raises
    ------
    RecordError
    """
    if text[-1:] in "\r\n":
        return
    words = text.split()[-2:]
    if len(words) == 2 and len(words[0].lstrip("+-")) != len(words[1].lstrip("+-")):
        before, last = (w.partition(".")[2] for w in words)
        if len(before) != len(last):
            raise RecordError(f"{file} line {line}: the last number, {words[1]!r}, is cut; get the file again")


def fixed_columns(
    lines: Sequence[str], file: str, first_line: int, *, width: int, per_line: int, count: int
) -> NDArray[np.float64]:
    """Numbers in columns of fixed width, which may touch (FORTRAN ``8F10.3``).

    Parameters
    ----------
    lines : sequence of str
        At least the lines that hold the numbers; further lines are left.
    file : str
        What an error names.
    first_line : int
        Number of the first of the lines in the file, counted from 1.
    width, per_line, count : int
        Characters per number, numbers per full line, and how many numbers there are.

    Returns
    -------
    ndarray, shape (count,)

    Raises
    ------
    RecordError
        If lines are missing, or a column holds something else than a number.
    """
    needed = -(-count // per_line)
    if len(lines) < needed:
        raise RecordError(
            f"{file} line {first_line + len(lines)}: the file ends after {len(lines)} of {needed} lines of samples; "
            "it is cut: get it again"
        )
    words = []
    for index in range(needed):
        line = lines[index].rstrip()
        in_line = min(per_line, count - index * per_line)
        cells = [line[k * width : (k + 1) * width] for k in range(in_line)]
        rest = line[in_line * width :].strip()
        # Numbers are set flush right, so a line that is shorter than its columns has lost the end of its last number.
        if (
            rest
            or len(line) < in_line * width
            or any(set(cell.strip()) - _ALLOWED for cell in cells)
            or not all(cell.strip() for cell in cells)
        ):
            for cell in cells:
                number(cell, file, first_line + index, "a sample")
            if not rest:
                raise RecordError(
                    f"{file} line {first_line + index}: {len(line)} characters where {in_line} columns of {width} belong; the line is "
                    "cut: get the file again"
                )
            raise RecordError(
                f"{file} line {first_line + index}: {rest!r} after the last of {in_line} columns of {width} characters; "
                "the columns have moved: get the file again"
            )
        words += cells
    try:
        return np.array(words, dtype=np.float64)
    except ValueError:
        for index, word in enumerate(words):
            number(word, file, first_line + index // per_line, "a sample")
        raise


def fixed_integers(
    lines: Sequence[str], file: str, first_line: int, *, width: int, per_line: int, count: int
) -> NDArray[np.int64]:
    """Whole numbers in columns of fixed width (FORTRAN ``10I8``); see :func:`fixed_columns`.

    Raises
    ------
    RecordError
        Also if a number is not whole or has more than nine digits.
    """
    values = fixed_columns(lines, file, first_line, width=width, per_line=per_line, count=count)
    wrong = np.flatnonzero((np.abs(values) >= 1e9) | (values != np.round(values)))
    if wrong.size:
        line = first_line + int(wrong[0]) // per_line
        raise RecordError(f"{file} line {line}: {values[wrong[0]]:g} where a whole number belongs; get the file again")
    return values.astype(np.int64)
