"""The ensemble: its members, the cells it runs, and what it finds."""

from pathlib import Path

import numpy as np
import pytest

from overturning.dem.cases import Cases
from overturning.dem.grid import Grid
from overturning.dem.numerics import Progress
from overturning.dem.results import Results
from overturning.dem.run import run_cases
from overturning.dem.simulate import simulate_arrays
from overturning.errors import ConfigError, ResultError
from overturning.motion.motion import Motion
from overturning.study.ensemble import ENSEMBLE_VARIABLES, cells_to_run, run_ensemble
from overturning.study.load import check_study
from overturning.study.members import Members, draw_members, read_members, write_members
from overturning.study.sections import Ensemble

AZIMUTH = np.arange(0, 360, 60, dtype=np.int16)
GRID = Grid(AZIMUTH, np.array([0.6]), np.array([0.1, 0.2, 0.3, 0.4, 0.5]), np.array([0.5, 1.0]))


@pytest.fixture(scope="module")
def motion() -> Motion:
    time = np.arange(0, 4, 0.01)
    pulse = np.where((time > 1) & (time < 1.8), 6.0 * np.sin(2 * np.pi * (time - 1) / 0.8), 0.0)
    return Motion(pulse, 0.3 * np.roll(pulse, 20), sampling_interval=0.01)


@pytest.fixture(scope="module")
def nominal(motion: Motion) -> dict[str, np.ndarray]:
    return simulate_arrays(
        motion, azimuth_deg=AZIMUTH.astype(float), height=GRID.height, b_over_h=GRID.b_over_h, friction=GRID.friction
    )


def run(motion: Motion, nominal: dict[str, np.ndarray], members: Members, everywhere: bool = True, **more):
    def members_of(cases: Cases, progress: Progress | None) -> Results:
        return run_cases(motion, cases, progress=progress, threads=2)

    return run_ensemble(motion, GRID, nominal, members, members_of, everywhere=everywhere, **more)[0]


def test_members_fill_their_neighbourhood_and_no_more() -> None:
    settings = Ensemble(members=64, initial_tilt=0.01)
    members = draw_members(settings)
    assert members.size == 64
    for name in ("amplitude", "b_over_h", "friction", "damping"):
        width, factor = getattr(settings, name), getattr(members, name)
        assert np.abs(factor - 1).max() <= width
        assert np.abs(factor - 1).max() > 0.9 * width
        for scramble in (0, 1):  # each scramble is balanced by itself: one point in every 32nd part
            place = np.floor((factor[members.scramble == scramble] - 1 + width) / (2 * width) * 32).astype(int)
            assert sorted(np.clip(place, 0, 31)) == list(range(32))
    assert np.abs(members.azimuth_deg).max() <= 2
    assert np.abs(members.initial_tilt).max() <= 0.01


def test_members_depend_on_the_seed_alone(tmp_path: Path) -> None:
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        write_members(draw_members(Ensemble(seed=seed)), tmp_path / name)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes() != (tmp_path / "c").read_bytes()
    members, again = draw_members(Ensemble()), read_members(tmp_path / "a")
    for name in ("scramble", "amplitude", "azimuth_deg", "initial_tilt"):
        assert np.array_equal(getattr(members, name), getattr(again, name))


def test_a_wrong_table(tmp_path: Path) -> None:
    for text in (
        "",
        "a,b\n1,2\n",
        "scramble,amplitude,b_over_h,friction,damping,azimuth_deg,initial_tilt\n0,x,1,1,1,0,0\n",
    ):
        (tmp_path / "members.csv").write_text(text)
        with pytest.raises(ResultError, match=r"members\.csv"):
            read_members(tmp_path / "members.csv")


def test_odd_members_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"ensemble.members.*even"):
        check_study({"name": "x", "records": {"use": ["a"]}, "ensemble": {"members": 7}}, "x.yaml")


def test_cells_near_a_change() -> None:
    flags = np.array([1, 1, 1, 1, 0, 0, 0, 0, 0, 0], np.int8)[None, None, :, None]
    assert cells_to_run(flags, everywhere=False)[0, 0, :, 0].nonzero()[0].tolist() == [2, 3, 4, 5]
    assert cells_to_run(flags, everywhere=True).all()
    assert not cells_to_run(np.zeros_like(flags), everywhere=False).any()
    side = np.array([1, -1, -1, -1, -1, -1], np.int8)[None, None, :, None]
    assert cells_to_run(side, everywhere=False)[0, 0, :, 0].nonzero()[0].tolist() == [0, 1, 2]
    assert cells_to_run(np.zeros((3, 1, 1, 2), np.int8), everywhere=False).all()


def test_no_spread_gives_the_nominal_answer(motion: Motion, nominal: dict[str, np.ndarray]) -> None:
    members = draw_members(Ensemble(members=4, amplitude=0, b_over_h=0, friction=0, damping=0, azimuth=0))
    found = run(motion, nominal, members)
    assert np.array_equal(found["probability_towards"], (nominal["overturned"] == 1).astype(np.float32))
    assert np.array_equal(found["probability_away"], (nominal["overturned"] == -1).astype(np.float32))
    assert (found["members"] == 4).all()
    assert (found["scramble_difference_towards"] == 0).all()


def test_spread_is_that_of_the_members_run_one_by_one(motion: Motion, nominal: dict[str, np.ndarray]) -> None:
    members = draw_members(Ensemble(members=8, amplitude=0.2, b_over_h=0.1))
    found = run(motion, nominal, members)
    cell = (1, 0, 2, 1)
    flags = [
        int(
            run_cases(
                motion,
                Cases(
                    60 + members.azimuth_deg[j], 0.6, 0.3 * members.b_over_h[j], 1.0 * members.friction[j],
                    members.amplitude[j], members.damping[j], members.initial_tilt[j],
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


def test_mirrored_cells_exchange_the_sides(motion: Motion, nominal: dict[str, np.ndarray]) -> None:
    members = draw_members(Ensemble(members=8, amplitude=0.2, b_over_h=0.1, initial_tilt=0.02))
    found = run(motion, nominal, members)
    assert nominal["mirrored"][3:].all()
    for name in ("probability", "scramble_difference"):
        assert np.array_equal(found[f"{name}_towards"][3:], found[f"{name}_away"][:3])
        assert np.array_equal(found[f"{name}_away"][3:], found[f"{name}_towards"][:3])
    assert ((found["probability_towards"] > 0) & (found["probability_towards"] < 1)).any()


def test_where_it_is_not_run_it_is_missing(motion: Motion, nominal: dict[str, np.ndarray]) -> None:
    members = draw_members(Ensemble(members=4))
    found = run(motion, nominal, members, everywhere=False)
    chosen = cells_to_run(nominal["overturned"], everywhere=False)
    assert 0 < chosen.sum() < chosen.size
    assert np.array_equal(np.isfinite(found["probability_towards"]), chosen)
    assert np.array_equal(found["members"] > 0, chosen)


def test_the_same_in_any_portion(
    motion: Motion, nominal: dict[str, np.ndarray], monkeypatch: pytest.MonkeyPatch
) -> None:
    members = draw_members(Ensemble(members=4, amplitude=0.1))
    whole = run(motion, nominal, members)
    monkeypatch.setattr("overturning.study.ensemble.MOST_GROUND_VALUES", 1)
    reports: list[tuple[int, int]] = []
    pieces = run(motion, nominal, members, progress=lambda done, total: reports.append((done, total)))
    for variable in ENSEMBLE_VARIABLES:
        assert np.array_equal(whole[variable.name], pieces[variable.name], equal_nan=True)
    shares = [done / total for done, total in reports]
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1)
