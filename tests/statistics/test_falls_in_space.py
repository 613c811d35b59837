"""Falls of the 3-D model, compared with hand computation or another library."""

from collections.abc import Sequence

import numpy as np
import pytest
import xarray as xr
from obspy.geodetics import gps2dist_azimuth
from scipy.stats import bootstrap, circmean, norm, t

from overturning.model.body import Body
from overturning.model.falls import default_model_of_same_kind_as_results_cube
from overturning.statistics.circular import ROSE_SECTOR_COUNT
from overturning.statistics.earthquakes import (
    fall_axes_from_fault_normal_by_earthquake,
    fall_sums_for_direction_statistics_by_record,
    summarise_fall_axes,
)
from overturning.statistics.falls import (
    mean_cosine_and_sine_to_reference,
    mean_fall_directions_and_axes_over_azimuths,
    mean_fall_probability_over_directions,
)
from overturning.statistics.illustrative import find_best_case_for_each_behaviour
from overturning.statistics.reference_directions import (
    alignments_with_reference_axes_by_record_group,
    azimuth_away_from_epicentre,
)
from overturning.statistics.roses import fall_rose
from overturning.statistics.space import (
    count_agreeing_and_differing_2d_3d_outcomes,
    moved_stone_twist_deg_by_b_over_h_and_friction,
    shares_of_agreeing_2d_and_3d_outcomes,
    summarise_twists_sorting_in_place,
)

EARTHQUAKE_NAMES_BY_RECORD = ("A", "A", "B", "C", "D")
FAULT_NORMALS_DEG = np.array([10.0, 10.0, 80.0, 150.0, 40.0])
DIMENSIONS = ("record", "orientation", "height", "b_over_h", "aspect", "friction")


def random_3d_cube(
    seed: int = 1,
    events: Sequence[str] = EARTHQUAKE_NAMES_BY_RECORD,
    spread: float = 30.0,
    normals: np.ndarray = FAULT_NORMALS_DEG,
) -> xr.Dataset:
    """Return a random 3-D cube in which blocks fall about 20° clockwise of the fault normal, or opposite.

    Two of three blocks fall, 30 % of them in the opposite direction.
    """
    generator = np.random.default_rng(seed)
    shape = (len(events), 6, 2, 3, 1, 2)
    normals = normals[: len(events)]
    fell = generator.random(shape) < 2 / 3
    azimuth = normals.reshape(-1, 1, 1, 1, 1, 1) + 20.0 + spread * generator.normal(size=shape)
    azimuth = np.where(fell, (azimuth + 180.0 * (generator.random(shape) < 0.3)) % 360.0, np.nan).astype(np.float32)
    flags = np.where(generator.random(shape) < 0.03, np.nan, fell).astype(np.float32)
    return xr.Dataset(
        {"overturned": (DIMENSIONS, flags), "fall_azimuth": (DIMENSIONS, np.where(flags == 1, azimuth, np.nan))},
        coords={
            "orientation": np.arange(0, 90, 15), "height": [0.6, 1.2], "b_over_h": [0.2, 0.3, 0.4], "aspect": [1.0],
            "friction": [0.5, 1.0], "event": ("record", list(events)), "fault_normal": ("record", normals),
            "pulse": ("record", np.ones(len(events), np.int8)),
        },
    )  # fmt: skip


def fall_azimuths_of_record(cube: xr.Dataset, record: int) -> np.ndarray:
    """Return the azimuths of all falls under one record, degrees."""
    values = cube["fall_azimuth"].isel(record=record).to_numpy().ravel().astype(np.float64)
    return values[np.isfinite(values)]


