"""Write the metadata of a study's results as a research crate (RO-Crate 1.1): files, inputs, software and licences.

The metadata contain no time of writing and no random ids, so equal results give equal files.
"""

import hashlib
import json
from collections.abc import Iterable, Sequence
from fnmatch import fnmatch
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from overturning.errors import ResultError
from overturning.files import folders_of_shipped_files_in_wheel_and_checkout, read_yaml_mapping, write_text
from overturning.study.cube import COMPLETE_STUDY_FILE_NAME
from overturning.study.load import study_settings_with_file_names_for_absolute_paths
from overturning.study.schema import Study

if TYPE_CHECKING:
    from rocrate.rocrate import ROCrate

METADATA_FILE_NAME: Final = "ro-crate-metadata.json"

_EXTRA_JSON_LD_TERMS: Final = {"sha256": "http://schema.org/sha256"}
"""Terms that the JSON-LD context of version 1.1 does not define."""

_FOLDER_NAMES_AND_DESCRIPTIONS: Final = {
    "motion": ("Motions", "Ground motion of each record: accelerations north, east and up, as computed with."),
    "figures": ("Figures", "Figures of the report, and further ones."),
    "survey": ("Surveys", "Observed stones, and the predictions of the study."),
    "fragility": (
        "Fragility",
        "Fragility curves of the study's population, as tables and for OpenQuake.",
    ),
    "explore-records": ("Cells of the explorer", "What explore.html reads of each record."),
}

_FILE_NAMES_AND_DESCRIPTIONS: Final = {
    COMPLETE_STUDY_FILE_NAME: (
        "Configuration",
        "The whole study with every key filled in: `overturning study check` reads it.",
    ),
    "cube.nc": ("Cube", "Outcome of every case of the study (CF-1.11)."),
    "cube.*.nc": ("Cube of the variant {part}", "Outcome of every case under this setting (CF-1.11)."),
    "intensity.nc": ("Intensity", "Intensity measures of each record along every azimuth (CF-1.11)."),
    "members.csv": ("Members", "What each member of the ensemble adds to a case."),
    "convergence.json": ("Convergence", "A part of the study computed again with finer steps and stiffer springs."),
    "findings.json": ("Findings", "Every number of the report, with interval, unit and number of earthquakes."),
    "report.html": ("Report", "What the study found, as one self-contained page."),
    "report.pdf": ("Report on paper", "What the study found."),
    "explore.html": ("Explorer", "What is known of each cell of the cube, to look around in."),
    "motion/*/*.nc": ("Motion {stem} of the variant {folder}", "Acceleration of the ground through its soil."),
    "motion/*.nc": ("Motion {stem}", "Acceleration of the ground, after processing and before."),
    "figures/polar/*": ("Falls under {stem}", "Where blocks fall, by azimuth or orientation, and slenderness."),
    "figures/blocks/*": ("Falls under {stem}, every block", "Where blocks of every height and friction fall."),
    "figures/intensity/*": ("Intensity of {stem}", "Peak acceleration and velocity by azimuth."),
    "figures/maps/*": ("Map {stem}", "Stations by earthquake: epicentre, fault, and mean axis of the falls."),
    "figures/illustrative/*": ("Case {stem}", "Of a case to watch, chosen by rule."),
    "figures/survey/*": ("Survey {stem}", "Observed and predicted stones."),
    "figures/rose.*": ("Rose", "Azimuths of the falls of all records."),
    "figures/axes.*": ("Axes", "Alignment of falls with the fault normal, by earthquake."),
    "figures/plane.*": ("Plane", "Falls over peak acceleration and velocity."),
    "figures/follow.*": ("What falls follow", "Falls relative to peaks, pulse, fault normal and epicentre."),
    "figures/earthquakes.*": ("Roses by earthquake", "Azimuths of the falls of each earthquake."),
}
"""Name and description of files by path pattern; other files are named by their path."""

_MEDIA_TYPE_BY_SUFFIX: Final = {
    ".csv": "text/csv",
    ".html": "text/html",
    ".js": "text/javascript",
    ".json": "application/json",
    ".nc": "application/x-netcdf",
    ".pdf": "application/pdf",
    ".png": "image/png",
    ".svg": "image/svg+xml",
    ".txt": "text/plain",
    ".xml": "application/xml",
    ".yaml": "application/yaml",
}


