"""Options of the subcommands that read record files: what the files do not say themselves."""

from typing import Annotated, Any, get_args

import typer

Azimuths = Annotated[
    str, typer.Option(help="azimuths of the two horizontal axes where the files do not state them: 0,90")
]
Columns = Annotated[str, typer.Option(help="read as columns: 'time:s north:gal east:gal up:gal'")]
Form = Annotated[str, typer.Option("--format", help="the only format allowed; otherwise by content")]
Interval = Annotated[float | None, typer.Option(help="sampling interval of columns without a time, s")]
Processed = Annotated[
    bool | None,
    typer.Option(
        "--processed/--raw", help="whether samples of columns or SAC are corrected already", show_default=False
    ),
]
Sensor = Annotated[str, typer.Option(help="surface, or borehole, which must be declared")]
TrustData = Annotated[
    bool,
    typer.Option("--trust-data", help="go on where header and data contradict each other, or the size is no motion's"),
]
Unit = Annotated[str, typer.Option(help="unit of the samples where the format leaves it open (SAC): m/s2, gal, g…")]
VerticalSense = Annotated[
    str,
    typer.Option(help="up, down or none (leave out), for a vertical axis that does not say which way it points"),
]


def declared(
    azimuths: str = "",
    columns: str = "",
    form: str = "",
    interval: float | None = None,
    processed: bool | None = None,
    sensor: str = "",
    trust_data: bool = False,
    unit: str = "",
    vertical_sense: str = "",
) -> dict[str, Any]:
    """The same as arguments of `read_path` and `check_paths`; an ArgumentError names a wrong one."""
    from overturning.errors import ArgumentError
    from overturning.records import assembly, component
    from overturning.records.detect import FORMATS
    from overturning.records.source import ReadOptions
    from overturning.units import UNITS

    for option, value, known in (
        ("--vertical-sense", vertical_sense, get_args(assembly.VerticalSense)),
        ("--sensor", sensor, get_args(component.Sensor)),
        ("--unit", unit, tuple(UNITS)),
        ("--format", form, tuple(each.name for each in FORMATS)),
    ):
        if value and value not in known:
            raise ArgumentError(f"{option}: {value!r}; known are {', '.join(known)}")
    try:
        pair = [float(a) for a in azimuths.replace(",", " ").split()] or None
    except ValueError:
        raise ArgumentError(f"--azimuths: {azimuths!r}; two numbers of degrees, e.g. 0,90") from None
    return {
        "options": ReadOptions(unit or None, columns, interval, processed),
        "form": form or None,
        "azimuths_deg": pair,
        "vertical_sense": vertical_sense or None,
        "trust_data": trust_data,
    } | ({"sensor": sensor} if sensor else {})