def test_mean_directions_axes_and_shares_of_3d_falls_match_scipy_and_numpy() -> None:
    cube = random_3d_cube()
    assert isinstance(default_model_of_same_kind_as_results_cube(cube), Body)
    means, shares = (
        of(cube, summed_dims=Body.case_dims_without_direction)
        for of in (mean_fall_directions_and_axes_over_azimuths, mean_fall_probability_over_directions)
    )
    for record in range(len(EARTHQUAKE_NAMES_BY_RECORD)):
        angles = np.radians(fall_azimuths_of_record(cube, record))
        expected = np.degrees(circmean(angles))
        assert float(means["mean_direction"][record]) == pytest.approx(expected, abs=1e-4)
        assert float(means["mean_axis"][record]) == pytest.approx(np.degrees(circmean(angles, high=np.pi)), abs=1e-4)
        assert float(means["axis_resultant"][record]) == pytest.approx(abs(np.exp(2j * angles).mean()), abs=1e-6)
        flags = cube["overturned"].isel(record=record).to_numpy()
        assert float(shares[record]) == pytest.approx(np.nanmean(flags))
    whole = cube.assign(overturned=cube["overturned"].fillna(-128).astype("int8"))  # as in the file
    assert mean_fall_probability_over_directions(whole, summed_dims=Body.case_dims_without_direction).equals(shares)


def test_an_ensemble_takes_the_place_of_the_nominal_falls_where_it_was_run() -> None:
    cube = random_3d_cube()
    run = np.random.default_rng(3).random(cube["overturned"].shape) < 0.5
    half, angle = 0.5 * np.ones(run.shape), np.radians(70.0)
    parts = (1.0, np.cos(angle), np.sin(angle), np.cos(2 * angle), np.sin(2 * angle))
    names = ("probability_falls", "fall_north", "fall_east", "fall_axis_cosine", "fall_axis_sine")
    with_members = cube.assign({
        name: (DIMENSIONS, np.where(run, half * part, np.nan)) for name, part in zip(names, parts, strict=True)
    })  # fmt: skip
    everywhere = with_members.assign(
        {name: with_members[name].fillna(0.5 * part) for name, part in zip(names, parts, strict=True)}
    )
    found = mean_fall_directions_and_axes_over_azimuths(everywhere, summed_dims=Body.case_dims_without_direction)
    assert found["mean_direction"].to_numpy() == pytest.approx(70.0)
    assert found["direction_resultant"].to_numpy() == pytest.approx(1.0)
    mixed = mean_fall_probability_over_directions(
        with_members, summed_dims=("record", *Body.case_dims_without_direction)
    )
    flags = np.where(run, 0.5, cube["overturned"].to_numpy())
    assert float(mixed) == pytest.approx(np.nanmean(flags), abs=1e-6)


def test_fall_axes_relative_to_fault_normals_are_averaged_by_earthquake() -> None:
    cube = random_3d_cube(spread=10.0)
    axes = fall_axes_from_fault_normal_by_earthquake(cube)
    vectors = [
        np.exp(2j * np.radians(fall_azimuths_of_record(cube, record) - FAULT_NORMALS_DEG[record])).mean()
        for record in range(5)
    ]
    means = [np.mean(vectors[:2]), *vectors[2:]]
    assert axes["axis"].to_numpy() == pytest.approx(np.degrees(np.angle(means)) / 2, abs=1e-4)
    assert summarise_fall_axes(axes).mean_axis_from_fault_normal_deg == pytest.approx(20.0, abs=5.0)


def fall_shares_by_sector_of_record(cube: xr.Dataset, record: int, zero: float = 0.0) -> np.ndarray:
    """Return the share of the falls of one record in each sector of 15°, counted clockwise from ``zero``, degrees."""
    angles = (fall_azimuths_of_record(cube, record) - zero + 7.5) % 360.0 - 7.5
    return np.histogram(angles, np.arange(-7.5, 360.0, 15.0))[0] / angles.size


