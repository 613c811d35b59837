"""Base class of findings, numbers that JSON can hold, and estimates with their intervals."""

import math
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, PlainSerializer

from overturning.statistics.bootstrap import Mean


def _known(value: Any) -> Any:
    """Return None for a number that is not known (NaN), and plain numbers for those of NumPy."""
    value = value.item() if hasattr(value, "item") else value
    return None if isinstance(value, float) and math.isnan(value) else value


def _finite(value: float | None) -> float | str | None:
    """Return a number as JSON can hold it: infinity as text."""
    return f"{value}" if value is not None and math.isinf(value) else value


Number = Annotated[float | None, BeforeValidator(_known), PlainSerializer(_finite, when_used="json")]
"""A number; None (null in JSON) if it is not known, the text "inf" in JSON if it lies above the range of the data."""


class Finding(BaseModel):
    """Part of the findings of a study: numbers and names, without sentences."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Estimate(Finding):
    """An estimate with its interval over earthquakes."""

    statistic: str
    """Quantity that is estimated."""
    value: Number
    """Estimate; None if it is not defined."""
    low: Number
    """Lower end of the interval; None if there are too few earthquakes for an interval."""
    high: Number
    """Upper end of the interval; None if there are too few earthquakes for an interval."""
    level: float = 0.95
    """Probability of the interval."""
    earthquakes: int
    """Number of earthquakes with a value."""
    unit: str = "1"

    @property
    def excludes_zero(self) -> bool:
        """True if there is an interval and 0 lies outside."""
        return self.low is not None and self.high is not None and (self.low > 0 or self.high < 0)


def estimate(mean: Mean, statistic: str, unit: str = "1") -> Estimate:
    """Return the estimate of a mean over earthquakes."""
    return Estimate(statistic=statistic, value=mean.value, low=mean.low, high=mean.high, earthquakes=mean.n, unit=unit)
