"""Inputs of the command one: a scene or a gravestone, and a record or a pulse."""

from pathlib import Path
from typing import TYPE_CHECKING, Literal

from overturning.commands.declared import (
    DEFAULT_RECORD_FOLDER,
    DEFAULT_RECORD_TABLE_PATH,
    MotionOptionsOfCommandOne,
    PlanarOptionsOfCommandOne,
    RecordFileOptions,
)

if TYPE_CHECKING:
    from overturning.model.scene import Scene
    from overturning.records.record import Record


def load_scene_or_create_gravestone(
    planar_model_options: PlanarOptionsOfCommandOne, damping_ratio: float | None
) -> "Scene":
    """Return the named scene; by default, a gravestone with the density and contact that the options state."""
    from overturning.errors import ArgumentError
    from overturning.model.contact import Contact
    from overturning.model.scene import gravestone, load_scene
    from overturning.units import DEFAULT_STONE_DENSITY_KG_M3

    if planar_model_options.scene is None:
        stiffness: Literal["auto"] | float = (
            "auto" if planar_model_options.stiffness is None else planar_model_options.stiffness
        )
        contact = Contact(stiffness=stiffness, damping_ratio=damping_ratio, damping=planar_model_options.damping)
        return gravestone(
            contact,
            DEFAULT_STONE_DENSITY_KG_M3 if planar_model_options.density is None else planar_model_options.density,
        )
    if any(
        value is not None
        for value in (
            planar_model_options.density,
            planar_model_options.stiffness,
            damping_ratio,
            planar_model_options.damping,
        )
    ):
        raise ArgumentError("--scene: the scene defines density, stiffness and damping; set them in the scene file")
    return load_scene(planar_model_options.scene)


def read_and_process_record_or_create_pulse(
    motion_options: MotionOptionsOfCommandOne, file_options: RecordFileOptions
) -> "Record":
    """Read a record from its table entry or file and apply the default processing, or create a pulse."""
    from overturning.errors import ArgumentError, ConfigError, closest_name_hint
    from overturning.files import path_in_working_folder_or_package
    from overturning.records.catalogue import read_record_table
    from overturning.records.processing import process_record
    from overturning.records.pulses import PULSE_SHAPES, parse_pulse, record_of_pulse
    from overturning.records.read import read_record, read_record_without_processing
    from overturning.records.store import round_samples_to_stored_decimals

    name, table = motion_options.record_id_file_or_pulse, motion_options.record_table_path or DEFAULT_RECORD_TABLE_PATH
    is_pulse = bool(name.split()) and name.split()[0] in PULSE_SHAPES
    is_table_or_folder_given = (motion_options.record_table_path, motion_options.record_folder) != (None, None)
    if (is_pulse or Path(name).is_file()) and is_table_or_folder_given:
        what = "a pulse" if is_pulse else "a file"
        raise ArgumentError(f"--table, --folder: --record {name!r} is {what}, not in a record table; leave them out")
    if Path(name).is_file():
        return round_samples_to_stored_decimals(
            process_record(read_record_without_processing(Path(name), file_options.to_declared_file_properties()), None)
        )
    if file_options != RecordFileOptions():
        raise ArgumentError(f"--record {name!r}: no such file; options that describe a file, such as --unit, need one")
    if is_pulse:
        return round_samples_to_stored_decimals(record_of_pulse(parse_pulse(name)))
    if " " not in name and (Path(name).suffix or len(Path(name).parts) > 1):
        raise ConfigError(f"--record {name}: no such file; give a file, or the id of a record in {table}")
    entries = read_record_table(path_in_working_folder_or_package(table))
    if name not in entries:
        raise ConfigError(
            f"{table}: no record {name!r}, nor a file of that name or a pulse; {closest_name_hint(name, entries)}"
        )
    return round_samples_to_stored_decimals(
        process_record(read_record(entries[name], motion_options.record_folder or DEFAULT_RECORD_FOLDER), None)
    )
