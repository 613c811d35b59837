"""The command line: subcommands for users, and one subcommand for each step of the workflow."""

import sys
from collections.abc import Callable, Sequence
from typing import Annotated

import typer

from overturning.commands import cube, records, study, surveys, workflow
from overturning.commands.explore import explore
from overturning.commands.one import one
from overturning.errors import OverturningError
from overturning.files import os_error_message

_INTERRUPTED = 130

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,  # plain help: importing rich would take half of the time
    pretty_exceptions_enable=False,
    help="Which way gravestones fall in an earthquake, and how sure one can be.",
)


def _first_paragraph(command: Callable[..., None] | None) -> str:
    """What a list of commands says of one, whole: Typer would cut it."""
    return " ".join((command.__doc__ or "").partition("\n\n")[0].split())


def _add(group: typer.Typer, name: str) -> None:
    """Add a group, whose lists of commands say of each the same as the list of all."""
    groups = [group, *(each.typer_instance for each in group.registered_groups if each.typer_instance)]
    for each in groups:
        for below in each.registered_commands:
            below.short_help = _first_paragraph(below.callback)
    app.add_typer(group, name=name, short_help=group.info.help)


# What a subcommand needs is imported inside its function, so that this is quick.
_OF_CUBES, _OF_STONES = (cube.figure, explore), (surveys.survey, surveys.backwards, surveys.stood)
for _command in (study.init, one, *_OF_CUBES, *_OF_STONES, cube.recheck, *workflow.STEPS):
    app.command(short_help=_first_paragraph(_command))(_command)
for _name, _group in {"study": study.app, "records": records.app, "cube": cube.app}.items():
    _add(_group, _name)


def _version(wanted: bool) -> None:
    if wanted:
        from importlib import metadata

        print(f"overturning {metadata.version('overturning')}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Say which version this is.")
    ] = False,
) -> None:
    pass


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line.

    An error that a user can cause ends in one or two lines on standard error and exit status 1; a traceback is a bug of
    this package.
    """
    try:
        app(args=None if arguments is None else list(arguments))
    except OverturningError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(1)
    except OSError as error:
        if not (said := os_error_message(error)):
            raise
        print(f"error: {said}", file=sys.stderr)
        sys.exit(1)
    except RuntimeError as error:
        # Met where the cells of a cube from elsewhere are read, which may be at any time after it was opened.
        if not str(error).startswith("NetCDF: "):
            raise
        print(f"error: a cube that the command names is damaged ({error}); get it, or make it, again", file=sys.stderr)
        sys.exit(1)
    except SystemExit as end:
        if end.code == _INTERRUPTED:
            print("Stopped; nothing half-written was kept.", file=sys.stderr)
        raise


if __name__ == "__main__":
    main()
