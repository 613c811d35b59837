"""The ground of a study: soil layers over rock, through which its records go to the surface."""

from dataclasses import replace
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import BaseModel, Field

from overturning.errors import RecordError
from overturning.motion.soil import TAIL, Layer, Rock, through_soil
from overturning.records.record import Record


class Site(BaseModel, extra="forbid", frozen=True):
    """The ground of a study: takes the horizontal motion from rock through soil layers to the surface, after all steps.

    Needs pystrata (group `soil`). Linear, or equivalent-linear where a layer has a curve. The vertical motion is left
    as it is (`overturning.motion.soil`).
    """

    step: ClassVar[str] = "site"  # among the steps that were applied to a record
    layers: tuple[Layer, ...] = Field(min_length=1, description="Layers from the surface down.")
    rock: Rock = Field(description="The half-space below them.")
    motion: Literal["outcrop", "within"] = Field(
        default="outcrop", description="Whether the record is of outcropping rock or of the rock below the layers."
    )

    def apply(self, record: Record) -> tuple[Record, str]:
        """The record at the surface, and where a layer has a curve what became of the iteration.

        A RecordError where a borehole's record is taken for outcropping rock: what the surface reflects is in it.
        """
        if self.motion == "outcrop" and "borehole sensor" in record.extra.get("declared", ()) and not record.trusted:
            raise RecordError(
                f"record {record.record_id}: of a borehole, where rock moves with what the surface reflects, too, but "
                "the site takes it for outcropping rock; write `motion: within` at the site, or say trust_data"
            )
        tail, outcrop = (0, round(TAIL / record.sampling_interval)), self.motion == "outcrop"
        surface: dict[str, Any] = {}
        notes = []
        for axis, samples in (("north", record.north), ("east", record.east)):
            passed = through_soil(samples, record.sampling_interval, self.layers, self.rock, outcrop=outcrop)
            state = "converged" if passed.converged else f"not converged (last change {100 * passed.change:.1f} %)"
            notes.append(f"{axis} {state}, strain {100 * passed.largest_strain:.2g} %")
            surface[axis] = passed.samples
        up = None if record.up is None else np.pad(record.up, tail)
        return replace(record, up=up, **surface), "; ".join(notes) if any(one.curve for one in self.layers) else ""