@pytest.mark.parametrize("from_normal", [False, True])
def test_fall_rose_is_the_mean_over_earthquakes_of_their_sector_shares(from_normal: bool) -> None:
    cube = random_3d_cube()
    rose = fall_rose(cube, measure_from_fault_normal=from_normal)
    shares = [
        fall_shares_by_sector_of_record(cube, record, FAULT_NORMALS_DEG[record] if from_normal else 0.0)
        for record in range(5)
    ]
    assert rose.mean_fall_share_by_sector == pytest.approx(np.mean([np.mean(shares[:2], axis=0), *shares[2:]], axis=0))
    assert rose.mean_fall_share_by_sector.sum() == pytest.approx(1.0)
    assert rose.fall_count == sum(fall_azimuths_of_record(cube, record).size for record in range(5))
    assert rose.count_of_earthquakes_with_falls == 4
    assert np.isnan(rose.share_interval_low_by_sector).all()  # of four earthquakes there is no interval


def test_falls_random_within_their_ensemble_affect_neither_mean_nor_rose() -> None:
    """Falls whose ensemble members fall in random directions count neither in the mean nor in the rose.

    Half of the cases fall towards 30°, as do their ensemble members. The others fall towards 120°, but their members
    in random directions.

    The mean is 30°, where nearly all of the rose lies. Without the ensemble, the mean would be 75°, and half of the
    rose at 120°.
    """
    generator, cube = np.random.default_rng(8), random_3d_cube()
    shape, members = cube["overturned"].shape, 24
    chance = generator.random(shape) < 0.5
    azimuth = np.where(chance, 120.0, 30.0)
    angle = np.radians(np.where(chance[..., None], generator.uniform(0, 360, (*shape, members)), 30.0))
    nominal = cube.assign(
        overturned=(DIMENSIONS, np.ones(shape, np.float32)), fall_azimuth=(DIMENSIONS, azimuth.astype(np.float32))
    )
    means = {
        "probability_falls": np.ones(shape), "fall_north": np.cos(angle).mean(-1), "fall_east": np.sin(angle).mean(-1),
        "fall_axis_cosine": np.cos(2 * angle).mean(-1), "fall_axis_sine": np.sin(2 * angle).mean(-1),
        "members": np.full(shape, members),
    }  # fmt: skip
    weighed = nominal.assign({name: (DIMENSIONS, values) for name, values in means.items()})
    over = ("record", *Body.case_dims_without_direction)
    assert float(
        mean_fall_directions_and_axes_over_azimuths(nominal, summed_dims=over)["mean_direction"]
    ) == pytest.approx(75.0, abs=8.0)
    assert float(
        mean_fall_directions_and_axes_over_azimuths(weighed, summed_dims=over)["mean_direction"]
    ) == pytest.approx(30.0, abs=3.0)
    before, after = (fall_rose(one).mean_fall_share_by_sector for one in (nominal, weighed))
    assert before[8] == pytest.approx(0.5, abs=0.1)
    assert after[8] < 0.15
    assert after[2] == pytest.approx(1.0 - after[8])
    assert fall_rose(weighed).fall_count == fall_rose(nominal).fall_count


def test_rose_intervals_match_scipy() -> None:
    cube = random_3d_cube(events="ABCDEFGH", normals=np.arange(8) * 20.0)
    half = fall_rose(cube, confidence_level=0.5, bootstrap_sample_count=20_000)
    means = np.array([fall_shares_by_sector_of_record(cube, record) for record in range(8)])
    scipys = bootstrap((means,), np.mean, method="percentile", confidence_level=0.5, n_resamples=20_000, rng=5)
    assert (half.share_interval_low_by_sector, half.share_interval_high_by_sector) == tuple(
        pytest.approx(ends, abs=0.006) for ends in scipys.confidence_interval
    )


def test_rose_without_falls_has_empty_sectors() -> None:
    cube = random_3d_cube()
    cube["fall_azimuth"] = cube["fall_azimuth"] * np.nan
    rose = fall_rose(cube)
    assert (rose.fall_count, rose.mean_fall_share_by_sector.tolist()) == (0, [0.0] * ROSE_SECTOR_COUNT)


