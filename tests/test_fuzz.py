"""Input from strangers, spoilt at random: read or refused in a few lines, within 10 s and 1 GB, and nothing else.

`make fuzz` gives each reader a share of ten minutes, `make test` a share of some seconds: FUZZ_SECONDS.
"""

import io
import itertools
import json
import os
import random
from collections.abc import Callable, Iterator
from contextlib import redirect_stderr, redirect_stdout, suppress
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
import yaml
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st
from malformed_corpus import COUNTS, WHOLE
from seed_writers import write_inventory, write_mseed, write_sac

from overturning.cli import main
from overturning.dem.scene import load_scene
from overturning.dem.solid.mesh import read_mesh
from overturning.errors import LONGEST_LINE, MOST_LINES, OverturningError
from overturning.figures.explore import write_explorer
from overturning.files import seal
from overturning.records.catalogue import read_catalogue
from overturning.records.options import ReadOptions
from overturning.records.read import read_path
from overturning.records.record import Record
from overturning.report import blocks
from overturning.report.html import render_html
from overturning.study.check import check_files, check_size
from overturning.study.cube import open_cube, processing_of, sources_of_records, study_of
from overturning.study.gather import gather
from overturning.study.load import load_study
from overturning.study.sweep import sweep_record
from overturning.surveys.stones import read_survey
from tests.bounds import bounded

ROOT = Path(__file__).parents[1]
SECONDS = float(os.environ.get("FUZZ_SECONDS", "10"))
READERS = 12

EVIL_NUMBERS = [
    *("nan", "inf", "-inf", "1e308", "-1e308", "1e-320", "1e999", "-0", "9" * 400, "0x1F", "٣", "1_0", "--1", ""),
    *("0", "-1", "4294967296", "9223372036854775807", "9223372036854775808", "1e9", "99999999999"),
]
EVIL_WORDS = [
    *("../../../etc/passwd", "/etc/passwd", "..", ".", "~", "C:\\x", "a/b", "\0", "\n", "\r", "\x1b[2J", "\ud7ff", "‮"),
    *("</script><script>window.hurt = 1</script>", "<img src=x onerror=hurt()>", "javascript:hurt()", "'\"&{{7*7}}"),
    *("x" * 100_000, "true", "null", "yes", "[]", "{}", "&a [*a]", "!!python/object/apply:os.system [id]", "%s%n{0}"),
]
BOMB = "a: &a [x,x,x,x,x,x,x,x,x]\n" + "".join(
    f"{name}: &{name} [{','.join([f'*{last}'] * 9)}]\n" for last, name in itertools.pairwise("abcdefghij")
)
DEEP = "[" * 5000 + "]" * 5000


def spoilt(content: bytes) -> st.SearchStrategy[bytes]:
    """Whole content with a few bytes, runs, numbers or words changed, moved, multiplied or lost."""
    pieces = st.one_of(
        st.binary(max_size=8),
        st.sampled_from([*EVIL_NUMBERS, *EVIL_WORDS]).map(lambda word: word.encode("utf-8", "surrogatepass")),
    )
    edit = st.tuples(st.sampled_from("rdipxnwt"), st.floats(0, 1), st.integers(0, 400), pieces)
    return st.lists(edit, max_size=6).map(lambda edits: _edited(content, edits))


def _edited(content: bytes, edits: list[tuple[str, float, int, bytes]]) -> bytes:
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
    """Every place in nested mappings and lists."""
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
    """Read something within the bounds; an error of ours must be brief and plain."""
    try:
        with bounded():
            read()
    except OverturningError as problem:
        message = str(problem)
        assert message
        assert message.count("\n") <= MOST_LINES, f"{message.count(chr(10))} lines: {message[:300]}"
        assert max(map(len, message.split("\n"))) < LONGEST_LINE + 10, message[:300]
        assert not set(message) & {"\0", "\x1b", "\r", "\u202e"}, repr(message[:300])


