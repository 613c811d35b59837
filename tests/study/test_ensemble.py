"""The ensemble: members, cells that are run, and results."""

from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import netCDF4
import numpy as np
import pytest
from scipy.special import i0, i1
from scipy.stats import binom

from overturning.dem.numerics import ProgressCallback
from overturning.dem.run import run_cases
from overturning.dem.simulate import simulate_as_arrays
from overturning.errors import ResultError
from overturning.model.body import Body
from overturning.model.cases import Cases
from overturning.model.grid import CaseGrid
from overturning.model.planes import PlanarModel
from overturning.model.results import CaseResults
from overturning.model.space import case_weight_in_direction_statistics
from overturning.model.variables import PLANE_ENSEMBLE_VARIABLES
from overturning.motion.motion import Motion
from overturning.settings import EnsembleSettings
from overturning.study import ensemble
from overturning.study.cube import open_cube
from overturning.study.ensemble import (
    MEMBERS_PER_BATCH,
    EnsembleRunner,
    fall_probability_convergence_mask,
    mask_of_cases_for_ensemble_runs,
    wilson_95_percent_interval,
)
from overturning.study.ensemble_members import EnsembleParameterChanges, draw_parameter_changes_of_members
from overturning.study.load import study_from_content
from overturning.study.recheck import recompute_and_compare_random_cases
from tests.study.small_study import simulate_study_cube, sine_cycle_record

AZIMUTH = np.arange(0, 360, 60, dtype=np.int16)
GRID = CaseGrid({
    "azimuth": AZIMUTH, "height": np.array([0.6]), "b_over_h": np.array([0.1, 0.2, 0.3, 0.4, 0.5]),
    "friction": np.array([0.5, 1.0]),
})  # fmt: skip


@pytest.fixture(scope="module")
def motion_of_two_cycles_with_vertical() -> Motion:
    """Motion of a pulse northwards and a weaker, delayed one eastwards."""
    cycle = sine_cycle_record().north
    return Motion(cycle, 0.3 * np.roll(cycle, 20), sampling_interval=0.01)


@pytest.fixture(scope="module")
def outcomes_without_ensemble(motion_of_two_cycles_with_vertical: Motion) -> dict[str, np.ndarray]:
    """Outcomes of all cases of `GRID` with the unchanged motion and parameters, without an ensemble."""
    return simulate_as_arrays(
        motion_of_two_cycles_with_vertical,
        azimuth_deg=AZIMUTH.astype(float),
        **{name: GRID[name] for name in GRID.dimension_names[1:]},
    )


def ensemble_statistics_of_grid(
    motion: Motion,
    nominal: dict[str, np.ndarray],
    members: EnsembleParameterChanges,
    run_all_cells: bool = True,
    **more,
):
    """Run the ensemble members of the cells of `GRID` and return their statistics."""

    def run_member_cases(cases: Cases, progress: ProgressCallback | None) -> CaseResults:
        return run_cases(motion, cases, progress=progress, threads=2)

    progress = more.pop("progress", None)
    return EnsembleRunner(PlanarModel(), members, run_all_cells, **more).choose_cases_and_run_their_ensembles(
        motion, GRID, nominal, run_member_cases, progress
    )[0]


def test_ensemble_members_fill_the_set_ranges_without_exceeding_them() -> None:
    settings = EnsembleSettings(members=64, initial_tilt=0.01)
    members = draw_parameter_changes_of_members(settings)
    assert members.member_count == 64
    for name in ("amplitude", "b_over_h", "friction", "damping"):
        width, factor = getattr(settings, name), getattr(members, f"{name}_factor")
        assert np.abs(factor - 1).max() <= width
        assert np.abs(factor - 1).max() > 0.9 * width
        for scramble in (0, 1):  # each scramble is balanced by itself: one point in every 32nd part
            place = np.floor((factor[members.sobol_sequence_number == scramble] - 1 + width) / (2 * width) * 32).astype(
                int
            )
            assert sorted(np.clip(place, 0, 31)) == list(range(32))
    assert np.abs(members.azimuth_change_deg).max() <= 2
    assert np.abs(members.initial_tilt_rad).max() <= 0.01


