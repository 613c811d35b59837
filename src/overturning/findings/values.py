"""Base class of findings, numbers that JSON can hold, and estimates with their intervals."""

import math
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, PlainSerializer

from overturning.statistics.bootstrap import MeanOverEarthquakes


def _convert_to_python_number_or_none(field_value: Any) -> Any:
    """Convert NaN to None, the texts "inf" and "-inf" to numbers, and a NumPy scalar to a Python number."""
    field_value = field_value.item() if hasattr(field_value, "item") else field_value
    field_value = float(field_value) if field_value in ("inf", "-inf") else field_value
    return None if isinstance(field_value, float) and math.isnan(field_value) else field_value


def _infinity_to_text(number_or_none: float | None) -> float | str | None:
    """Convert an infinite number to "inf" or "-inf", since JSON has no infinity."""
    return f"{number_or_none}" if number_or_none is not None and math.isinf(number_or_none) else number_or_none


OptionalNumberOrInfinity = Annotated[
    float | None,
    BeforeValidator(_convert_to_python_number_or_none),
    PlainSerializer(_infinity_to_text, when_used="json"),
]
"""A number; None (null in JSON) if it is not known, the text "inf" in JSON if it lies above the range of the data."""


class FindingBaseClass(BaseModel):
    """Base class of a report's findings: immutable groups of numbers and names, without sentences."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)


class Estimate(FindingBaseClass):
    """Estimate of a statistic, with its confidence interval over earthquakes and its unit."""

    statistic: str
    """Quantity that is estimated."""
    value: OptionalNumberOrInfinity
    """Estimate; None if it is not defined."""
    low: OptionalNumberOrInfinity
    """Lower end of the interval; None if there are too few earthquakes for an interval."""
    high: OptionalNumberOrInfinity
    """Upper end of the interval; None if there are too few earthquakes for an interval."""
    level: float = 0.95
    """Probability of the interval."""
    earthquake_count: int
    """Number of earthquakes with a value."""
    unit: str = "1"
    """Unit; "1" for a pure number."""

    @property
    def excludes_zero(self) -> bool:
        """True if the confidence interval of the estimate is known and does not include 0."""
        return self.low is not None and self.high is not None and (self.low > 0 or self.high < 0)


def negate_estimate(estimate: Estimate) -> Estimate:
    """Multiply an estimate by −1; the ends of its interval are swapped accordingly."""
    value, low, high = (None if one is None else -one for one in (estimate.value, estimate.low, estimate.high))
    return estimate.model_copy(update={"value": value, "low": high, "high": low})


def estimate_from_mean(mean: MeanOverEarthquakes, statistic_description: str, statistic_unit: str = "1") -> Estimate:
    """Convert a mean over earthquakes to an `Estimate`, named by the quantity in `statistic_description`."""
    return Estimate(
        statistic=statistic_description,
        value=mean.mean,
        low=mean.interval_low,
        high=mean.interval_high,
        earthquake_count=mean.earthquake_count,
        unit=statistic_unit,
    )
