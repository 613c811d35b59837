"""Randomly corrupted input is read or refused in a few lines, within 10 s and 1 GB."""

import itertools
import random
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import strategies as st

from overturning.model.mesh import read_scanned_stone
from overturning.model.scene import load_scene
from overturning.records.catalogue import read_record_table
from overturning.records.declared_properties import DeclaredFileProperties
from overturning.records.read import read_record_without_processing
from overturning.study.load import load_study
from overturning.study.preflight import estimate_and_check_study_size, find_record_rows_and_files
from overturning.surveys.counted_stones import read_counted_stones
from tests.fuzz.spoiling import (
    apply_edits,
    assert_read_or_plain_error,
    run_on_random_examples_for_share_of_fuzzing_time,
    strategy_for_corrupted_bytes,
    strategy_for_yaml_files_with_changed_settings,
)
from tests.model.solids import box
from tests.records.malformed_corpus import SAMPLES_IN_COUNTS, VALID_FILES_AND_HEADER_LINE_COUNTS
from tests.records.seed_writers import write_mseed, write_sac, write_stationxml_of_channels

pytestmark = pytest.mark.long

ROOT = Path(__file__).parents[2]
ALIAS_BOMB = "a: &a [x,x,x,x,x,x,x,x,x]\n" + "".join(
    f"{name}: &{name} [{','.join([f'*{last}'] * 9)}]\n" for last, name in itertools.pairwise("abcdefghij")
)
DEEP_NESTING = "[" * 5000 + "]" * 5000


def test_a_corrupted_text_record_is_read_or_refused_plainly(isolated_folder: Path) -> None:
    def read_corrupted_text_record(case: tuple[str, bytes]) -> None:
        form, content = case
        paths = [isolated_folder / name for name in VALID_FILES_AND_HEADER_LINE_COUNTS[form][0]]
        for path, text in zip(paths, VALID_FILES_AND_HEADER_LINE_COUNTS[form][0].values(), strict=True):
            path.write_bytes(content if path == paths[0] else text.encode())
        assert_read_or_plain_error(lambda: read_record_without_processing(paths, DeclaredFileProperties(unit="gal")))

    forms = [
        st.tuples(st.just(form), strategy_for_corrupted_bytes(next(iter(texts.values())).encode()))
        for form, (texts, _) in VALID_FILES_AND_HEADER_LINE_COUNTS.items()
    ]
    run_on_random_examples_for_share_of_fuzzing_time(st.one_of(forms), read_corrupted_text_record)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("form", ["mseed", "sac", "xml", "zip"])
def test_a_corrupted_binary_record_is_read_or_refused_plainly(isolated_folder: Path, form: str) -> None:
    if form == "sac":
        first = write_sac(isolated_folder / "a.sac", SAMPLES_IN_COUNTS[0] / 1e3, "HNN", 0.0, 90.0)
        other = write_sac(isolated_folder / "b.sac", SAMPLES_IN_COUNTS[1] / 1e3, "HNE", 90.0, 90.0)
    elif form == "zip":
        first = other = ROOT / "src" / "overturning" / "records" / "examples" / "20161113_110259_WTMC_20.V2A.zip"
    else:
        first = write_mseed(
            isolated_folder / "x.mseed",
            {"HNN": np.repeat(SAMPLES_IN_COUNTS[0], 10), "HNE": np.repeat(SAMPLES_IN_COUNTS[1], 10)},
        )
        other = write_stationxml_of_channels(isolated_folder / "s.xml", {"HNN": (0.0, 0.0), "HNE": (90.0, 0.0)})
        first, other = (first, other) if form == "mseed" else (other, first)
    path, whole = isolated_folder / f"spoilt{first.suffix}", first.read_bytes()

    def read_corrupted_binary_record(content: bytes) -> None:
        path.write_bytes(content)
        assert_read_or_plain_error(
            lambda: read_record_without_processing(
                [path] if form == "zip" else [path, other], DeclaredFileProperties(unit="gal")
            )
        )

    run_on_random_examples_for_share_of_fuzzing_time(strategy_for_corrupted_bytes(whole), read_corrupted_binary_record)


def read_record_table_and_check_ids_as_file_names(path: Path) -> None:
    """Read a record table and check that no record id, used as a file name, leads out of the results folder."""
    for name in read_record_table(path):
        assert Path("results", name).resolve().parent == Path("results").resolve(), "a name that leads out"


def read_study_and_check_names_as_file_names(path: Path) -> None:
    """Read and check a study, and check that no name in it, used as a file name, leads out of the results folder."""
    study = load_study(path)
    for name in (study.name, *(f"cube.{variant}.nc" for variant in study.variants)):
        assert Path("results", name).resolve().parent == Path("results").resolve(), "a name that leads out"
    estimate_and_check_study_size(study, "mine.yaml")
    find_record_rows_and_files(study, "mine.yaml")


