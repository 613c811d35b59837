"""Site of a study: soil layers over rock that carry the records to the surface."""

from dataclasses import replace
from typing import Any, ClassVar, Final, Literal

import numpy as np
from pydantic import Field

from overturning.arrays import FloatArray
from overturning.errors import RecordError
from overturning.motion.soil import RockHalfSpace, SoilLayer, propagate_through_soil
from overturning.records.record import Record
from overturning.validation import StrictModel

STRAIN_BEYOND_CURVE_PHRASE: Final = "beyond the curve"
"""Part of the account of a soil-response analysis whose effective strain exceeds the curve of a layer."""


class SoilSite(StrictModel):
    """Soil layers through which a study propagates the horizontal motion from rock to the surface.

    Needs pystrata (group `soil`). The analysis is linear, or equivalent-linear if a layer has a modulus-reduction
    curve (`overturning.motion.soil`). The vertical motion is unchanged.
    """

    step: ClassVar[str] = "site"  # name in the processing of a record
    layers: tuple[SoilLayer, ...] = Field(min_length=1, description="Layers from the surface down.")
    rock: RockHalfSpace = Field(description="Half-space below the layers.")
    motion: Literal["outcrop", "within"] = Field(
        default="outcrop", description="Rock under the instrument, outcropping or below the layers (within)."
    )

    def propagate_record_to_surface_with_note(self, record: Record) -> tuple[Record, str]:
        """Compute the record's motion at the surface; return also a text on convergence and strain ("" if linear).

        Raises a RecordError if a borehole record is taken for outcropping rock, because it contains waves that the
        surface reflected; not if the user trusts the data.
        """
        if (
            self.motion == "outcrop"
            and "borehole sensor" in record.extra.get("declared", ())
            and not record.user_trusts_data
        ):
            raise RecordError(
                f"record {record.record_id}: of a borehole, where rock moves with what the surface reflects, too, but "
                "the site takes it for outcropping rock; write `motion: within` at the site, or say trust_data"
            )
        surface: dict[str, FloatArray] = {} if record.up is None else {"up": record.up}
        outcrop, notes = self.motion == "outcrop", []
        for axis, samples in (("north", record.north), ("east", record.east)):
            passed = propagate_through_soil(
                samples, record.sampling_interval, self.layers, self.rock, motion_is_on_outcrop=outcrop
            )
            state = (
                "converged"
                if passed.is_converged
                else f"not converged (last change {100 * passed.last_relative_modulus_and_damping_change:.1f} %)"
            )
            note = f"{axis} {state}, strain {100 * passed.max_shear_strain_of_any_layer:.2g} %"
            if passed.effective_strain_and_end_of_curve_if_exceeded is not None:
                strain, end = (100 * one for one in passed.effective_strain_and_end_of_curve_if_exceeded)
                note += f", effective strain {strain:.2g} % {STRAIN_BEYOND_CURVE_PHRASE} (which ends at {end:.2g} %)"
            notes.append(note)
            surface[axis] = passed.surface_acceleration
        # The tails of the components differ: the samples that are left out are below a small share of the peak.
        count = max(samples.size for samples in surface.values())
        padded: dict[str, Any] = {axis: np.pad(samples, (0, count - samples.size)) for axis, samples in surface.items()}
        return replace(record, **padded), "; ".join(notes) if any(one.curve for one in self.layers) else ""
