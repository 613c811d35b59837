"""Falls by azimuth, shares, mean directions and axes of cubes with known answers; falls of elements."""

import numpy as np
import pytest
import xarray as xr

from overturning.errors import ResultError
from overturning.labels import unsimulated_azimuth_ranges_text
from overturning.model.body import Body
from overturning.model.falls import default_model_of_same_kind_as_results_cube
from overturning.model.plane_weights import (
    MAX_RESULTANT_LENGTH_OF_UNIFORM_PLANE_AZIMUTHS,
    distinct_plane_indices,
    mask_of_azimuths_before_gap_and_grid_step,
    plane_azimuths_alone_impose_fall_axis,
    plane_weights_by_azimuth_spacing,
)
from overturning.model.planes import PlanarModel, fall_probabilities_towards_and_away
from overturning.model.stack import Stack
from overturning.statistics.circular import MIN_RESULTANT_WITH_MEAN_DIRECTION
from overturning.statistics.elements import count_falls_of_each_and_any_element, summarise_element_displacements
from overturning.statistics.falls import (
    BLOCK_SELECTION_RULES_IN_REPORT,
    mask_of_blocks_for_direction_statistics,
    mean_fall_directions_and_axes_over_azimuths,
    mean_fall_probability_over_directions,
    share_of_directions_with_overturning,
)
from overturning.statistics.opposite_azimuths import (
    count_differing_and_all_neighbour_pairs,
    cube_with_opposite_azimuths,
    fall_count_or_probability_by_fall_azimuth,
    overturned_share,
    overturned_shares_by_record,
    overturned_shares_near_and_off_fault_normal,
    overturning_indicator,
)


def dataset_of_fall_flags_by_azimuth(azimuth: list[int], overturned: list[float]) -> xr.Dataset:
    """Return a dataset of fall flags of one block by azimuth, degrees."""
    return xr.Dataset(
        {"overturned": ("azimuth", np.array(overturned))}, coords={"azimuth": np.array(azimuth, np.int16)}
    )


def test_shares_weight_unevenly_spaced_azimuths_by_the_arc_they_represent() -> None:
    """Planes at 0, 20, 40 and 90° stand for the azimuths nearest to them: 55, 20, 35 and 70 of 180°."""
    azimuth = [0, 20, 40, 90, 180, 270]
    flags = np.array([[1, 1, 0, 0, -1, 0], [0, np.nan, 1, 1, 0, -1]], np.float32)
    cube = xr.Dataset(
        {"overturned": (("record", "azimuth"), flags)},
        {"azimuth": np.array(azimuth, np.int16), "fault_normal": ("record", [10.0, np.nan])},
    )
    shares = overturned_shares_by_record(cube)
    assert shares.to_numpy() == pytest.approx([75 / 180, 105 / 160])
    assert float(overturned_share(cube)) == pytest.approx((75 + 105) / (180 + 160))
    # Planes within 45° of the normal 10° are those at 0, 20 and 40°.
    assert overturned_shares_near_and_off_fault_normal(cube) == pytest.approx((75 / 110, 0.0))
    regular = cube.isel(azimuth=[0, 3, 4, 5])
    np.testing.assert_array_equal(overturned_shares_by_record(regular), [0.5, 0.5])


@pytest.mark.parametrize(
    ("azimuth", "flags", "share"),
    [
        ([0, 45, 90, 135, 180], [1, 0, 0, 0, -1], 1 / 4),  # the plane of 0 and 180° once, not 2 of 5
        ([0, 45, 90, 135, 270, 315], [1, 0, 0, 0, 0, 0], 1 / 4),
        ([0, 5, 10, 60, 120], [1, 1, 1, 0, 0], (32.5 + 5 + 27.5) / 180),  # and not 3 of 5
    ],
)
def test_each_plane_counts_once_in_shares_and_in_the_choice_of_blocks(
    azimuth: list[int], flags: list[float], share: float
) -> None:
    """A plane counts once in shares and in the choice of blocks, however many azimuths belong to it.

    One block falls in all planes, the other in at most half of them: only the latter is marginal.
    """
    second = np.where(np.array(azimuth) < 180, 1.0, -1.0)
    cube = xr.Dataset(
        {"overturned": (("azimuth", "b_over_h"), np.stack([flags, second], axis=1))}, coords={"azimuth": azimuth}
    )
    assert float(overturned_share(cube)) == pytest.approx((share + 1) / 2)
    assert overturned_share(cube, "b_over_h").values == pytest.approx([share, 1.0])
    assert mask_of_blocks_for_direction_statistics(cube).values.tolist() == [True, False]
    of_some = BLOCK_SELECTION_RULES_IN_REPORT[3].selected_block_mask(share_of_directions_with_overturning(cube))
    assert of_some.values.tolist() == [True, False], "in some planes, but not in all"


