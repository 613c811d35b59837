"""Entry point of the program `overturning`; it imports little, so that a step in a fork server starts quickly."""

import sys
from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the program `overturning`; a workflow step runs in a fork of the workflow's server process if possible.

    Only a command line of this process (`arguments` is None) may run in the server; given `arguments` run here. See
    `overturning.commands.application.run_command_line`.
    """
    if arguments is None:
        from overturning.commands.fork_client import run_workflow_step_in_fork_server_if_possible

        status = run_workflow_step_in_fork_server_if_possible(sys.argv[1:])
        if status is not None:
            sys.exit(status)
    from overturning.commands.application import run_command_line

    run_command_line(arguments)


if __name__ == "__main__":
    main()
