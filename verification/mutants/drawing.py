"""Every one-token mutant of a module, and a draw among those of the layers."""

import ast
import hashlib
import io
import tokenize
from collections import Counter
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Final, NamedTuple

from verification.tables import ROOT

LAYERS: Final = ("statistics", "records", "motion", "study", "model", "dem")
PACKAGE: Final = ROOT / "src" / "overturning"
_SWAPPED: Final = (
    *(("+", "-"), ("+=", "-="), ("*=", "/="), ("&", "|"), ("<", "<="), (">", ">="), ("==", "!=")),
    *(("and", "or"), ("True", "False"), ("min", "max"), ("any", "all"), ("minimum", "maximum")),
)
_REPLACED: Final = {one: other for pair in _SWAPPED for one, other in (pair, pair[::-1])} | {
    **dict(zip(("*", "/", "//", "%", "**"), "/*/**", strict=True)),
    "not": "",
}


class Mutant(NamedTuple):
    """One token, and what stands in its place.

    The line is known by its text, so that a change elsewhere in the file leaves the mutant what it is.
    """

    file: str  # from the package on
    text: str  # of the line, without blanks around it
    turn: int  # which of the lines of this text it is, from 0
    column: int  # where the token begins in `text`
    old: str
    new: str

    def line(self, lines: list[str]) -> int | None:
        """Its line among those of the file, from 0; None where it is not there any more."""
        same = [number for number, line in enumerate(lines) if line.strip() == self.text]
        return same[self.turn] if self.turn < len(same) else None

    def applied(self, text: str) -> str:
        """The text of the file with the token replaced."""
        lines = text.splitlines(keepends=True)
        number = self.line(lines)
        assert number is not None, f"{self.file} has changed"
        row = lines[number]
        begin = len(row) - len(row.lstrip()) + self.column
        lines[number] = row[:begin] + self.new + row[begin + len(self.old) :]
        return "".join(lines)


def _other_number(token: str) -> str:
    """Whole numbers one larger, others three tenths larger: beyond any tolerance that a test may have."""
    if token.isdecimal():
        return str(int(token) + 1)
    try:
        value = float(token)
    except ValueError:  # a complex or hexadecimal one
        return ""
    return repr(1.3 * value if value else 1.0)


def _annotations(text: str) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
    """Places of what says the type of something; it does nothing when the program runs."""
    for node in ast.walk(ast.parse(text)):
        for name in ("annotation", "returns"):
            part = getattr(node, name, None)
            if isinstance(part, ast.expr):
                yield (part.lineno, part.col_offset), (part.end_lineno or 0, part.end_col_offset or 0)


def mutants_of(path: Path) -> Iterator[Mutant]:
    """Every one-token mutant of a module; a few of them Python cannot compile."""
    text = path.read_text(encoding="utf-8")
    lines = text.splitlines()
    left_out = list(_annotations(text))
    seen: Counter[str] = Counter()
    turns = []
    for line in lines:
        turns.append(seen[line.strip()])
        seen[line.strip()] += 1
    name, before = path.relative_to(PACKAGE).as_posix(), ""
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        new = ""
        if token.type == tokenize.NUMBER:
            new = _other_number(token.string)
        elif token.type in (tokenize.OP, tokenize.NAME) and not (token.string in ("*", "**") and before in "(,["):
            new = _REPLACED.get(token.string, token.string)
        (row, column), before = token.start, token.string
        line = lines[row - 1] if row <= len(lines) else ""
        # Places of the syntax tree count bytes, those of tokens characters.
        if not line.isascii() or any(begin <= token.start < end for begin, end in left_out):
            continue
        if new == token.string or (not new and token.string != "not"):
            continue
        indent = len(line) - len(line.lstrip())
        yield Mutant(name, line.strip(), turns[row - 1], column - indent, token.string, new)


def _compiles(mutant: Mutant) -> bool:
    try:
        compile(mutant.applied((PACKAGE / mutant.file).read_text(encoding="utf-8")), mutant.file, "exec")
    except SyntaxError:
        return False
    return True


def draw(count: int, seed: int) -> list[Mutant]:
    """Mutants of the layers in turn, each of a layer equally likely; the first of a longer draw are a shorter one.

    In turn, since more than half of all tokens are those of the kernels. The order is that of a hash of seed and
    mutant: an edit of the sources leaves the draw what it was, but for the lines edited.
    """

    def lot(mutant: Mutant) -> bytes:
        return hashlib.sha256(repr((seed, *mutant)).encode()).digest()

    layers = []
    for layer in LAYERS:
        every = (mutant for path in sorted((PACKAGE / layer).rglob("*.py")) for mutant in mutants_of(path))
        layers.append(filter(_compiles, sorted(every, key=lot)))
    drawn = (mutant for turn in zip(*layers, strict=False) for mutant in turn)
    return list(islice(drawn, count))