@pytest.mark.parametrize(
    ("azimuth", "flags", "expected"),
    [
        # A block under 30° falls back to 210°; the opposite motion says the same.
        ([30, 120, 210, 300], [-1, 0, 1, 0], {30: 0, 120: 0, 210: 1, 300: 0}),
        # Opposites that the cube does not hold are added.
        ([30, 120], [-1, 1], {30: 0, 120: 1, 210: 1, 300: 0}),
    ],
)
def test_falls_of_opposite_azimuths_are_counted_once(azimuth, flags, expected) -> None:
    assert (
        fall_count_or_probability_by_fall_azimuth(dataset_of_fall_flags_by_azimuth(azimuth, flags))
        .to_series()
        .to_dict()
        == expected
    )
    lazy = fall_count_or_probability_by_fall_azimuth(
        dataset_of_fall_flags_by_azimuth(azimuth, flags).chunk({"azimuth": 2})
    )
    assert lazy.chunks is not None
    assert lazy.to_series().to_dict() == expected


def test_missing_outcomes_are_counted_neither_as_fall_nor_as_stand() -> None:
    assert np.isnan(
        fall_count_or_probability_by_fall_azimuth(dataset_of_fall_flags_by_azimuth([0, 180], [np.nan, np.nan]))
    ).all()
    np.testing.assert_array_equal(
        overturning_indicator(dataset_of_fall_flags_by_azimuth([0, 90], [np.nan, -1])), [np.nan, 1]
    )


def test_integer_and_float_fall_flags_give_equal_statistics() -> None:
    read = dataset_of_fall_flags_by_azimuth([0, 30, 60, 90, 120, 150], [1, np.nan, np.nan, 0, -1, 0])
    whole = read.fillna(-128).astype("int8").assign_coords(azimuth=read["azimuth"])  # as in the file
    for found in (
        overturning_indicator,
        mask_of_blocks_for_direction_statistics,
        mean_fall_probability_over_directions,
        lambda one: mean_fall_directions_and_axes_over_azimuths(one, only_informative_blocks=True),
    ):
        assert found(whole).equals(found(read))
    assert (
        count_differing_and_all_neighbour_pairs(whole, "azimuth")
        == count_differing_and_all_neighbour_pairs(read, "azimuth")
        == (2, 2)
    )
    assert float(mean_fall_probability_over_directions(whole)) == pytest.approx(2 / 4)


def test_outcome_changes_are_counted_only_between_adjacent_cells_with_outcomes() -> None:
    flags = dataset_of_fall_flags_by_azimuth([0, 90, 180, 270], [1, 1, np.nan, 0])
    assert count_differing_and_all_neighbour_pairs(flags, "azimuth") == (1, 2)  # round the compass: from 270 to 0
    assert count_differing_and_all_neighbour_pairs(flags.isel(azimuth=slice(0, 2)), "azimuth") == (0, 1)
    ratios = xr.concat([flags, flags * 0, flags * 0 - 1], xr.DataArray([0.2, 0.3, 0.4], dims="b_over_h"))
    assert count_differing_and_all_neighbour_pairs(ratios, "b_over_h") == (5, 6)


def test_blocks_are_informative_if_they_fall_in_some_planes_but_at_most_half() -> None:
    flags = np.array([[0, 1, 1, 1], [0, 0, -1, -1], [0, 0, 1, np.nan], [0, 0, 0, 1]], dtype=float)
    data = xr.Dataset({"overturned": (("azimuth", "b_over_h"), flags)}, coords={"azimuth": [0, 45, 90, 135]})
    assert mask_of_blocks_for_direction_statistics(data).values.tolist() == [False, True, False, False]
    assert mask_of_blocks_for_direction_statistics(data.isel(azimuth=[0, 1, 3])).values.tolist() == [
        False,
        True,
        False,
        False,
    ]
    # Without marginal blocks all falls count.
    assert mask_of_blocks_for_direction_statistics(data.isel(azimuth=[0, 1, 3], b_over_h=[2])).values.tolist() == [True]