def test_alignment_is_the_mean_cosine_of_angles_from_falls_to_reference() -> None:
    cube, reference = random_3d_cube(), xr.DataArray([0.0, 90.0, np.nan, 45.0, 300.0], dims="record")
    sums = fall_sums_for_direction_statistics_by_record(cube, "b_over_h")
    for axial, factor in ((True, 2), (False, 1)):
        for part in (slice(None), slice(1, 2), slice(0, 2)):
            found = mean_cosine_and_sine_to_reference(sums.isel(b_over_h=part).sum("b_over_h"), reference, axial=axial)[
                "cosine"
            ]
            for record in range(5):
                angles = fall_azimuths_of_record(cube.isel(b_over_h=part), record) - float(reference[record])
                assert float(found[record]) == pytest.approx(
                    np.cos(np.radians(factor * angles)).mean(), abs=1e-6, nan_ok=True
                )


def test_falls_against_a_reference_have_axial_alignment_1() -> None:
    cube = random_3d_cube()
    pgv = np.array([0.0, 30.0, 100.0, 220.0, 300.0])
    azimuth = np.broadcast_to(pgv.reshape(-1, 1, 1, 1, 1, 1) + 180.0, cube["overturned"].shape) % 360.0
    cube["fall_azimuth"] = (DIMENSIONS, np.where(cube["overturned"] == 1, azimuth, np.nan))
    other = ("record", pgv + 90.0)
    intensity = xr.Dataset({"pgv_azimuth": ("record", pgv), "pga_azimuth": other, "pulse_axis": other})
    (found,) = alignments_with_reference_axes_by_record_group(cube, intensity, [slice(0, 3), slice(1, 2)]).values()
    assert [
        one.mean for one in found.cosines_per_b_over_h_by_reference_and_axial["peak velocity", True]
    ] == pytest.approx([1.0, 1.0])
    assert [
        one.mean for one in found.cosines_per_b_over_h_by_reference_and_axial["peak velocity", False]
    ] == pytest.approx([-1.0, -1.0])
    assert found.cosines_per_b_over_h_by_reference_and_axial["pulse", True][0].mean == pytest.approx(-1.0)
    assert ("pulse", False) not in found.cosines_per_b_over_h_by_reference_and_axial
    cube["fall_azimuth"] = cube["fall_azimuth"] + xr.DataArray([0.0, 45.0, 90.0], dims="b_over_h")
    (each,) = alignments_with_reference_axes_by_record_group(cube, intensity).values()
    assert [
        one.mean for one in each.cosines_per_b_over_h_by_reference_and_axial["peak velocity", True]
    ] == pytest.approx([1.0, 0.0, -1.0], abs=1e-6)
    heads = [one.mean for one in each.cosines_per_b_over_h_by_reference_and_axial["peak velocity", False]]
    assert heads == pytest.approx([-1.0, -np.sqrt(0.5), 0.0], abs=1e-6)


