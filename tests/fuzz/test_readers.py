"""Randomly corrupted input is read or refused in a few lines, within 10 s and 1 GB."""

import itertools
import random
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import strategies as st

from overturning.model.mesh import read_scan
from overturning.model.scene import load_scene
from overturning.records.catalogue import read_record_table
from overturning.records.declared_properties import DeclaredFileProperties
from overturning.records.read import read_record_without_processing
from overturning.study.load import load_study
from overturning.study.preflight import check_record_files, check_study_size
from overturning.surveys.stones import read_stones
from tests.fuzz.spoiling import edited, fuzz, met, spoilt, wrong_tree
from tests.model.solids import box
from tests.records.malformed_corpus import COUNTS, VALID_FILES
from tests.records.seed_writers import write_inventory, write_mseed, write_sac

pytestmark = pytest.mark.long

ROOT = Path(__file__).parents[2]
BOMB = "a: &a [x,x,x,x,x,x,x,x,x]\n" + "".join(
    f"{name}: &{name} [{','.join([f'*{last}'] * 9)}]\n" for last, name in itertools.pairwise("abcdefghij")
)
DEEP = "[" * 5000 + "]" * 5000


def test_records_as_text(folder: Path) -> None:
    def read(case: tuple[str, bytes]) -> None:
        form, content = case
        paths = [folder / name for name in VALID_FILES[form][0]]
        for path, text in zip(paths, VALID_FILES[form][0].values(), strict=True):
            path.write_bytes(content if path == paths[0] else text.encode())
        met(lambda: read_record_without_processing(paths, DeclaredFileProperties(unit="gal")))

    forms = [
        st.tuples(st.just(form), spoilt(next(iter(texts.values())).encode()))
        for form, (texts, _) in VALID_FILES.items()
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
        met(
            lambda: read_record_without_processing(
                [path] if form == "zip" else [path, other], DeclaredFileProperties(unit="gal")
            )
        )

    fuzz(spoilt(whole), read)


def whole_table(path: Path) -> None:
    for name in read_record_table(path):
        assert Path("results", name).resolve().parent == Path("results").resolve(), "a name that leads out"


def whole_study(path: Path) -> None:
    study = load_study(path)
    for name in (study.name, *(f"cube.{variant}.nc" for variant in study.variants)):
        assert Path("results", name).resolve().parent == Path("results").resolve(), "a name that leads out"
    check_study_size(study, "mine.yaml")
    check_record_files(study, "mine.yaml")


BOMBS_OF_STUDIES = ("name: {DEEP}", "{whole}\nfriction: *a", "{BOMB}{whole_j}")
BOMBS_OF_SCENES = ("elements: {DEEP}", "{BOMB}name: *j\nelements: [*j, *j]\n")


@pytest.mark.parametrize(
    ("name", "read", "bombs"),
    [
        ("config/records.tsv", whole_table, ()),
        ("surveys/example-ruin.csv", read_stones, ()),
        ("config/near-fault.yaml", whole_study, BOMBS_OF_STUDIES),
        ("config/in-space.yaml", whole_study, BOMBS_OF_STUDIES),
        ("config/scenes/three-tier.yaml", load_scene, BOMBS_OF_SCENES),
    ],
)
def test_files_that_users_write(folder: Path, name: str, read: Callable[[Path], object], bombs: Sequence[str]) -> None:
    whole = (ROOT / name).read_bytes()
    path = folder / f"mine{Path(name).suffix}"

    def put(content: bytes) -> None:
        path.write_bytes(content)
        met(lambda: read(path))

    if bombs:
        text = whole.decode()
        words = {"BOMB": BOMB, "DEEP": DEEP, "whole": text, "whole_j": text.replace("name:", "name: *j #")}
        for bomb in (BOMB, *(bomb.format(**words) for bomb in bombs)):
            put(bomb.encode())
    fuzz(wrong_tree(yaml.safe_load(whole)) | spoilt(whole) if bombs else spoilt(whole), put)


_BOX = box((0.4, 0.6, 1.0))
_TRIANGLES = "".join("f {} {} {}\n".format(*one) for one in _BOX.triangles + 1)
_LINES = "".join("v {} {} {}\n".format(*one) for one in _BOX.vertices)
_PLY = (
    "ply\nformat {}\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 12\nproperty list uchar int vertex_indices\nend_header\n"
)
MESHES = {
    "obj": (_LINES + _TRIANGLES).encode(),
    "ply": (
        _PLY.format("ascii 1.0")
        + _LINES.replace("v ", "")
        + "".join("3 {} {} {}\n".format(*one) for one in _BOX.triangles)
    ).encode(),
    "binary.ply": _PLY.format("binary_little_endian 1.0").encode()
    + _BOX.vertices.astype("<f4").tobytes()
    + b"".join(b"\3" + one.astype("<i4").tobytes() for one in _BOX.triangles),
    "stl": bytes(80)
    + (12).to_bytes(4, "little")
    + b"".join(bytes(12) + one.astype("<f4").tobytes() + b"\0\0" for one in _BOX.corners),
}


def test_meshes(folder: Path) -> None:
    pytest.importorskip("trimesh")

    def read(case: tuple[str, bytes]) -> None:
        path = folder / f"body.{case[0]}"
        path.write_bytes(case[1])
        met(lambda: read_scan(path))

    huge = _PLY.replace("vertex 8", "vertex 99999999999").format("binary_little_endian 1.0")
    read(("ply", huge.encode()))
    read(("stl", bytes(80) + b"\xff\xff\xff\xff"))
    fuzz(st.one_of([st.tuples(st.just(form), spoilt(whole)) for form, whole in MESHES.items()]), read)


def test_random_corruption_changes_files() -> None:
    """Random corruption changes a file nearly always, and leaves the rest of it intact."""
    content, throw = bytes(range(256)) * 8, random.Random(3)
    edits = [(throw.choice("rdipxnt"), throw.random(), throw.randrange(400), b"12345678") for _ in range(200)]
    assert sum(edited(content, [edit]) != content for edit in edits) > 190
