"""Random corruption of input, and the limits within which it must be read or refused.

Each reader has a share of FUZZ_SECONDS of processor time: of ten minutes in `make fuzz`, of some seconds in `make
test-long`.
"""

import itertools
import json
import os
from collections.abc import Callable, Iterator
from html.parser import HTMLParser
from typing import Any

import yaml
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

from overturning.errors import LONGEST_LINE, MOST_LINES, OverturningError
from tests.bounds import bounded

SECONDS = float(os.environ.get("FUZZ_SECONDS", "10"))
READERS = 12

EVIL_NUMBERS = [
    *("nan", "inf", "-inf", "1e308", "-1e308", "1e-320", "1e999", "-0", "9" * 400, "0x1F", "٣", "1_0", "--1", ""),
    *("0", "-1", "4294967296", "9223372036854775807", "9223372036854775808", "1e9", "99999999999"),
]
EVIL_WORDS = [
    *("../../../etc/passwd", "/etc/passwd", "..", ".", "~", "C:\\x", "a/b"),
    *("\0", "\n", "\r", "\x1b[2J", "\ud7ff", "‮"),
    *("</script><script>window.hurt = 1</script>", "<img src=x onerror=hurt()>", "javascript:hurt()", "'\"&{{7*7}}"),
    *("x" * 100_000, "true", "null", "yes", "[]", "{}", "&a [*a]", "!!python/object/apply:os.system [id]", "%s%n{0}"),
]


def spoilt(content: bytes) -> st.SearchStrategy[bytes]:
    """Content with a few bytes, runs, numbers or words changed, moved, multiplied or deleted."""
    pieces = st.one_of(
        st.binary(max_size=8),
        st.sampled_from([*EVIL_NUMBERS, *EVIL_WORDS]).map(lambda word: word.encode("utf-8", "surrogatepass")),
    )
    edit = st.tuples(st.sampled_from("rdipxnwt"), st.floats(0, 1), st.integers(0, 400), pieces)
    return st.lists(edit, max_size=6).map(lambda edits: edited(content, edits))


def edited(content: bytes, edits: list[tuple[str, float, int, bytes]]) -> bytes:
    """Return the content after edits (kind, position as a share of the length, length, inserted bytes)."""
    data = bytearray(content)
    for what, where, length, piece in edits:
        at = int(where * len(data))
        match what:
            case "r":
                data[at : at + len(piece)] = piece
            case "d":
                del data[at : at + length]
            case "i":
                data[at:at] = piece
            case "p":
                data[at:at] = data[at : at + length] * 3
            case "x" if at < len(data):
                data[at] ^= 1 << (length % 8)
            case "n" | "w":
                # The number, or the word, that begins next.
                signs = b"0123456789.+-eE" if what == "n" else b"abcdefghijklmnopqrstuvwxyz_"
                begin = next((i for i in range(at, len(data)) if data[i] in signs), len(data))
                end = next((i for i in range(begin, len(data)) if data[i] not in signs), len(data))
                data[begin:end] = piece
            case "t":
                del data[at:]
    return bytes(data)


def leaves(data: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield every position in nested mappings and lists."""
    if path:
        yield path
    for key, value in data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ():
        yield from leaves(value, (*path, key))


ANYTHING = st.recursive(
    st.one_of(
        st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=20), st.dates(),
        st.sampled_from(EVIL_WORDS), st.sampled_from([10**30, 1e308, -0.0, 5e-324]),
    ),
    lambda more: st.lists(more, max_size=4) | st.dictionaries(st.text(max_size=8), more, max_size=4),
    max_leaves=12,
)  # fmt: skip


def wrong_tree(data: dict[str, Any]) -> st.SearchStrategy[bytes]:
    """A file of keys and values in which some have another value, are lost or doubled under another name."""
    change = st.tuples(st.sampled_from(list(leaves(data))), st.sampled_from("vvvdk"), ANYTHING)

    def changed(changes: list[tuple[tuple[Any, ...], str, Any]]) -> bytes:
        tree = json.loads(json.dumps(data))
        for path, what, value in changes:
            inner = tree
            try:
                for key in path[:-1]:
                    inner = inner[key]
                if what == "d":
                    del inner[path[-1]]
                else:
                    inner[path[-1] if what == "v" else str(value)[:40]] = value
            except (KeyError, IndexError, TypeError):
                continue  # an earlier change has taken it away
        return yaml.safe_dump(tree, allow_unicode=True).encode("utf-8", "surrogatepass")

    return st.lists(change, min_size=1, max_size=3).map(changed)


def met(read: Callable[[], Any]) -> None:
    """Read a file within the limits; an error of this package must be short and plain."""
    try:
        with bounded():
            read()
    except OverturningError as problem:
        message = str(problem)
        assert message
        assert message.count("\n") <= MOST_LINES, f"{message.count(chr(10))} lines: {message[:300]}"
        assert max(map(len, message.split("\n"))) < LONGEST_LINE + 10, message[:300]
        assert not set(message) & {"\0", "\x1b", "\r", "\u202e"}, repr(message[:300])


def fuzz(strategy: st.SearchStrategy[Any], test: Callable[[Any], None], examples: int = 25) -> None:
    """Run a test on random examples, in rounds with different seeds, for a reader's share of the time."""
    end = sum(os.times()[:4]) + SECONDS / READERS  # of processor time, that of children too
    for turn in itertools.count():
        run = given(strategy)(lambda example: test(example))
        run = settings(
            max_examples=examples,
            deadline=None,
            database=None,
            suppress_health_check=list(HealthCheck),
            phases=[Phase.generate, Phase.shrink],
        )(run)
        seed(turn)(run)()
        if sum(os.times()[:4]) > end:
            return


class _Scripts(HTMLParser):
    """Collects the scripts of a page, and other code that a browser would run."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag in ("script", "iframe", "object", "embed", "base", "meta", "link"):
            self.found.append(tag)
        for name, value in attrs:
            if name.startswith("on") or (value or "").strip().lower().startswith(("javascript:", "data:text")):
                self.found.append(f"{tag} {name}")


def scripts_of(page: str) -> list[str]:
    parser = _Scripts()
    parser.feed(page)
    return parser.found