def test_the_radial_direction_is_that_of_the_great_circle_at_the_station() -> None:
    """Azimuths away from the epicentre match Clairaut's relation, and those of ObsPy on the ellipsoid to 0.3°.

    By Clairaut's relation, sin azimuth × cos latitude is constant along a great circle.
    """
    places = np.array([
        (0.0, 0.0, 45.0, 90.0, 90.0),  # leaves towards the north-east, passes 45° N due east
        (0.0, 0.0, 10.0, 0.0, 0.0),
        (0.0, 179.9, 0.0, -179.9, 90.0),
        (35.0, 135.0, 34.0, 135.0, 180.0),
        (10.0, 20.0, 10.0, 20.0, np.nan),  # within 1 km there is no direction
        (np.nan, 20.0, 10.0, 20.0, np.nan),
    ])  # fmt: skip
    names = ("epicentre_latitude", "epicentre_longitude", "station_latitude", "station_longitude")
    cube = xr.Dataset(coords={name: ("record", column) for name, column in zip(names, places.T, strict=False)})
    assert azimuth_away_from_epicentre(cube).to_numpy() == pytest.approx(places[:, 4], abs=1e-9, nan_ok=True)
    assert np.isnan(azimuth_away_from_epicentre(xr.Dataset(coords={"event": ("record", ["A", "B"])}))).all()
    lines = np.random.default_rng(4).uniform((-60, -180, -3, -3), (60, 180, 3, 3), (20, 4))
    lines[:, 2:] += lines[:, :2]
    cube = xr.Dataset(coords={name: ("record", column) for name, column in zip(names, lines.T, strict=True)})
    back = np.array([gps2dist_azimuth(*line)[2] for line in lines])
    apart = (azimuth_away_from_epicentre(cube).to_numpy() - back) % 360 - 180
    assert np.abs(apart).max() < 0.3


def test_falls_towards_the_epicentre_align_with_the_radial_axis() -> None:
    cube = random_3d_cube()
    radial = np.array([0.0, 90.0, 180.0, 270.0, 0.0])
    east, north = np.sin(np.radians(radial)), np.cos(np.radians(radial))
    places = {"epicentre_latitude": 0.0, "epicentre_longitude": 0.0, "station_latitude": north}
    places["station_longitude"] = east
    cube = cube.assign_coords({name: ("record", np.zeros(5) + values) for name, values in places.items()})
    azimuth = np.broadcast_to(radial.reshape(-1, 1, 1, 1, 1, 1) + 180.0, cube["overturned"].shape) % 360.0
    cube["fall_azimuth"] = (DIMENSIONS, np.where(cube["overturned"] == 1, azimuth, np.nan))
    other = ("record", radial + 90.0)
    intensity = xr.Dataset({"pgv_azimuth": other, "pga_azimuth": other, "pulse_axis": other})
    (found,) = alignments_with_reference_axes_by_record_group(cube, intensity, [slice(0, 3)]).values()
    assert [
        found.cosines_per_b_over_h_by_reference_and_axial["radial direction", axial][0].mean for axial in (True, False)
    ] == pytest.approx([1.0, -1.0])
    assert found.two_best_aligned_reference_names[0] == "radial direction"
    nowhere = cube.assign_coords(epicentre_latitude=("record", np.full(5, np.nan)))
    (found,) = alignments_with_reference_axes_by_record_group(nowhere, intensity, [slice(0, 3)]).values()
    assert ("radial direction", True) not in found.cosines_per_b_over_h_by_reference_and_axial


def test_a_direction_known_for_one_record_is_not_called_the_closest() -> None:
    """Falls go along the only known fault normal, of one record, and 30° from the peak velocity of the others."""
    cube = random_3d_cube(normals=np.array([40.0, *[np.nan] * 4]))
    azimuth = np.broadcast_to(np.full(5, 40.0).reshape(-1, 1, 1, 1, 1, 1), cube["overturned"].shape)
    cube["fall_azimuth"] = (DIMENSIONS, np.where(cube["overturned"] == 1, azimuth, np.nan))
    pgv, other = np.array([40.0, 70.0, 70.0, 70.0, 70.0]), ("record", np.full(5, 130.0))
    intensity = xr.Dataset({"pgv_azimuth": ("record", pgv), "pga_azimuth": other, "pulse_axis": other})
    (found,) = alignments_with_reference_axes_by_record_group(cube, intensity, [slice(0, 3)]).values()
    normal, peak = (
        found.cosines_per_b_over_h_by_reference_and_axial[name, True][0] for name in ("fault normal", "peak velocity")
    )
    assert (normal.earthquake_count, normal.mean > peak.mean) == (1, True)
    assert found.two_best_aligned_reference_names[0] == "peak velocity", "which under that one record is as close"