def fuzz(strategy: st.SearchStrategy[Any], test: Callable[[Any], None]) -> None:
    """Put examples to a test, in rounds of their own seeds, for a reader's share of the time."""
    end = sum(os.times()[:4]) + SECONDS / READERS  # of processor time, that of children too
    for turn in itertools.count():
        run = given(strategy)(lambda example: test(example))
        run = settings(
            max_examples=25,
            deadline=None,
            database=None,
            suppress_health_check=list(HealthCheck),
            phases=[Phase.generate, Phase.shrink],
        )(run)
        seed(turn)(run)()
        if sum(os.times()[:4]) > end:
            return


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """An empty folder to work in, beside which nothing may appear."""
    inner = tmp_path / "inner"
    inner.mkdir()
    monkeypatch.chdir(inner)
    yield inner
    assert [path.name for path in tmp_path.iterdir()] == ["inner"]


def test_records_as_text(folder: Path) -> None:
    def read(case: tuple[str, bytes]) -> None:
        form, content = case
        paths = [folder / name for name in WHOLE[form][0]]
        for path, text in zip(paths, WHOLE[form][0].values(), strict=True):
            path.write_bytes(content if path == paths[0] else text.encode())
        met(lambda: read_path(paths, options=ReadOptions(unit="gal")))

    forms = [
        st.tuples(st.just(form), spoilt(next(iter(texts.values())).encode())) for form, (texts, _) in WHOLE.items()
    ]
    fuzz(st.one_of(forms), read)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("form", ["mseed", "sac", "xml", "zip"])
def test_records_in_binary(folder: Path, form: str) -> None:
    if form == "sac":
        first = write_sac(folder / "a.sac", COUNTS[0] / 1e3, "HNN", 0.0, 90.0)
        other = write_sac(folder / "b.sac", COUNTS[1] / 1e3, "HNE", 90.0, 90.0)
    elif form == "zip":
        first = other = ROOT / "src" / "overturning" / "records" / "examples" / "20161113_110259_WTMC_20.V2A.zip"
    else:
        first = write_mseed(folder / "x.mseed", {"HNN": np.repeat(COUNTS[0], 10), "HNE": np.repeat(COUNTS[1], 10)})
        other = write_inventory(folder / "s.xml", {"HNN": (0.0, 0.0), "HNE": (90.0, 0.0)})
        first, other = (first, other) if form == "mseed" else (other, first)
    path, whole = folder / f"spoilt{first.suffix}", first.read_bytes()

    def read(content: bytes) -> None:
        path.write_bytes(content)
        met(lambda: read_path([path] if form == "zip" else [path, other], options=ReadOptions(unit="gal")))

    fuzz(spoilt(whole), read)


def test_record_tables(folder: Path) -> None:
    path = folder / "records.tsv"

    def read(content: bytes) -> None:
        path.write_bytes(content)

        def all_of_it() -> None:
            for name in read_catalogue(path):
                assert Path("results", name).resolve().parent == folder / "results", "a name that leads out"

        met(all_of_it)

    fuzz(spoilt((ROOT / "config" / "records.tsv").read_bytes()), read)


@pytest.mark.parametrize("name", ["near-fault", "in-space"])
def test_studies(folder: Path, name: str) -> None:
    path, whole = folder / "mine.yaml", (ROOT / "config" / f"{name}.yaml").read_bytes()

    def read(content: bytes) -> None:
        path.write_bytes(content)

        def all_of_it() -> None:
            study = load_study(path)
            assert Path("results", study.name).resolve().parent == folder / "results", "a name that leads out"
            for variant in study.variants:
                assert Path("results", f"cube.{variant}.nc").resolve().parent == folder / "results"
            check_size(study, "mine.yaml")
            check_files(study, "mine.yaml")

        met(all_of_it)

    for harm in (
        BOMB,
        f"name: {DEEP}",
        f"{whole.decode()}\nfriction: *a",
        BOMB + whole.decode().replace("name:", "name: *j #"),
    ):
        read(harm.encode())
    fuzz(wrong_tree(yaml.safe_load(whole)) | spoilt(whole), read)


