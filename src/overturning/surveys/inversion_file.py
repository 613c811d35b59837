"""A posterior of the motion as a file, with what a reader has to know of the survey and the motions."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from overturning.arrays import FloatArray
from overturning.errors import ResultError
from overturning.files import atomic_write
from overturning.motion.motion import Motion
from overturning.surveys.inversion import Posterior
from overturning.surveys.motions import largest_peaks
from overturning.surveys.stones import Stone
from overturning.units import CM, STANDARD_GRAVITY


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
    posterior : Posterior
        Of motion, factor and azimuth.
    pga, pgv : ndarray, shape (s,)
        Largest of each motion over all azimuths, m/s² and m/s.
    along_north : bool
        Whether every motion goes along the north alone, so that the angle by which it is turned is its azimuth.
    """

    name: str
    fell: int
    stood: int
    fixed: float
    posterior: Posterior
    pga: FloatArray
    pgv: FloatArray
    along_north: bool

    @classmethod
    def of(
        cls,
        name: str,
        stones: Sequence[Stone],
        posterior: Posterior,
        motions: Mapping[str, Motion],
        fixed: float = 0.0,
    ) -> "Backwards":
        """From a survey, its posterior, and the motions that were tried."""
        fell, stood = (sum(one.count for one in stones if one.fell is kind) for kind in (True, False))
        pga, pgv = np.array([largest_peaks(motions[source]) for source in posterior.sources]).T
        along_north = not any(motion.east.any() for motion in motions.values())
        return cls(name, fell, stood, fixed, posterior, pga, pgv, along_north)

    @property
    def strengths(self) -> dict[str, FloatArray]:
        """PGA in g and PGV in cm/s of each motion at each factor, shape (s, a)."""
        factor = self.posterior.amplitude
        return {
            "PGA, g": self.pga[:, None] * factor / STANDARD_GRAVITY,
            "PGV, cm/s": self.pgv[:, None] * factor / CM,
        }


def write_backwards(found: Backwards, path: Path) -> None:
    """Write a posterior (NetCDF)."""
    one, dims = found.posterior, ("source", "amplitude", "azimuth")
    table = xr.Dataset(
        {
            "probability": (dims, one.probability),
            "prior": (dims, one.prior),
            "pga": ("source", found.pga),
            "pgv": ("source", found.pgv),
        },
        {"source": list(one.sources), "amplitude": one.amplitude, "azimuth": one.azimuth},
        {"survey": found.name, "fell": found.fell, "stood": found.stood, "fixed": found.fixed}
        | {"along_north": int(found.along_north)},
    )
    with atomic_write(path) as part:
        table.to_netcdf(part, engine="netcdf4")


def read_backwards(path: Path) -> Backwards:
    """Read what `write_backwards` wrote; a ResultError where it is missing or of another kind."""
    try:
        with xr.open_dataset(path, engine="netcdf4") as stored:
            table = stored.load()
        sources = tuple(str(name) for name in table["source"].to_numpy())
        axes = (table[name].to_numpy() for name in ("amplitude", "azimuth", "probability", "prior"))
        about = table.attrs
        return Backwards(
            str(about["survey"]), int(about["fell"]), int(about["stood"]), float(about["fixed"]),
            Posterior(sources, *axes), table["pga"].to_numpy(), table["pgv"].to_numpy(),
            bool(about["along_north"]),
        )  # fmt: skip
    except (OSError, ValueError, KeyError) as error:
        raise ResultError(f"{path}: cannot be read ({error}); run the study again") from None
