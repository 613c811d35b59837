"""The command line: a thin face, one subcommand per rule of the workflow and per question of a user."""

import importlib
import sys
from collections.abc import Sequence
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from overturning.errors import OverturningError
from overturning.files import describe

# Subcommand: module in overturning.commands that holds a typer app named `app`, with that subcommand alone, with a
# command of that name, or with commands of its own; and its line in --help. Only the module of the subcommand that runs
# is imported.
COMMANDS = {
    "init": ("init", "Make a folder for studies of one's own: study, record table, scenes, workflow."),
    "study": ("study", "Write a new study, or check one; write the schema and the key table."),
    "records": ("records", "Say what record files are, or why they are refused; add or fetch records."),
    "read": ("workflow", "Read one record of the table into motion.nc."),
    "rotate": ("workflow", "Intensity measures per azimuth of all records into intensity.nc."),
    "sweep": ("workflow", "Simulate every case of one record."),
    "members": ("workflow", "Draw the members of a study's ensemble."),
    "gather": ("workflow", "Gather the parts of a sweep into the cube."),
    "figures": ("workflow", "Draw the figures of a study."),
    "check-convergence": ("workflow", "Compute a random part of a study again, with finer steps and stiffer springs."),
    "surface": ("workflow", "Take the motions of all records through the soil of a variant."),
    "fragility": ("workflow", "Fragility curves of a population, as CSV and for OpenQuake."),
    "report": ("workflow", "Write the report of a study."),
    "explore": ("explore", "Write a page to look around in a cube: point at a cell, see what is known of it."),
    "survey": ("survey", "Compare a survey of fallen stones with the cube of its site."),
    "backwards": ("backwards", "From a survey of fallen stones back to the motion: strength, azimuth, record."),
    "recheck": ("recheck", "Compute a random sample of a cube's cells again and compare bit for bit."),
    "one": ("one", "Simulate one block; print what it does, and make a film of it."),
}


_INTERRUPTED = 130


class _LazyGroup(TyperGroup):
    def list_commands(self, ctx: Any) -> list[str]:  # noqa: ARG002
        return list(COMMANDS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:  # noqa: ARG002
        if cmd_name not in COMMANDS:
            return None
        module = importlib.import_module(f"overturning.commands.{COMMANDS[cmd_name][0]}")
        command = typer.main.get_command(module.app)
        command = getattr(command, "commands", {}).get(cmd_name, command)  # one of the steps of a module with several
        command.name = cmd_name
        return command

    def format_commands(self, ctx: Any, formatter: Any) -> None:  # noqa: ARG002
        # From the table above: the overview needs no subcommand's module.
        with formatter.section("Commands"):
            formatter.write_dl([(name, line) for name, (_, line) in COMMANDS.items()])


app = typer.Typer(
    cls=_LazyGroup,
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,  # plain help: importing rich would take half of the time
    pretty_exceptions_enable=False,
    help="Which way gravestones fall in an earthquake, and how sure one can be.",
)


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
        if not (said := describe(error)):
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
