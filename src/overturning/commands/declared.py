"""Groups of options that several subcommands share."""

import inspect
import re
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Annotated, Any, Final, get_type_hints

import typer

from overturning.records.declared_properties import DeclaredFileProperties, FilePropertiesInTableRow

DEFAULT_RECORD_TABLE_PATH: Final = Path("config/records.tsv")
"""Default record table."""

DEFAULT_RECORD_FOLDER: Final = Path("resources/records")
"""Default folder of the record files."""


def expand_dataclass_parameters_to_options(command: Callable[..., None]) -> Callable[..., None]:
    """Decorate a command: each field of its dataclass parameters becomes a command-line option.

    Typer makes one option for each parameter in the signature of a function. The returned function has the fields of
    the dataclasses as parameters; it builds the dataclasses and passes them to the command.
    """
    hints = get_type_hints(command, include_extras=True)
    groups: dict[str, Any] = {name: kind for name, kind in hints.items() if is_dataclass(kind)}
    options: list[inspect.Parameter] = []
    for name, parameter in inspect.signature(command).parameters.items():
        group = groups.get(name)
        types = get_type_hints(group, include_extras=True) if group else hints
        several = inspect.signature(group).parameters.values() if group else [parameter]
        options += [one.replace(kind=one.KEYWORD_ONLY, annotation=types[one.name]) for one in several]

    def build_dataclasses_and_call_command(**given: Any) -> None:
        """Build the dataclasses from the options, and call the command with them."""
        made = {name: kind(**{one.name: given.pop(one.name) for one in fields(kind)}) for name, kind in groups.items()}
        command(**made, **given)

    build_dataclasses_and_call_command.__name__, build_dataclasses_and_call_command.__doc__ = (
        command.__name__,
        command.__doc__,
    )
    build_dataclasses_and_call_command.__annotations__ = {option.name: option.annotation for option in options}
    build_dataclasses_and_call_command.__signature__ = inspect.Signature(options)  # type: ignore[attr-defined]
    return build_dataclasses_and_call_command


def _option_name_without_unit_of_field(field_name: str) -> str:
    """Return the command-line option for a field of `RecordFileOptions`, such as --azimuths for ``azimuths_deg``."""
    return f"--{field_name.removesuffix('_deg').removesuffix('_s').replace('_', '-')}"


def _option_for_record_file_property(property_name: str, option_flag: str = "") -> Any:
    """Return the command-line option for a property of record files, with the help text of this property."""
    return typer.Option(
        option_flag or _option_name_without_unit_of_field(property_name),
        help=FilePropertiesInTableRow.model_fields[property_name].description,
        show_default=False,
    )


@dataclass(frozen=True)
class RecordFileOptions:
    """Command-line options that state properties of a record file which the file itself does not contain."""

    azimuths_deg: Annotated[str, _option_for_record_file_property("azimuths_deg")] = ""
    columns: Annotated[str, _option_for_record_file_property("columns")] = ""
    format: Annotated[str, _option_for_record_file_property("format")] = ""
    sampling_interval_s: Annotated[float | None, _option_for_record_file_property("sampling_interval_s")] = None
    processed: Annotated[bool | None, _option_for_record_file_property("processed", "--processed/--raw")] = None
    sensor: Annotated[str, _option_for_record_file_property("sensor")] = ""
    trust_data: Annotated[bool, _option_for_record_file_property("trust_data")] = False
    unit: Annotated[str, _option_for_record_file_property("unit")] = ""
    vertical_sense: Annotated[str, _option_for_record_file_property("vertical_sense")] = ""

    def to_declared_file_properties(self) -> DeclaredFileProperties:
        """Convert the options to declared file properties; an ArgumentError for an invalid value names the option."""
        from overturning.errors import ArgumentError
        from overturning.records.formats.table import find_format_by_name_or_none_if_auto

        given: dict[str, Any] = {name: value for name, value in vars(self).items() if value not in ("", None)}
        try:
            find_format_by_name_or_none_if_auto(self.format or "auto")
            return DeclaredFileProperties(**given)
        except ArgumentError as problem:
            raise ArgumentError(
                re.sub(
                    r"(?m)^(\s*)(\w+)", lambda key: key[1] + _option_name_without_unit_of_field(key[2]), str(problem)
                )
            ) from None


