"""The exceptions a user can meet. Each message names what is wrong, the value, the bound and the remedy."""


class OverturningError(Exception):
    """Base of every error that a user can cause; the command line prints it in one or two lines, without a traceback."""


class ArgumentError(OverturningError, ValueError):
    """An argument is outside its bounds. The message names argument, value and bound."""


class ConfigError(OverturningError, ValueError):
    """A configuration file or record table is wrong. The message names file, key, value and remedy."""


class RecordError(OverturningError, ValueError):
    """A record file cannot be read or contradicts itself. The message names file, line where there is one, and remedy."""


class MissingDataError(OverturningError, FileNotFoundError):
    """Data that the user has to provide is not there. The message says which, from where, and where to put it."""

    def __str__(self) -> str:
        # FileNotFoundError would format its arguments as errno and file name.
        return str(self.args[0]) if self.args else ""


class ResultError(OverturningError):
    """A result file is missing, incomplete or of another version."""
