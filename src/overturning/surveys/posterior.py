"""Posterior probability of motion, strength and rotation for a survey, and its file."""

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.errors import ResultError
from overturning.files import atomic_write
from overturning.units import CM, STANDARD_GRAVITY

MOTION_ROTATION_STEP_DEG: Final = 10
"""Step of the rotation of each motion, degrees."""

MOTION_ROTATION_COUNT: Final = 360 // MOTION_ROTATION_STEP_DEG

CREDIBLE_INTERVAL_PROBABILITY: Final = 0.9
"""Probability of the credible intervals."""

CREDIBLE_ARC_WIDTH_OF_RANDOM_AXIS_DEG: Final = 180.0 * CREDIBLE_INTERVAL_PROBABILITY
"""Width of an arc that contains a random axis with probability `CREDIBLE_INTERVAL_PROBABILITY`, degrees.

A survey in which every stone fell does not constrain the axis: in simulated surveys of this kind, arcs with a mean
width of 71 % of 180° contained the true axis in 73 % of cases, like random arcs
(`verification/backwards_coverage.py`).
"""

_STORED_VARIABLE_AND_DIMENSIONS_BY_ATTRIBUTE: Final = {
    "pgv_levels_m_s": ("level", ("level",)), "clockwise_rotations_deg": ("turn", ("turn",)),
    "posterior_probability": ("probability", ("source", "level", "turn")),
    "prior_probability": ("prior", ("source", "level", "turn")), "pga_m_s2_at_pgv_1_m_s": ("pga", ("source",)),
    "unrotated_peak_velocity_azimuth_deg": ("axis", ("source",)),
}  # fmt: skip
"""Attributes of a `MotionPosterior` that are stored in its file, each with its variable there and its dimensions."""

_STORED_NAME_BY_SITE_ATTRIBUTE: Final = {"fell": "fell", "stood": "stood", "goodness_of_fit_p_value": "fit"}
"""Attributes of the result for one site that are stored in the file of the survey, each with its name there."""


