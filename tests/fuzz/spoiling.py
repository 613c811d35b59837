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

from overturning.errors import MAX_MESSAGE_LINE_CHARACTERS, MAX_MESSAGE_LINES, OverturningError
from tests.bounds import limited_time_and_memory

TOTAL_FUZZING_SECONDS = float(os.environ.get("FUZZ_SECONDS", "10"))
COUNT_OF_TESTS_SHARING_FUZZING_TIME = 12

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


def strategy_for_corrupted_bytes(content: bytes) -> st.SearchStrategy[bytes]:
    """Return a strategy for a content in which up to six parts are changed, added, repeated or deleted."""
    pieces = st.one_of(
        st.binary(max_size=8),
        st.sampled_from([*EVIL_NUMBERS, *EVIL_WORDS]).map(lambda word: word.encode("utf-8", "surrogatepass")),
    )
    edit = st.tuples(st.sampled_from("rdipxnwt"), st.floats(0, 1), st.integers(0, 400), pieces)
    return st.lists(edit, max_size=6).map(lambda edits: apply_edits(content, edits))


def apply_edits(content: bytes, edits: list[tuple[str, float, int, bytes]]) -> bytes:
    """Return a content after edits: the kind, position (share of all bytes), byte count and new bytes of each."""
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


def paths_of_nested_values(data: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the path of every value in nested mappings and lists."""
    if path:
        yield path
    for key, value in data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ():
        yield from paths_of_nested_values(value, (*path, key))


STRATEGY_FOR_ANY_VALUE = st.recursive(
    st.one_of(
        st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=20), st.dates(),
        st.sampled_from(EVIL_WORDS), st.sampled_from([10**30, 1e308, -0.0, 5e-324]),
    ),
    lambda more: st.lists(more, max_size=4) | st.dictionaries(st.text(max_size=8), more, max_size=4),
    max_leaves=12,
)  # fmt: skip


def strategy_for_yaml_files_with_changed_settings(data: dict[str, Any]) -> st.SearchStrategy[bytes]:
    """Return a strategy for YAML files with up to three values replaced, deleted or repeated under another name."""
    change = st.tuples(
        st.sampled_from(list(paths_of_nested_values(data))), st.sampled_from("vvvdk"), STRATEGY_FOR_ANY_VALUE
    )

    def file_with_changed_values(changes: list[tuple[tuple[Any, ...], str, Any]]) -> bytes:
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

    return st.lists(change, min_size=1, max_size=3).map(file_with_changed_values)


def assert_read_or_plain_error(read: Callable[[], Any]) -> None:
    """Call a reader within limits of time and memory; an error of this package must have a short, plain message."""
    try:
        with limited_time_and_memory():
            read()
    except OverturningError as problem:
        message = str(problem)
        assert message
        assert message.count("\n") <= MAX_MESSAGE_LINES, f"{message.count(chr(10))} lines: {message[:300]}"
        assert max(map(len, message.split("\n"))) < MAX_MESSAGE_LINE_CHARACTERS + 10, message[:300]
        assert not set(message) & {"\0", "\x1b", "\r", "\u202e"}, repr(message[:300])


def run_on_random_examples_for_share_of_fuzzing_time(
    strategy: st.SearchStrategy[Any], test: Callable[[Any], None], examples: int = 25
) -> None:
    """Run a test on random examples, with a new seed each round, until its share of the fuzzing time is used up."""
    end = (
        sum(os.times()[:4]) + TOTAL_FUZZING_SECONDS / COUNT_OF_TESTS_SHARING_FUZZING_TIME
    )  # of processor time, that of children too
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


class _CollectorOfTagsAndAttributesThatRunOrLoadCode(HTMLParser):
    """Parser that collects the tags and attributes by which a page runs or loads code."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag in ("script", "iframe", "object", "embed", "base", "meta", "link"):
            self.found.append(tag)
        for name, value in attrs:
            if name.startswith("on") or (value or "").strip().lower().startswith(("javascript:", "data:text")):
                self.found.append(f"{tag} {name}")


def tags_and_attributes_that_run_or_load_code(page: str) -> list[str]:
    """Return each tag, or tag and attribute, by which a page runs or loads code or content."""
    parser = _CollectorOfTagsAndAttributesThatRunOrLoadCode()
    parser.feed(page)
    return parser.found