def test_difference_of_two_reference_alignments_is_paired_by_earthquake() -> None:
    normals = np.arange(9) * 20.0
    cube = random_3d_cube(events="AABCDEFGH", normals=normals)
    away = np.array([40.0, 35, 45, 50, 30, 55, 25, 60, 40])
    references = {"pgv_azimuth": normals + 20.0, "pga_azimuth": normals + 110.0, "pulse_axis": normals + 20.0 + away}
    intensity = xr.Dataset({name: ("record", values) for name, values in references.items()})
    (found,) = alignments_with_reference_axes_by_record_group(cube, intensity, [slice(0, 3)]).values()
    assert found.two_best_aligned_reference_names == ("peak velocity", "fault normal")

    def mean_cosine_of_doubled_angle(record: int, reference: float) -> float:
        return float(np.cos(2 * np.radians(fall_azimuths_of_record(cube, record) - reference)).mean())

    apart = np.array(
        [
            mean_cosine_of_doubled_angle(record, normals[record] + 20.0)
            - mean_cosine_of_doubled_angle(record, normals[record])
            for record in range(9)
        ]
    )
    apart = np.array([apart[:2].mean(), *apart[2:]])
    level = 1 - 2 * norm.cdf(-np.sqrt(8 / 7) * t.ppf(0.975, 7))  # expanded percentile (Hesterberg 2015)
    scipys = bootstrap(
        (apart,), np.mean, method="percentile", confidence_level=level, n_resamples=20_000, rng=5
    ).confidence_interval
    (closer,) = found.best_minus_second_axis_cosines_per_b_over_h
    assert (closer.earthquake_count, closer.mean) == (8, pytest.approx(apart.mean(), abs=1e-6))
    assert (closer.interval_low, closer.interval_high) == pytest.approx(tuple(scipys), abs=0.01)


def test_agreement_with_the_2d_model_matches_counts_by_hand() -> None:
    flags = np.array([1, 1, 1, 0, 0, 1, np.nan, 1], np.float32)
    plane = np.array([1, 1, 0, 0, 1, 1, 1, np.nan], np.float32)
    falls = np.array([350.0, 100.0, 5.0, np.nan, np.nan, 190.0, np.nan, 5.0])
    predicted = np.array([20.0, 0.0, np.nan, np.nan, 0.0, 0.0, 0.0, np.nan])
    names = ("overturned", "plane_overturned", "fall_azimuth", "plane_fall_azimuth")
    cube = xr.Dataset(
        {name: ("record", values) for name, values in zip(names, (flags, plane, falls, predicted), strict=True)}
    ).expand_dims(b_over_h=[0.3])
    found = shares_of_agreeing_2d_and_3d_outcomes(count_agreeing_and_differing_2d_3d_outcomes(cube))
    assert found["cases"] == 6
    shares = {"flag": 4 / 6, "only_space": 1 / 6, "only_plane": 1 / 6, "face": 1 / 3, "axis": (30.0 + 80.0 + 10.0) / 3}
    assert {name: float(found[name]) for name in shares} == pytest.approx(shares)
    assert np.isnan(found["flag_beside"]), "no neighbour"
    by_record = shares_of_agreeing_2d_and_3d_outcomes(count_agreeing_and_differing_2d_3d_outcomes(cube), "record")
    assert by_record["flag"].to_numpy() == pytest.approx([1, 1, 0, 1, 0, 1, np.nan, np.nan], nan_ok=True)
    # Along B/H the 3-D flags are 1 1 0 0 ? 0: the second and third differ from a neighbour; 2-D has one right.
    row = (
        cube.isel(record=[0] * 6, b_over_h=0, drop=True).rename(record="b_over_h").expand_dims("record").copy(deep=True)
    )
    row["overturned"][:], row["plane_overturned"][:] = [1, 1, 0, 0, np.nan, 0], [1, 0, 0, 1, 1, 1]
    assert float(
        shares_of_agreeing_2d_and_3d_outcomes(count_agreeing_and_differing_2d_3d_outcomes(row))["flag_beside"]
    ) == pytest.approx(1 / 2)


