"""The Python interface."""

import importlib.util
import inspect
import json
import pydoc
import re
import shutil
import struct
import sys
from collections.abc import Callable
from dataclasses import fields, replace
from operator import attrgetter
from pathlib import Path
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray
from typer.main import get_command as click_of

import overturning
from overturning.arrays import FloatArray
from overturning.cli import main
from overturning.commands import declared
from overturning.commands.application import app
from overturning.dem.numerics import NumericalOptions
from overturning.errors import ArgumentError, ConfigError, MissingDataError, ResultError
from overturning.figures.explore import explorer_page_data
from overturning.figures.ground import pseudo_acceleration_spectra_along_azimuths, smoothed_fourier_spectra
from overturning.figures.write import parse_font_family_and_size, remove_layout_engine_and_check_if_text_cut_or_overlaps
from overturning.model.contact import ContactSettings
from overturning.motion.intensity import intensity_dataset_by_azimuth
from overturning.motion.motion import Motion
from overturning.records.catalogue import RecordTableRow
from overturning.records.declared_properties import DeclaredFileProperties, FilePropertiesInTableRow
from overturning.records.store import write_record_to_motion_file
from overturning.study.intensity import write_intensity_measures
from overturning.study.load import study_from_content
from overturning.study.schema import Study
from overturning.study.sections import BodyShapeSettings, SimulationSettings
from tests.expect import expect_error, skip_test_unless_skipping_is_forbidden
from tests.study.small_study import simulate_study_cube, sine_cycle_record, small_study

WAVE = Motion.sine(6.0, 0.8)
CONTACT: Any = overturning.Contact()


def test_the_module_has_a_version_and_help_for_each_public_name() -> None:
    assert set(overturning.__all__) <= set(dir(overturning))
    assert overturning.__version__[0].isdigit()
    text = pydoc.plain(pydoc.render_doc(overturning))
    for name in overturning.__all__:
        assert name in text
        assert (getattr(overturning, name).__doc__ or "").strip()
    assert (Path(overturning.__file__).parent / "py.typed").is_file()


@pytest.mark.parametrize("face", [Motion, Motion.sine, Motion.from_obspy, overturning.Contact, overturning.simulate])
def test_the_error_for_an_unknown_keyword_lists_the_known_keywords(face: Callable[..., Any]) -> None:
    """The known keywords in the error message do not include `self` or `cls`, which Python itself passes."""
    with pytest.raises(ArgumentError, match=r"frobnicate: no keyword of .*; known are ") as found:
        face(frobnicate=1)
    named = str(found.value).partition("known are ")[2].split(", ")
    assert not {"self", "cls"} & set(named)
    assert set(inspect.signature(face).parameters) - {"numerics", "options", "given", "more"} >= set(named[:2])


def test_every_public_name_is_in_the_api_reference() -> None:
    text = (Path(__file__).parents[1] / "docs" / "reference" / "python.md").read_text(encoding="utf-8")
    parts = {path.rpartition(".")[2]: path for path in re.findall(r"^::: (overturning[\w.]+)$", text, re.MULTILINE)}
    assert set(overturning.__all__) - {*parts} == set()
    assert [path for path in parts.values() if not pydoc.locate(path)] == []


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: overturning.simulate(WAVE, "three-tier", azimuth_deg=[0]), "'three-tier'; give 'rectangle'"),
        (lambda: overturning.simulate(WAVE, CONTACT, azimuth_deg=[0]), "model: a Contact; give a scene"),
        (lambda: overturning.Body(contact=CONTACT), "contact: a Contact; a 3-D body has a Vertex"),
        (lambda: overturning.trajectory(WAVE, azimuth_deg=[0, 1]), "trajectory: 2 cases; give one value each"),
        (lambda: overturning.run_study("wtmc"), "give a list of them, run_study([record], …)"),
        (lambda: overturning.run_study(WAVE), "give a list of them, run_study([record], …)"),
        (lambda: overturning.run_study(None), "records: a NoneType; give a list of them"),
        (lambda: overturning.run_study({"one": WAVE}), "records: a dict; give a list of them"),
        (lambda: overturning.run_study(one for one in [WAVE, 3]), "records: a int; give a record"),
        (lambda: overturning.read([]), "paths: none; name the files"),
        (lambda: overturning.plot.fall_map(WAVE), "fall_map: a Motion; give a cube of overturning.open_cube"),
        (lambda: overturning.plot.fall_rose({}), "fall_rose: a dict; give a cube of overturning.open_cube"),
        (lambda: overturning.plot.hodograph(cube=WAVE), "time_histories and spectra draw a motion"),
    ],
)
def test_wrong_argument_types_give_plain_errors(call: Callable[[], Any], message: str) -> None:
    with expect_error(ArgumentError, message, brief=True):
        call()