def test_ensemble_members_depend_only_on_the_seed(tmp_path: Path) -> None:
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        draw_parameter_changes_of_members(EnsembleSettings(seed=seed)).write_csv(tmp_path / name)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes() != (tmp_path / "c").read_bytes()
    members, again = (
        draw_parameter_changes_of_members(EnsembleSettings()),
        EnsembleParameterChanges.read_csv(tmp_path / "a"),
    )
    for name in ("sobol_sequence_number", "amplitude_factor", "azimuth_change_deg", "initial_tilt_rad"):
        assert np.array_equal(getattr(members, name), getattr(again, name))


def test_a_damaged_table_of_ensemble_members_is_refused_by_name(tmp_path: Path) -> None:
    for text in (
        "",
        "a,b\n1,2\n",
        "scramble,amplitude,b_over_h,friction,damping,azimuth_deg,initial_tilt\n0,x,1,1,1,0,0\n",
    ):
        (tmp_path / "members.csv").write_text(text)
        with pytest.raises(ResultError, match=r"members\.csv"):
            EnsembleParameterChanges.read_csv(tmp_path / "members.csv")


def test_ensembles_are_run_near_a_change_of_the_overturning_flag() -> None:
    flags = np.array([1, 1, 1, 1, 0, 0, 0, 0, 0, 0], np.int8)[None, None, :, None]
    assert mask_of_cases_for_ensemble_runs(flags, choose_all_cells=False)[0, 0, :, 0].nonzero()[0].tolist() == [
        2,
        3,
        4,
        5,
    ]
    assert mask_of_cases_for_ensemble_runs(flags, choose_all_cells=True).all()
    assert not mask_of_cases_for_ensemble_runs(np.zeros_like(flags), choose_all_cells=False).any()
    side = np.array([1, -1, -1, -1, -1, -1], np.int8)[None, None, :, None]
    assert mask_of_cases_for_ensemble_runs(side, choose_all_cells=False)[0, 0, :, 0].nonzero()[0].tolist() == [0, 1, 2]
    assert mask_of_cases_for_ensemble_runs(np.zeros((3, 1, 1, 2), np.int8), choose_all_cells=False).all()
    assert [EnsembleSettings().has_ensemble_runs_for_all_cases(count) for count in (1, 2)] == [True, False]
    assert EnsembleSettings(where="everywhere").has_ensemble_runs_for_all_cases(2)


def test_ensembles_are_also_run_near_a_change_of_the_fall_azimuth() -> None:
    """Ensembles are run near a change of the fall azimuth by 150°, but not near one by 20° across north.

    The fall azimuth changes from one B/H to the next.
    """
    flags = np.ones((1, 1, 8, 1), np.int8)
    azimuth = np.array([350.0, 10.0, 12.0, 14.0, 164.0, 166.0, 168.0, 170.0]).reshape(flags.shape)
    assert not mask_of_cases_for_ensemble_runs(flags, choose_all_cells=False).any()
    chosen = mask_of_cases_for_ensemble_runs(flags, choose_all_cells=False, nominal_fall_azimuth_deg=azimuth)
    assert chosen.ravel().nonzero()[0].tolist() == [2, 3, 4, 5]
    stands = np.array([1, 1, 1, 1, 1, 1, 1, 0], np.int8).reshape(flags.shape)
    chosen = mask_of_cases_for_ensemble_runs(
        stands, choose_all_cells=False, nominal_fall_azimuth_deg=np.where(stands == 1, azimuth, np.nan)
    )
    assert chosen.ravel().nonzero()[0].tolist() == [2, 3, 4, 5, 6, 7]


