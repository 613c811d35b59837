"""Research crate of a folder of results: files, hashes and conformance to the profile."""

import importlib.util
import json
from hashlib import sha256
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

from overturning.errors import ResultError
from overturning.study.crate import METADATA_FILE_NAME, write_complete_study_file_and_ro_crate_metadata
from overturning.study.load import load_study
from overturning.study.schema import Study
from tests.expect import skip_test_unless_skipping_is_forbidden
from tests.study.small_study import simulate_study_cube, sine_cycle_record, small_study

PUBLICATION_METADATA = {"licence": "https://spdx.org/licenses/CC-BY-4.0", "date": "2026-01-31", "authors": ["A. Mason"]}


def study_without_ensemble(**keys: Any) -> Study:
    """Return the small study without an ensemble, which only adds variables to the cube."""
    return small_study(**keys, ensemble={"members": 0})


def write_and_read_crate(settings: Study, folder: Path) -> dict[str, dict[str, Any]]:
    """Write a research crate of a cube, its motions and a figure; return the entities of the crate by id."""
    cube = simulate_study_cube(settings, [sine_cycle_record("a"), sine_cycle_record("b", east_over_north=-0.8)], folder)
    figures = folder / "figures" / "polar"
    figures.mkdir(parents=True)
    (figures / "a.svg").write_text("<svg/>", encoding="utf-8")
    write_complete_study_file_and_ro_crate_metadata(settings, folder, [cube, folder / "motion", figures / "a.svg"])
    return {one["@id"]: one for one in json.loads((folder / METADATA_FILE_NAME).read_text(encoding="utf-8"))["@graph"]}


