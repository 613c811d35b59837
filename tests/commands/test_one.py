"""`overturning one`."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from overturning import read
from overturning.figures.film import Film
from overturning.figures.style import format_at_least_three_significant_digits
from overturning.records.record import start_offset_from_file_start_s
from overturning.report.filters import format_number
from tests.expect import run_overturning_and_return_printed_text
from tests.model.solids import column_with_overhanging_slab, rotate_surface, write_mesh

DEFAULT_RECORD_TABLE_PATH = str(Path(__file__).parents[2] / "config/records.tsv")


def run_overturning_one(*arguments: object, status: int = 0) -> str:
    """Run `overturning one` with the shipped record table, or with a pulse, and return its output."""
    of_table = (
        () if any(str(word).startswith("sine ") for word in arguments) else ("--table", DEFAULT_RECORD_TABLE_PATH)
    )
    return run_overturning_and_return_printed_text("one", *of_table, *arguments, status=status)


def test_command_one_gives_outcomes_film_and_figure_for_two_azimuths(tmp_path: Path) -> None:
    page, figure = tmp_path / "fall.html", tmp_path / "response.png"
    text = run_overturning_one(
        "--record", "rinaldi", "--azimuth", "32", "--azimuth", "122", "--animate", page, "--response", figure
    )
    assert "motion along N32°E: falls towards S32°W" in text
    assert "motion along S58°E: stands" in text
    assert page.stat().st_size < 300_000
    first = page.read_bytes()
    run_overturning_one("--record", "rinaldi", "--azimuth", "32", "--azimuth", "122", "--animate", page)
    assert page.read_bytes() == first
    assert figure.read_bytes().startswith(b"\x89PNG")


def test_command_one_accepts_a_damping_coefficient_in_absolute_units() -> None:
    assert "N32°E" in run_overturning_one("--record", "rinaldi", "--azimuth", "32", "--damping", "35000")


def test_command_one_simulates_a_planar_scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(Path(DEFAULT_RECORD_TABLE_PATH).parents[1])
    page, figure = tmp_path / "fall.html", tmp_path / "response.svg"
    given = ("--record", "rinaldi", "--azimuth", "32", "--azimuth", "122", "--scene", "three-tier")
    text = run_overturning_one(*given, "--animate", page, "--response", figure)
    assert "A shaft on two bases" in text
    assert "motion along N32°E: 1 of 3 falls: shaft falls towards S32°W" in text
    assert "motion along S58°E: everything stands" in text
    film = page.read_text(encoding="utf-8")
    assert all(name in film for name in ("lower-base", "upper-base", "shaft"))
    assert page.stat().st_size < 300_000
    assert figure.read_text(encoding="utf-8").startswith("<?xml")


def test_a_printed_value_rounded_to_zero_has_no_minus_sign(monkeypatch: pytest.MonkeyPatch) -> None:
    """A slip of −0.04 mm is printed as 0.0 cm, and not as −0.0 cm."""
    import overturning.dem.trajectory as module

    follow = module.trajectory

    def trajectory_with_tiny_negative_slip(*given: object, **more: object) -> object:
        path = follow(*given, **more)
        return path.assign(residual_slip=0.0 * path["residual_slip"] - 4e-5)

    monkeypatch.setattr(module, "trajectory", trajectory_with_tiny_negative_slip)
    text = run_overturning_one("--record", "sine amplitude_gal=100 period_s=0.5", "--azimuth", "0")
    assert text.rstrip().endswith("stands; does not lean; slipped 0.0 cm by the end")
    assert format_at_least_three_significant_digits(-0.0) == "0"
    assert format_number(-0.001) == "0.00"


def test_the_package_runs_as_a_module() -> None:
    command = [sys.executable, "-m", "overturning", "one", "--record", "none"]
    wrong = subprocess.run(command, capture_output=True, text=True, check=False)
    assert wrong.returncode == 1
    assert wrong.stdout == ""
    assert wrong.stderr.startswith("error: ")
    assert "overturning" in run_overturning_and_return_printed_text("study", "--help")


def test_the_help_lists_workflow_steps_separately() -> None:
    """The commands that only workflow rules call are in a second list; the commands for users are in the first."""
    first, steps = run_overturning_and_return_printed_text("--help").split("Steps of the workflow (run by Snakemake):")
    listed = [set(re.findall(r"^  ([a-z][a-z-]+)  +\S", part, flags=re.MULTILINE)) for part in (first, steps)]
    rules = "".join(
        path.read_text(encoding="utf-8")
        for path in (Path(DEFAULT_RECORD_TABLE_PATH).parents[1] / "workflow/rules").glob("*.smk")
    )
    called = set(re.findall(r"\"overturning ([a-z-]+) ", rules)) - {"explore", "findings", "survey", "backwards"}
    assert listed[1] == called
    assert {"init", "one", "findings", "figure", "explore", "survey", "study", "records", "cube"} <= listed[0]


RINALDI_RECORD_OPTIONS = ("--record", "rinaldi")
RINALDI_AND_AZIMUTH_OPTIONS = (*RINALDI_RECORD_OPTIONS, "--azimuth", "1")
BODY_OPTIONS = (*RINALDI_RECORD_OPTIONS, "--body")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (("--record", "rinaldo", "--azimuth", "1"), "did you mean rinaldi?"),
        ((*RINALDI_AND_AZIMUTH_OPTIONS, "--animate", "fall.avi"), "use the extension"),
        ((*RINALDI_AND_AZIMUTH_OPTIONS, "--damping", "3", "--damping-ratio", "1"), "keep one"),
        ((*RINALDI_AND_AZIMUTH_OPTIONS, "--b-over-h", "-1"), "b_over_h"),
        ((*RINALDI_RECORD_OPTIONS, "--azimuth", "nan"), "azimuth"),
        ((*RINALDI_AND_AZIMUTH_OPTIONS, "--height", "60"), "height: 60 m; a stone is 0.01 to 50 m high"),
        ((*BODY_OPTIONS, "--height", "60"), "height: 60 m; a stone is 0.01 to 50 m high"),
        ((*RINALDI_AND_AZIMUTH_OPTIONS, "--scene", "gone"), "scene gone: no file"),
        ((*RINALDI_AND_AZIMUTH_OPTIONS, "--scene", "boulder", "--damping", "3"), "set them in the scene file"),
        (RINALDI_RECORD_OPTIONS, "--azimuth: not given; give it, or in 3-D --orientation with --body or --scene"),
        ((*BODY_OPTIONS, "--azimuth", "3"), "--body, --mesh: accept --orientation"),
        ((*BODY_OPTIONS, "--animate", "a.gif"), "a.gif: a film of a 3-D body is an HTML page; use the extension .html"),
        ((*BODY_OPTIONS, "--plan", "oval"), "--plan: 'oval'"),
        ((*BODY_OPTIONS, "--plan", "²"), "--plan: '²'"),
        ((*BODY_OPTIONS, "--plan", "circle", "--mesh", "a.obj"), "--plan, --mesh: both given; leave one out"),
        ((*BODY_OPTIONS, "--mesh", "a.obj"), "a.obj: No such file"),
        ((*RINALDI_RECORD_OPTIONS, "--mesh", "a.obj", "--mesh-unit", "ft"), "--mesh-unit: 'ft'; give m, cm or mm"),
        ((*RINALDI_RECORD_OPTIONS, "--mesh", "a.obj", "--azimuth", "3"), "--body, --mesh: accept --orientation"),
        ((*BODY_OPTIONS, "--relief", "0.001"), "--mesh-unit, --relief: only for a mesh; add --mesh"),
        ((*BODY_OPTIONS, "--density", "2000"), "density without --mesh"),
        ((*RINALDI_AND_AZIMUTH_OPTIONS, "--plan", "circle"), "error: --plan: only for a 3-D body; add --body"),
        (
            (*RINALDI_AND_AZIMUTH_OPTIONS, "--relief", "0.001", "--mesh-unit", "mm"),
            "error: --mesh-unit, --relief: only for a 3-D body",
        ),
        (
            (*BODY_OPTIONS, "--orientation=1", "--orientation=2", "--response", "a.svg"),
            "one orientation at a time",
        ),
    ],
)
def test_error_messages_of_command_one_name_the_wrong_value(
    given: tuple[str, ...], message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(Path(DEFAULT_RECORD_TABLE_PATH).parents[1])
    assert message in (text := run_overturning_one(*given, status=1))
    assert "Traceback" not in text


def test_a_block_slides_if_its_friction_is_below_b_over_h() -> None:
    """A block can tip from rest only if µ is at least B/H; with less friction it slides, however strong the motion."""
    given = ("--record", "sine amplitude_gal=400 period_s=1", "--azimuth", "0", "--b-over-h", "0.3", "--friction")
    assert "motion along N: stands; does not lean; slipped" in run_overturning_one(*given, "0.1")
    assert "motion along N: falls" in run_overturning_one(*given, "1")


@pytest.mark.parametrize("space", [("--azimuth", "0"), ("--body",)])
def test_printed_times_are_counted_from_the_start_of_the_record_file(
    tmp_path: Path, space: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A block falls in a pulse 4 s into a raw file. Regression: the fall was printed 30 s (filter padding) too late."""
    time = np.arange(1000) / 100
    wave = np.where((time > 4) & (time < 6), 600 * np.sin(2 * np.pi * (time - 4) / 2), 0.0)
    np.savetxt(tmp_path / "x.csv", np.column_stack([wave, 0.1 * wave]), fmt="%.3f", delimiter=",")
    given = (
        "one",
        "--record",
        tmp_path / "x.csv",
        "--columns",
        "north:gal east:gal",
        "--sampling-interval",
        "0.01",
        *space,
    )
    films: list[Film] = []
    monkeypatch.setattr("overturning.figures.page.write_film_html_page", lambda film, _: films.append(film))
    times = {}
    for kind in ("--raw", "--processed"):
        text = run_overturning_and_return_printed_text(
            *given, kind, "--b-over-h", "0.2", "--height", "1", "--animate", tmp_path / "film.html"
        )
        film, panel = films[-1], films[-1].panels[0]
        trace = (
            np.hypot(*panel.horizontal_base_acceleration)
            if panel.horizontal_base_acceleration.ndim > 1
            else np.abs(panel.horizontal_base_acceleration)
        )
        assert 4.0 < int(trace.argmax()) * panel.acceleration_sampling_interval < 6.0, (
            "the trace has the clock of the bodies"
        )
        assert 2.0 < film.first_frame_time < 5.0
        record = read(
            tmp_path / "x.csv", columns="north:gal east:gal", sampling_interval_s=0.01, processed=kind == "--processed"
        )
        clock = start_offset_from_file_start_s(record) + 0.01 * np.arange(record.north.size)
        moved = cumulative_trapezoid(cumulative_trapezoid(record.north, dx=0.01, initial=0), dx=0.01, initial=0)
        there = np.interp(film.frame_times, clock, moved)
        ground = (
            panel.ground_displacement_by_frame[:, 1]
            if panel.shows_3d_body
            else panel.ground_displacement_by_frame[:, 0]
        )
        assert ground == pytest.approx(there - there[0], abs=2e-3), "the ground moved before the file, too"
        times[kind] = float(re.search(r" falls towards \S+ at ([\d.]+) s", text)[1])  # type: ignore[index]
        assert panel.last_fall_time == pytest.approx(times[kind], abs=0.006)
        assert ("times count from the first sample of the file; the motion that was simulated" in text) == (
            kind == "--raw"
        )
        assert ("begins 30 s earlier" in text) == (kind == "--raw")
    assert 4.0 < times["--processed"] < 9.0
    assert times["--raw"] == pytest.approx(times["--processed"], abs=0.3)