def test_3d_ensemble_members_are_run_where_the_fall_azimuth_changes(motion_of_two_cycles_with_vertical: Motion) -> None:
    """3-D ensembles are run near a block that falls in another direction than its neighbours.

    All blocks fall, and the ensemble members of that block, of B/H 0.2, fall in all directions.
    """
    grid = CaseGrid({
        "orientation": np.array([0]), "height": np.array([0.6]), "b_over_h": np.arange(1, 10) / 10,
        "aspect": np.array([1.0]), "friction": np.array([0.5]),
    })  # fmt: skip
    azimuth = np.full(grid.shape, 40.0, np.float32)
    azimuth[:, :, 1] = 260.0
    nominal = {"overturned": np.ones(grid.shape, np.int8), "repeated": np.zeros(grid.shape, np.int8)}
    members = draw_parameter_changes_of_members(EnsembleSettings(members=8, b_over_h=0.0))

    def fake_member_results(cases: Cases, _: ProgressCallback | None) -> Any:
        shape = np.asarray(cases.b_over_h)
        every_way = np.tile(45.0 * np.arange(8), shape.size // 8)
        towards = np.where(np.isclose(shape, 0.2), every_way, 40.0) + np.tile(
            members.azimuth_change_deg, shape.size // 8
        )
        return SimpleNamespace(
            overturned=np.ones(shape.size, np.int8), fall_azimuth=towards, block_steps=np.ones(shape.size)
        )

    found = EnsembleRunner(Body(), members, run_all_cells=False).choose_cases_and_run_their_ensembles(
        motion_of_two_cycles_with_vertical, grid, nominal | {"fall_azimuth": azimuth}, fake_member_results
    )
    run = (found[0]["members"] > 0).ravel()
    assert run.nonzero()[0].tolist() == [0, 1, 2, 3]
    names = ("probability_falls", "fall_north", "fall_east", "members")
    weight = case_weight_in_direction_statistics(*(found[0][name] for name in names)).ravel()
    assert weight == pytest.approx([1.0, 0.0, *[1.0] * 7], abs=1e-3)


def test_case_weight_is_the_unbiased_resultant_of_fall_directions_of_members() -> None:
    """The weight of a case is the resultant of the fall directions of its members, corrected for bias.

    The directions of eight members are drawn from von Mises distributions of known resultant. Without correction, the
    mean resultant is 0.31 where the true one is 0.
    """
    generator, count = np.random.default_rng(5), 4000
    for kappa in (0.0, 0.5, 2.0, 8.0):
        truth = i1(kappa) / i0(kappa)
        angle = generator.vonmises(0.3, kappa, (count, 8)) if kappa else generator.uniform(0, 2 * np.pi, (count, 8))
        parts = np.cos(angle).mean(axis=1), np.sin(angle).mean(axis=1)
        square = (8 * np.hypot(*parts) ** 2 - 1) / 7
        weight = case_weight_in_direction_statistics(np.ones(count), *parts, np.full(count, 8))
        assert weight**2 == pytest.approx(np.clip(square, 0, 1))
        assert square.mean() == pytest.approx(truth**2, abs=0.01), "unbiased before it is cut at 0"
        plain = np.hypot(*parts).mean()
        assert abs(weight.mean() - truth) < max(abs(plain - truth), 0.02)
        # Half of the members stand: the means over all are half as long, and four fall.
        fewer = case_weight_in_direction_statistics(
            np.full(count, 0.5), 0.5 * parts[0], 0.5 * parts[1], np.full(count, 8)
        )
        assert fewer**2 == pytest.approx(np.clip((4 * np.hypot(*parts) ** 2 - 1) / 3, 0, 1))
    assert case_weight_in_direction_statistics(np.nan, np.nan, np.nan, 0) == 1.0
    assert case_weight_in_direction_statistics(1 / 8, 1 / 8, 0.0, 8) == 1.0


def test_an_ensemble_without_spread_gives_the_nominal_outcome(
    motion_of_two_cycles_with_vertical: Motion, outcomes_without_ensemble: dict[str, np.ndarray]
) -> None:
    members = draw_parameter_changes_of_members(
        EnsembleSettings(members=4, amplitude=0, b_over_h=0, friction=0, damping=0, azimuth=0)
    )
    found = ensemble_statistics_of_grid(motion_of_two_cycles_with_vertical, outcomes_without_ensemble, members)
    assert np.array_equal(
        found["probability_towards"], (outcomes_without_ensemble["overturned"] == 1).astype(np.float32)
    )
    assert np.array_equal(found["probability_away"], (outcomes_without_ensemble["overturned"] == -1).astype(np.float32))
    assert (found["members"] == 4).all()
    assert (found["scramble_difference_towards"] == 0).all()


def test_ensemble_probabilities_equal_those_of_members_run_one_by_one(
    motion_of_two_cycles_with_vertical: Motion, outcomes_without_ensemble: dict[str, np.ndarray]
) -> None:
    members = draw_parameter_changes_of_members(EnsembleSettings(members=8, amplitude=0.2, b_over_h=0.1))
    found = ensemble_statistics_of_grid(motion_of_two_cycles_with_vertical, outcomes_without_ensemble, members)
    cell = (1, 0, 2, 1)
    flags = [
        int(
            run_cases(
                motion_of_two_cycles_with_vertical,
                Cases(
                    60 + members.azimuth_change_deg[j], 0.6, 0.3 * members.b_over_h_factor[j],
                    1.0 * members.friction_factor[j],
                    members.amplitude_factor[j], members.damping_factor[j], members.initial_tilt_rad[j],
                ),
            ).overturned[0]
        )
        for j in range(8)
    ]  # fmt: skip
    assert found["probability_towards"][cell] == pytest.approx(np.mean(np.array(flags) == 1))
    assert found["probability_away"][cell] == pytest.approx(np.mean(np.array(flags) == -1))
    halves = np.array(flags).reshape(2, 4) != 0
    difference = found["scramble_difference_towards"][cell] + found["scramble_difference_away"][cell]
    assert difference == pytest.approx(halves[0].mean() - halves[1].mean())


@pytest.mark.parametrize(
    ("name", "most"), [("MAX_ROTATED_MOTION_SAMPLES_IN_MEMORY", 2 * 8 * 400), ("MAX_MEMBER_CASES_PER_RUN", 2 * 8 * 10)]
)
def test_an_ensemble_is_run_in_pieces_within_the_memory_limit(
    motion_of_two_cycles_with_vertical: Motion, monkeypatch: pytest.MonkeyPatch, name: str, most: int
) -> None:
    """There are six directions with ten cases, eight members each and 400 samples per motion.

    The limit allows two directions at a time.
    """
    grid = GRID.copy_with_dimension_values(height=np.array([0.6, 1.2]), friction=np.array([1.0]))
    members = draw_parameter_changes_of_members(EnsembleSettings(members=8))
    nothing = {name: np.zeros(grid.shape, np.int8) for name in ("overturned", "mirrored")}
    calls = []

    def fake_results_all_standing(cases: Cases, progress: ProgressCallback | None) -> Any:
        calls.append(np.column_stack([cases.azimuth_deg, cases.height, cases.b_over_h, cases.friction]))
        return SimpleNamespace(overturned=np.zeros(len(calls[-1]), np.int8), block_steps=np.ones(len(calls[-1])))

    monkeypatch.setattr(ensemble, name, most)
    found = EnsembleRunner(PlanarModel(), members).choose_cases_and_run_their_ensembles(
        motion_of_two_cycles_with_vertical, grid, nothing, fake_results_all_standing
    )[0]
    held = [
        (np.unique(cases[:, 0]).size * motion_of_two_cycles_with_vertical.sample_count, len(cases)) for cases in calls
    ]
    assert held == [(2 * 8 * 400, 2 * 8 * 10)] * 3
    assert len(np.unique(np.concatenate(calls), axis=0)) == 6 * 10 * 8, "each member of each cell once"
    assert (found["members"] == 8).all()


def test_opposite_azimuths_exchange_the_probabilities_of_both_fall_sides(
    motion_of_two_cycles_with_vertical: Motion, outcomes_without_ensemble: dict[str, np.ndarray]
) -> None:
    members = draw_parameter_changes_of_members(
        EnsembleSettings(members=8, amplitude=0.2, b_over_h=0.1, initial_tilt=0.02)
    )
    found = ensemble_statistics_of_grid(motion_of_two_cycles_with_vertical, outcomes_without_ensemble, members)
    assert outcomes_without_ensemble["mirrored"][3:].all()
    for name in ("probability", "scramble_difference"):
        assert np.array_equal(found[f"{name}_towards"][3:], found[f"{name}_away"][:3])
        assert np.array_equal(found[f"{name}_away"][3:], found[f"{name}_towards"][:3])
    assert ((found["probability_towards"] > 0) & (found["probability_towards"] < 1)).any()


def test_ensemble_batches_contain_equal_numbers_of_both_sobol_scrambles() -> None:
    members = draw_parameter_changes_of_members(EnsembleSettings())
    batches = members.split_members_into_batches_of_both_sequences(MEMBERS_PER_BATCH)
    assert [batch.size for batch in batches] == [8, 8, 8]
    assert sorted(np.concatenate(batches)) == list(range(24))
    for batch in batches:
        assert members.select_members(batch).sobol_sequence_number.tolist() == [0, 0, 0, 0, 1, 1, 1, 1]
    # Fewer members are the first of more, so that a larger number only adds to them.
    few, size = draw_parameter_changes_of_members(EnsembleSettings(members=16)), 16
    assert np.array_equal(
        few.amplitude_factor[np.concatenate(few.split_members_into_batches_of_both_sequences(MEMBERS_PER_BATCH))],
        members.amplitude_factor[np.concatenate(batches)[:size]],
    )


def test_ensembles_whose_members_agree_converge_with_fewer_members() -> None:
    flags = np.full((5, 24), -128, np.int8)
    flags[0, :8] = 1  # all alike
    flags[1, :8] = [1, 1, 1, 1, 1, 1, 1, 0]
    flags[2, :16] = [1] * 3 + [0] * 13
    flags[3, :16] = [-1] * 4 + [1] * 12
    flags[4] = [1] * 12 + [-1] * 12
    assert fall_probability_convergence_mask(flags, 0.19).tolist() == [True, False, True, False, True]
    assert not fall_probability_convergence_mask(flags, 0.0).any()
    assert not fall_probability_convergence_mask(
        np.full((1, 24), -128, np.int8), 0.19
    ).any()  # no member has an outcome
    elements = np.stack([flags, np.broadcast_to(flags[:1], flags.shape)], axis=2)
    assert np.array_equal(
        fall_probability_convergence_mask(elements, 0.19),
        fall_probability_convergence_mask(flags, 0.19),
    )  # every element counts


def test_adaptive_member_count_of_a_cell_ignores_the_other_cells(
    motion_of_two_cycles_with_vertical: Motion, outcomes_without_ensemble: dict[str, np.ndarray]
) -> None:
    members = draw_parameter_changes_of_members(EnsembleSettings(amplitude=0.1, b_over_h=0.05))
    every = ensemble_statistics_of_grid(motion_of_two_cycles_with_vertical, outcomes_without_ensemble, members)
    some = ensemble_statistics_of_grid(
        motion_of_two_cycles_with_vertical,
        outcomes_without_ensemble,
        members,
        max_fall_probability_interval_half_width=0.19,
    )
    assert set(np.unique(some["members"])) == {8, 16, 24}
    assert (every["members"] == 24).all()
    whole = some["members"] == 24
    for name in ("probability_towards", "scramble_difference_away"):
        assert np.array_equal(every[name][whole], some[name][whole])
    # Whatever stands beside it, a cell has the same members.
    for flat in np.flatnonzero(outcomes_without_ensemble["mirrored"] == 0)[::7]:
        place = np.unravel_index(flat, GRID.shape)
        one = GRID.copy_with_dimension_values(
            **{name: GRID[name][[at]] for name, at in zip(GRID.dimension_names, place, strict=True)}
        )
        own = {
            name: values[tuple(slice(at, at + 1) for at in place)] for name, values in outcomes_without_ensemble.items()
        }
        few = EnsembleRunner(PlanarModel(), members, max_fall_probability_interval_half_width=0.19)
        alone = few.choose_cases_and_run_their_ensembles(
            motion_of_two_cycles_with_vertical,
            one,
            own,
            lambda cases, _: run_cases(motion_of_two_cycles_with_vertical, cases),
        )[0]
        for variable in PLANE_ENSEMBLE_VARIABLES:
            assert alone[variable.name].item() == some[variable.name][place].item()


def test_a_recheck_finds_only_the_changed_values_if_ensembles_stopped_early(tmp_path: Path) -> None:
    study = study_from_content(
        {
            "name": "few", "records": {"use": ["pulse"]}, "azimuth": {"start": 0, "stop": 360, "step": 60},
            "height": [0.6], "b_over_h": [0.2, 0.3, 0.4], "friction": [1.0], "verification": "none",
            "ensemble": {"where": "everywhere", "amplitude": 0.2, "b_over_h": 0.1},
        },
        "few.yaml",
    )  # fmt: skip
    simulate_study_cube(study, [sine_cycle_record("pulse")], tmp_path)
    with open_cube(tmp_path / "cube.nc") as cube:
        assert len(np.unique(cube["members"].to_numpy())) > 1
    with netCDF4.Dataset(tmp_path / "cube.nc", "a") as cube:
        cube["peak_penetration"][:] = 99.0
    found = recompute_and_compare_random_cases(tmp_path / "cube.nc", max_random_case_count=18)
    assert found.recomputed_cell_count == found.cell_count_with_recomputed_ensemble == 18
    # What was changed is found in every cell, each of them looked at once, and nothing else.
    assert len(set(found.difference_messages)) == len(found.difference_messages) == 18
    assert all("peak_penetration is 99.0 in the cube" in line for line in found.difference_messages)


@cache
def _stopping_rule_ends_ensemble(falls: int, size: int, max_interval_width: float) -> bool:
    """Return whether the stopping rule ends an ensemble after `size` members, of which `falls` fall."""
    flags = np.array([[1] * falls + [0] * (size - falls)], np.int8)
    return bool(fall_probability_convergence_mask(flags, max_interval_width)[0])


def _stopping_probability_by_falls_and_members(
    probability: float, max_interval_width: float, batches: list[int]
) -> dict[tuple[int, int], float]:
    """Return the exact probability that an ensemble ends with k falls of n members, by (k, n)."""
    going, ended, size = {0: 1.0}, {}, 0
    for batch in batches:
        size += batch
        more = binom.pmf(np.arange(batch + 1), batch, probability)
        reached = np.zeros(size + 1)
        for falls, chance in going.items():
            reached[falls : falls + batch + 1] += chance * more
        going = {}
        for falls, chance in enumerate(reached):
            if _stopping_rule_ends_ensemble(falls, size, max_interval_width) or size == sum(batches):
                ended[falls, size] = chance
            else:
                going[falls] = chance
    return ended


def test_intervals_with_early_stopping_cover_as_well_as_those_of_16_members() -> None:
    """The coverage of Wilson intervals is computed exactly at known probabilities.

    With early stopping no half-width exceeds the stated limit of 0.19.
    """
    coverage, error, widest, interval = {}, {}, {}, cache(wilson_95_percent_interval)
    for batches in ([16], [8, 8, 8]):
        covered, square, widths = [], [], [0.0]
        for probability in np.linspace(0, 1, 101):
            cover = off = 0.0
            for (falls, size), chance in _stopping_probability_by_falls_and_members(probability, 0.19, batches).items():
                low, high = (float(end) for end in interval(falls, size))
                half = (high - low) / 2
                cover += chance * (low - 1e-12 <= probability <= high + 1e-12)
                off += chance * (falls / size - probability) ** 2
                widths.append(half)
            covered.append(cover)
            square.append(off)
        key = len(batches)
        coverage[key], error[key], widest[key] = np.array(covered), np.sqrt(square), max(widths)
    assert widest[3] <= 0.19 < widest[1]
    assert coverage[3].mean() >= max(0.95, coverage[1].mean())
    assert coverage[3].min() > 0.91 > coverage[1].min()
    assert error[3].max() < error[1].max()


def test_ensemble_probabilities_are_missing_where_no_members_were_run(
    motion_of_two_cycles_with_vertical: Motion, outcomes_without_ensemble: dict[str, np.ndarray]
) -> None:
    members = draw_parameter_changes_of_members(EnsembleSettings(members=4))
    found = ensemble_statistics_of_grid(
        motion_of_two_cycles_with_vertical, outcomes_without_ensemble, members, run_all_cells=False
    )
    chosen = mask_of_cases_for_ensemble_runs(outcomes_without_ensemble["overturned"], choose_all_cells=False)
    assert 0 < chosen.sum() < chosen.size
    assert np.array_equal(np.isfinite(found["probability_towards"]), chosen)
    assert np.array_equal(found["members"] > 0, chosen)


def test_memory_limit_does_not_change_ensemble_results(
    motion_of_two_cycles_with_vertical: Motion,
    outcomes_without_ensemble: dict[str, np.ndarray],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    members = draw_parameter_changes_of_members(EnsembleSettings(members=4, amplitude=0.1))
    whole = ensemble_statistics_of_grid(motion_of_two_cycles_with_vertical, outcomes_without_ensemble, members)
    monkeypatch.setattr("overturning.study.ensemble.MAX_ROTATED_MOTION_SAMPLES_IN_MEMORY", 1)
    reports: list[tuple[int, int]] = []
    pieces = ensemble_statistics_of_grid(
        motion_of_two_cycles_with_vertical,
        outcomes_without_ensemble,
        members,
        progress=lambda done, total: reports.append((done, total)),
    )
    for variable in PLANE_ENSEMBLE_VARIABLES:
        assert np.array_equal(whole[variable.name], pieces[variable.name], equal_nan=True)
    shares = [done / total for done, total in reports]
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1)