def test_scenes(folder: Path) -> None:
    path, whole = folder / "mine.yaml", (ROOT / "config" / "scenes" / "three-tier.yaml").read_bytes()

    def read(content: bytes) -> None:
        path.write_bytes(content)
        met(lambda: load_scene(path))

    for harm in (BOMB, f"elements: {DEEP}", BOMB + "name: *j\nelements: [*j, *j]\n"):
        read(harm.encode())
    fuzz(wrong_tree(yaml.safe_load(whole)) | spoilt(whole), read)


def test_surveys(folder: Path) -> None:
    path = folder / "stones.csv"

    def read(content: bytes) -> None:
        path.write_bytes(content)
        met(lambda: read_survey(path))

    fuzz(spoilt((ROOT / "surveys" / "example-ruin.csv").read_bytes()), read)


CORNERS = np.array(list(itertools.product((-0.2, 0.2), (-0.3, 0.3), (0.0, 1.0))))
_LINES = "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS)
_PLY = "ply\nformat {}\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
MESHES = {
    "obj": _LINES.encode(),
    "ply": (_PLY.format("ascii 1.0") + _LINES.replace("v ", "")).encode(),
    "binary.ply": _PLY.format("binary_little_endian 1.0").encode() + CORNERS.astype("<f4").tobytes(),
    "stl": bytes(80)
    + (8).to_bytes(4, "little")
    + b"".join(
        np.array([[0, 0, 0], *np.roll(CORNERS, turn, axis=0)[:3]], dtype="<f4").tobytes() + b"\0\0" for turn in range(8)
    ),
}


def test_meshes(folder: Path) -> None:
    def read(case: tuple[str, bytes]) -> None:
        path = folder / f"body.{case[0]}"
        path.write_bytes(case[1])
        met(lambda: read_mesh(path))

    huge = _PLY.replace("vertex 8", "vertex 99999999999").format("binary_little_endian 1.0")
    read(("ply", huge.encode()))
    read(("stl", bytes(80) + b"\xff\xff\xff\xff"))
    fuzz(st.one_of([st.tuples(st.just(form), spoilt(whole)) for form, whole in MESHES.items()]), read)