def test_the_response_figure_states_the_amplitude_factor(tmp_path: Path) -> None:
    """Regression: a fall under twice the record was drawn as a fall under the record itself."""
    figure = tmp_path / "response.svg"
    given = ("--record", "sine amplitude_gal=400 period_s=1", "--azimuth", "0", "--amplitude", "2")
    assert "pulse, sine pulse, motion × 2: B/H = 0.4" in run_overturning_one(*given, "--response", figure)
    assert "motion × 2" in figure.read_text(encoding="utf-8")
    text = run_overturning_one("--record", "wtmc", "--azimuth", "0", "--amplitude", "0.1", "--no-vertical")
    assert "Kaikoura 2016, motion × 0.1, vertical motion left out: B/H = 0.4" in text


def test_printed_slip_of_an_upper_stone_is_relative_to_its_support() -> None:
    """The lowest base slides on the ground by 9 mm, the shaft on the upper base by a third of a millimetre."""
    given = ("--record", "sine amplitude_gal=600 period_s=1 cycles=3", "--azimuth", "0", "--friction", "0.3")
    assert "slipped 0.0 cm by the end (shaft)" in run_overturning_one(*given, "--scene", "three-tier")


def test_command_one_says_that_the_scene_sets_friction_and_refuses_another(tmp_path: Path) -> None:
    scene = tmp_path / "icy.yaml"
    scene.write_text(
        """name: icy
contacts: [{between: [stone, stone], friction: 0.1}]
elements:
  - {name: ground, kind: driven, width: 40, height: 1, at: [0, -1]}
  - {name: stone, width: 0.24, height: 0.6, stands_on: ground}
""",
        encoding="utf-8",
    )
    given = ("--record", "sine amplitude_gal=600 period_s=1", "--azimuth", "0", "--scene", scene)
    assert "µ = that of the scene\n  motion along N: stands; does not lean" in run_overturning_one(*given)
    assert "--friction: the scene defines its own coefficients" in run_overturning_one(
        *given, "--friction", "1", status=1
    )


