"""Films and the report work in two browsers, and hostile names do no harm in them."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from overturning.dem.trajectory import trajectory
from overturning.figures.drawn_case import read_illustrative_case_list
from overturning.figures.film import Film
from overturning.figures.film_of_trajectory import film_of_trajectories
from overturning.figures.page import film_page_html
from overturning.motion.motion import Motion
from tests.figures.films import film_of_one_falling_and_one_rocking_block, trajectory_of_3d_body
from tests.report.browsers import run_scripts_in_browser
from tests.report.test_rendering import SCRIPT_AS_NAME

HOSTILE_TITLE = "A </script><script>window.hurt = 1</script> & <b>name</b>"

FILM_CONTROLS_SCRIPT = """
const film = document.querySelector(".film"), data = film.dataset, seen = [];
const look = () => seen.push([data.state, Number(data.time), data.forces, data.earth, data.rate]);
await until(() => data.ready === "true");
look();
film.querySelector(".film-play").click();
await until(() => data.state === "playing" && data.time > 0.1);
await until(() => data.state === "ended");
look();
const outcomes = [...document.querySelectorAll(".film-outcome")].map((one) => one.textContent);
document.activeElement.blur();
for (const key of ["Home", "ArrowRight", "f", "g", "s"]) { press(document.body, key); look(); }
press(document.body, " ");
await until(() => data.time > 0.1);
press(document.body, " ");
const paused = data.state;
set(film.querySelector("input[type=range]"), 0.1, "input");
look();
const [, half, full] = film.querySelectorAll(".film-speed input");
full.click();
const rates = [data.rate];
half.click();
rates.push(data.rate);
return {seen, outcomes, paused, rates, title: document.querySelector(".film-title").textContent, hurt: window.hurt};
"""
FALLEN_BLOCK_PIXELS_SCRIPT = """
const film = document.querySelector(".film");
await until(() => film.dataset.ready === "true");
const count = () => {
  const c = document.querySelector("canvas"), d = c.getContext("2d").getImageData(0, 0, c.width, c.height).data;
  let left = 0, right = 0;
  for (let i = 0; i < d.length; i += 4) if (d[i] === 0xc9 && d[i + 1] === 0xc4) {
    if ((i / 4) % c.width < c.width * 0.4) left++; else right++; }
  return [left, right]; };
const before = count();
press(film, "End");
return {before, after: count(), boxes: document.querySelectorAll(".film-controls input[type=checkbox]").length,
        outcome: document.querySelector(".film-outcome").textContent};
"""
PANEL_POSITIONS_ON_PHONE_SCRIPT = """
return await onPhone((page) => [...page.querySelectorAll(".film-panel")].map((one) =>
  Math.round(one.getBoundingClientRect().top)));
"""
FILM_IN_3D_SCRIPT = """
const film = document.querySelector(".film"), canvas = document.querySelector("canvas");
await until(() => film.dataset.ready === "true");
canvas.setPointerCapture = () => {};
const pictures = [canvas.toDataURL()];
for (const [kind, across] of [["pointerdown", 0], ["pointermove", 60], ["pointerup", 60]])
  canvas.dispatchEvent(new PointerEvent(kind, {bubbles: true, clientX: 90 + across, clientY: 90}));
pictures.push(canvas.toDataURL());
press(film, "a");
pictures.push(canvas.toDataURL());
press(film, "End");
return {different: new Set(pictures).size, outcome: document.querySelector(".film-outcome").textContent};
"""
STONE_WITHIN_CANVAS_SCRIPT = """
const film = document.querySelector(".film"), canvas = document.querySelector("canvas"), found = [];
const slider = film.querySelector("input[type=range]");
await until(() => film.dataset.ready === "true");
const bar = Number(film.dataset.bar);
// The stone's faces, whose red, green and blue are as 201, 196 and 186: number of pixels, and of those on the edge.
const stone = () => {
  const w = canvas.width, h = canvas.height, d = canvas.getContext("2d").getImageData(0, 0, w, h).data;
  let all = 0, edge = 0;
  for (let i = 0; i < d.length; i += 4) if (d[i] > 90 && [[196, 1], [186, 2]].every(([part, k]) =>
    Math.abs(d[i + k] - d[i] * part / 201) < 1.2)) {
    const x = i / 4 % w, y = Math.floor(i / 4 / w);
    all++;
    if (x < 2 || y < 2 || x >= w - 2 || y >= h - 2) edge++; }
  return [all, edge]; };
for (const tick of [false, true]) {
  const box = film.querySelector("input[type=checkbox]");
  if (box.checked !== tick) box.click();
  for (let k = 0; k <= 20; k++) {
    set(slider, Number(slider.min) + k / 20 * (slider.max - slider.min), "input");
    found.push(stone()); } }