def write_complete_study_file_and_ro_crate_metadata(
    study: Study, results_folder: Path, produced_files_and_folders: Sequence[Path]
) -> None:
    """Write the study and the metadata file of a research data package (RO-Crate) into the results folder.

    Parameters
    ----------
    study : Study
        The study, as it was run.
    results_folder : Path
        Folder with the results of the study.
    produced_files_and_folders : sequence of Path
        Files and folders of results to describe, the cube among them, all in that folder.

    Raises
    ------
    ResultError
        If a produced file is missing, or the cube cannot be read.
    """
    import yaml
    from rocrate.rocrate import ROCrate

    text = yaml.safe_dump(
        study_settings_with_file_names_for_absolute_paths(study), allow_unicode=True, sort_keys=False, width=120
    )
    write_text(results_folder / COMPLETE_STUDY_FILE_NAME, text)
    cube = _record_metadata_and_package_versions_of_cube(results_folder / "cube.nc")
    program = _citation_metadata_of_program()
    crate = ROCrate(version="1.1")
    crate.metadata.extra_terms = _EXTRA_JSON_LD_TERMS
    root = crate.root_dataset
    root["name"] = study.title or study.name
    root["description"] = f"{study.question} Results of the study {study.name} by overturning: {program['abstract']}"
    root["datePublished"] = str(study.crate.date or program["date-released"])
    root["license"] = _get_or_add_licence_entity(crate, study.crate.licence or _UNSTATED_LICENCE_TEXT)
    if study.crate.authors:
        named = enumerate(study.crate.authors, 1)
        root["author"] = _unwrap_list_of_single_value(
            _add_crate_entity(crate, f"#author-{number}", "Person", name=name) for number, name in named
        )
    records = _add_record_entities_by_id(crate, cube["records"])
    files = _add_file_and_folder_entities(crate, results_folder, produced_files_and_folders, records)
    versions = {
        name: _add_crate_entity(
            crate, f"#{name}", "SoftwareApplication", name=name, version=version, softwareVersion=version
        )
        for name, version in cube["versions"].items()
    }
    overturning = versions.pop("overturning")
    overturning["license"] = _get_or_add_licence_entity(crate, f"https://spdx.org/licenses/{program['license']}")
    overturning["softwareRequirements"] = _unwrap_list_of_single_value(versions.values())
    configuration = files.pop(COMPLETE_STUDY_FILE_NAME)
    root["mentions"] = _add_crate_entity(
        crate,
        "#run",
        "CreateAction",
        name=f"Run of the study {study.name}",
        instrument=overturning,
        object=_unwrap_list_of_single_value([configuration, *records.values()]),
        result=_unwrap_list_of_single_value(files.values()),
    )
    written = json.dumps(crate.metadata.generate(), indent=1, ensure_ascii=False, sort_keys=True)
    write_text(results_folder / METADATA_FILE_NAME, written + "\n")


_UNSTATED_LICENCE_TEXT: Final = (
    "Not stated by those who made it (key crate.licence of a study). Records are on terms of their own."
)


def _record_metadata_and_package_versions_of_cube(cube_path: Path) -> dict[str, Any]:
    """Return sources, hashes, licences and names of the records of a results cube, and package versions."""
    import netCDF4

    try:
        with netCDF4.Dataset(cube_path) as cube:
            rows, versions = json.loads(cube.record_sources), json.loads(cube.versions)
            named = zip(rows, cube["station"][:], cube["event"][:], strict=True)
            return {"records": [row | {"where": (where, when)} for row, where, when in named], "versions": versions}
    except (OSError, AttributeError, IndexError, ValueError) as problem:
        raise ResultError(f"{cube_path}: cannot be read ({problem}); run the study again") from None


def _citation_metadata_of_program() -> dict[str, Any]:
    """Read the citation metadata (CITATION.cff) of this version of the program."""
    files = (root / "CITATION.cff" for root in folders_of_shipped_files_in_wheel_and_checkout())
    return read_yaml_mapping(
        next(file for file in files if file.is_file()), "citation", "citation-file-format.github.io"
    )


def _unwrap_list_of_single_value(metadata_values: Iterable[Any]) -> Any:
    """Return values as a list, or the only value without a list, as RO-Crate metadata require."""
    listed = list(metadata_values)
    return listed[0] if len(listed) == 1 else listed