def test_command_one_prints_a_note_on_a_scene_without_equilibrium_at_rest(tmp_path: Path) -> None:
    scene = tmp_path / "overhang.yaml"
    text = """name: overhang
elements:
  - {name: ground, kind: driven, width: 40, height: 1, at: [0, -1]}
  - {name: block, width: 0.5, height: 1.0, stands_on: ground}
  - {name: slab, width: 0.5, height: 0.1, stands_on: block, at: [SHIFT, 0]}
"""
    given = ("--record", "sine amplitude_gal=50 period_s=1", "--azimuth", "0", "--scene", scene)
    scene.write_text(text.replace("SHIFT", "0.245"), encoding="utf-8")
    assert "note:" not in run_overturning_one(*given)
    scene.write_text(text.replace("SHIFT", "0.255"), encoding="utf-8")
    assert "  note: the scene has no equilibrium at rest: an element falls or slides without an" in run_overturning_one(
        *given
    )


def test_command_one_simulates_a_3d_body(tmp_path: Path) -> None:
    page, figure = tmp_path / "fall.html", tmp_path / "axis.svg"
    given = ("--record", "rinaldi", "--body", "--orientation", "20", "--b-over-h", "0.3", "--friction", "0.6")
    text = run_overturning_one(*given, "--animate", page, "--response", figure)
    assert "the base moves level" in text
    assert "facing N20°E: falls towards S" in text
    assert '"faces":[[' in page.read_text(encoding="utf-8")
    assert page.stat().st_size < 100_000
    assert "tilt of the axis" in figure.read_text(encoding="utf-8")