@dataclass(frozen=True)
class MotionPosterior:
    """Posterior and prior probabilities of candidate motions, each at several peak velocities and rotations.

    In the shapes below, s is the number of motions, l of peak-velocity levels, and r of rotations.

    Attributes
    ----------
    motion_names : tuple of str
        Names of the motions.
    pgv_levels_m_s : ndarray, shape (l,)
        Peak velocities to which motions are scaled, m/s (maximum over all azimuths).
    clockwise_rotations_deg : ndarray, shape (r,)
        Clockwise rotations of the motions, degrees.
    posterior_probability, prior_probability : ndarray, shape (s, l, r)
        Posterior and prior; each sums to 1.
    pga_m_s2_at_pgv_1_m_s : ndarray, shape (s,)
        PGA of each motion scaled to a peak velocity of 1 m/s, m/s².
    unrotated_peak_velocity_azimuth_deg : ndarray, shape (s,)
        Azimuth of the largest velocity of each unrotated motion, degrees.
    """

    motion_names: tuple[str, ...]
    pgv_levels_m_s: FloatArray
    clockwise_rotations_deg: FloatArray
    posterior_probability: FloatArray
    prior_probability: FloatArray
    pga_m_s2_at_pgv_1_m_s: FloatArray
    unrotated_peak_velocity_azimuth_deg: FloatArray

    @property
    def pgv_by_motion_and_level(self) -> FloatArray:
        """Peak velocity (m/s) to which each candidate motion is scaled, for each level, shape (motions, levels)."""
        return np.broadcast_to(self.pgv_levels_m_s, self.posterior_probability.shape[:2])

    def probabilities_of_lowest_and_highest_pgv(self) -> tuple[float, float]:
        """Return the posterior probabilities of the lowest and the highest peak velocity that were considered."""
        weight = self.posterior_probability.sum(axis=(0, 2))
        return float(weight[0]), float(weight[-1])

    def credible_interval(
        self, intensity_by_motion_and_velocity_level: ArrayLike, *, uses_prior_instead_of_posterior: bool = False
    ) -> tuple[float, float]:
        """Return the credible interval (`CREDIBLE_INTERVAL_PROBABILITY`) of an intensity of the motion, such as PGV.

        The two tails outside the interval have equal probability. The intensity increases with the velocity level.

        Parameters
        ----------
        intensity_by_motion_and_velocity_level : array_like, shape (s, l)
            The intensity for each of s motions and l peak-velocity levels, positive.
        uses_prior_instead_of_posterior : bool
            Take the prior probabilities instead of the posterior ones.

        Returns
        -------
        (float, float)
            Ends of the interval; the distribution function is interpolated linearly in the logarithm of the intensity.
            If the lowest (highest) level has more posterior probability than one tail, the levels do not cover the
            posterior, and the lower (upper) end is 0 (infinite). The ends for the prior are always finite.
        """
        weight = (
            (self.prior_probability if uses_prior_instead_of_posterior else self.posterior_probability)
            .sum(axis=2)
            .ravel()
        )
        logs = np.log(np.asarray(intensity_by_motion_and_velocity_level, dtype=np.float64)).ravel()
        distinct, place = np.unique(logs.round(12), return_inverse=True)
        mass = np.bincount(place.ravel(), weight)
        # Each value represents the cell that reaches half way to its neighbours.
        middle = (distinct[1:] + distinct[:-1]) / 2
        edges = np.concatenate([[2 * distinct[0] - middle[0]], middle, [2 * distinct[-1] - middle[-1]]])
        below, tail = np.concatenate([[0.0], np.cumsum(mass)]), (1 - CREDIBLE_INTERVAL_PROBABILITY) / 2
        low, high = np.exp(np.interp([tail, 1 - tail], below / below[-1], edges))
        weakest, strongest = (
            (0.0, 0.0) if uses_prior_instead_of_posterior else self.probabilities_of_lowest_and_highest_pgv()
        )
        return 0.0 if weakest > tail else float(low), math.inf if strongest > tail else float(high)

    def posterior_probability_of_each_motion(self) -> FloatArray:
        """Return the posterior probability of each candidate motion, for all velocities and rotations together.

        The shape is (motions,).
        """
        return np.asarray(self.posterior_probability.sum(axis=(1, 2)))

    def posterior_probabilities_of_velocity_axis(self) -> FloatArray:
        """Return the posterior probability of each axis along which the velocity of the motion can be largest.

        The axes have azimuths from 0° to below 180° in steps of `MOTION_ROTATION_STEP_DEG`.
        """
        place, weight = (
            (self.unrotated_peak_velocity_azimuth_deg[:, None] + self.clockwise_rotations_deg)
            / MOTION_ROTATION_STEP_DEG,
            self.posterior_probability.sum(axis=1),
        )
        below, count = np.floor(place).astype(np.intp), 180 // MOTION_ROTATION_STEP_DEG
        # An axis between two steps is divided linearly between both.
        parts = ((below, 1 - (place - below)), (below + 1, place - below))
        shares = [np.bincount((at % count).ravel(), (part * weight).ravel(), count) for at, part in parts]
        return np.asarray(shares[0] + shares[1])

    def credible_axis_arc_middle_and_width_deg(self, *, all_stones_of_survey_fell: bool = False) -> tuple[float, float]:
        """Return middle (0 to 180°) and width, degrees, of the credible arc for the axis of largest velocity.

        The credible arc is the shortest arc with probability `CREDIBLE_INTERVAL_PROBABILITY`, widened to
        `CREDIBLE_ARC_WIDTH_OF_RANDOM_AXIS_DEG` if every stone of the survey fell (`all_stones_of_survey_fell`).
        """
        middle, width = self._shortest_credible_axis_arc_middle_and_width_deg()
        return middle, max(width, CREDIBLE_ARC_WIDTH_OF_RANDOM_AXIS_DEG) if all_stones_of_survey_fell else width

    def _shortest_credible_axis_arc_middle_and_width_deg(self) -> tuple[float, float]:
        """Return middle and width, degrees, of the shortest arc that holds the axis of largest velocity.

        The probability that the arc holds the axis is at least `CREDIBLE_INTERVAL_PROBABILITY`.
        """
        share = self.posterior_probabilities_of_velocity_axis()
        total = np.concatenate([[0.0], np.cumsum(np.tile(share, 2))])
        for bins in range(1, share.size + 1):
            held = total[bins : bins + share.size] - total[: share.size]
            if held.max() >= CREDIBLE_INTERVAL_PROBABILITY * share.sum() - 1e-12:
                middle = MOTION_ROTATION_STEP_DEG * (int(held.argmax()) + (bins - 1) / 2)
                return middle % 180, float(MOTION_ROTATION_STEP_DEG * bins)
        return math.nan, 180.0