def test_opposite_azimuths_of_one_plane_are_counted_once(make_cube_from_fall_rules, make_sector_fall_rule) -> None:
    cube = make_cube_from_fall_rules(make_sector_fall_rule(60, 20))
    whole = mean_fall_probability_over_directions(cube)
    half = mean_fall_probability_over_directions(cube.isel(azimuth=cube["azimuth"] < 180))
    assert whole.values == pytest.approx(9 / 36)  # 40° to 80° by 5° of 36 planes
    xr.testing.assert_allclose(whole, half)
    assert (
        default_model_of_same_kind_as_results_cube(cube).fall_probability_and_direction_by_case(cube).sizes["azimuth"]
        == 36
    )


def fall_rule_both_ways_along_30_degrees(azimuth, *_):
    """Return fall flags: of 21 planes about the axis 30°, blocks fall towards it in eleven and away in ten."""
    near = np.abs((azimuth - 30 + 90) % 180 - 90) <= 10
    return np.where(near, np.where(azimuth.astype(int) % 2 == 0, 1, -1), 0)


@pytest.mark.parametrize(
    ("rule", "share", "direction", "axis"),
    [
        ("towards 60", 9 / 36, (60, (0.9, 1)), (60, (0.9, 1))),
        ("away from 60", 9 / 36, (240, (0.9, 1)), (60, (0.9, 1))),
        (fall_rule_both_ways_along_30_degrees, 21 / 180, (None, (0, 0.06)), (30, (0.9, 1))),
        (lambda azimuth, *_: np.zeros_like(azimuth), 0, (np.nan, None), (np.nan, None)),
        (lambda azimuth, *_: np.where(azimuth < 180, 1, -1), 1, (None, (0.6, 0.7)), (np.nan, (0, 1e-9))),
    ],
)
def test_fall_shares_mean_directions_and_axes_match_known_fall_rules(
    make_cube_from_fall_rules, make_sector_fall_rule, rule, share, direction, axis
) -> None:
    if isinstance(rule, str):
        rule = make_sector_fall_rule(60, 20, side=1 if rule == "towards 60" else -1)
    cube = make_cube_from_fall_rules(
        rule, azimuth=range(360) if rule is fall_rule_both_ways_along_30_degrees else range(0, 360, 5)
    )
    means = mean_fall_directions_and_axes_over_azimuths(cube)
    assert mean_fall_probability_over_directions(cube).values == pytest.approx(share)
    for kind, (angle, resultant) in (("direction", direction), ("axis", axis)):
        if angle is not None:
            assert means[f"mean_{kind}"].values == pytest.approx(angle, nan_ok=True)
        length = means[f"{kind}_resultant"].values
        assert (
            np.isnan(length).all() if resultant is None else ((resultant[0] <= length) & (length <= resultant[1])).all()
        )


def test_missing_outcomes_do_not_count_as_standing_in_shares(make_cube_from_fall_rules, make_sector_fall_rule) -> None:
    cube = make_cube_from_fall_rules(make_sector_fall_rule(60, 20))
    cube["overturned"] = cube["overturned"].where(cube["azimuth"] % 180 != 0)
    shares = mean_fall_probability_over_directions(cube)
    assert shares.values == pytest.approx(9 / 35)
    raw = cube.assign(overturned=cube["overturned"].fillna(-128).astype("int8"))
    xr.testing.assert_allclose(mean_fall_probability_over_directions(raw), shares)
    assert mean_fall_probability_over_directions(cube.where(False)).isnull().all()


def test_fall_shares_are_averaged_over_all_block_parameters(make_cube_from_fall_rules, make_sector_fall_rule) -> None:
    shares = mean_fall_probability_over_directions(
        make_cube_from_fall_rules(make_sector_fall_rule(60, 20, largest_b_over_h=0.3)),
        summed_dims=PlanarModel.case_dims_without_direction,
    )
    assert float(shares[0]) == pytest.approx(9 / 36 * 3 / 5)
    assert shares.dims == ("record",)


def test_statistics_of_a_lazy_cube_are_those_of_a_loaded_one(make_cube_from_fall_rules, make_sector_fall_rule) -> None:
    cube = make_cube_from_fall_rules(make_sector_fall_rule(100, 30), events=("A", "B", "C"))
    for function in (mean_fall_probability_over_directions, mean_fall_directions_and_axes_over_azimuths):
        answer = function(cube.chunk({"record": 1, "azimuth": 12}))
        assert answer.chunks
        xr.testing.assert_allclose(answer.compute(), function(cube))