def test_an_obspy_stream_in_place_of_a_motion_gives_a_plain_error() -> None:
    from obspy import Stream

    with pytest.raises(ArgumentError, match=r"an obspy Stream; convert it with Motion\.from_obspy"):
        overturning.simulate(Stream(), azimuth_deg=[0])
    with pytest.raises(ArgumentError, match=r"a ndarray; give a Motion"):
        overturning.trajectory(np.zeros(3), azimuth_deg=0)


def test_a_record_can_be_read_simulated_and_used_in_a_study_from_python(tmp_path: Path) -> None:
    wave = Motion.sine(6.0, 0.8, azimuth_deg=60)
    time = np.arange(wave.sample_count) * wave.sampling_interval
    rows = [f"{t:.3f},{100 * n:.6f},{100 * e:.6f}" for t, n, e in zip(time, wave.north, wave.east, strict=True)]
    (tmp_path / "pulse.csv").write_text("\n".join(["time,north,east", *rows]) + "\n", encoding="utf-8")
    columns = "time:s north:gal east:gal"
    record = overturning.read(tmp_path / "pulse.csv", columns=columns, processed=True)
    assert Motion.from_record(record).acceleration_along(60).max() == pytest.approx(6.0, rel=1e-3)
    with pytest.raises(ArgumentError, match=r"units: no keyword of read; did you mean unit\?"):
        overturning.read(tmp_path / "pulse.csv", units="gal")
    grid = {"b_over_h": [0.2, 0.4], "height": [0.6], "friction": [1.0]}
    halved = overturning.read(
        tmp_path / "pulse.csv", columns=columns, processed=True, processing=[{"step": "scale", "factor": 0.5}]
    )
    np.testing.assert_array_equal(halved.north, 0.5 * record.north)
    with pytest.raises(ArgumentError, match=r"processing\.0\.factor: this key is needed"):
        overturning.read(tmp_path / "pulse.csv", columns=columns, processed=True, processing=[{"step": "scale"}])
    outcome = overturning.simulate(record, azimuth_deg=[60, 150, 240, 330], **grid)
    assert overturning.to_dataframe(outcome)["overturned"].tolist() == outcome["overturned"].to_numpy().ravel().tolist()
    cube = overturning.run_study([record], azimuth={"step": 30}, ensemble={"members": 0}, **grid)
    assert cube["record_id"].to_numpy().tolist() == ["pulse"]
    np.testing.assert_array_equal(
        cube["overturned"].sel(azimuth=[60, 150, 240, 330]).squeeze("record").to_numpy(),
        outcome["overturned"].to_numpy(),
    )
    with pytest.raises(ConfigError, match="azimth: unknown key; did you mean azimuth"):
        overturning.run_study([record], azimth={"step": 30})
    with pytest.raises(ConfigError, match="processing: a record or motion that is given is taken as it is"):
        overturning.run_study([record], processing=[{"step": "scale", "factor": 2.0}])
    with pytest.raises(ConfigError, match="variants: one cube is returned, that of the study itself"):
        overturning.run_study([record], variants={"paper": {"contact": {"damping": 3500}}})


