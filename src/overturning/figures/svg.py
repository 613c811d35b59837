"""Matplotlib's SVG made smaller: coordinates to a hundredth of a point, no metadata, no unused names.

Matplotlib writes six decimals for each coordinate and a name for each group. Rounding saves a fifth to a quarter of a
file.
"""

import re
from typing import Final

_NUMBER: Final = re.compile(r"-?\d+\.\d+(?:e-?\d+)?")
_COORDINATES: Final = re.compile(r' (?:d|x|y|points|transform)="[^"]*"')
_METADATA: Final = re.compile(r"\s*<metadata>.*?</metadata>", flags=re.DOTALL)
_NAME: Final = re.compile(r' id="([^"]*)"')
_NAMED: Final = re.compile(r'(?:href="|url\()#([^")]*)')


def compact(text: str) -> str:
    """Return an SVG file of Matplotlib with fewer characters and the same picture to a hundredth of a point."""
    used = set(_NAMED.findall(text))
    text = _NAME.sub(lambda one: one[0] if one[1] in used else "", _METADATA.sub("", text))
    return _COORDINATES.sub(_rounded, text)


def _rounded(found: "re.Match[str]") -> str:
    """Return an attribute with its coordinates rounded; factors and matrices of a transformation stay exact."""
    words = " " + " ".join(found[0].split()).replace(' "', '"')
    if "scale" in words or "matrix" in words:
        return words
    return _NUMBER.sub(lambda one: f"{float(one[0]):.2f}".rstrip("0").rstrip("."), words)