@pytest.fixture(scope="module")
def result_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the results that the crate describes."""
    return tmp_path_factory.mktemp("crate")


@pytest.fixture(scope="module")
def crate_entities(result_folder: Path) -> dict[str, dict[str, Any]]:
    """Entities of the research crate of the small study by id."""
    return write_and_read_crate(
        study_without_ensemble(records={"use": ["a", "b"]}, crate=PUBLICATION_METADATA), result_folder
    )


def test_the_research_crate_lists_all_files_with_hashes_and_descriptions(
    crate_entities: dict[str, dict[str, Any]], result_folder: Path
) -> None:
    found = {name: one for name, one in crate_entities.items() if one["@type"] == "File"}
    assert found.keys() == {"cube.nc", "motion/a.nc", "motion/b.nc", "figures/polar/a.svg", "study.yaml"}
    for name, one in found.items():
        content = (result_folder / name).read_bytes()
        assert (one["sha256"], one["contentSize"]) == (sha256(content).hexdigest(), str(len(content))), name
        assert {"name", "description", "encodingFormat"} <= one.keys(), name
    assert {part["@id"] for part in crate_entities["./"]["hasPart"]} == found.keys() | {"motion/", "figures/"}


def test_crate_names_the_variant_of_a_motion_through_soil(tmp_path: Path) -> None:
    settings = study_without_ensemble(records={"use": ["a"]})
    cube, own = simulate_study_cube(settings, [sine_cycle_record("a")], tmp_path), tmp_path / "motion" / "a.nc"
    soft = tmp_path / "motion" / "soft" / "a.nc"
    soft.parent.mkdir()
    soft.write_bytes(own.read_bytes())
    write_complete_study_file_and_ro_crate_metadata(settings, tmp_path, [cube, tmp_path / "motion"])
    graph = json.loads((tmp_path / METADATA_FILE_NAME).read_text(encoding="utf-8"))["@graph"]
    named = {one["@id"]: one["name"] for one in graph if one["@id"].startswith("motion/")}
    assert named == {
        "motion/": "Motions",
        "motion/a.nc": "Motion a",
        "motion/soft/a.nc": "Motion a of the variant soft",
    }


def test_crate_states_source_hash_and_licence_of_records_and_links_motions(
    crate_entities: dict[str, dict[str, Any]],
) -> None:
    record = crate_entities["#record-b"]
    assert (record["identifier"], record["sha256"], record["description"]) == ("made", "0" * 64, "S, E")
    assert crate_entities[record["license"]["@id"]]["name"] == "none"
    assert crate_entities["motion/b.nc"]["isBasedOn"] == {"@id": "#record-b"}
    run = crate_entities["#run"]
    assert {one["@id"] for one in run["object"]} == {"study.yaml", "#record-a", "#record-b"}
    assert {"@id": "cube.nc"} in run["result"]
    program = crate_entities[run["instrument"]["@id"]]
    assert program["name"] == "overturning"
    assert {"@id": "#numba"} in program["softwareRequirements"]
    assert crate_entities["#numba"]["version"]


def test_licence_date_and_authors_of_the_crate_are_those_of_the_study(
    crate_entities: dict[str, dict[str, Any]],
) -> None:
    root = crate_entities["./"]
    assert root["license"] == {"@id": PUBLICATION_METADATA["licence"]}
    assert root["datePublished"] == PUBLICATION_METADATA["date"]
    assert [crate_entities[root["author"]["@id"]]["name"]] == PUBLICATION_METADATA["authors"]


def test_the_study_file_in_the_crate_is_the_complete_study(
    crate_entities: dict[str, dict[str, Any]], result_folder: Path
) -> None:
    assert load_study(result_folder / "study.yaml") == study_without_ensemble(
        records={"use": ["a", "b"]}, crate=PUBLICATION_METADATA
    )


def test_the_crate_is_reproducible_and_contains_no_local_path(
    crate_entities: dict[str, dict[str, Any]], result_folder: Path, tmp_path: Path
) -> None:
    plain = study_without_ensemble(records={"use": ["a", "b"]})
    assert write_and_read_crate(plain, tmp_path)["./"]["datePublished"] == "2026-11-21", (
        "of the version, in CITATION.cff"
    )
    write_and_read_crate(
        study_without_ensemble(records={"use": ["a", "b"]}, crate=PUBLICATION_METADATA), tmp_path / "again"
    )
    text = (result_folder / METADATA_FILE_NAME).read_bytes()
    assert (tmp_path / "again" / METADATA_FILE_NAME).read_bytes() == text
    assert str(result_folder).encode() not in text


def test_the_error_names_a_result_file_missing_for_the_crate(tmp_path: Path) -> None:
    cube = simulate_study_cube(study_without_ensemble(records={"use": ["a"]}), [sine_cycle_record("a")], tmp_path)
    with pytest.raises(ResultError, match=r"report\.html: no such file; run the study again"):
        write_complete_study_file_and_ro_crate_metadata(
            study_without_ensemble(records={"use": ["a"]}), tmp_path, [cube, tmp_path / "report.html"]
        )


@pytest.mark.long
def test_the_crate_passes_the_ro_crate_validator(
    crate_entities: dict[str, dict[str, Any]], result_folder: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The crate is valid RO-Crate 1.1 (roc-validator); its terms are looked up offline, in the package `rocrate`."""
    if importlib.util.find_spec("rocrate_validator") is None:
        skip_test_unless_skipping_is_forbidden("roc-validator is not installed (`make crate`)")
    from rocrate_validator import models, services
    from rocrate_validator.utils.http import HttpRequester

    words = json.loads((files("rocrate") / "data" / "ro-crate.jsonld").read_text(encoding="utf-8"))

    class StubResponse:
        status_code, headers, text = 200, {"Content-Type": "application/ld+json"}, json.dumps(words)

        def json(self) -> Any:
            return words

    monkeypatch.setattr(HttpRequester, "get", lambda *_, **__: StubResponse(), raising=False)
    settings = {"rocrate_uri": str(result_folder), "profile_identifier": "ro-crate-1.1", "no_cache": True}
    found = services.validate(models.ValidationSettings(**settings, requirement_severity="RECOMMENDED"))
    # Who publishes the crate, and for whom its authors work, is not known.
    said = [issue.message or "" for issue in found.get_issues()]
    assert [one for one in said if "publisher" not in one and "affiliation" not in one] == []
    (tmp_path / METADATA_FILE_NAME).write_text(
        (result_folder / METADATA_FILE_NAME).read_text(encoding="utf-8"), encoding="utf-8"
    )
    settings["rocrate_uri"] = str(tmp_path)
    assert not services.validate(models.ValidationSettings(**settings, requirement_severity="REQUIRED")).passed()