@pytest.fixture(scope="module")
def cube(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A small cube, as it is written."""
    from overturning.study.load import check_study

    folder = tmp_path_factory.mktemp("cube")
    study = check_study(
        {
            "name": "small", "records": {"use": ["a"]}, "azimuth": {"step": 90}, "b_over_h": [0.3], "friction": [0.5],
            "ensemble": {"members": 0}, "verification": "none",
        },
        "test",
    )  # fmt: skip
    wave = 6.0 * np.sin(np.arange(300) / 12.0)
    record = Record("a", wave, 0.1 * wave, None, 0.01, station="S", event="E", sha256="0" * 64)
    sweep_record(study, record, folder / "a.nc")
    gather(study, [record], [folder / "a.nc"], folder / "cube.nc")
    return (folder / "cube.nc").read_bytes()


def look_at(path: Path) -> None:
    """Look around in a cube that comes from elsewhere, by the command; its page has two scripts, its data and its own."""
    assert write_explorer  # imported, so that a child need not
    page = path.with_suffix(".html")
    page.unlink(missing_ok=True)
    try:
        with redirect_stderr(io.StringIO()) as said, redirect_stdout(io.StringIO()):
            main(["explore", str(path), "--output", str(page)])
        code: object = 0
    except SystemExit as end:
        code = end.code
    assert not code or (code == 1 and said.getvalue().startswith("error: ")), said.getvalue()
    if page.is_file():
        assert scripts_of(page.read_text(encoding="utf-8")) == ["meta", "meta", "script", "script"], (
            "a script in the page"
        )
    with suppress(RuntimeError), open_cube(path) as opened:
        study_of(opened), sources_of_records(opened), processing_of(opened)


def in_a_child(read: Callable[[], Any]) -> str:
    """Read in a process of its own, which a damaged file may bring down; what became of it."""
    receiver, sender = os.pipe()
    child = os.fork()
    if not child:
        try:
            met(read)
        except BaseException as other:
            os.write(sender, f"{type(other).__name__}: {other}"[:2000].encode("utf-8", "replace"))
        os._exit(0)
    os.close(sender)
    with os.fdopen(receiver, "rb") as pipe:
        said = pipe.read().decode(errors="replace")
    _, status = os.waitpid(child, 0)
    return said or (f"signal {os.WTERMSIG(status)}" if os.WIFSIGNALED(status) else "")


def test_cubes(folder: Path, cube: bytes) -> None:
    path = folder / "cube.nc"
    bare = cube[:-75]

    def read(case: tuple[bool, bytes]) -> None:
        path.write_bytes(case[1])
        if case[0]:
            seal(path)
        said = in_a_child(lambda: look_at(path))
        # The library of HDF5 itself may fall over a file that was made to; a process of ours falls with it.
        assert said in ("", "signal 11", "signal 6"), said

    read((False, cube))
    read((False, bare))
    fuzz(st.tuples(st.booleans(), spoilt(bare)), read)


def test_cubes_with_other_content(folder: Path, cube: bytes) -> None:
    (folder / "whole.nc").write_bytes(cube)
    path = folder / "cube.nc"
    with xr.open_dataset(folder / "whole.nc", decode_timedelta=False) as opened:
        whole = opened.load()
    study = json.loads(whole.attrs["study"])

    def read(case: tuple[str, str, Any]) -> None:
        what, name, value = case
        changed = whole.copy()
        if what == "variable":
            changed = changed.drop_vars(name)
        elif what == "dimension":
            changed = changed.isel({name: slice(0, 0)})
        elif what == "attribute":
            changed.attrs.pop(name)
        else:
            changed.attrs[name] = value
        changed.drop_encoding().to_netcdf(path, engine="netcdf4")
        said = in_a_child(lambda: look_at(path))
        assert said == "", f"{case[:2]}: {said}"

    def studied(value: bytes) -> str:
        return json.dumps(yaml.safe_load(value), default=str)

    words = st.sampled_from(["", "{", "[]", "null", '"x"', "3", "[1]", '{"a": []}', "</script><script>hurt()</script>"])
    cases = st.one_of(
        st.tuples(st.just("variable"), st.sampled_from(sorted(map(str, whole.variables))), st.none()),
        st.tuples(st.just("dimension"), st.sampled_from(sorted(map(str, whole.dims))), st.none()),
        st.tuples(st.just("attribute"), st.sampled_from(sorted(whole.attrs)), st.none()),
        st.tuples(st.just("value"), st.sampled_from(sorted(whole.attrs)), words),
        st.tuples(st.just("value"), st.just("study"), wrong_tree(study).map(studied)),
    )
    fuzz(cases, read)


class _Scripts(HTMLParser):
    """The scripts of a page, and what else would run."""

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


def test_names_in_the_report(folder: Path) -> None:
    name = (
        st.text(max_size=40)
        | st.sampled_from(EVIL_WORDS[:-1])
        | st.tuples(st.text(max_size=5), st.sampled_from(EVIL_WORDS)).map("".join)
    )

    def page_of(names: list[str]) -> str:
        one, two, three = names
        section = blocks.Section(
            one,
            (
                blocks.Paragraph(two),
                blocks.Bullets((one, three)),
                blocks.Code(two),
                blocks.Table((one, two), ((three, one),)),
                blocks.Link(one, two),
                blocks.Disclosure(three, (blocks.Note(one), blocks.Caution(two))),
            ),
        )
        return render_html(blocks.Report(three, one, (section,)))

    usual = scripts_of(page_of(["a", "b", "c"]))

    def read(names: list[str]) -> None:
        assert scripts_of(page_of(names)) == usual

    fuzz(st.lists(name, min_size=3, max_size=3), read)


def test_dice_are_not_loaded() -> None:
    """What spoils a file changes it nearly always, and not the rest of it."""
    content, throw = bytes(range(256)) * 8, random.Random(3)
    edits = [(throw.choice("rdipxnt"), throw.random(), throw.randrange(400), b"12345678") for _ in range(200)]
    assert sum(_edited(content, [edit]) != content for edit in edits) > 190