def _add_crate_entity(crate: "ROCrate", entity_id: str, entity_type: str, **properties: Any) -> Any:
    """Add an entity, such as a person or licence, to the RO-Crate; properties without a value are left out."""
    from rocrate.model.contextentity import ContextEntity

    stated = {name: value for name, value in properties.items() if value not in ("", [])}
    return crate.add(ContextEntity(crate, entity_id, properties={"@type": entity_type, **stated}))


def _get_or_add_licence_entity(crate: "ROCrate", licence_url_or_text: str) -> Any:
    """Return the RO-Crate entity of a licence; its identifier is the licence's URL, or a hash of its text."""
    key = (
        licence_url_or_text
        if licence_url_or_text.startswith("http")
        else f"#licence-{hashlib.sha256(licence_url_or_text.encode()).hexdigest()[:8]}"
    )
    name = key.rpartition("/")[2] if key is licence_url_or_text else licence_url_or_text
    return crate.get(key) or _add_crate_entity(
        crate, key, "CreativeWork", name=name, description=f"Terms of use: {licence_url_or_text}"
    )


def _add_record_entities_by_id(
    crate: "ROCrate", record_source_dictionaries: Sequence[dict[str, Any]]
) -> dict[str, Any]:
    """Add the input records to the RO-Crate; return their entities by record id.

    Many records must not be redistributed, so the crate has only the hash of each.
    """
    return {
        row["id"]: _add_crate_entity(
            crate,
            f"#record-{row['id']}",
            "CreativeWork",
            name=f"Record {row['id']}",
            description=", ".join(filter(None, row["where"])) or "Ground motion",
            identifier=row["source"],
            sha256=row["sha256"],
            license=_get_or_add_licence_entity(crate, row["licence"]) if row["licence"] else "",
        )
        for row in record_source_dictionaries
    }


def _add_file_and_folder_entities(
    crate: "ROCrate",
    results_folder: Path,
    produced_files_and_folders: Sequence[Path],
    record_entities_by_id: dict[str, Any],
) -> dict[str, Any]:
    """Add result files and the folders that group them to the RO-Crate; return the file entities by path."""
    paths = [below for path in produced_files_and_folders for below in (path.rglob("*") if path.is_dir() else [path])]
    names = {
        path.relative_to(results_folder).as_posix(): path for path in paths if path.name[0] != "." and not path.is_dir()
    }
    names[COMPLETE_STUDY_FILE_NAME] = results_folder / COMPLETE_STUDY_FILE_NAME
    files = {name: _add_file_entity(crate, name, names[name], record_entities_by_id) for name in sorted(names)}
    for folder in dict.fromkeys(name.partition("/")[0] for name in files if "/" in name):
        name, description = _FOLDER_NAMES_AND_DESCRIPTIONS.get(folder, (folder, "Further results."))
        about = {"name": name, "description": description}
        within = _unwrap_list_of_single_value(file for path, file in files.items() if path.startswith(f"{folder}/"))
        crate.add_dataset(dest_path=f"{folder}/", properties=about | {"hasPart": within})
    return files


def _add_file_entity(
    crate: "ROCrate", path_in_crate: str, file_path: Path, record_entities_by_id: dict[str, Any]
) -> Any:
    """Add a file with its size and hash to the RO-Crate; a motion file also with record and licence."""
    stem, part = file_path.stem, file_path.name.removeprefix("cube.").removesuffix(".nc")
    said = {"part": part, "stem": stem, "folder": file_path.parent.name}
    name, description = next(
        (both for pattern, both in _FILE_NAMES_AND_DESCRIPTIONS.items() if fnmatch(path_in_crate, pattern)),
        (path_in_crate, ""),
    )
    about: dict[str, Any] = {
        "name": name.format(**said),
        "encodingFormat": _MEDIA_TYPE_BY_SUFFIX.get(file_path.suffix, ""),
    }
    try:
        with file_path.open("rb") as opened:
            about |= {"sha256": hashlib.file_digest(opened, "sha256").hexdigest()}
        about |= {"contentSize": str(file_path.stat().st_size)}
    except FileNotFoundError:
        raise ResultError(f"{file_path}: no such file; run the study again, which makes it") from None
    if description:
        about["description"] = description
    if path_in_crate.startswith("motion/") and stem in record_entities_by_id:
        about["isBasedOn"] = record_entities_by_id[stem]
        if "license" in record_entities_by_id[stem]:
            about["license"] = record_entities_by_id[stem]["license"]
    return crate.add_file(dest_path=path_in_crate, properties={key: value for key, value in about.items() if value})
