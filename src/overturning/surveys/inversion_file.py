"""A posterior of the motion as a file, with what a reader has to know of the survey."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import xarray as xr

from overturning.arrays import FloatArray
from overturning.errors import ResultError
from overturning.files import atomic_write
from overturning.surveys.inversion import Inversion, Posterior
from overturning.surveys.stones import Stone
from overturning.units import CM, STANDARD_GRAVITY

_DIMENSIONS: Final = {
    "level": "level", "turn": "turn", "probability": ("source", "level", "turn"), "prior": ("source", "level", "turn"),
    "pga": "source", "axis": "source",
}  # fmt: skip


@dataclass(frozen=True)
class Backwards:
    """What a survey says of the motion.

    Attributes
    ----------
    name : str
        Of the survey's file.
    fell, stood : int
        Stones.
    fixed : float
        Share taken to be fixed.
    fit : float
        p-value of the check whether the library fits, see `Inversion.fit`.
    posterior : Posterior
        Of motion, level and turn.
    """

    name: str
    fell: int
    stood: int
    fixed: float
    fit: float
    posterior: Posterior

    @classmethod
    def of(cls, name: str, stones: Sequence[Stone], inversion: Inversion) -> "Backwards":
        """Ask a survey about its motion."""
        logs = inversion.log_likelihood(stones)
        posterior = inversion.posterior(logs)
        fell, stood = (sum(one.count for one in stones if one.fell is kind) for kind in (True, False))
        return cls(name, fell, stood, inversion.fixed, inversion.fit(stones, posterior), posterior)

    @property
    def strengths(self) -> dict[str, FloatArray]:
        """PGV in cm/s and PGA in g, largest over all azimuths, of each motion at each level, shape (s, l)."""
        pgv = self.posterior.pgv
        return {"PGV, cm/s": pgv / CM, "PGA, g": self.posterior.pga[:, None] * pgv / STANDARD_GRAVITY}


def write_backwards(found: Backwards, path: Path) -> None:
    """Write a posterior (NetCDF)."""
    table = xr.Dataset(
        {name: (dims, getattr(found.posterior, name)) for name, dims in _DIMENSIONS.items()},
        {"source": list(found.posterior.sources)},
        {"survey": found.name, "fell": found.fell, "stood": found.stood, "fixed": found.fixed, "fit": found.fit},
    )
    with atomic_write(path) as part:
        table.to_netcdf(part, engine="netcdf4")


def read_backwards(path: Path) -> Backwards:
    """Read what `write_backwards` wrote; a ResultError where it is missing or of another kind."""
    try:
        with xr.open_dataset(path, engine="netcdf4") as stored:
            table = stored.load()
        sources, about = tuple(str(name) for name in table["source"].to_numpy()), table.attrs
        posterior = Posterior(sources, **{name: np.asarray(table[name]) for name in _DIMENSIONS})
        numbers = (int(about["fell"]), int(about["stood"]), float(about["fixed"]), float(about["fit"]))
        return Backwards(str(about["survey"]), *numbers, posterior)
    except (OSError, ValueError, KeyError) as error:
        raise ResultError(f"{path}: cannot be read ({error}); run the study again") from None
