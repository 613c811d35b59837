"""Predict the falls of the stones of a survey from the cube of its site."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.model.edges import fall_probability_over_each_edge
from overturning.model.planes import fall_probabilities_towards_and_away
from overturning.model.symmetry import FULL_TURN_DEG, nearest_simulated_directions
from overturning.statistics.circular import sector_index
from overturning.statistics.opposite_azimuths import (
    cube_with_opposite_azimuths,
    fall_count_or_probability_by_fall_azimuth,
)
from overturning.surveys.sectors import AzimuthSectors
from overturning.surveys.stones import MAX_FACTOR_OUTSIDE_SIMULATED_RANGE, RANDOM_OUTCOME_SHARE, Stone

STANDING_OR_FALL_SIDES = ("stood", "forwards", "to its right", "backwards", "to its left")
"""Outcomes of a stone with known face: falls towards the azimuth of the face, then clockwise in steps of 90°."""


class SiteFallPrediction(AzimuthSectors):
    """Prediction of whether and in which directions stones at a site fall, from simulations with its record.

    Parameters
    ----------
    cube_of_one_record : Dataset
        Results cube of one record. Its heights and frictions have equal weight, as have its B/H for a stone whose B/H
        is unknown.
    random_outcome_stone_share : float
        See `RANDOM_OUTCOME_SHARE`.

    Raises
    ------
    ArgumentError
        If the cube has several records or is from the 3-D model, or the share is not from 0 to below 1.
    """

    def __init__(
        self, cube_of_one_record: xr.Dataset, *, random_outcome_stone_share: float = RANDOM_OUTCOME_SHARE
    ) -> None:
        if cube_of_one_record.sizes.get("record", 1) != 1:
            raise ArgumentError(
                f"cube: {cube_of_one_record.sizes['record']} records; a survey belongs to one site, so name its record "
                "(--record)"
            )
        if not 0 <= random_outcome_stone_share < 1:
            raise ArgumentError(f"background: {random_outcome_stone_share}; a share from 0 to below 1")
        if "azimuth" not in cube_of_one_record.dims:
            raise ArgumentError(
                "cube: of 3-D bodies, next to one of a 2-D study; give --cube and each --site-cube of one kind"
            )
        site = cube_of_one_record.isel(record=0) if "record" in cube_of_one_record.dims else cube_of_one_record
        dims = ("azimuth", "b_over_h", "height", "friction")
        self.random_outcome_stone_share = random_outcome_stone_share
        self.b_over_h: FloatArray = site["b_over_h"].values.astype(np.float64)
        self.height: FloatArray = site["height"].values.astype(np.float64)
        super().__init__(fall_count_or_probability_by_fall_azimuth(site)["azimuth"].values.astype(np.float64))
        self._sector_probabilities_by_b_over_h_key: dict[str, FloatArray] = {}
        self._b_over_h_keys_without_falls: set[str] = set()
        self._fall_probabilities: dict[str, FloatArray] = {}
        self._side_probabilities: dict[tuple[bytes, tuple[float, float]], FloatArray] = {}
        # Probability of falling towards and away from the azimuth of each plane, and time of the fall, for each block
        # (height and friction); NaN if unknown.
        site = cube_with_opposite_azimuths(site)
        p = fall_probabilities_towards_and_away(site).transpose(*dims)
        self.plane_azimuths_deg: FloatArray = p["azimuth"].values.astype(np.float64)
        # For interpolation round the circle: planes in ascending order between the last one and the first one.
        ascending = np.argsort(self.plane_azimuths_deg % 360.0)
        self._plane_order = np.concatenate([ascending[-1:], ascending, ascending[:1]])
        self._plane_ends = self.plane_azimuths_deg[self._plane_order] % 360.0
        self._plane_ends[[0, -1]] += -360.0, 360.0
        times = site["overturning_time"].transpose(*dims) if "overturning_time" in site else p["towards"] * math.nan
        blocks = [
            one.values.reshape(self.plane_azimuths_deg.size, self.b_over_h.size, -1)
            for one in (p["towards"], p["away"], times)
        ]
        self.fall_probabilities: FloatArray = np.stack(blocks[:2], axis=-2).astype(np.float64)
        self.fall_times_s: FloatArray = blocks[2].astype(np.float64)

    def _interpolate_falls_towards_azimuths_and_opposites(
        self, fall_azimuths_deg: FloatArray, stone_b_over_h: float
    ) -> tuple[FloatArray, FloatArray]:
        """Interpolate probabilities of falls towards n azimuths and their opposites; return them and the fall times, s.

        The probabilities have the shape (2, blocks, n), the times (blocks, n); a block is a height and friction of the
        cube. Times are those of the nearest azimuth and B/H. Far outside the simulated range of B/H the probabilities
        are NaN, unless the stone is stouter than the stoutest block and this block never falls.
        """
        place = float(np.interp(stone_b_over_h, self.b_over_h, np.arange(self.b_over_h.size)))
        # A B/H of the grid has its own outcomes, also next to a B/H without outcomes.
        low, high = math.floor(round(place, 9)), math.ceil(round(place, 9))
        by_azimuth = self.fall_probabilities[:, low] + (place - low) * (
            self.fall_probabilities[:, high] - self.fall_probabilities[:, low]
        )
        lines = by_azimuth.reshape(self.plane_azimuths_deg.size, -1).T[:, self._plane_order]
        p = np.array([np.interp(fall_azimuths_deg % 360.0, self._plane_ends, line) for line in lines])
        p = p.reshape(*by_azimuth.shape[1:], -1)
        if stone_b_over_h > MAX_FACTOR_OUTSIDE_SIMULATED_RANGE * self.b_over_h[-1]:
            p = np.where(p.sum(axis=0) == 0, p, math.nan)
        elif MAX_FACTOR_OUTSIDE_SIMULATED_RANGE * stone_b_over_h < self.b_over_h[0]:
            p = np.full(p.shape, math.nan)
        cell = nearest_simulated_directions(
            self.plane_azimuths_deg, fall_azimuths_deg, FULL_TURN_DEG
        ).simulated_direction_index
        return p, self.fall_times_s[cell, round(place)].T

    def has_b_over_h_outside_grid(self, stone: Stone) -> bool:
        """True if a B/H of a stone lies outside the simulated range."""
        least, most = self.b_over_h[[0, -1]].tolist()
        return min(stone.b_over_h_in_both_planes) < least - 1e-9 or max(stone.b_over_h_in_both_planes) > most + 1e-9

    def has_b_over_h_far_outside_grid(self, stone: Stone) -> bool:
        """True if a stone's B/H lies so far outside the simulated range that its fall is not predicted."""
        return self.has_b_over_h_outside_grid(stone) and bool(
            np.isnan(self.simulated_fall_probability_by_height_and_friction(stone)).all()
        )

    def sector_probabilities_given_fall_for_unknown_face(
        self, b_over_h_in_plane_of_face_normal: float = math.nan, b_over_h_in_perpendicular_plane: float = math.nan
    ) -> FloatArray:
        """Return the probabilities that a stone of unknown orientation, if it falls, falls into each azimuth sector.

        The shape is (sectors,), and the sum is 1. The probabilities are means of `standing_and_side_probabilities` over
        all face azimuths. Without ``b_over_h_in_plane_of_face_normal`` all B/H of the cube have equal weight, and
        without ``b_over_h_in_perpendicular_plane`` the footprint is square.
        """
        of = _b_over_h_cache_key(b_over_h_in_plane_of_face_normal, b_over_h_in_perpendicular_plane)
        if of in self._sector_probabilities_by_b_over_h_key:
            return self._sector_probabilities_by_b_over_h_key[of]
        shapes = [
            (
                b_over_h_in_plane_of_face_normal,
                b_over_h_in_plane_of_face_normal
                if math.isnan(b_over_h_in_perpendicular_plane)
                else b_over_h_in_perpendicular_plane,
            )
        ]
        if math.isnan(b_over_h_in_plane_of_face_normal):
            shapes = [(one, one) for one in self.b_over_h.tolist()]
        # A fall towards an azimuth is a fall forwards, to the right, backwards or to the left, by face azimuth.
        falls = [
            np.sum(
                [
                    self._simulated_standing_and_side_probabilities(self.azimuth - 90.0 * turn, shape)[1 + turn]
                    for turn in range(4)
                ],
                axis=0,
            )
            for shape in shapes
        ]
        known = np.isfinite(falls)
        values = np.where(known, falls, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
        # An azimuth with unknown outcomes gets the mean of the others, not 0.
        directed = known.any(axis=0)
        values[~directed] = values[directed].mean() if directed.any() else 0.0
        mass = values * self.share
        total = mass.sum()
        if directed.any() and not total > 0:
            self._b_over_h_keys_without_falls.add(of)
        model = mass / total if total > 0 else self.share
        found = np.asarray((1 - self.random_outcome_stone_share) * model + self.random_outcome_stone_share * self.share)
        self._sector_probabilities_by_b_over_h_key[of] = found
        return found

    def no_simulated_block_like_stone_falls(self, stone: Stone) -> bool:
        """True if no simulated block with the stone's B/H (and face azimuth, if known) falls.

        The cube then predicts no direction of its fall.
        """
        if has_known_face_and_at_least_one_b_over_h(stone):
            return bool(
                (
                    self._simulated_standing_and_side_probabilities(
                        np.array([stone.face_azimuth_deg]), stone.b_over_h_in_both_planes
                    )[1:, 0]
                    == 0
                ).all()
            )
        self.sector_probabilities_given_fall_for_unknown_face(*stone.b_over_h_in_both_planes)
        return _b_over_h_cache_key(*stone.b_over_h_in_both_planes) in self._b_over_h_keys_without_falls

    def standing_and_side_probabilities(self, stone: Stone) -> FloatArray:
        """Return the probabilities that a stone with known face azimuth and B/H stands or falls to each side.

        The five probabilities, in the order of `STANDING_OR_FALL_SIDES`, sum to 1.

        A rectangular stone falls over one of its edges. The falls in the two vertical planes normal to its faces
        are computed separately, each with the B/H in its plane, for each height and friction of the cube. Falls in
        the two planes are taken as independent; where the stone would fall in both planes,
        `fall_probability_over_each_edge` divides the probability between the two edges. Rolling on a corner is left
        out: only the 3-D model has it (Contento, Zulli & Di Egidio 2013, doi 10.5772/54863).
        """
        blind = np.concatenate([[0.5], np.full(4, 0.125)])
        model = self._simulated_standing_and_side_probabilities(
            np.array([stone.face_azimuth_deg]), stone.b_over_h_in_both_planes
        )[:, 0]
        if not np.isfinite(model).all():
            return blind
        return np.asarray((1 - self.random_outcome_stone_share) * model + self.random_outcome_stone_share * blind)

    def _simulated_standing_and_side_probabilities(
        self, face_azimuths_deg: FloatArray, b_over_h_in_both_planes: tuple[float, float]
    ) -> FloatArray:
        """Return probabilities of standing and of a fall to each side, shape (5, face azimuths).

        The probabilities are means over heights and frictions of the cube, without the random outcomes of the share
        `random_outcome_stone_share`; NaN if unknown.
        """
        return _mean_of_known_values(
            self._cached_outcome_probabilities_by_face_azimuth(face_azimuths_deg, b_over_h_in_both_planes),
            averaged_axes=1,
        )

    def _cached_outcome_probabilities_by_face_azimuth(
        self, face_azimuths_deg: FloatArray, b_over_h_in_both_planes: tuple[float, float]
    ) -> FloatArray:
        """Return probabilities of standing and of a fall to each side, by height and friction, shape (5, blocks, n).

        A block is a height and friction of the cube; n is the number of `face_azimuths_deg`. A probability is NaN if
        unknown. Results are kept in memory, since a comparison needs them several times for the same stone.
        """
        key = (face_azimuths_deg.tobytes(), b_over_h_in_both_planes)
        if key not in self._side_probabilities:
            self._side_probabilities[key] = self._compute_standing_and_fall_side_probabilities(
                face_azimuths_deg, b_over_h_in_both_planes
            )
        return self._side_probabilities[key]

    def _compute_standing_and_fall_side_probabilities(
        self, face_azimuths_deg: FloatArray, b_over_h_in_both_planes: tuple[float, float]
    ) -> FloatArray:
        """Compute the probabilities that a stone stands, and that it falls to each of its four sides; NaN if unknown.

        Shape (5, blocks, n): blocks are all combinations of height and friction, n is the number of face azimuths.
        """
        planes = [
            self._interpolate_falls_towards_azimuths_and_opposites(face_azimuths_deg + 90.0 * i, shape)
            for i, shape in enumerate(b_over_h_in_both_planes)
        ]
        p = np.array([probability for probability, _ in planes])
        known = np.isfinite(p).all(axis=(0, 1))
        p = np.where(known, p, 0.0)
        over = fall_probability_over_each_edge(np.minimum(p.sum(axis=1), 1.0), np.array([times for _, times in planes]))
        model = [1 - over.sum(axis=0)]
        for ends, falls in zip(p, over, strict=True):
            both = ends.sum(axis=0)
            model += list(falls * np.divide(ends, both, out=np.full(ends.shape, 0.5), where=both > 0))
        stood, forwards, backwards, right, left = model
        return np.where(known, np.stack([stood, forwards, right, backwards, left]), math.nan)

    def simulated_fall_probability_by_height_and_friction(self, stone: Stone) -> FloatArray:
        """Return the probability that a stone falls, for each simulated height and friction.

        Random outcomes, of the share `random_outcome_stone_share`, are not included.

        For a stone of known height, the probability is interpolated between the heights with an outcome; outside this
        range it is that of the nearest height. A stone without face azimuth has the mean over all face
        azimuths. A stone without B/H has the mean over all B/H of the grid, with a square footprint.

        Returns
        -------
        ndarray, shape (heights, frictions)
            Probability, 0 to 1; NaN if unknown.
        """
        shape, face = stone.b_over_h_in_both_planes, stone.face_azimuth_deg
        key = f"{face} {_b_over_h_cache_key(*shape)}"
        if key not in self._fall_probabilities:
            shapes = [(one, one) for one in self.b_over_h.tolist()] if math.isnan(shape[0]) else [shape]
            faces = np.array([face]) if math.isfinite(face) else self.azimuth
            weight = np.ones(1) if math.isfinite(face) else self.share
            # Shape (blocks, B/H, faces).
            falls = 1.0 - np.stack(
                [self._cached_outcome_probabilities_by_face_azimuth(faces, one)[0] for one in shapes], axis=1
            )
            found = _mean_of_known_values(falls, averaged_axes=(1, 2), weights_along_last_axis=weight)
            self._fall_probabilities[key] = found.reshape(self.height.size, -1)
        found = self._fall_probabilities[key]
        if math.isnan(stone.height_m):
            return found
        at_height = np.full(found.shape[1], math.nan)
        for place, column in enumerate(found.T):
            if (known := np.isfinite(column)).any():
                at_height[place] = np.interp(stone.height_m, self.height[known], column[known])
        return np.asarray(np.broadcast_to(at_height, found.shape))

    def has_known_fall_probability(self, stone: Stone) -> bool:
        """True if the fall probability interpolated to a stone's B/H and face azimuth is known at any height and µ."""
        return bool(np.isfinite(self.simulated_fall_probability_by_height_and_friction(stone)).any())

    def has_height_outside_grid(self, stone: Stone) -> bool:
        """True if the height of a stone is known and lies outside the simulated range."""
        return bool(stone.height_m < self.height[0] - 1e-9 or stone.height_m > self.height[-1] + 1e-9)


class SurveyFallPrediction:
    """Predicted falls of all stones of a survey, whose sites may have different ground motions.

    Parameters
    ----------
    cube : Dataset
        Cube of one record, for the stones of all sites that are not in `results_cube_by_site`.
    results_cube_by_site : mapping of str to Dataset, optional
        Cubes for the stones of single sites, by name of the site: those of the motions at their surfaces.
    random_outcome_stone_share : float
        See `RANDOM_OUTCOME_SHARE`.

    Raises
    ------
    ArgumentError
        As `SiteFallPrediction`, and if the cubes differ in azimuths, B/H or heights.
    """

    def __init__(
        self,
        cube: xr.Dataset,
        results_cube_by_site: Mapping[str, xr.Dataset] | None = None,
        *,
        random_outcome_stone_share: float = RANDOM_OUTCOME_SHARE,
    ) -> None:
        self.default_prediction = SiteFallPrediction(cube, random_outcome_stone_share=random_outcome_stone_share)
        self._prediction_by_site = {
            site: SiteFallPrediction(one, random_outcome_stone_share=random_outcome_stone_share)
            for site, one in (results_cube_by_site or {}).items()
        }
        for site, one in self._prediction_by_site.items():
            for name in ("azimuth", "b_over_h", "height"):
                if not np.array_equal(getattr(one, name), getattr(self.default_prediction, name)):
                    raise ArgumentError(
                        f"site {site!r}: its cube has other values of {name} than the other sites; compute the cubes "
                        "of one survey with one grid"
                    )

    def site_prediction_for_stone(self, stone: Stone) -> SiteFallPrediction:
        """Return the prediction for the survey site at which a stone stands."""
        return self._prediction_by_site.get(stone.site, self.default_prediction)


def _b_over_h_cache_key(b_over_h_in_plane_of_face_normal: float, b_over_h_in_perpendicular_plane: float) -> str:
    """Return a text as dictionary key for two values of B/H, which may be NaN.

    The numbers themselves are no suitable key, since NaN does not equal itself.
    """
    return f"{b_over_h_in_plane_of_face_normal} {b_over_h_in_perpendicular_plane}"


def _mean_of_known_values(
    values_or_nan: FloatArray, averaged_axes: int | tuple[int, ...], weights_along_last_axis: FloatArray | None = None
) -> FloatArray:
    """Return the mean over `averaged_axes`, ignoring NaN, with weights along the last axis (None: equal weights)."""
    known = np.isfinite(values_or_nan)
    weights = known if weights_along_last_axis is None else known * weights_along_last_axis
    with np.errstate(invalid="ignore"):
        return np.asarray(
            (np.where(known, values_or_nan, 0.0) * weights).sum(axis=averaged_axes) / weights.sum(axis=averaged_axes)
        )


def note_on_b_over_h_far_outside_study(
    stones: Sequence[Stone], b_over_h_values_of_study: Sequence[float], survey_name: str
) -> tuple[str, ...]:
    """Return a note if stones of a survey have a B/H far outside those of a 2-D study; () if none has."""
    least, most = min(b_over_h_values_of_study), max(b_over_h_values_of_study)
    low, high = least / MAX_FACTOR_OUTSIDE_SIMULATED_RANGE, MAX_FACTOR_OUTSIDE_SIMULATED_RANGE * most
    far = [
        (stone.stone_count, values)
        for stone in stones
        if (values := [one for one in stone.b_over_h_in_both_planes if one < low or one > high])
    ]
    if not far:
        return ()
    count, values = sum(count for count, _ in far), [one for _, several in far for one in several]
    theirs = f"{min(values):g}" + (f" to {max(values):g}" if max(values) > min(values) else "")
    grid = f"{least:g}" + (f" to {most:g}" if most > least else "")
    return (
        f"{survey_name}: {count} stone{'s' * (count != 1)} with b_over_h or b_over_h_side {theirs}, far outside the "
        f"study's b_over_h, {grid}: without prediction if the nearest blocks fall; add such values to b_over_h",
    )


def has_known_face_and_at_least_one_b_over_h(stone: Stone) -> bool:
    """True if the face azimuth and at least one B/H of a stone are known."""
    return math.isfinite(stone.face_azimuth_deg) and math.isfinite(stone.b_over_h_in_both_planes[0])


def observed_standing_or_side_index(stone: Stone) -> int:
    """Return the index in `STANDING_OR_FALL_SIDES` of a stone's observed outcome: standing, or the side of its fall."""
    return 1 + int(sector_index(stone.fall_azimuth_deg - stone.face_azimuth_deg, 4)) if stone.fell else 0
