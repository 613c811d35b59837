"""The command line: subcommands for users, and one subcommand for each step of the workflow."""

import sys
from collections.abc import Callable, Sequence
from functools import cache
from typing import Annotated, Any

import typer
from typer.core import TyperGroup
from typer.main import get_command
from typing_extensions import override

from overturning.commands import cube, records, stood, study, surveys, workflow
from overturning.commands.explore import write_interactive_cube_page
from overturning.commands.one import simulate_stone_or_scene_under_one_record
from overturning.errors import OverturningError
from overturning.files import os_error_message_or_empty_without_remedy

_INTERRUPTED_EXIT_STATUS = 130
"""Exit status of a command stopped by Ctrl-C."""

_WORKFLOW_STEPS_HELP_HEADING = "Steps of the workflow (run by Snakemake)"
"""Heading of the list of commands that the workflow calls."""


class _GroupWithHelpHeadings(TyperGroup):
    """Command group whose help lists commands under headings (`rich_help_panel`), without the package rich."""

    @override
    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the list of commands in the help text, under their headings."""
        panels: dict[str, list[tuple[str, str]]] = {"Commands": []}
        for name in self.list_commands(ctx):
            command = self.get_command(ctx, name)
            if command is not None and not command.hidden:
                panel = getattr(command, "rich_help_panel", None)
                rows = panels.setdefault(panel if isinstance(panel, str) else "Commands", [])
                rows.append((name, command.get_short_help_str(formatter.width)))
        for panel, rows in panels.items():
            if rows:
                with formatter.section(panel):
                    formatter.write_dl(rows)


app = typer.Typer(
    cls=_GroupWithHelpHeadings,
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,  # plain help: importing rich would take half of the time
    pretty_exceptions_enable=False,
    help="Simulate the directions in which gravestones fall in earthquakes, with their uncertainty.",
)


def _first_docstring_paragraph(command: Callable[..., None] | None) -> str:
    """Return the first paragraph of a command's docstring; Typer would show only its beginning in the help."""
    return " ".join((command.__doc__ or "").partition("\n\n")[0].split())


def _add_group_and_set_short_help_of_subcommands(group: typer.Typer, group_name: str) -> None:
    """Add a group of subcommands to the command line, and set the short help text of each subcommand."""
    groups = [group, *(each.typer_instance for each in group.registered_groups if each.typer_instance)]
    for each in groups:
        for below in each.registered_commands:
            below.short_help = _first_docstring_paragraph(below.callback)
    app.add_typer(group, name=group_name, short_help=group.info.help)


# Subcommands import what they need inside their functions, so that this module is imported quickly.
_FUNCTION_BY_USER_COMMAND: dict[str, Callable[..., None]] = {
    "init": study.create_project,
    "one": simulate_stone_or_scene_under_one_record,
    "findings": cube.print_findings,
    "figure": cube.draw_figure,
    "explore": write_interactive_cube_page,
    "survey": surveys.summarise_or_compare_survey,
    "backwards": surveys.infer_motion_from_survey,
    "stood": stood.print_survival_probability,
    "recheck": cube.recheck_random_cases_of_cube,
}
for _name, _command in _FUNCTION_BY_USER_COMMAND.items():
    app.command(_name, short_help=_first_docstring_paragraph(_command))(_command)
for _name, _command in workflow.WORKFLOW_STEPS_BY_COMMAND.items():
    app.command(_name, short_help=_first_docstring_paragraph(_command), rich_help_panel=_WORKFLOW_STEPS_HELP_HEADING)(
        _command
    )
for _name, _group in {"study": study.app, "records": records.app, "cube": cube.app}.items():
    _add_group_and_set_short_help_of_subcommands(_group, _name)


def _print_version(version_requested: bool) -> None:
    """Print the version of the package and exit, if the option --version is given."""
    if version_requested:
        from importlib import metadata

        print(f"overturning {metadata.version('overturning')}")
        raise typer.Exit


@app.callback()
def _accept_version_option_before_command(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    pass


@cache
def _create_command_line_program() -> Any:
    """Create the command-line program with all commands; cached, since a process may run several command lines."""
    return get_command(app)


def run_command_line(arguments: Sequence[str] | None = None) -> None:
    """Run the command-line program `overturning` with the given arguments (default: those of this process).

    For an error that a user can cause, it prints one or two lines on standard error and exits with status 1; a
    traceback is a bug of this package.
    """
    try:
        _create_command_line_program()(args=None if arguments is None else list(arguments), prog_name="overturning")
    except OverturningError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(1)
    except OSError as error:
        if not (said := os_error_message_or_empty_without_remedy(error)):
            raise
        print(f"error: {said}", file=sys.stderr)
        sys.exit(1)
    except RuntimeError as error:
        # A damaged cube may raise this at any time after it was opened, when its cells are read.
        if not str(error).startswith("NetCDF: "):
            raise
        print(f"error: a cube of this command is damaged ({error}); copy or compute it again", file=sys.stderr)
        sys.exit(1)
    except SystemExit as end:
        if end.code == _INTERRUPTED_EXIT_STATUS:
            print("Stopped; no incomplete file was kept.", file=sys.stderr)
        raise