@dataclass(frozen=True)
class MotionOptionsOfCommandOne:
    """Options of `overturning one` that select the input motion, and scale its amplitude."""

    record_id_file_or_pulse: Annotated[
        str,
        typer.Option(
            "--record", help="id in the record table, a record file, or a pulse: 'sine amplitude_gal=800 period_s=1'"
        ),
    ]
    amplitude_factor: Annotated[float, typer.Option("--amplitude", help="factor on the motion")] = 1.0
    applies_vertical_motion: Annotated[
        bool, typer.Option("--vertical/--no-vertical", help="apply the vertical motion, if the record has one")
    ] = True
    record_table_path: Annotated[
        Path | None, typer.Option("--table", help=f"record table (default {DEFAULT_RECORD_TABLE_PATH})")
    ] = None
    record_folder: Annotated[
        Path | None,
        typer.Option("--folder", help=f"folder of the record files of the table (default {DEFAULT_RECORD_FOLDER})"),
    ] = None


@dataclass(frozen=True)
class StoneOptionsOfCommandOne:
    """Options of `overturning one` for size, friction and contact damping ratio of the stone."""

    b_over_h: Annotated[float | None, typer.Option(help="slenderness B/H (default 0.4, or the scene's)")] = None
    height: Annotated[float | None, typer.Option(help="height H, m (default 0.6, or the scene's)")] = None
    friction: Annotated[float | None, typer.Option(help="friction coefficient µ (default 1, or the scene's)")] = None
    damping_ratio: Annotated[float | None, typer.Option(help="damping ratio of the contact (default 3)")] = None

    @property
    def friction_coefficient_or_1(self) -> float:
        """Coefficient of friction from the option --friction; 1 if the option is not given."""
        return 1.0 if self.friction is None else self.friction


@dataclass(frozen=True)
class PlanarOptionsOfCommandOne:
    """Options of `overturning one` for 2-D simulations: azimuths, scene, density, stiffness and damping."""

    azimuth: Annotated[
        list[float] | None, typer.Option(help="degrees clockwise from north; may be given several times")
    ] = None
    scene: Annotated[
        str | None,
        typer.Option(help="scene in config/scenes, or a scene file; height and B/H are those of its reference element"),
    ] = None
    density: Annotated[float | None, typer.Option(help="density, kg/m³ (default 2650)")] = None
    damping: Annotated[float | None, typer.Option(help="dashpot per corner instead of the ratio, N·s/m")] = None
    stiffness: Annotated[float | None, typer.Option(help="normal stiffness per corner, N/m (default: automatic)")] = (
        None
    )


@dataclass(frozen=True)
class BodyOptionsOfCommandOne:
    """Options of `overturning one` for a 3-D body: its shape, and the azimuths of its front face."""

    body: Annotated[bool, typer.Option("--body", help="simulate a 3-D body instead of a 2-D scene")] = False
    orientation: Annotated[
        list[float] | None,
        typer.Option(
            help="3-D body, or scene in 3-D: azimuth of its front face; may be given several times (default 0)"
        ),
    ] = None
    plan: Annotated[
        str | None, typer.Option(help="3-D body: rectangle, circle, or number of sides (default rectangle)")
    ] = None
    mesh: Annotated[
        Path | None, typer.Option(help="3-D body: scan of a stone (closed mesh; OBJ, PLY, STL), also without --body")
    ] = None
    mesh_unit: Annotated[
        str | None, typer.Option(help="unit of the mesh: m, cm or mm (default m, if the size is plausible)")
    ] = None
    relief: Annotated[
        float | None,
        typer.Option(help="3-D body from a mesh: height of the points of its base that bear, m (default 0.002)"),
    ] = None
    aspect: Annotated[
        float, typer.Option(help="3-D body with a rectangular plan: D/B, ratio of its width across to its width along")
    ] = 1.0


@dataclass(frozen=True)
class FilmAndFigureOptionsOfCommandOne:
    """Options of `overturning one` for the film and figure files that it writes, and their language."""

    film_path: Annotated[
        Path | None,
        typer.Option(
            "--animate",
            help="film to write: .html (a self-contained page, optionally with contact forces), .gif or .mp4",
        ),
    ] = None
    response_figure_path: Annotated[
        Path | None,
        typer.Option(
            "--response",
            help="figure of rotation, slip and uplift against time (3-D body: of its axis): .svg, .png or .pdf",
        ),
    ] = None
    language: Annotated[str | None, typer.Option(help="language of film and figure: en (default) or ja")] = None
