"""Members of an ensemble: the changes of parameters of each run, drawn at random and stored as a table."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import create_model

from overturning.arrays import FloatArray
from overturning.errors import ResultError
from overturning.files import append_checksum, atomic_write, checksum_at_end_matches
from overturning.settings import EnsembleSettings
from overturning.tables import read_table_rows

SCRAMBLED_SOBOL_SEQUENCE_COUNT: Final = 2
"""Number of scrambled Sobol sequences; the difference of their means shows the error of the fall probability."""


@dataclass(frozen=True)
class EnsembleParameterChanges:
    """Parameter changes of the runs (members) of an ensemble; the same set of runs is used for every case.

    Attributes
    ----------
    sobol_sequence_number : ndarray of int, shape (n,)
        Number of the scrambled Sobol sequence from which the run is drawn, 0 or 1.
    amplitude_factor, b_over_h_factor, friction_factor, damping_factor : ndarray, shape (n,)
        Factors on the nominal values.
    azimuth_change_deg : ndarray, shape (n,)
        Rotation of the sensor, added to the azimuth, degrees.
    initial_tilt_rad : ndarray, shape (n,)
        Initial rotation, rad.
    orientation_change_deg : ndarray, shape (n,)
        Rotation of the body on the ground, added to its orientation, degrees clockwise.
    relief_m : ndarray, shape (n,)
        Height above the lowest point up to which points of a scanned stone's base bear load, m; NaN: the body's own.
    """

    sobol_sequence_number: NDArray[np.int64]
    amplitude_factor: FloatArray
    b_over_h_factor: FloatArray
    friction_factor: FloatArray
    damping_factor: FloatArray
    azimuth_change_deg: FloatArray
    initial_tilt_rad: FloatArray
    orientation_change_deg: FloatArray
    relief_m: FloatArray

    @property
    def varies_scanned_base_relief(self) -> bool:
        """True if the runs differ in relief, the height up to which points of a scanned stone's base bear."""
        return bool(np.isfinite(self.relief_m).all() and self.relief_m.size)

    @property
    def above_median_relief_mask(self) -> NDArray[np.bool_]:
        """True for runs whose relief (height up to which base points bear) is above the median, shape (n,)."""
        return np.asarray(self.relief_m > np.median(self.relief_m))

    @property
    def csv_column_names(self) -> tuple[str, ...]:
        """Columns of the CSV file: all of `FIELD_BY_CSV_COLUMN`, relief and orientation only if they vary."""
        varies = {"relief": self.varies_scanned_base_relief, "orientation_deg": bool(self.orientation_change_deg.any())}
        return tuple(column for column in FIELD_BY_CSV_COLUMN if varies.get(column, True))

    @property
    def member_count(self) -> int:
        """Number of members (runs with changed parameters) of the ensemble."""
        return int(self.sobol_sequence_number.size)

    def select_members(self, member_numbers: NDArray[np.intp]) -> "EnsembleParameterChanges":
        """Return an ensemble with only the members (runs with changed parameters) of the given numbers."""
        return EnsembleParameterChanges(*(getattr(self, name)[member_numbers] for name in FIELD_BY_CSV_COLUMN.values()))

    def split_members_into_batches_of_both_sequences(self, members_per_batch: int) -> list[NDArray[np.intp]]:
        """Divide the runs (members) of the ensemble into batches, each with runs from both Sobol sequences."""
        own = [np.flatnonzero(self.sobol_sequence_number == number) for number in range(SCRAMBLED_SOBOL_SEQUENCE_COUNT)]
        each = members_per_batch // SCRAMBLED_SOBOL_SEQUENCE_COUNT
        starts = range(0, max(places.size for places in own), each)
        return [np.concatenate([places[start : start + each] for places in own]) for start in starts]

    def write_csv(self, csv_path: Path) -> None:
        """Write the parameter changes of all ensemble runs as CSV, with a SHA-256 checksum as last line."""
        names = self.csv_column_names
        rows = zip(*(getattr(self, FIELD_BY_CSV_COLUMN[name]).tolist() for name in names), strict=True)
        with atomic_write(csv_path) as part:
            part.write_text("".join(f"{','.join(map(str, row))}\n" for row in (names, *rows)), encoding="utf-8")
            append_checksum(part)

    @classmethod
    def read_csv(cls, csv_path: Path) -> Self:
        """Read the parameter changes of all ensemble runs from a CSV file; a `ResultError` if missing or unsuitable."""
        if csv_path.exists() and not checksum_at_end_matches(csv_path):
            raise ResultError(
                f"{csv_path}: damaged, or no table of ensemble members; run the study again to recreate it"
            )
        rows = read_table_rows(
            csv_path, _MemberRow, delimiter=",", error_class=ResultError, table_kind="table of ensemble members"
        )
        numbers = [[getattr(row, column) for column in FIELD_BY_CSV_COLUMN] for _, row in rows]
        scramble, *columns = np.array(numbers, np.float64).reshape(-1, len(FIELD_BY_CSV_COLUMN)).T
        return cls(scramble.astype(np.int64), *columns)