return {found, bar};
"""
REPORT_SCRIPT = """
const table = [...document.querySelectorAll("table.sortable")].find((one) => one.querySelector("a"));
const order = () => [...table.tBodies[0].rows].map((row) => row.cells[0].textContent);
const click = (which) => table.querySelector(which).click();
location.hash = "#record-two";
await until(() => document.getElementById("record-two").open);
const opened = document.getElementById("record-two").parentElement.closest("details").open;
const orders = [order()];
click("th"); click("th"); orders.push(order());
click("th:nth-child(5)"); orders.push(order());  // by PGA, as numbers
const {wide} = await onPhone(() => null, (page) => {
  page.querySelectorAll("details").forEach((one) => { one.open = true; });
  page.querySelectorAll("td").forEach((one) => one.append(" and some more")); });
const letters = (one) => parseFloat(getComputedStyle(one.querySelector("td")).fontSize);
const tables = (await onPhone((page) => [...page.querySelectorAll("table")].filter((one) => !one.closest("details"))
  .map((one) => [letters(one), one.scrollWidth - one.closest(".wide").clientWidth]))).seen;
const [few] = document.querySelectorAll("table.sortable"), cells = () => [...few.rows].slice(1).map((one) => one.cells);
few.tHead.rows[0].cells[1].className = "n";
cells().forEach((one, k) => { one[1].textContent = ["12,345", "2,000", "30"][k]; });
few.tHead.rows[0].cells[1].click();
const sorted = cells().map((one) => one[1].textContent).filter((one) => one);
const films = document.querySelectorAll(".film[data-ready=true]").length;
return {orders, opened, sorted, films, wide, tables, title: document.title, hurt: window.hurt};
"""
LETTER_SIZES_SCRIPT = """
const {wide, seen} = await onPhone((page) => {
  const sizes = [];
  for (const one of page.querySelectorAll("figure > svg, figure > .narrow > svg")) {
    if (!one.getBoundingClientRect().width) continue;  // in a fold
    const scale = one.getBoundingClientRect().width / one.viewBox.baseVal.width;
    for (const text of one.querySelectorAll("text")) sizes.push(scale * parseFloat(text.style.fontSize)); }
  return [Math.min(...sizes), sizes.length]; });
return {wide, least: seen[0], letters: seen[1]};
"""


@pytest.fixture(scope="module", params=["chromium", pytest.param("firefox", marks=pytest.mark.long)])
def film_and_report_script_results(
    request: pytest.FixtureRequest, report_page_and_pdf: tuple[str, bytes], tmp_path_factory: Any
) -> dict[str, Any]:
    """Return the results of the film and report scripts in one browser, by page name."""
    film = film_of_one_falling_and_one_rocking_block()
    time = np.arange(0, 1.2, 0.01)
    motion = Motion(7.0 * np.sin(2 * np.pi * time), 3.0 * np.sin(2 * np.pi * time), sampling_interval=0.01)
    path = trajectory_of_3d_body(motion)
    vertical = 45.0 * np.sin(4 * np.pi * time) * (time < 0.5)
    jump = Motion(0.02 * vertical, np.zeros(time.size), vertical, sampling_interval=0.01)
    rest = Motion(*2 * [0.9 * np.sin(2 * np.pi * time)], sampling_interval=0.01)
    films = {
        "thrown": trajectory(jump, "rectangle", height=0.6, b_over_h=0.5, orientation_deg=0.0),
        "slender": trajectory(rest, "rectangle", height=0.01, b_over_h=0.1, orientation_deg=0.0),
    }
    pages = {
        "film": (
            film_page_html(film_of_one_falling_and_one_rocking_block(duration=0.2, title=HOSTILE_TITLE)),
            FILM_CONTROLS_SCRIPT,
        ),
        "three": (
            film_page_html(Film("three", 0.0, 0.02, (*film.panels, film.panels[0]))),
            PANEL_POSITIONS_ON_PHONE_SCRIPT,
        ),
    }
    with pytest.MonkeyPatch.context() as patch:  # frames for print, which these scripts do not look at
        patch.setattr("overturning.figures.film_strip.film_strip_figure", lambda *_, **__: Figure((1.0, 1.0)))
        pages |= {
            "fall": (
                film_page_html(film_of_one_falling_and_one_rocking_block(forces=False)),
                FALLEN_BLOCK_PIXELS_SCRIPT,
            ),
            "space": (film_page_html(film_of_trajectories([path], motion, "title")), FILM_IN_3D_SCRIPT),
            **{
                name: (
                    film_page_html(film_of_trajectories([path], {"thrown": jump, "slender": rest}[name], name)),
                    STONE_WITHIN_CANVAS_SCRIPT,
                )
                for name, path in films.items()
            },
        }
    pages["report"] = (report_page_and_pdf[0], REPORT_SCRIPT)
    if request.param == "chromium":  # one start of the browser for all
        pages["letters"] = (report_page_and_pdf[0], LETTER_SIZES_SCRIPT)
    profile: Path = tmp_path_factory.mktemp("browser") / "profile"
    return run_scripts_in_browser(request.param, pages, profile)


@pytest.mark.browser
def test_film_page_plays_and_obeys_its_keys(film_and_report_script_results: dict[str, Any]) -> None:
    film = film_and_report_script_results["film"]
    assert film["title"] == HOSTILE_TITLE
    assert "hurt" not in film
    assert film["outcomes"][1] == "stands"
    assert film["paused"] == "paused"
    assert film["rates"] == ["1", "0.5"]
    assert film["seen"] == [
        ["paused", 0, "false", "false", "0.2"],
        ["ended", 0.2, "false", "false", "0.2"],
        ["paused", 0, "false", "false", "0.2"],
        ["paused", 0.02, "false", "false", "0.2"],
        ["paused", 0.02, "true", "false", "0.2"],
        ["paused", 0.02, "true", "true", "0.2"],
        ["paused", 0.02, "true", "true", "0.5"],
        ["paused", 0.1, "true", "true", "0.5"],
    ]


@pytest.mark.browser
def test_canvas_of_a_film_shows_the_block_after_its_fall(film_and_report_script_results: dict[str, Any]) -> None:
    """The block's colour leaves its first place and comes to the right of it."""
    fall = film_and_report_script_results["fall"]
    assert fall["before"][0] > 1000 > fall["before"][1]
    assert fall["after"][1] > 5 * fall["after"][0]
    assert fall["outcome"].startswith("falls towards N60")
    assert fall["boxes"] == 1, "of the ground; without forces there is no box for them"


