"""A posterior of the motion as a file, with what a reader has to know of the survey and the motions."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from overturning.arrays import FloatArray
from overturning.errors import ResultError
from overturning.files import atomic_write
from overturning.surveys.inversion import Posterior
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
    """

    name: str
    fell: int
    stood: int
    fixed: float
    posterior: Posterior
    pga: FloatArray
    pgv: FloatArray

    @classmethod
    def of(
        cls,
        name: str,
        stones: Sequence[Stone],
        posterior: Posterior,
        peaks: Mapping[str, tuple[float, float]],
        fixed: float = 0.0,
    ) -> "Backwards":
        """From a survey, its posterior, and the largest PGA and PGV of each motion."""
        fell, stood = (sum(one.count for one in stones if one.fell is kind) for kind in (True, False))
        pga, pgv = np.array([peaks[source] for source in posterior.sources]).T
        return cls(name, fell, stood, fixed, posterior, pga, pgv)

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
        {"survey": found.name, "fell": found.fell, "stood": found.stood, "fixed": found.fixed},
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
        )  # fmt: skip
    except (OSError, ValueError, KeyError) as error:
        raise ResultError(f"{path}: cannot be read ({error}); run the study again") from None