@dataclass(frozen=True)
class SurveyInversionResult:
    """Result of inferring the motion from a survey: posterior, p-value of fit, and numbers of stones.

    Attributes
    ----------
    survey_or_site_name : str
        Name of the survey file; in the result of a site, name of the site.
    fell, stood : int
        Number of stones.
    assumed_fixed_stone_share : float
        Assumed share of stones that are fixed to their base, so that no motion overturns them.
    goodness_of_fit_p_value : float
        p-value of the check of fit, see `SurveyInversion.posterior_predictive_p_value`.
    posterior : MotionPosterior
        Posterior of the motion, of the peak velocity to which it is scaled, and of its rotation about the vertical.
    site_results : tuple of SurveyInversionResult
        Results for the stones of each site by itself, whose names are those of the sites; empty for one site.
    """

    survey_or_site_name: str
    fell: int
    stood: int
    assumed_fixed_stone_share: float
    goodness_of_fit_p_value: float
    posterior: MotionPosterior
    site_results: tuple["SurveyInversionResult", ...] = ()

    @property
    def everything_fell(self) -> bool:
        """True if stones of the survey fell, and none of the stones that statistics count stands."""
        return self.fell > 0 and self.stood == 0

    @property
    def credible_axis_arc_middle_and_width_deg(self) -> tuple[float, float]:
        """Middle and width, degrees, of the credible arc for the axis of the motion's largest velocity.

        See `MotionPosterior.credible_axis_arc_middle_and_width_deg`.
        """
        return self.posterior.credible_axis_arc_middle_and_width_deg(all_stones_of_survey_fell=self.everything_fell)

    @property
    def pgv_and_pga_by_motion_and_level(self) -> dict[str, FloatArray]:
        """PGV (cm/s) and PGA (g), by name, of each candidate motion scaled to each level, shape (motions, levels).

        Both are the largest over all azimuths.
        """
        pgv = self.posterior.pgv_by_motion_and_level
        return {"PGV, cm/s": pgv / CM, "PGA, g": self.posterior.pga_m_s2_at_pgv_1_m_s[:, None] * pgv / STANDARD_GRAVITY}


def write_inversion_result(inversion_result: SurveyInversionResult, path: Path) -> None:
    """Write the motion that was inferred from a survey, with its probabilities, to a NetCDF file."""
    variables = {
        name: (dims, getattr(inversion_result.posterior, attribute))
        for attribute, (name, dims) in _STORED_VARIABLE_AND_DIMENSIONS_BY_ATTRIBUTE.items()
    }
    coordinates = {"source": list(inversion_result.posterior.motion_names)}
    if sites := inversion_result.site_results:
        coordinates["site"] = [one.survey_or_site_name for one in sites]
        probability = np.stack([one.posterior.posterior_probability for one in sites])
        variables["site_probability"] = (("site", "source", "level", "turn"), probability)
        variables |= {
            f"site_{name}": (("site",), [getattr(one, attribute) for one in sites])
            for attribute, name in _STORED_NAME_BY_SITE_ATTRIBUTE.items()
        }
    table = xr.Dataset(
        variables,
        coordinates,
        {
            "survey": inversion_result.survey_or_site_name,
            "fell": inversion_result.fell,
            "stood": inversion_result.stood,
            "fixed": inversion_result.assumed_fixed_stone_share,
            "fit": inversion_result.goodness_of_fit_p_value,
        },
    )
    with atomic_write(path) as part:
        table.to_netcdf(part, engine="netcdf4")


def read_inversion_result(path: Path) -> SurveyInversionResult:
    """Read the motion that was inferred from a survey; raise a ResultError if the file cannot be read."""
    try:
        with xr.open_dataset(path, engine="netcdf4") as stored:
            table = stored.load()
        sources, about = tuple(str(name) for name in table["source"].to_numpy()), table.attrs
        posterior = MotionPosterior(
            sources,
            **{
                attribute: np.asarray(table[name])
                for attribute, (name, _) in _STORED_VARIABLE_AND_DIMENSIONS_BY_ATTRIBUTE.items()
            },
        )
        numbers = (int(about["fell"]), int(about["stood"]), float(about["fixed"]), float(about["fit"]))
        return SurveyInversionResult(
            str(about["survey"]), *numbers, posterior, _site_results_from_stored_dataset(table, posterior)
        )
    except (OSError, ValueError, KeyError) as error:
        raise ResultError(f"{path}: cannot be read ({error}); run the study again") from None


def _site_results_from_stored_dataset(
    stored_inversion_result: xr.Dataset, whole_survey_posterior: MotionPosterior
) -> tuple[SurveyInversionResult, ...]:
    """Return the inversion results of the single sites from the dataset stored for a survey; empty for one site."""
    if "site" not in stored_inversion_result:
        return ()
    fixed = float(stored_inversion_result.attrs["fixed"])
    columns = [
        stored_inversion_result["site"].to_numpy().tolist(),
        *(stored_inversion_result[f"site_{name}"].to_numpy() for name in _STORED_NAME_BY_SITE_ATTRIBUTE.values()),
    ]
    return tuple(
        SurveyInversionResult(
            str(name),
            int(fell),
            int(stood),
            fixed,
            float(fit),
            replace(whole_survey_posterior, posterior_probability=probability),
        )
        for name, fell, stood, fit, probability in zip(
            *columns, stored_inversion_result["site_probability"].to_numpy(), strict=True
        )
    )
