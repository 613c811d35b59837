"""Matplotlib's SVG made small: the same picture in about a tenth of the lines and the same bytes each time.

Matplotlib writes a group for each tick, six decimals for each coordinate and a line for each of a path's points. Here
groups that say nothing go, coordinates keep a hundredth of a point, the ticks of an axis become one path, a picture
inside keeps as many colours as it has, and every element stands on a line of its own.
"""

import base64
import io
import re
from itertools import cycle, groupby
from typing import Final
from xml.etree import ElementTree as ET

import numpy as np

_SVG: Final = "{http://www.w3.org/2000/svg}"
_HREF: Final = "{http://www.w3.org/1999/xlink}href"
_NUMBER: Final = re.compile(r"-?\d+\.\d+(?:e-?\d+)?")
_FAMILY: Final = re.compile(r" ?font-family: [^;]*,[^;]*;")


def compact(text: str) -> str:
    """The same drawing, an SVG file as Matplotlib writes it, in fewer lines."""
    ET.register_namespace("", _SVG.strip("{}"))
    ET.register_namespace("xlink", _HREF[1:].partition("}")[0])
    root = ET.fromstring(text)
    for metadata in root.findall(f"{_SVG}metadata"):
        root.remove(metadata)
    referred = set(re.findall(r"(?:xlink:href=\"|url\()#(\w+)", text))
    for element in root.iter():
        if element.get("id") not in referred:
            element.attrib.pop("id", None)
        _shorten(element)
    _flatten(root)
    markers = {name: element for element in root.iter(f"{_SVG}path") if (name := element.get("id"))}
    for element in list(root.iter()):
        groups = groupby(element, lambda child: _kind(child, markers))
        element[:] = [one for kind, group in groups for one in _joined(list(group), markers.get(kind[0]))]
    _share_family(root)
    _break_lines(root)
    return f'<?xml version="1.0" encoding="utf-8"?>\n{ET.tostring(root, encoding="unicode")}\n'


def _round(text: str) -> str:
    return _NUMBER.sub(lambda match: f"{float(match[0]):.2f}".rstrip("0").rstrip("."), text)


def _shorten(element: ET.Element) -> None:
    """Coordinates to a hundredth of a point, a path on one line, a picture with the colours that it has."""
    for name, value in element.items():
        if name == "d":
            element.set(name, _round(" ".join(value.split())))
        elif name in ("x", "y", "points") or (name == "transform" and "scale" not in value and "matrix" not in value):
            element.set(name, _round(value))
        elif name == _HREF and value.startswith("data:image/png"):
            element.set(name, f"data:image/png;base64,{_palette(value.partition(',')[2])}")


def _palette(data: str) -> str:
    """A PNG, base64, with a palette where it has few enough colours: not one of its pixels changes."""
    from PIL import Image

    with Image.open(io.BytesIO(base64.b64decode(data))) as picture:
        kept = picture.convert("RGBA")
    # A colour as one number, its bytes in their order: a fraction of the time of comparing four of them. Most pixels
    # have the colour of the one before.
    pixels = np.asarray(kept).view(">u4").ravel().astype(np.uint32)
    begins = np.flatnonzero(np.diff(pixels, prepend=~pixels[:1]))
    numbers, index = np.unique(pixels[begins], return_inverse=True)
    if len(numbers) <= 256:
        colours = numbers.astype(">u4")
        index = np.repeat(index.astype(np.uint8), np.diff(begins, append=pixels.size))
        kept = Image.frombytes("P", kept.size, index.tobytes())
        kept.putpalette(colours.tobytes(), "RGBA")
    written = io.BytesIO()
    kept.save(written, format="PNG")  # `optimize` takes ten times as long for a twentieth of the size
    return base64.b64encode(written.getvalue()).decode("ascii")


def _flatten(parent: ET.Element) -> None:
    """Put the content of groups that say nothing themselves in their place."""
    for child in parent:
        _flatten(child)
    parent[:] = [
        one for child in parent for one in ([child] if child.tag != f"{_SVG}g" or child.attrib else list(child))
    ]


def _kind(child: ET.Element, markers: dict[str, ET.Element]) -> tuple[str, ...]:
    """The same for marks that can be one path, open lines of one form as ticks are, another for every other element."""
    marker = child.get(_HREF, "")[1:]
    if child.tag != f"{_SVG}use" or set(markers[marker].get("d", "").upper()) & set("CZ"):
        return (str(id(child)),)
    return marker, child.get("style", ""), child.get("clip-path", "")


def _joined(run: list[ET.Element], marker: ET.Element | None) -> list[ET.Element]:
    """Neighbouring marks of one kind as one path."""
    if len(run) == 1 or marker is None:
        return run
    first = run[0]
    first.set("d", " ".join(_moved(marker.get("d", ""), mark) for mark in run))
    first.tag = marker.tag
    first.set("style", f"{first.get('style', '')}; {marker.get('style', '')}".strip("; "))
    for name in (_HREF, "x", "y"):
        del first.attrib[name]
    return [first]


def _moved(path: str, mark: ET.Element) -> str:
    """A path of M and L at the place of a mark."""
    shift = cycle((float(mark.get("x", 0)), float(mark.get("y", 0))))
    words = path.split()
    return " ".join(word if word.isalpha() else _round(f"{float(word) + next(shift):.6f}") for word in words)


def _share_family(root: ET.Element) -> None:
    """Say once, in a group around all, which fonts a text may take, and not in each text."""
    styled = [element for element in root.iter() if _FAMILY.search(element.get("style", ""))]
    families = {family for element in styled for family in _FAMILY.findall(element.get("style", ""))}
    if len(families) != 1:
        return
    (family,) = families
    for element in styled:
        element.set("style", element.get("style", "").replace(family, "").strip())
    group = ET.Element(f"{_SVG}g", {"style": family.strip().rstrip(";")})
    group[:], root[:] = list(root), [group]


def _break_lines(element: ET.Element, inside_text: bool = False) -> None:
    """An element a line; a text with all its parts on one."""
    inside_text = inside_text or element.tag in (f"{_SVG}text", f"{_SVG}style")
    if len(element) or not inside_text:
        element.text = "\n" if len(element) and not inside_text else None
    for child in element:
        child.tail = None if inside_text else "\n"
        _break_lines(child, inside_text)