def test_azimuths_added_to_a_grid_do_not_change_shares_and_axes(
    make_cube_from_fall_rules, make_sector_fall_rule
) -> None:
    regular = make_cube_from_fall_rules(make_sector_fall_rule(60, 20))
    extra = make_cube_from_fall_rules(
        make_sector_fall_rule(60, 20), azimuth=sorted([*range(0, 360, 5), 61, 62, 63, 64, 241, 242, 243, 244])
    )
    assert plane_weights_by_azimuth_spacing(
        extra["azimuth"].values[distinct_plane_indices(extra["azimuth"].values)]
    ).sum() == pytest.approx(1)
    assert float(
        mean_fall_probability_over_directions(extra, summed_dims=("record", *PlanarModel.case_dims_without_direction))
    ) == pytest.approx(9 / 36)
    assert mean_fall_directions_and_axes_over_azimuths(extra)["mean_axis"].values == pytest.approx(
        mean_fall_directions_and_axes_over_azimuths(regular)["mean_axis"].values, abs=0.01
    )


def test_all_planes_of_a_partial_circle_have_equal_weight(make_cube_from_fall_rules, make_sector_fall_rule) -> None:
    """Of twelve planes from 30° to 85°, blocks fall in those from 40° on; each plane counts once."""
    part = np.arange(30, 90, 5)
    assert plane_weights_by_azimuth_spacing(part) == pytest.approx(np.full(12, 1 / 12))
    assert plane_weights_by_azimuth_spacing(part, divide_uncomputed_gaps_between_neighbours=True)[
        [0, 1, -1]
    ] == pytest.approx([65 / 180, 5 / 180, 65 / 180])
    cube = make_cube_from_fall_rules(make_sector_fall_rule(62.5, 24), azimuth=part.tolist())
    assert mean_fall_probability_over_directions(cube).values == pytest.approx(10 / 12)
    assert mean_fall_directions_and_axes_over_azimuths(cube)["mean_axis"].values == pytest.approx(62.5, abs=1e-4)
    assert plane_weights_by_azimuth_spacing([0, 60, 90]) == pytest.approx([75 / 180, 45 / 180, 60 / 180]), (
        "no part of a finer grid"
    )


def test_end_planes_of_two_partial_circles_have_no_extra_weight() -> None:
    """End planes of azimuth ranges near both faces of a stone have the same weight as all other planes."""
    both = [*range(0, 25, 5), *range(90, 115, 5)]
    assert plane_weights_by_azimuth_spacing(both) == pytest.approx(np.full(10, 1 / 10))
    not_computed, step = mask_of_azimuths_before_gap_and_grid_step(both)
    assert (np.flatnonzero(not_computed).tolist(), step) == ([4, 9], 5.0)
    assert np.flatnonzero(mask_of_azimuths_before_gap_and_grid_step(both, 360.0)[0]).tolist() == [4, 9]


@pytest.mark.parametrize(
    ("part", "last"), [(range(0, 175, 5), 170), (range(0, 165, 15), 150), ([0, 45, 90], 90), ([30, 90], 90)]
)
def test_grid_with_a_missing_plane_is_a_partial_circle(part, last: float) -> None:
    """An azimuth range that stops one step short, as its end is excluded, counts as a partial circle with a gap."""
    not_computed, step = mask_of_azimuths_before_gap_and_grid_step(list(part))
    assert np.flatnonzero(not_computed).tolist() == [len(part) - 1]
    assert step == part[1] - part[0]
    assert plane_weights_by_azimuth_spacing(list(part)) == pytest.approx(1 / len(part))
    said = unsimulated_azimuth_ranges_text(xr.Dataset(coords={"azimuth": ("azimuth", list(part))}))
    assert said == f"between {last}° and {180 + part[0]}°"


