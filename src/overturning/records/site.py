"""The ground of a study: soil layers over rock, through which its records go to the surface."""

from dataclasses import replace
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from overturning.errors import RecordError
from overturning.records.record import Record


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Rock(_Part):
    """The half-space below the soil."""

    velocity_m_s: float = Field(gt=0, le=1e4, description="Shear-wave velocity, m/s.")
    density_kg_m3: float = Field(default=2200, ge=100, le=1e4, description="Density, kg/m³.")
    damping: float = Field(default=0.01, ge=0, lt=0.5, description="Damping ratio.")


class Layer(_Part):
    """A layer of soil."""

    thickness_m: float = Field(gt=0, le=1e4, description="Thickness, m.")
    velocity_m_s: float = Field(gt=0, le=1e4, description="Shear-wave velocity, m/s.")
    density_kg_m3: float = Field(default=1800, ge=100, le=1e4, description="Density, kg/m³.")
    damping: float = Field(
        default=0.05,
        ge=0,
        lt=0.5,
        description="Damping ratio; beside a curve, which has its own, it counts for nothing.",
    )
    curve: str | None = Field(
        default=None, description="Published modulus-reduction curve, by pystrata's name; none: the layer is linear."
    )


class Site(_Part):
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
        from overturning.motion.soil import TAIL, Soil, through_soil

        tail = (0, round(TAIL / record.sampling_interval))
        layers = [
            Soil(one.thickness_m, one.velocity_m_s, one.density_kg_m3, one.damping, one.curve) for one in self.layers
        ]
        layers.append(Soil(0, self.rock.velocity_m_s, self.rock.density_kg_m3, self.rock.damping))
        surface: dict[str, Any] = {}
        notes = []
        for axis, samples in (("north", record.north), ("east", record.east)):
            passed = through_soil(samples, record.sampling_interval, layers, outcrop=self.motion == "outcrop")
            state = "converged" if passed.converged else f"not converged (last change {100 * passed.change:.1f} %)"
            notes.append(f"{axis} {state}, strain {100 * passed.largest_strain:.2g} %")
            surface[axis] = passed.samples
        up = None if record.up is None else np.pad(record.up, tail)
        return replace(record, up=up, **surface), "; ".join(notes) if any(one.curve for one in self.layers) else ""