def test_command_one_simulates_a_3d_stack(tmp_path: Path) -> None:
    page, figure = tmp_path / "fall.html", tmp_path / "axis.svg"
    given = ("--record", "rinaldi", "--scene", "three-tier", "--orientation", "20", "--friction", "0.6")
    text = run_overturning_one(*given, "--animate", page, "--response", figure)
    assert "A shaft on two bases in 3-D" in text
    assert "facing N20°E: " in text
    assert page.read_text(encoding="utf-8").count('"faces":[[') == 3
    assert "tilt of the axis" in figure.read_text(encoding="utf-8")
    refused = run_overturning_one(*given, "--azimuth", "0", status=1)
    assert "--scene with --orientation simulates a stack in 3-D; leave out azimuth" in refused
    assert "no stack" in run_overturning_one(*given[:3], "against-a-wall", *given[4:6], status=1)


def test_command_one_counts_all_fallen_elements_of_a_gate(tmp_path: Path) -> None:
    """Both pillars of the gate (0.3 m × 2.2 m) fall, and the lintel comes to lie on them."""
    scene = tmp_path / "gate.yaml"
    scene.write_text(
        """name: gate
elements:
  - {name: ground, kind: driven, width: 40, height: 1, at: [0, -1]}
  - {name: left, width: 0.3, height: 2.2, at: [-1, 0], stands_on: ground}
  - {name: right, width: 0.3, height: 2.2, at: [1, 0], stands_on: ground}
  - {name: lintel, width: 2.9, height: 0.3, at: [1, 0], stands_on: left}
""",
        encoding="utf-8",
    )
    text = run_overturning_one("--record", "rinaldi", "--azimuth", "32", "--scene", scene)
    assert "motion along N32°E: 3 of 3 fall: " in text
    assert all(f"{name} falls towards" in text for name in ("left", "right", "lintel"))