STUDY_FILE_TEMPLATES_WITH_YAML_BOMBS = ("name: {DEEP}", "{whole}\nfriction: *a", "{BOMB}{whole_j}")
SCENE_FILE_TEMPLATES_WITH_YAML_BOMBS = ("elements: {DEEP}", "{BOMB}name: *j\nelements: [*j, *j]\n")


@pytest.mark.parametrize(
    ("name", "read", "bombs"),
    [
        ("config/records.tsv", read_record_table_and_check_ids_as_file_names, ()),
        ("surveys/example-ruin.csv", read_counted_stones, ()),
        ("config/near-fault.yaml", read_study_and_check_names_as_file_names, STUDY_FILE_TEMPLATES_WITH_YAML_BOMBS),
        ("config/in-space.yaml", read_study_and_check_names_as_file_names, STUDY_FILE_TEMPLATES_WITH_YAML_BOMBS),
        ("config/scenes/three-tier.yaml", load_scene, SCENE_FILE_TEMPLATES_WITH_YAML_BOMBS),
    ],
)
def test_corrupted_files_of_the_user_are_read_or_refused_plainly(
    isolated_folder: Path, name: str, read: Callable[[Path], object], bombs: Sequence[str]
) -> None:
    whole = (ROOT / name).read_bytes()
    path = isolated_folder / f"mine{Path(name).suffix}"

    def write_and_read_corrupted_file(content: bytes) -> None:
        path.write_bytes(content)
        assert_read_or_plain_error(lambda: read(path))

    if bombs:
        text = whole.decode()
        words = {
            "BOMB": ALIAS_BOMB,
            "DEEP": DEEP_NESTING,
            "whole": text,
            "whole_j": text.replace("name:", "name: *j #"),
        }
        for bomb in (ALIAS_BOMB, *(bomb.format(**words) for bomb in bombs)):
            write_and_read_corrupted_file(bomb.encode())
    run_on_random_examples_for_share_of_fuzzing_time(
        strategy_for_yaml_files_with_changed_settings(yaml.safe_load(whole)) | strategy_for_corrupted_bytes(whole)
        if bombs
        else strategy_for_corrupted_bytes(whole),
        write_and_read_corrupted_file,
    )


_BOX = box((0.4, 0.6, 1.0))
_OBJ_TRIANGLE_LINES = "".join("f {} {} {}\n".format(*one) for one in _BOX.triangles + 1)
_OBJ_VERTEX_LINES = "".join("v {} {} {}\n".format(*one) for one in _BOX.vertices)
_PLY_HEADER_TEMPLATE = (
    "ply\nformat {}\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 12\nproperty list uchar int vertex_indices\nend_header\n"
)
MESH_FILE_CONTENTS = {
    "obj": (_OBJ_VERTEX_LINES + _OBJ_TRIANGLE_LINES).encode(),
    "ply": (
        _PLY_HEADER_TEMPLATE.format("ascii 1.0")
        + _OBJ_VERTEX_LINES.replace("v ", "")
        + "".join("3 {} {} {}\n".format(*one) for one in _BOX.triangles)
    ).encode(),
    "binary.ply": _PLY_HEADER_TEMPLATE.format("binary_little_endian 1.0").encode()
    + _BOX.vertices.astype("<f4").tobytes()
    + b"".join(b"\3" + one.astype("<i4").tobytes() for one in _BOX.triangles),
    "stl": bytes(80)
    + (12).to_bytes(4, "little")
    + b"".join(bytes(12) + one.astype("<f4").tobytes() + b"\0\0" for one in _BOX.triangle_corners),
}


def test_a_corrupted_mesh_is_read_or_refused_plainly(isolated_folder: Path) -> None:
    pytest.importorskip("trimesh")

    def read_corrupted_mesh(case: tuple[str, bytes]) -> None:
        path = isolated_folder / f"body.{case[0]}"
        path.write_bytes(case[1])
        assert_read_or_plain_error(lambda: read_scanned_stone(path))

    huge = _PLY_HEADER_TEMPLATE.replace("vertex 8", "vertex 99999999999").format("binary_little_endian 1.0")
    read_corrupted_mesh(("ply", huge.encode()))
    read_corrupted_mesh(("stl", bytes(80) + b"\xff\xff\xff\xff"))
    run_on_random_examples_for_share_of_fuzzing_time(
        st.one_of(
            [
                st.tuples(st.just(form), strategy_for_corrupted_bytes(whole))
                for form, whole in MESH_FILE_CONTENTS.items()
            ]
        ),
        read_corrupted_mesh,
    )


def test_random_corruption_nearly_always_changes_a_file() -> None:
    """More than 190 of 200 random edits change the content of a file."""
    content, throw = bytes(range(256)) * 8, random.Random(3)
    edits = [(throw.choice("rdipxnt"), throw.random(), throw.randrange(400), b"12345678") for _ in range(200)]
    assert sum(apply_edits(content, [edit]) != content for edit in edits) > 190
