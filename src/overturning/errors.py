"""The exceptions a user can meet. Each message names what is wrong, the value, the bound and the remedy."""

import re
from typing import Final

MOST_LINES: Final = 20
"""Lines of a message; of more their number."""

LONGEST_LINE: Final = 600
"""Characters of a line of a message, whatever the file or name is that it tells about."""

_CONTROL: Final = re.compile(r"[^\x20-\x7e\xa0-\u2027\u202f-\u2065\u2070-\ud7ff\ue000-\U0010ffff\n\t]")


class OverturningError(Exception):
    """Base of every error that a user can cause; the command line prints it in one or two lines, without a traceback.

    What a message quotes of a stranger's file is cut where it is long, and signs that would steer a terminal are spelt
    out.
    """

    def __str__(self) -> str:
        # FileNotFoundError would format its arguments as errno and file name.
        lines = _CONTROL.sub(lambda sign: repr(sign[0])[1:-1], str(self.args[0]) if self.args else "").split("\n")
        more = [f"       … and {len(lines) - MOST_LINES} more lines"] if len(lines) > MOST_LINES else []
        half = LONGEST_LINE // 2
        short = [
            line if len(line) <= LONGEST_LINE else f"{line[:half]} … {line[-half:]}" for line in lines[:MOST_LINES]
        ]
        return "\n".join(short + more)


class ArgumentError(OverturningError, ValueError):
    """An argument is outside its bounds. The message names argument, value and bound."""


class ConfigError(OverturningError, ValueError):
    """A configuration file or record table is wrong. The message names file, key, value and remedy."""


class RecordError(OverturningError, ValueError):
    """A record file cannot be read or contradicts itself. The message names file, line and remedy."""


class MissingDataError(OverturningError, FileNotFoundError):
    """Data that the user has to provide is not there. The message says which, from where, and where to put it."""


class ResultError(OverturningError):
    """A result file is missing, incomplete or of another version."""