def test_twist_statistics_omit_fallen_and_unmoved_stones() -> None:
    cube = xr.Dataset({
        "overturned": ("record", [0.0, 0.0, 0.0, 1.0, 0.0]),
        "status": ("record", [0, 0, 0, 0, 1]),
        "residual_twist": ("record", [-3.0, 1.0, 10.0, np.nan, 0.0]),
    }).expand_dims(b_over_h=[0.2], friction=[0.6])  # fmt: skip
    ((shape, turned),) = moved_stone_twist_deg_by_b_over_h_and_friction(cube).items()
    assert shape == (0.2, 0.6)
    found = summarise_twists_sorting_in_place(turned, probability_of_upper_quantile=0.5)
    assert (found.stone_count, found.median_deg, found.upper_quantile_deg, found.largest_deg) == (3, 3.0, 3.0, 10.0)
    assert (
        summarise_twists_sorting_in_place(
            moved_stone_twist_deg_by_b_over_h_and_friction(cube.isel(record=[3, 4]))[shape]
        ).stone_count
        == 0
    )


@pytest.mark.parametrize("size", [1, 2, 3, 10, 997])
def test_quantiles_of_twist_match_numpy(size: int) -> None:
    turned = np.random.default_rng(size).normal(size=size).astype(np.float32)
    expected = np.quantile(turned.astype(np.float64), [0.5, 0.9, 1.0])
    found = summarise_twists_sorting_in_place(turned.copy())
    assert (found.median_deg, found.upper_quantile_deg, found.largest_deg) == tuple(expected)


def test_each_illustrative_3d_case_is_the_extreme_by_its_selection_rule() -> None:
    cube = random_3d_cube()
    shape = cube["overturned"].shape
    turned, plane = np.zeros(shape, np.float32), np.ones(shape, np.float32)
    flags, falls = cube["overturned"].to_numpy().copy(), cube["fall_azimuth"].to_numpy().copy()
    flags[2, 1, 0, 2, 0, 1], plane[2, 1, 0, 2, 0, 1], falls[2, 1, 0, 2, 0, 1] = 1.0, 0.0, 15.0
    flags[0, 4, 1, 0, 0, 0], falls[0, 4, 1, 0, 0, 0], turned[0, 4, 1, 0, 0, 0] = 0.0, np.nan, -30.0
    values = {"overturned": flags, "fall_azimuth": falls, "plane_overturned": plane, "residual_twist": turned}
    whole = cube.assign({name: (DIMENSIONS, value) for name, value in values.items()})
    which_side, alone, corner, twisted = find_best_case_for_each_behaviour(whole)
    two = (
        whole["fall_azimuth"][which_side.record_index]
        .sel(which_side.block_coordinates)
        .sel(orientation=list(which_side.panel_azimuths_deg))
    )
    assert abs(abs(float(two[0] - two[1])) - 180.0) < 90.0
    assert which_side.block_coordinates["b_over_h"] == 0.4
    block = {"height": 0.6, "b_over_h": 0.4, "aspect": 1.0, "friction": 1.0}
    assert (alone.record_index, alone.panel_azimuths_deg, alone.block_coordinates) == (
        2,
        (15.0,),
        block,
    )
    assert corner.block_coordinates["b_over_h"] == 0.4
    assert (twisted.record_index, twisted.panel_azimuths_deg, twisted.block_coordinates["height"]) == (
        0,
        (60.0,),
        1.2,
    )
    still = cube.assign(residual_twist=(DIMENSIONS, np.zeros(shape)))
    assert find_best_case_for_each_behaviour(still.assign(overturned=still["overturned"] * 0)) == []