@pytest.mark.parametrize(
    "whole",
    [
        sorted({*range(0, 180, 5), *range(61, 65)}),
        sorted({*range(0, 180, 5), *range(60, 121)}),
        sorted({*range(0, 180, 5), *range(61, 65), *range(71, 75)}),
        [0, 60, 90],
        [30],
        [0, 90],
    ],
)
def test_azimuths_added_to_a_full_circle_do_not_make_it_partial(whole) -> None:
    assert not mask_of_azimuths_before_gap_and_grid_step(whole)[0].any()
    assert plane_weights_by_azimuth_spacing(whole) == pytest.approx(
        plane_weights_by_azimuth_spacing(whole, divide_uncomputed_gaps_between_neighbours=True)
    )


def test_opposite_azimuths_of_an_asymmetric_scene_are_two_different_cases(make_cube_from_fall_rules) -> None:
    """The stone falls away from its wall: towards azimuths from 0° to 175°; for azimuths from 180° on it stands."""
    cube = make_cube_from_fall_rules(lambda azimuth, *_: np.where(azimuth < 180, 1, 0))
    falling = make_cube_from_fall_rules(lambda azimuth, *_: np.ones_like(azimuth))
    for one in (cube, falling):
        one["azimuth"].attrs["period"] = 360.0
    assert mean_fall_probability_over_directions(cube).values == pytest.approx(0.5)
    assert mean_fall_directions_and_axes_over_azimuths(falling)["direction_resultant"].values == pytest.approx(
        0, abs=1e-9
    )
    # The whole of the eastern half, seen from −2.5 to 177.5°: its middle is 87.5°.
    assert mean_fall_directions_and_axes_over_azimuths(cube)["mean_direction"].values == pytest.approx(87.5)
    xr.testing.assert_identical(cube_with_opposite_azimuths(cube), cube)
    block = cube.isel(record=0, height=0, b_over_h=0, friction=0)
    for case, expected in ((block, [1, 1, 0, 0]), (-block, [0, 0, 1, 1])):
        assert (
            fall_count_or_probability_by_fall_azimuth(case).sel(azimuth=[0, 175, 180, 355]).values.tolist() == expected
        )


def test_fall_probabilities_come_from_the_ensemble_where_it_was_run(
    make_cube_from_fall_rules, make_sector_fall_rule
) -> None:
    cube = make_cube_from_fall_rules(make_sector_fall_rule(60, 20))
    towards = xr.full_like(cube["overturned"], np.nan)
    towards[{"b_over_h": 1}] = 0.25
    cube = cube.assign(probability_towards=towards, probability_away=towards * 0 + 0.5)
    p, nominal = (
        fall_probabilities_towards_and_away(cube),
        fall_probabilities_towards_and_away(cube, use_ensemble=False),
    )
    assert (p["towards"].isel(b_over_h=1) == 0.25).all()
    assert (p["away"].isel(b_over_h=1) == 0.5).all()
    xr.testing.assert_equal(p.isel(b_over_h=0), nominal.isel(b_over_h=0))
    assert set(np.unique(nominal["towards"])) == {0, 1}


def test_mean_axis_of_a_single_azimuth_is_that_azimuth(make_cube_from_fall_rules) -> None:
    cube = make_cube_from_fall_rules(lambda azimuth, *_rest: np.ones_like(azimuth), azimuth=(32,))
    assert mean_fall_directions_and_axes_over_azimuths(cube)["mean_axis"].values == pytest.approx(32)
    assert (mean_fall_probability_over_directions(cube) == 1).all()


def test_dataset_without_fall_flags_is_refused() -> None:
    with pytest.raises(ResultError, match="overturned"):
        fall_probabilities_towards_and_away(xr.Dataset({"x": 1}))


def test_a_scene_falls_where_any_of_its_elements_falls() -> None:
    """Of five cases one has no outcome.

    In the others nothing falls, only the lintel falls, the pillar and later the lintel fall, or only the pillar falls.
    """
    flags = np.array([[[0, 0], [0, 1], [-1, 1], [1, 0], [np.nan, np.nan]]])
    times = np.array([[[np.nan, np.nan], [np.nan, 3.0], [1.0, 2.0], [5.0, np.nan], [np.nan, np.nan]]])
    dims = ("record", "azimuth", "element")
    made = xr.Dataset(
        {"overturned": (dims, flags), "overturning_time": (dims, times)}, {"element": ["pillar", "lintel"]}
    )
    pillar, lintel, anything = count_falls_of_each_and_any_element(made)
    assert (pillar.known_outcome_case_count, pillar.fall_count, pillar.count_of_falls_with_no_earlier_fall) == (
        4,
        2,
        2,
    )
    assert (lintel.known_outcome_case_count, lintel.fall_count, lintel.count_of_falls_with_no_earlier_fall) == (
        4,
        2,
        1,
    )
    assert (
        anything.known_outcome_case_count,
        anything.fall_count,
        anything.fall_share,
        anything.median_fall_time_s,
    ) == (4, 3, 0.75, 3.0)


