"""Options that belong together, each group declared once and spread over the subcommands that take it."""

import inspect
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, get_type_hints

import typer

if TYPE_CHECKING:
    from overturning.records.source import Declarations

TABLE: Final = Path("config/records.tsv")
"""Record table, where no other is named."""

RESOURCES: Final = Path("resources/records")
"""Folder of the record files of a table."""


def grouped(command: Callable[..., None]) -> Callable[..., None]:
    """Spread each parameter of a command that is a dataclass into one option for each of its fields.

    Typer makes options of a function's signature, one for each parameter. What is returned has the signature with the
    fields in place of their group, and hands the command the groups, made of what was given.
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
class Declared:
    """What record files do not say themselves, of the subcommands that read them."""

    azimuths_deg: Annotated[
        str,
        typer.Option("--azimuths", help="azimuths of the two horizontal axes where the files do not state them: 0,90"),
    ] = ""
    columns: Annotated[
        str,
        typer.Option(
            help="read as columns: 'time:s north:gal east:gal up:gal'; by file: 'x_n.txt=north:gal x_e.txt=east:gal'"
        ),
    ] = ""
    format: Annotated[str, typer.Option(help="the only format allowed; otherwise by content")] = ""
    sampling_interval_s: Annotated[
        float | None, typer.Option("--sampling-interval", help="sampling interval of columns without a time, s")
    ] = None
    processed: Annotated[
        bool | None,
        typer.Option(
            "--processed/--raw", help="whether samples of columns or SAC are corrected already", show_default=False
        ),
    ] = None
    sensor: Annotated[str, typer.Option(help="surface, or borehole, which must be declared")] = ""
    trust_data: Annotated[
        bool,
        typer.Option(
            "--trust-data", help="go on where header and data contradict each other, or the size is no motion's"
        ),
    ] = False
    unit: Annotated[
        str, typer.Option(help="unit of the samples where the format leaves it open (SAC): m/s2, gal, g…")
    ] = ""
    vertical_sense: Annotated[
        str,
        typer.Option(help="up or down, for a vertical axis that does not say which way it points; none leaves any out"),
    ] = ""

    def declarations(self) -> "Declarations":
        """What was declared, as the readers take it; an ArgumentError names a wrong option."""
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
class Shaking:
    """The motion of `overturning one`."""

    record: Annotated[
        str, typer.Option(help="id in the record table, a record file, or a pulse: 'sine amplitude_gal=800 period_s=1'")
    ]
    amplitude: Annotated[float, typer.Option(help="factor on the motion")] = 1.0
    vertical: Annotated[bool, typer.Option(help="apply the vertical motion where the record has one")] = True
    table: Annotated[Path | None, typer.Option(help=f"record table (default {TABLE})")] = None
    folder: Annotated[
        Path | None, typer.Option(help=f"folder of the record files of the table (default {RESOURCES})")
    ] = None


@dataclass(frozen=True)
class Stone:
    """Size, m, and contact of what stands on the ground in `overturning one`."""

    b_over_h: Annotated[float | None, typer.Option(help="slenderness B/H (default 0.4, or the scene's)")] = None
    height: Annotated[float | None, typer.Option(help="height H, m (default 0.6, or the scene's)")] = None
    friction: Annotated[float | None, typer.Option(help="friction coefficient µ (default 1, or the scene's)")] = None
    damping_ratio: Annotated[float | None, typer.Option(help="damping ratio of the contact (default 3)")] = None

    @property
    def coefficient(self) -> float:
        """Friction coefficient of a stone whose scene has none of its own: as given, or 1."""
        return 1.0 if self.friction is None else self.friction


@dataclass(frozen=True)
class InPlane:
    """What only a block or scene in a vertical plane has in `overturning one`."""

    azimuth: Annotated[
        list[float] | None, typer.Option(help="degrees clockwise from north; may be given several times")
    ] = None
    scene: Annotated[
        str | None,
        typer.Option(help="scene of config/scenes, or a scene file; height and B/H are its reference element's"),
    ] = None
    density: Annotated[float | None, typer.Option(help="density, kg/m³ (default 2650)")] = None
    damping: Annotated[float | None, typer.Option(help="dashpot per corner instead of the ratio, N·s/m")] = None
    stiffness: Annotated[float | None, typer.Option(help="normal stiffness per corner, N/m (default: automatic)")] = (
        None
    )


@dataclass(frozen=True)
class InSpace:
    """What only a free body in space has in `overturning one`."""

    body: Annotated[bool, typer.Option("--body", help="a free body in space instead of a scene in a plane")] = False
    orientation: Annotated[
        list[float] | None,
        typer.Option(help="of a body: azimuth that it faces; may be given several times (default 0)"),
    ] = None
    plan: Annotated[
        str | None, typer.Option(help="of a body: rectangle, circle, or number of sides (default rectangle)")
    ] = None
    mesh: Annotated[Path | None, typer.Option(help="of a body, instead of a plan: its file (OBJ, PLY, STL)")] = None
    aspect: Annotated[float, typer.Option(help="of a rectangle: D/B, width across over that along")] = 1.0


@dataclass(frozen=True)
class Outputs:
    """Files that `overturning one` writes."""

    animate: Annotated[
        Path | None,
        typer.Option(
            help="film to write: .html (one self-contained page, with the contact forces on demand), .gif or .mp4"
        ),
    ] = None
    response: Annotated[
        Path | None,
        typer.Option(
            help="figure of rotation, slip and uplift against time, of a body of its axis: .svg, .png or .pdf"
        ),
    ] = None
