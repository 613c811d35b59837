"""Processing steps as data: what a config may ask for, each with its parameters and bounds."""

from typing import Annotated, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator


class _Step(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class RemoveMean(_Step):
    """Subtract the mean: of the pre-event part where its length is given, else of the whole record."""

    step: Literal["remove_mean"] = "remove_mean"
    first_s: float | None = Field(
        default=None, gt=0, description="Length of the pre-event part, s; none: the whole record."
    )


class Detrend(_Step):
    """Subtract the least-squares polynomial of the whole record."""

    step: Literal["detrend"] = "detrend"
    order: int = Field(default=1, ge=0, le=5, description="Order of the polynomial; 1 is a line.")


class Taper(_Step):
    """Multiply both ends by half a cosine bell."""

    step: Literal["taper"] = "taper"
    length_s: float = Field(gt=0, description="Length of the bell at each end, s.")


Positive = Annotated[float, Field(gt=0)]


class Filter(_Step):
    """Butterworth filter, forward and backward (zero phase)."""

    step: Literal["highpass", "lowpass"]  # here for its place among the keys
    corner_hz: Positive | Literal["auto"] = Field(
        description="Corner frequency; the amplitude there is halved by the two passes. "
        "A high-pass filter takes `auto` too."
    )
    order: int = Field(default=2, ge=1, le=8, description="Order of each of the two passes.")


class Highpass(Filter):
    """Butterworth high-pass filter, forward and backward (zero phase).

    Zeros are put before and behind the record, 1.5 n/f_c seconds each, and stay: the filter acts there too, and without
    them the velocity would drift. The record's start moves accordingly. With the corner ``auto`` it is where the signal
    rises above the noise before the onset (`overturning.records.processing`).
    """

    step: Literal["highpass"] = "highpass"


class Lowpass(Filter):
    """Butterworth low-pass filter, forward and backward (zero phase); the record keeps its length."""

    step: Literal["lowpass"] = "lowpass"
    corner_hz: Positive = Field(description="Corner frequency; the amplitude there is halved by the two passes.")


class Baseline(_Step):
    """Baseline correction by the named published scheme.

    ``boore-2001``: Boore (2001, BSSA 91, 1199-1211) after Iwan et al. (1985): a line v = v0 + a_f t is fitted to the
    end of the velocity; a_f is subtracted after t2, and the mean offset that leads to that line between t1 and t2.
    Without t2 it is the time at which the fitted line is zero, and one step is subtracted from there on (Boore's v0
    correction).
    """

    step: Literal["baseline"] = "baseline"
    scheme: Literal["boore-2001"] = Field(default="boore-2001", description="Name of the scheme.")
    fit_from_s: float = Field(gt=0, description="Where the fit to the end of the velocity begins, s.")
    t1_s: float | None = Field(default=None, ge=0, description="Where the offset of the strong motion begins, s.")
    t2_s: float | None = Field(default=None, gt=0, description="Where it ends, s; none: where the fitted line is zero.")

    @model_validator(mode="after")
    def _ordered(self) -> "Baseline":
        if (self.t1_s is None) != (self.t2_s is None):
            raise ValueError("t1_s and t2_s: give both or neither")
        if self.t1_s is not None and self.t2_s is not None and not self.t1_s < self.t2_s <= self.fit_from_s:
            raise ValueError("t1_s, t2_s, fit_from_s must ascend")
        return self


class Resample(_Step):
    """Band-limited resampling (polyphase FIR); the ratio of the intervals must be a fraction of small whole numbers."""

    step: Literal["resample"] = "resample"
    sampling_interval_s: float = Field(gt=0, le=1, description="New time between samples, s.")


class Cut(_Step):
    """Keep the samples from start to end."""

    step: Literal["cut"] = "cut"
    start_s: float = Field(default=0.0, ge=0, description="First sample kept, s after the record's start.")
    end_s: float | None = Field(default=None, gt=0, description="Last sample kept, s; none: to the end.")

    @model_validator(mode="after")
    def _ordered(self) -> "Cut":
        if self.end_s is not None and self.end_s <= self.start_s:
            raise ValueError(f"end_s {self.end_s:g} must lie after start_s {self.start_s:g}")
        return self


class Scale(_Step):
    """Multiply every sample by a factor."""

    step: Literal["scale"] = "scale"
    factor: float = Field(gt=0, description="Factor, without unit.")


class Rock(_Step):
    """The half-space below the soil."""

    velocity_m_s: float = Field(gt=0, le=1e4, description="Shear-wave velocity, m/s.")
    density_kg_m3: float = Field(default=2200, gt=0, le=1e4, description="Density, kg/m³.")
    damping: float = Field(default=0.01, ge=0, lt=0.5, description="Damping ratio.")


class Layer(_Step):
    """A layer of soil."""

    thickness_m: float = Field(gt=0, le=1e4, description="Thickness, m.")
    velocity_m_s: float = Field(gt=0, le=1e4, description="Shear-wave velocity, m/s.")
    density_kg_m3: float = Field(default=1800, gt=0, le=1e4, description="Density, kg/m³.")
    damping: float = Field(default=0.05, ge=0, lt=0.5, description="Damping ratio; a curve has its own.")
    curve: str | None = Field(
        default=None, description="Published modulus-reduction curve, by pystrata's name; none: the layer is linear."
    )


class Site(_Step):
    """The ground of a study: takes the horizontal motion from rock through soil layers to the surface, after all steps.

    Needs pystrata (group `soil`). Linear, or equivalent-linear where a layer has a curve. The vertical motion is left
    as it is (`overturning.motion.soil`).
    """

    step: ClassVar[str] = "site"  # in the account of what was done to a record
    layers: tuple[Layer, ...] = Field(min_length=1, description="Layers from the surface down.")
    rock: Rock = Field(description="The half-space below them.")
    motion: Literal["outcrop", "within"] = Field(
        default="outcrop", description="Whether the record is of outcropping rock or of the rock below the layers."
    )


Step = Annotated[
    RemoveMean | Detrend | Taper | Highpass | Lowpass | Baseline | Resample | Cut | Scale,
    Field(discriminator="step"),
]
"""Any of the steps, told apart by the key ``step``."""