def test_displacements_of_each_stone_of_a_stack_match_hand_computation() -> None:
    """The base slips by 3 cm to the north and 4 cm to the west, 5 cm in all.

    The shaft stands in five of eight cases and slides off in one of the other three.
    """
    dims = ("record", "orientation", "element")
    shape = (1, 8, 2)
    fell, north, east, twist, slid = (np.zeros(shape) for _ in range(5))
    north[..., 0], east[..., 0] = 0.03, -0.04
    fell[0, 5:, 1] = 1.0
    slid[0, 7, 1] = 1.0
    twist[0, :, 1] = [-1.0, 2.0, -3.0, 4.0, np.nan, 90.0, 90.0, 90.0]  # NaN: the motion moves nothing
    names = ("overturned", "residual_slip_north", "residual_slip_east", "residual_twist", "slid_off")
    made = xr.Dataset(
        {name: (dims, values) for name, values in zip(names, (fell, north, east, twist, slid), strict=True)},
        {"element": ["base", "shaft"]},
    )
    base, shaft = summarise_element_displacements(made)
    assert (base.standing_case_count, base.fallen_case_count, base.count_of_falls_over_support_rim) == (8, 0, 0)
    assert base.standing_median_and_p90_slip_m == pytest.approx((0.05, 0.05))
    assert (shaft.standing_case_count, shaft.fallen_case_count, shaft.count_of_falls_over_support_rim) == (5, 3, 1)
    assert shaft.standing_median_and_p90_slip_m == (0.0, 0.0)
    assert shaft.standing_median_and_p90_twist_deg == pytest.approx((2.0, 3.6)), "of 0, 1, 2, 3, 4 degrees"
    assert summarise_element_displacements(made.drop_vars("slid_off"))[1].count_of_falls_over_support_rim is None


def test_model_kind_is_recognised_from_the_coordinates_of_a_cube() -> None:
    """Statistics tell from a cube's coordinates whether its model is planar, a 3-D body or a stack.

    They load few variables of a cube, so that the model must follow from the coordinates that remain.
    """
    stack = xr.Dataset({"overturned": (("orientation", "height"), np.zeros((2, 1)))}, {"height": [0.6]})
    assert isinstance(default_model_of_same_kind_as_results_cube(stack), Stack)
    assert isinstance(default_model_of_same_kind_as_results_cube(stack.expand_dims(aspect=[1.0])), Body)
    assert isinstance(default_model_of_same_kind_as_results_cube(stack.expand_dims(aspect=[1.0]).isel(aspect=0)), Body)
    assert isinstance(default_model_of_same_kind_as_results_cube(stack.rename(orientation="azimuth")), PlanarModel)


@pytest.mark.parametrize(
    ("azimuth", "imposed"),
    [
        ([32], True),
        ([32, 212], True),  # one plane, moved both ways
        (range(60, 120, 20), True),
        ([*range(60, 120, 20), *range(240, 300, 20)], True),
        (range(0, 90, 5), True),
        (range(0, 165, 15), True),  # a plane of twelve is missing: resultant 1/11
        (range(0, 175, 5), False),  # a plane of 36 is missing: resultant 1/35
        (range(0, 180, 5), False),
        (range(0, 360, 30), False),
        (range(90, 270, 10), False),
        ([0, 45, 90], True),
        ([0, 90], False),
        ([0, 60, 90], True),  # weights 5/12, 1/4 and 1/3: resultant 0.22
        ([10, 40, 90, 160], True),
        ([*range(0, 180, 30), 32], False),
        (sorted({*range(0, 180, 5), *range(60, 121)}), False),
    ],
)
def test_unevenly_spaced_planes_are_detected_as_imposing_the_fall_axis(azimuth, imposed: bool) -> None:
    assert plane_azimuths_alone_impose_fall_axis(list(azimuth)) is imposed
    assert (
        MAX_RESULTANT_LENGTH_OF_UNIFORM_PLANE_AZIMUTHS == MIN_RESULTANT_WITH_MEAN_DIRECTION
    )  # up to which falls have no axis
