"""Groups of options that several subcommands share."""

import inspect
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, get_type_hints

import typer

if TYPE_CHECKING:
    from overturning.records.source import Declarations

TABLE: Final = Path("config/records.tsv")
"""Default record table."""

RESOURCES: Final = Path("resources/records")
"""Default folder of the record files."""


def spread_options(command: Callable[..., None]) -> Callable[..., None]:
    """Decorate a command so that each field of its dataclass parameters becomes an option.

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

    def run(**given: Any) -> None:
        made = {name: kind(**{one.name: given.pop(one.name) for one in fields(kind)}) for name, kind in groups.items()}
        command(**made, **given)

    run.__name__, run.__doc__ = command.__name__, command.__doc__
    run.__annotations__ = {option.name: option.annotation for option in options}
    run.__signature__ = inspect.Signature(options)  # type: ignore[attr-defined]
    return run


@dataclass(frozen=True)
class FileOptions:
    """Options for properties that a record file does not state itself."""

    azimuths_deg: Annotated[
        str,
        typer.Option("--azimuths", help="azimuths of the two horizontal axes if the files do not state them: 0,90"),
    ] = ""
    columns: Annotated[
        str,
        typer.Option(
            help="read as columns: 'time:s north:gal east:gal up:gal'; by file: 'x_n.txt=north:gal x_e.txt=east:gal'"
        ),
    ] = ""
    format: Annotated[
        str, typer.Option(help="the only accepted format; by default it is detected from the content")
    ] = ""
    sampling_interval_s: Annotated[
        float | None, typer.Option("--sampling-interval", help="sampling interval of columns without a time, s")
    ] = None
    processed: Annotated[
        bool | None,
        typer.Option(
            "--processed/--raw", help="samples of columns or SAC are (not) corrected already", show_default=False
        ),
    ] = None
    sensor: Annotated[str, typer.Option(help="surface (default) or borehole")] = ""
    trust_data: Annotated[
        bool,
        typer.Option("--trust-data", help="accept contradictions of header and data, and implausible amplitudes"),
    ] = False
    unit: Annotated[
        str, typer.Option(help="unit of the samples if the format does not define it (SAC): m/s2, gal, g…")
    ] = ""
    vertical_sense: Annotated[
        str,
        typer.Option(
            help="up or down, if the file does not state the sense of its vertical axis; none leaves the axis out"
        ),
    ] = ""

    def declarations(self) -> "Declarations":
        """Return the options as `Declarations` for the readers; raise an ArgumentError that names a wrong option."""
        from overturning.errors import ArgumentError
        from overturning.records.formats.table import format_named
        from overturning.records.source import Declarations

        given: dict[str, Any] = {name: value for name, value in vars(self).items() if value not in ("", None)}
        try:
            if self.azimuths_deg:
                given["azimuths_deg"] = [float(a) for a in self.azimuths_deg.replace(",", " ").split()] or None
        except ValueError:
            raise ArgumentError(f"--azimuths: {self.azimuths_deg!r}; two numbers of degrees, e.g. 0,90") from None
        try:
            format_named(self.format or None)
            return Declarations(**given)
        except ArgumentError as problem:
            raise ArgumentError(f"--{str(problem).replace('_', '-', 1)}") from None


@dataclass(frozen=True)
class MotionOptions:
    """Options of `overturning one` for the motion."""

    record: Annotated[
        str, typer.Option(help="id in the record table, a record file, or a pulse: 'sine amplitude_gal=800 period_s=1'")
    ]
    amplitude: Annotated[float, typer.Option(help="factor on the motion")] = 1.0
    vertical: Annotated[bool, typer.Option(help="apply the vertical motion, if the record has one")] = True
    table: Annotated[Path | None, typer.Option(help=f"record table (default {TABLE})")] = None
    folder: Annotated[
        Path | None, typer.Option(help=f"folder of the record files of the table (default {RESOURCES})")
    ] = None


@dataclass(frozen=True)
class StoneOptions:
    """Options of `overturning one` for the size and contact of the stone."""

    b_over_h: Annotated[float | None, typer.Option(help="slenderness B/H (default 0.4, or the scene's)")] = None
    height: Annotated[float | None, typer.Option(help="height H, m (default 0.6, or the scene's)")] = None
    friction: Annotated[float | None, typer.Option(help="friction coefficient µ (default 1, or the scene's)")] = None
    damping_ratio: Annotated[float | None, typer.Option(help="damping ratio of the contact (default 3)")] = None

    @property
    def coefficient(self) -> float:
        """Friction coefficient, by default 1, if the scene does not define its own."""
        return 1.0 if self.friction is None else self.friction


@dataclass(frozen=True)
class PlaneOptions:
    """Options of `overturning one` for a 2-D block or scene."""

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
class BodyOptions:
    """Options of `overturning one` for a 3-D body."""

    body: Annotated[bool, typer.Option("--body", help="simulate a 3-D body instead of a 2-D scene")] = False
    orientation: Annotated[
        list[float] | None,
        typer.Option(help="3-D body: azimuth of its front face; may be given several times (default 0)"),
    ] = None
    plan: Annotated[
        str | None, typer.Option(help="3-D body: rectangle, circle, or number of sides (default rectangle)")
    ] = None
    mesh: Annotated[Path | None, typer.Option(help="3-D body: mesh file (OBJ, PLY, STL) instead of a plan")] = None
    aspect: Annotated[
        float, typer.Option(help="3-D body with a rectangular plan: D/B, ratio of its width across to its width along")
    ] = 1.0


@dataclass(frozen=True)
class OutputOptions:
    """Options of `overturning one` for output files."""

    animate: Annotated[
        Path | None,
        typer.Option(help="film to write: .html (a self-contained page, optionally with contact forces), .gif or .mp4"),
    ] = None
    response: Annotated[
        Path | None,
        typer.Option(
            help="figure of rotation, slip and uplift against time (3-D body: of its axis): .svg, .png or .pdf"
        ),
    ] = None