FIELD_BY_CSV_COLUMN: Final = {
    "scramble": "sobol_sequence_number", "amplitude": "amplitude_factor", "b_over_h": "b_over_h_factor",
    "friction": "friction_factor", "damping": "damping_factor", "azimuth_deg": "azimuth_change_deg",
    "initial_tilt": "initial_tilt_rad", "orientation_deg": "orientation_change_deg", "relief": "relief_m",
}  # fmt: skip
"""Field of `EnsembleParameterChanges` by column of the CSV file, in the order of the fields."""


_DEFAULTS_OF_OPTIONAL_CSV_COLUMNS: Final = {"orientation_deg": 0.0, "relief": np.nan}
"""Values of columns that the members' file may lack."""


_MemberRow = create_model(  # type: ignore[call-overload]
    "_MemberRow", **{name: (float, _DEFAULTS_OF_OPTIONAL_CSV_COLUMNS.get(name, ...)) for name in FIELD_BY_CSV_COLUMN}
)


def draw_parameter_changes_of_members(settings: EnsembleSettings) -> EnsembleParameterChanges:
    """Draw the parameter changes of all ensemble runs from two Sobol sequences, scrambled differently (Owen 1998).

    Values are rounded to 1e-9, so that the file has exactly the same numbers.
    """
    from scipy.stats import qmc

    half = settings.members // SCRAMBLED_SOBOL_SEQUENCE_COUNT
    power = max(half - 1, 0).bit_length()  # the sequence has a length of a power of two
    generators = (
        np.random.Generator(np.random.PCG64(stream))
        for stream in np.random.SeedSequence(settings.seed).spawn(SCRAMBLED_SOBOL_SEQUENCE_COUNT)
    )
    # Two more dimensions change the points of all; ensembles without them keep theirs.
    dimensions = 8 if settings.relief is not None or settings.orientation else 6
    points = [qmc.Sobol(d=dimensions, scramble=True, rng=one).random_base2(power)[:half] for one in generators]
    widths = (settings.amplitude, settings.b_over_h, settings.friction, settings.damping)
    signed = 2 * np.concatenate(points) - 1
    changes = signed[:, :6] * np.array([*widths, settings.azimuth, settings.initial_tilt])
    changes[:, : len(widths)] += 1.0  # factors
    count = SCRAMBLED_SOBOL_SEQUENCE_COUNT * half
    reliefs = np.full(count, np.nan)
    turns = np.round(settings.orientation * signed[:, 6], 9) if dimensions > 6 else np.zeros(count)
    if settings.relief is not None:
        low, high = settings.relief.low, settings.relief.high
        reliefs = np.round(low + (high - low) * 0.5 * (signed[:, 7] + 1.0), 9)
    sequence_numbers = np.repeat(np.arange(SCRAMBLED_SOBOL_SEQUENCE_COUNT), half)
    return EnsembleParameterChanges(sequence_numbers, *np.column_stack([np.round(changes, 9), turns, reliefs]).T)