@pytest.fixture(scope="module")
def cube_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Path of a cube of two pulses, in a folder that also holds the motions and their intensity measures."""
    folder, settings = tmp_path_factory.mktemp("cube"), small_study(ensemble={"members": 0})
    records = [sine_cycle_record(), replace(sine_cycle_record("b", 3.0), fault_strike_deg=30.0)]
    write_intensity_measures(settings, records, folder / "intensity.nc")
    return simulate_study_cube(settings, records, folder)


def test_a_cube_is_opened_from_a_path_string_and_selected_by_record_id(cube_file: Path) -> None:
    inside = xr.open_dataset(cube_file, decode_timedelta=False)
    for asked, known in (({"amplitude": 2.0}, "amplitude 2; known: 1"), ({"element": "roof"}, "'roof'; known: stone")):
        with pytest.raises(ResultError, match=f"no .*{known}"):
            overturning.open_cube(cube_file, **asked)
    overturning.open_cube(cube_file, element="stone").close()
    with overturning.open_cube(str(cube_file)) as cube:
        second = cube["overturned"].sel(record="b", azimuth=60)
        np.testing.assert_array_equal(second, inside["overturned"].isel(record=1).sel(azimuth=60))
        assert cube["record_id"].to_numpy().tolist() == ["a", "b"]
    assert inside["record"].to_numpy().tolist() == [0, 1]


def test_a_saved_selection_of_one_amplitude_keeps_its_amplitude_factor(tmp_path: Path) -> None:
    grid = {"azimuth": {"step": 180}, "b_over_h": [0.2, 0.4], "height": [0.6], "ensemble": {"members": 0}}
    cube = overturning.run_study([WAVE], scene="three-tier", amplitude=[1, 2], **grid)
    cube.to_netcdf(tmp_path / "whole.nc")
    cube.sel(amplitude=2.0).to_netcdf(tmp_path / "twice.nc")
    for name in (None, *cube["element"].to_numpy().tolist()):
        own = cube["overturned"] if name is None else cube["overturned"].sel(element=name)
        with overturning.open_cube(tmp_path / "whole.nc", element=name, amplitude=2) as again:
            np.testing.assert_array_equal(again["overturned"], own.sel(amplitude=2.0))
    with pytest.raises(ResultError, match=r"twice\.nc: no amplitude 1; known: 2"):  # it was taken for that as recorded
        overturning.open_cube(tmp_path / "twice.nc")
    with overturning.open_cube(tmp_path / "twice.nc", amplitude=2) as twice:
        assert "motion × 2" in overturning.plot.fall_map(twice).get_suptitle()


def test_a_record_is_accepted_in_place_of_a_motion() -> None:
    record, azimuth = sine_cycle_record(), [0.0, 30.0]
    motion = Motion.of(record)
    for draw in (smoothed_fourier_spectra, pseudo_acceleration_spectra_along_azimuths):
        np.testing.assert_allclose(draw(record, azimuth)[1], draw(motion, azimuth)[1], rtol=0, atol=1e-12)
    assert intensity_dataset_by_azimuth(record, azimuth).equals(intensity_dataset_by_azimuth(motion, azimuth))
    cases = overturning.Cases([0.0], 0.6, 0.2, 1.0)
    assert overturning.run_cases(record, cases).overturned == overturning.run_cases(motion, cases).overturned
    one = {"azimuth_deg": 0, "height": 0.6, "b_over_h": 0.2}
    assert overturning.trajectory(record, **one).equals(overturning.trajectory(motion, **one))
    grid = {"azimuth": {"step": 90}, "b_over_h": [0.2], "height": [0.6], "ensemble": {"members": 0}}
    both = overturning.run_study([record, motion], **grid)["overturned"]
    assert both.isel(record=0).equals(both.isel(record=1).assign_coords(both.isel(record=0).coords))
    assert both.sel(record="motion-2").sizes["azimuth"] == 4


def test_a_sine_cycle_has_the_expected_repr_velocity_and_displacement() -> None:
    record = sine_cycle_record()  # a cycle of 6 sin(2πt/T) with T = 0.8 s: its velocity ends at 0, and comes to 6 T/π
    motion = Motion.of(record)
    assert repr(motion) == "<Motion: 400 samples of 0.01 s, north and east, horizontal peak 6.26 m/s²>"
    assert repr(record) == "<Record a (S, E): 400 samples of 0.01 s, north and east, horizontal peak 6.26 m/s²>"
    north, east = record.velocity
    assert north.max() == pytest.approx(6 * 0.8 / np.pi, rel=1e-3)
    assert north[-1] == pytest.approx(0, abs=1e-9)
    np.testing.assert_allclose(east, 0.3 * north, rtol=1e-6, atol=1e-9)
    assert motion.displacement[0, -1] == pytest.approx(6 * 0.8**2 / (2 * np.pi), rel=1e-3)


@pytest.mark.parametrize("up", [None, 0.1])
def test_motion_survives_conversion_to_obspy_and_back(up: float | None) -> None:
    wave = Motion.sine(6.0, 0.8, azimuth_deg=60)
    motion = Motion(wave.north, wave.east, None if up is None else up * wave.north, sampling_interval=0.005)
    stream = motion.to_obspy()
    assert [trace.stats.channel for trace in stream] == ["HNN", "HNE", "HNZ"][: len(motion.components)]
    assert {(trace.stats.delta, trace.stats.unit) for trace in stream} == {(0.005, "m/s2")}
    back = Motion.from_obspy(stream)
    np.testing.assert_array_equal(np.array(back.components), np.array(motion.components))
    record = replace(sine_cycle_record(), start="2016-11-13T11:02:56.5")
    assert str(record.to_obspy()[0].stats.starttime) == "2016-11-13T11:02:56.500000Z"
    assert Motion.from_obspy(record.to_obspy()).acceleration_along(0).max() == record.north.max()


def run_command_and_return_exit_status(*words: str) -> int:
    """Run an `overturning` command in this process and return its exit status."""
    with pytest.raises(SystemExit) as stop:
        main(list(words))
    return int(stop.value.code or 0)


def polar_map_heading_with_study_friction(cube: xr.Dataset, folder: Path, friction: float) -> str:
    """Return height and friction in a polar map's heading if study.yaml next to the cube selects a friction.

    Check that the explorer page selects the same friction.
    """
    said = json.loads(cube.attrs["study"]) | {"figures": {"friction": friction}}
    (folder / "study.yaml").write_text(json.dumps(said))
    beside = cube.copy()
    beside.encoding["source"] = str(folder / "cube.nc")
    both = explorer_page_data(beside), explorer_page_data(cube, study=study_from_content(said, "said"))
    assert [cube["friction"][data["shown"]["friction"]].item() for data in both] == [friction, friction]
    return height_and_friction_in_heading(overturning.plot.fall_map(beside, "b"))


def height_and_friction_in_heading(figure: Figure) -> str:
    """Return the height and friction of the block in the heading of a polar map."""
    return figure.get_suptitle().splitlines()[-1].partition(";")[0]


def cube_repeated_for_two_frictions(cube: xr.Dataset) -> xr.Dataset:
    """Return a cube that repeats the outcomes of another one for the frictions 0.5 and 1."""
    several = xr.concat([cube.assign_coords(friction=[mu]) for mu in (0.5, 1.0)], "friction", data_vars="all")
    several.attrs["study"] = json.dumps(json.loads(cube.attrs["study"]) | {"friction": [0.5, 1.0]})
    return several


@pytest.mark.long
def test_each_cube_figure_is_drawn_without_changing_matplotlib_settings(cube_file: Path, tmp_path: Path) -> None:
    mpl.use("svg")
    before = dict(mpl.rcParams)
    kept, cube = plt.get_fignums(), overturning.open_cube(cube_file)
    several = cube_repeated_for_two_frictions(cube)
    for kind, draw in overturning.plot.CUBE_FIGURE_FUNCTIONS.items():
        if kind == "follow":
            with pytest.raises(ArgumentError, match="follow: a cube without orientation has no such figure"):
                draw(cube)
            continue
        figure = draw(cube, "b") if "record" in inspect.signature(draw).parameters else draw(cube)
        assert figure._repr_png_().startswith(b"\x89PNG"), kind  # what a notebook shows
    assert mpl.get_backend() == "svg"
    assert dict(mpl.rcParams) == before
    assert plt.get_fignums() == kept  # those of other tests
    maps = {kind: overturning.plot.CUBE_FIGURE_FUNCTIONS[kind](several, "b") for kind in ("polar", "blocks")}
    assert height_and_friction_in_heading(maps["polar"]) == "µ = 1, H = 0.6 m"  # what the study shows first
    assert [axes.get_title() for axes in maps["blocks"].axes] == ["µ = 0.5", "µ = 1"]
    assert (
        height_and_friction_in_heading(overturning.plot.fall_map(several.sel(friction=[0.5]), "b"))
        == "µ = 0.5, H = 0.6 m"
    )
    assert [polar_map_heading_with_study_friction(several, tmp_path, mu) for mu in (0.5, 1.0)] == [
        "µ = 0.5, H = 0.6 m",
        "µ = 1, H = 0.6 m",
    ]
    with pytest.raises(ArgumentError, match="recrd: no keyword of fall_map; did you mean record"):
        overturning.plot.fall_map(cube, recrd="b")
    with pytest.raises(ArgumentError, match=r"2 records; name one as record \(--record\): a, b$"):
        overturning.plot.fall_map(cube)
    with pytest.raises(ArgumentError, match="no record 'b'; it has a"):  # whose map was that of a
        overturning.plot.fall_map(cube.sel(record="a"), "b")
    assert len(overturning.plot.fall_map(cube.sel(record="a")).axes) == len(overturning.plot.fall_map(cube, "a").axes)
    with pytest.raises(ArgumentError, match="record: 'b'; it chooses a record of a cube"):
        overturning.plot.time_histories(sine_cycle_record(), "b")
    of_one = overturning.plot.spectra(sine_cycle_record(), 30).axes[0].get_legend_handles_labels()[1]
    assert of_one == ["N30°E"]
    assert Motion.sine(6.0, 0.8).plot().axes[0].get_title() == sine_cycle_record().plot().axes[0].get_title() == "north"
    mpl.use("Agg")


def test_a_variant_with_its_own_soil_is_drawn_with_its_own_motions(cube_file: Path, tmp_path: Path) -> None:
    soil = {"layers": [{"thickness_m": 20, "velocity_m_s": 150}], "rock": {"velocity_m_s": 760}}
    shutil.copytree(cube_file.parent, tmp_path, dirs_exist_ok=True)
    write_record_to_motion_file(sine_cycle_record("b", 5.0), tmp_path / "motion" / "soft" / "b.nc")
    soft = overturning.open_cube(tmp_path / "cube.nc").load()
    said = json.loads(soft.attrs["study"]) | {"variants": {"soft": {"site": soil}}}
    soft.attrs |= {"study": json.dumps(said), "variant": "soft"}
    shown = [overturning.plot.hodograph(cube, "b") for cube in (soft, overturning.open_cube(cube_file))]
    peaks = [f"{100 * peak * np.hypot(1, 0.3):.0f} Gal" for peak in (5.0, 3.0)]
    assert [figure.axes[0].get_title().split("\n")[1].partition(" towards")[0] for figure in shown] == peaks
    with pytest.raises(MissingDataError, match=r"measures of the variant soft do not exist"):
        overturning.plot.outcomes_by_pga_and_pgv_ratio(soft)


def test_output_of_a_variant_is_labelled_and_in_separate_files(
    cube_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    settings = small_study(ensemble={"members": 0}, variants={"stiff": {"contact": {"damping_ratio": 1}}})
    records = [replace(one, fault_strike_deg=10.0) for one in (sine_cycle_record(), sine_cycle_record("b", 3.0))]
    path, stones = simulate_study_cube(settings, records, tmp_path, "stiff"), tmp_path / "stones.csv"
    (tmp_path / "explore.html").write_text("of the study itself", encoding="utf-8")
    assert run_command_and_return_exit_status("explore", str(path), "--record", "b", "--record", "b") == 0
    assert capsys.readouterr().out == f"{tmp_path / 'explore.stiff.html'}\n"
    assert (tmp_path / "explore.html").read_text(encoding="utf-8") == "of the study itself"
    stones.write_text("octant\nN\n", encoding="utf-8")
    assert run_command_and_return_exit_status("survey", str(stones), "--cube", str(path), "--record", "b") == 0
    assert "\nstones.csv against b, variant stiff\n" in capsys.readouterr().out
    cube = overturning.open_cube(path)
    for draw in (
        overturning.plot.fall_rose,
        overturning.plot.fall_roses_by_earthquake,
        overturning.plot.fall_alignment_by_earthquake,
    ):
        assert draw(cube.assign_coords(amplitude=2.0)).get_suptitle() == "variant stiff, motion × 2"
    assert draw(cube).get_suptitle() == "variant stiff"
    assert draw(overturning.open_cube(cube_file)).get_suptitle() == ""


def test_the_polar_map_command_draws_each_named_friction(
    cube_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    several = cube_repeated_for_two_frictions(overturning.open_cube(cube_file))
    monkeypatch.setattr("overturning.study.cube.open_cube", lambda *_, **__: several)
    for words, titles in (((), ["1"]), (("0.5",), ["0.5"]), (("0.5", "1"), ["0.5", "1"])):
        path = tmp_path / "a.svg"
        named = [part for mu in words for part in ("--friction", mu)]
        assert (
            run_command_and_return_exit_status(
                "figure", "polar", str(cube_file), "--record", "b", *named, "-o", str(path)
            )
            == 0
        )
        assert re.findall(r"µ = ([\d.]+)", path.read_text(encoding="utf-8")) == titles


@pytest.mark.parametrize(("kind", "scale"), [(".png", 25.4 / 300), (".svg", 25.4 / 72), (".pdf", 25.4 / 72)])
def test_a_figure_has_the_requested_width_and_font_size(
    cube_file: Path, tmp_path: Path, kind: str, scale: float
) -> None:
    path = tmp_path / f"b{kind}"
    words = ["figure", "polar", str(cube_file), "--record", "b", "-o", str(path), "--dpi", "300"]
    assert run_command_and_return_exit_status(*words, "--width", "80mm", "--font", "6") == 0
    data = path.read_bytes()
    if kind == ".png":
        across = struct.unpack(">I", data[16:20])[0]
    else:
        across = float(
            re.search(rb'MediaBox ?\[ ?0 0 ([\d.]+)|svg [^>]*width="([\d.]+)pt"', data)[(kind == ".svg" and 2) or 1]
        )
    assert across * scale == pytest.approx(80, abs=0.1)
    if kind == ".svg":  # letters of 9 in a drawing that is shown at 6/9 of its size
        drawing = re.search(rb'viewBox="0 0 ([\d.]+) ', data)
        assert float(drawing[1]) == pytest.approx(across * 9 / 6, rel=1e-3)


def test_figure_text_that_does_not_fit_gives_a_warning(
    cube_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["figure", "boundary", str(cube_file), "--record", "b", "-o", str(tmp_path / "b.svg"), "--width", "80mm"]
    for font, told in (("4", False), ("12", True)):
        assert run_command_and_return_exit_status(*words, "--font", font) == 0
        assert ("text is cut off" in capsys.readouterr().out) == told


def test_overlapping_axis_labels_give_a_warning() -> None:
    """Two tick labels one inch apart fit; six tick labels over the same inch overlap."""
    for count, told in ((2, False), (6, True)):
        figure = Figure(figsize=(2.0, 2.0))
        axes = figure.add_axes((0.25, 0.25, 0.5, 0.5))
        places = np.linspace(0.0, 1.0, count)
        axes.set_xticks([*places, 9.0], [f"{place:.3f}" for place in places] + ["outside the panel"])
        axes.set_yticks([])
        axes.set_xlim(0.0, 1.0)
        FigureCanvasAgg(figure).draw()
        assert remove_layout_engine_and_check_if_text_cut_or_overlaps(figure) == told


def test_a_figure_for_a_paper_has_no_title_and_the_requested_font(cube_file: Path, tmp_path: Path) -> None:
    path = tmp_path / "b.svg"
    words = ["figure", "intensity", str(cube_file), "--record", "b", "-o", str(path)]
    for font, title, said, width in (("DejaVu Serif 8", "none", [], ""), ("DejaVu Serif", "Ours", ["Ours"], "80mm")):
        assert run_command_and_return_exit_status(*words, "--font", font, "--title", title, "--width", width) == 0
        text = path.read_text(encoding="utf-8")
        assert [name for name in ("Ours", "S, E", ">none<") if name in text] == said
        families = set(re.findall(r"(?:font-family: |font: [\d.]+px )'([^']+)'", text))
        assert families == {"DejaVu Serif"}
    assert 'width="226.77pt"' in text


@pytest.mark.parametrize(
    ("font", "expected"),
    [("8", (None, 8.0)), ("DejaVu Serif", ("DejaVu Serif", None)), ("DejaVu Serif 7.5", ("DejaVu Serif", 7.5))],
)
def test_the_font_option_takes_a_size_a_family_or_both(font: str, expected: tuple[str | None, float | None]) -> None:
    assert parse_font_family_and_size(font) == expected
    file = str(Path(mpl.get_data_path()) / "fonts" / "ttf" / "DejaVuSansMono.ttf")
    assert parse_font_family_and_size(f"{file} 9") == ("DejaVu Sans Mono", 9.0)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("polr",), "polr: no such figure; did you mean polar?"),
        (("contrast",), "convergence.json: no result of the convergence check"),
        (("fragility", "--height", "0.6"), "--height, --friction: fragility shows the whole study"),
        (("zzz",), "zzz: no such figure; known are polar, "),
        (("zzz",), "references, contrast, maps, scene, fall-rate, surveys, backwards, fragility"),
        (("rose", "--record", "b"), "--record: rose shows all records"),
        (
            ("intensity", "--record", "b", "--height", "0.6"),
            "--height, --friction: intensity shows the ground",
        ),
        (("polar", "--record", "c"), "no record 'c'; it has a, b"),
        (("polar", "--record", "b", "--width", "80mn"), "--width '80mn': unit 'mn' does not fit"),
        (("polar", "--record", "b", "--height", "0.7"), "--height 0.7: not in"),
        (("polar", "--record", "b", "--width", "20mm", "--font", "30"), "the text leaves no room"),
        (("polar", "--record", "b", "--font", "No Such Face 8"), "no font 'No Such Face' is installed"),
        (("polar", "--record", "b", "--font", "100"), "100 pt; it must be 1 to 72 pt"),
    ],
)
def test_wrong_figure_options_give_plain_errors(
    cube_file: Path, tmp_path: Path, words: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert (
        run_command_and_return_exit_status(
            "figure", words[0], str(cube_file), *words[1:], "-o", str(tmp_path / "a.svg")
        )
        == 1
    )
    assert message in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_polar_maps_of_several_records_share_one_radial_scale(cube_file: Path) -> None:
    cube = overturning.open_cube(cube_file)
    maps = [axes for axes in overturning.plot.fall_map(cube, ["b", "a"]).axes if axes.name == "polar"]
    names = [", ".join(str(cube[name].values[place]) for name in ("station", "event")) for place in (1, 0)]
    assert [axes.get_title().strip() or names[0] for axes in maps] == names
    assert len({axes.get_ylim() for axes in maps}) == 1
    assert all(any(line.get_path_effects() for line in axes.lines) for axes in maps), "with their peak velocities"


def test_outcomes_of_the_simulate_function_are_drawn() -> None:
    motion = Motion.sine(6.0, 0.8)
    stone = {"height": 0.6, "b_over_h": 0.2}
    outcome = overturning.simulate(motion, "circle", orientation_deg=[0, 30], height=[0.6], b_over_h=[0.2, 0.3])
    assert overturning.plot.fall_map(outcome, title="A drum").get_suptitle().startswith("A drum\n")
    outcome["overturned"][0, 0, 0], outcome["fall_azimuth"][0, 0, 0] = np.nan, np.nan  # it was drawn as one that stands
    with pytest.raises(ArgumentError, match="no record 'a'; it has none"):
        overturning.plot.fall_map(outcome, "a")
    marks = overturning.plot.fall_map(outcome).legends[0].get_texts()
    assert [mark.get_text() for mark in marks][:2] == ["stands", "no outcome"]
    assert overturning.to_dataframe(outcome)["overturned"].isna().sum() == 1
    with pytest.raises(ArgumentError, match="rotation_slip_and_uplift: a 3-D trajectory"):
        overturning.plot.rotation_slip_and_uplift(overturning.trajectory(motion, "circle", orientation_deg=0, **stone))
    assert (
        len(overturning.plot.rotation_slip_and_uplift(overturning.trajectory(motion, azimuth_deg=0, **stone)).axes) == 4
    )
    cube = overturning.run_study(
        (one for one in [motion]), azimuth={"step": 90}, b_over_h=[0.2], ensemble={"members": 0}
    )
    with pytest.raises(MissingDataError, match=r"motion/motion-1.nc: a cube in memory has no such file"):
        overturning.plot.time_histories(cube)


@pytest.mark.parametrize(
    ("figure", "message"),
    [
        ("time_histories", "motion/RECORD.nc: a cube in memory has no such file"),
        ("hodograph", "motion/RECORD.nc: a cube in memory has no such file"),
        ("pga_and_pgv_by_azimuth", "intensity.nc: a cube in memory has no such file"),
        ("rotation_slip_and_uplift", "outcomes without a time axis; give datasets of overturning.trajectory"),
    ],
)
def test_motion_and_trajectory_figures_are_refused_for_simulated_outcomes(figure: str, message: str) -> None:
    outcome = overturning.simulate(Motion.sine(6.0, 0.8), azimuth_deg=[0, 30], height=[0.6], b_over_h=[0.2, 0.3])
    with pytest.raises((ArgumentError, MissingDataError), match=message):
        getattr(overturning.plot, figure)(outcome)


def test_a_fall_map_of_a_scene_is_refused_unless_one_element_is_selected() -> None:
    outcome = overturning.simulate(
        overturning.Motion.sine(5.0, 0.8), overturning.load_scene("three-tier"), azimuth_deg=range(0, 360, 60),
        b_over_h=[0.2, 0.3],
    )  # fmt: skip
    with pytest.raises(ArgumentError, match=r"outcomes of 3 elements; choose one, as cube.sel\(element='shaft'\)"):
        overturning.plot.fall_map(outcome)
    assert overturning.plot.fall_map(outcome.sel(element="shaft")).axes
    with pytest.raises(ArgumentError, match=r"no dimension record; keep it .* or draw fall_map"):
        overturning.plot.fall_rose(outcome.sel(element="shaft"))


def fall_flags_drawn_in_map_cells(figure: Figure, azimuth: FloatArray, b_over_h: FloatArray) -> NDArray[np.int_]:
    """Return by azimuth and B/H what a polar map shows: 1 falls towards the azimuth, 0 falls away, -1 stands."""
    (mesh,) = figure.axes[0].collections
    corner = mesh.get_coordinates()
    kinds = np.ma.filled(mesh.get_array(), -1).reshape(corner.shape[0] - 1, -1)
    turn, radius = np.degrees(corner[0, :, 0]), corner[:, 0, 1]
    found = np.full((azimuth.size, b_over_h.size), -1)
    for column, (first, last) in enumerate(zip(*np.sort([turn[:-1], turn[1:]], axis=0), strict=True)):
        for row, (low, high) in enumerate(zip(*np.sort([radius[:-1], radius[1:]], axis=0), strict=True)):
            within = ((azimuth[:, None] + 0.01 - first) % 360 < last - first) & (low <= b_over_h) & (b_over_h < high)
            found[within] = kinds[row, column]
    return found


def test_a_fall_map_does_not_depend_on_grid_order_or_full_turns_of_azimuth() -> None:
    motion, azimuth, ratio = Motion.sine(6.0, 0.8, azimuth_deg=20), np.arange(0, 360, 30.0), np.array([0.2, 0.3, 0.9])
    stone = {"height": 0.6, "friction": 1.0}

    def simulate_and_draw_fall_map(azimuth_deg: FloatArray, b_over_h: FloatArray) -> Figure:
        outcome = overturning.simulate(motion, azimuth_deg=azimuth_deg, b_over_h=b_over_h, **stone)
        return overturning.plot.fall_map(outcome)

    flags = overturning.simulate(motion, azimuth_deg=azimuth, b_over_h=ratio, **stone)["overturned"][:, 0, :, 0]
    kinds = np.array([-1, 1, 0])[flags.to_numpy().astype(int)]  # stands (hatched), falls towards the azimuth, or not
    assert len(np.unique(kinds)) == 3
    for turned, sizes in (
        (azimuth, ratio), (azimuth - 180, ratio), (azimuth + 360, ratio), (np.append(azimuth, 360.0), ratio),
        (azimuth[::-1], ratio[::-1]), (azimuth, ratio[[1, 0, 2, 1]]),
    ):  # fmt: skip
        figure = simulate_and_draw_fall_map(turned, sizes)
        np.testing.assert_array_equal(fall_flags_drawn_in_map_cells(figure, azimuth, ratio), kinds)
        assert figure.axes[0].get_ylim()[1] == pytest.approx(1.2)
    outcome = overturning.simulate(motion, azimuth_deg=azimuth, b_over_h=ratio[::-1], **stone)
    alone = overturning.plot.fall_map(outcome.isel(height=0, friction=0))  # a part of it, without these dimensions
    np.testing.assert_array_equal(fall_flags_drawn_in_map_cells(alone, azimuth, ratio), kinds)
    (edge, *_) = overturning.plot.overturning_boundary(outcome).axes[0].lines
    falls = np.abs(flags.to_numpy()) == 1
    last = np.where(falls[:, 1], 0.6, np.where(falls[:, 0], 0.25, np.nan))
    np.testing.assert_allclose(edge.get_ydata()[:-1], last)
    with pytest.raises(ArgumentError, match="cube: nothing along azimuth"):
        overturning.plot.fall_map(outcome.isel(azimuth=[]))


def test_a_cube_is_exported_as_a_table_of_its_cases(
    cube_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    cube = overturning.open_cube(cube_file)
    table = overturning.to_dataframe(cube)
    assert len(table) == cube["overturned"].size
    assert table.columns[:5].tolist() == ["record", "azimuth", "height", "b_over_h", "friction"]
    for row in (0, 17, len(table) - 1):
        cell = {name: table[name][row] for name in cube["overturned"].dims}
        assert table["overturned"][row] == cube["overturned"].sel(cell).item()
    assert set(overturning.to_dataframe(cube.sel(record="b"))["fault_normal"]) == {120.0}
    assert run_command_and_return_exit_status("cube", "export", str(cube_file), str(tmp_path / "cases.csv")) == 0
    assert f"{len(table)} cases" in capsys.readouterr().out
    pd.testing.assert_frame_equal(
        pd.read_csv(tmp_path / "cases.csv")[["record", "overturned"]],
        table[["record", "overturned"]],
        check_dtype=False,
    )
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    assert run_command_and_return_exit_status("cube", "export", str(cube_file), str(tmp_path / "cases.parquet")) == 1
    assert "Parquet needs pyarrow; python -m pip install 'overturning[parquet]'" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["cases.csv"]


def test_a_cube_is_exported_as_a_parquet_table(cube_file: Path, tmp_path: Path) -> None:
    if importlib.util.find_spec("pyarrow") is None:
        skip_test_unless_skipping_is_forbidden("pyarrow is not installed (`make parquet`)")
    assert run_command_and_return_exit_status("cube", "export", str(cube_file), str(tmp_path / "cases.parquet")) == 0
    expected = overturning.to_dataframe(overturning.open_cube(cube_file))
    pd.testing.assert_frame_equal(pd.read_parquet(tmp_path / "cases.parquet"), expected, check_dtype=False)


@pytest.mark.parametrize(
    ("called", "typed", "meant"),
    [
        ("simulate", "b_overh", "b_over_h"),
        ("simulate", "thread", "threads"),
        ("trajectory", "azimut_deg", "azimuth_deg"),
        ("trajectory", "amplitud", "amplitude"),
        ("run_cases", "schem", "scheme"),
        ("Motion", "samplinginterval", "sampling_interval"),
        ("Motion.sine", "azimuth", "azimuth_deg"),
        ("Cases", "b_overh", "b_over_h"),
        ("Contact", "dampin_ratio", "damping_ratio"),
        ("open_cube", "elements", "element"),
        ("read", "formats", "format"),
    ],
)
def test_the_error_for_a_mistyped_keyword_suggests_the_correct_one(called: str, typed: str, meant: str) -> None:
    with expect_error(ArgumentError, f"{typed}: no keyword of {called}; did you mean {meant}?", brief=True):
        attrgetter(called)(overturning)(**{typed: 1})


@pytest.mark.parametrize(
    "name", ["simulate", "trajectory", "Motion", "Cases", "Record", "read", "run_study", "Body", "Contact"]
)
def test_python_help_shows_a_readable_signature(name: str) -> None:
    one = getattr(overturning, name)
    for shown in (one, *(value for key, value in vars(one).items() if inspect.isfunction(value) and key[0] != "_")):
        text = str(inspect.signature(shown))
        assert "numpy._typing" not in text
        assert "FieldInfo" not in text
        assert len(text) < 900


def test_options_have_the_same_names_in_commands_python_and_studies() -> None:
    def dataclass_field_names(*kinds: type) -> set[str]:
        return {field.name for kind in kinds for field in fields(kind)}

    study, body, contact = (set(one.model_fields) for one in (Study, BodyShapeSettings, ContactSettings))
    assert (
        dataclass_field_names(
            declared.BodyOptionsOfCommandOne, declared.PlanarOptionsOfCommandOne, declared.StoneOptionsOfCommandOne
        )
        <= study | body | contact
    )
    assert dataclass_field_names(declared.RecordFileOptions) == {*FilePropertiesInTableRow.model_fields}
    assert dataclass_field_names(declared.RecordFileOptions) <= {*DeclaredFileProperties.model_fields} & {
        *RecordTableRow.model_fields
    }
    assert {"scheme", "time_step", "leave_out"} == dataclass_field_names(NumericalOptions) & set(
        SimulationSettings.model_fields
    )
    given = {name.removesuffix("_deg") for name in inspect.signature(overturning.simulate).parameters}
    assert given - {"motion", "model", "options"} <= study | body
    assert {*overturning.Contact.model_fields} - {"static_penetration"} == contact
    options = {option for one in click_of(app).commands["one"].params for option in one.opts}
    assert {"--body", "--plan", "--mesh", "--sampling-interval"} <= options


@pytest.mark.parametrize(
    ("name", "value"), [("friction", "x"), ("height", ["tall"]), ("azimuth_deg", [[0], [1, 2]]), ("b_over_h", {"a": 1})]
)
def test_an_invalid_array_argument_is_named_in_the_error(name: str, value: object) -> None:
    given: dict[str, Any] = {"azimuth_deg": [0.0]} | {name: value}
    with pytest.raises(ArgumentError, match=rf"^{name}: .* it must be a number or a row of numbers$"):
        overturning.simulate(Motion.sine(6.0, 1.0), **given)
