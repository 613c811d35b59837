"""What a reader may need to be told because the file does not say it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

from overturning.records.source import SourceFile
from overturning.units import UNITS

Unit = Literal["m/s2", "cm/s2", "gal", "mm/s2", "nm/s2", "g", "mg"]

assert set(UNITS) == set(get_args(Unit))


@dataclass(frozen=True)
class ReadOptions:
    """Declarations of the record table or the command line."""

    unit: str | None = None  # of the samples, a key of ``UNITS``, where the format leaves it open (SAC)
    columns: str = ""  # of a CSV file: ``time:s north:gal east:gal up:gal``
    sampling_interval_s: float | None = None  # of a CSV file without a time column
    processed: bool | None = None  # whether the samples have been corrected already, where the format leaves it open
    metadata: Sequence[SourceFile] = ()  # StationXML files that go with MiniSEED or SAC files

    @property
    def declared(self) -> list[str]:
        """What was declared of the samples, in words."""
        words = [f"columns {self.columns}"] if self.columns else [f"unit {self.unit}"] if self.unit else []
        state = {True: ["processed"], False: ["raw"], None: []}[self.processed]
        return [*words, *state]

    def with_metadata_of(self, files: Iterable[SourceFile]) -> "ReadOptions":
        """The same, with the StationXML among files added to the metadata."""
        from overturning.records.formats import stationxml

        return replace(self, metadata=(*self.metadata, *(file for file in files if stationxml.detect(file))))