@pytest.mark.browser
def test_three_film_panels_fit_side_by_side_on_a_phone(film_and_report_script_results: dict[str, Any]) -> None:
    assert len(film_and_report_script_results["three"]["seen"]) == 3
    assert len(set(film_and_report_script_results["three"]["seen"])) == 1
    assert film_and_report_script_results["three"]["wide"] <= 390


@pytest.mark.browser
def test_dragging_and_keys_rotate_the_view_of_a_3d_body(film_and_report_script_results: dict[str, Any]) -> None:
    assert film_and_report_script_results["space"]["different"] == 3
    assert film_and_report_script_results["space"]["outcome"].startswith("falls towards")


@pytest.mark.browser
@pytest.mark.parametrize(
    ("name", "bars"),
    [
        pytest.param("thrown", [0.5, 1.0], id="a stone thrown up by the ground"),
        pytest.param("slender", [0.002], id="a slender stone of 1 cm that stays"),
    ],
)
def test_3d_film_shows_the_whole_stone_in_every_frame(
    film_and_report_script_results: dict[str, Any], name: str, bars: list[float]
) -> None:
    """Seen from the moving ground or the fixed earth, the whole stone is in the picture at all times.

    The slender stone and its floor, which is as wide as the stone is high, fill a picture 1.7 stones wide.
    """
    assert [edge for _, edge in film_and_report_script_results[name]["found"]] == 42 * [0]
    assert min(count for count, _ in film_and_report_script_results[name]["found"][:21]) > 200
    assert film_and_report_script_results[name]["bar"] in [pytest.approx(bar) for bar in bars]


@pytest.mark.browser
def test_report_page_sorts_tables_opens_chapters_and_fits_a_phone(
    film_and_report_script_results: dict[str, Any], results_with_hostile_names: Path
) -> None:
    page = film_and_report_script_results["report"]
    assert page["orders"] == [["one", "two"], ["two", "one"], ["two", "one"]]
    assert page["sorted"] == ["30", "2,000", "12,345"]
    assert page["opened"]
    assert (
        page["films"] == len(read_illustrative_case_list(results_with_hostile_names / "figures" / "illustrative")) >= 1
    )
    assert page["title"] == SCRIPT_AS_NAME
    assert "hurt" not in page
    # On a phone only scrollable elements are wider than the screen.
    assert page["wide"] <= 390
    assert len(page["tables"]) >= 1
    assert all(letters >= 11 and beyond <= 0 for letters, beyond in page["tables"])


@pytest.mark.browser
@pytest.mark.parametrize("film_and_report_script_results", ["chromium"], indirect=True)
def test_letters_of_report_figures_are_legible_on_a_phone(film_and_report_script_results: dict[str, Any]) -> None:
    found = film_and_report_script_results["letters"]
    assert found["letters"] > 20
    assert found["least"] >= 9.0
    assert found["wide"] <= 390