def test_a_stack_that_slides_as_a_whole_has_the_slip_of_its_lowest_stone() -> None:
    """Without friction, stones stand still; the ground moves by A T²/2π, 95.5 cm for 6 m/s² and a period of 1 s."""
    text = run_overturning_one(
        *("--record", "sine amplitude_gal=600 period_s=1", "--scene", "three-tier", "--orientation", "0"),
        *("--friction", "0"),
    )
    assert "slipped 95.5 cm by the end (lower-base)" in text


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--azimuth", "0", "--damping", "1e30"), "damping: 1e+30 N·s/m; it must be at most"),
        (("--azimuth", "0", "--damping-ratio", "1e9"), "less than or equal to 1000000"),
        (("--body", "--orientation", "nan"), "orientation_deg: nan; it must be finite"),
        (("--azimuth", "inf"), "azimuth_deg: inf; it must be finite"),
        (("--azimuth", "0", "--language", "ja"), "--language: only films and figures have one; add --animate or"),
        (("--body", "--orientation", "0", "--aspect", "0"), "aspect: 0; it must be above 0"),
    ],
)
def test_invalid_option_values_are_refused_with_the_name_of_the_option(options: tuple[str, ...], words: str) -> None:
    assert words in run_overturning_one("--record", "sine amplitude_gal=600 period_s=1", *options, status=1)


def test_command_one_prints_mass_pose_and_footprint_of_a_scan(tmp_path: Path) -> None:
    """A statue scanned in millimetres and tilted by 3°; its volume is 0.046 m³, and its foot is 0.2 m wide."""
    pytest.importorskip("trimesh")
    path = write_mesh(rotate_surface(column_with_overhanging_slab(), 1, 3.0), tmp_path / "statue.ply", 1000.0)
    given = ("--record", "sine amplitude_gal=600 period_s=1", "--mesh", str(path), "--orientation", "20")
    text = run_overturning_one(*given, "--density", "2000", "--mesh-unit", "mm", "--relief", "0.001")
    for words in (
        "volume 0.046 m³, mass 92 kg",
        "placed in its nearest stable pose, tilted by 3.00° from its own vertical",
        "footprint within a relief of 1 mm: 4 corners",
        "facing N20°E: falls",
    ):
        assert words in text
    assert "declare the unit" in run_overturning_one(*given, status=1)
    assert "--density: inf kg/m³; it must be above 0 and finite" in run_overturning_one(
        *given, "--density", "inf", status=1
    )
