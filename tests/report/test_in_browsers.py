"""Films, the explorer and the report do what they are to do in two browsers, and nothing hurts them."""

import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgb

from overturning.figures import explore
from overturning.figures.explore import explorer_data, explorer_page
from overturning.figures.film import Film
from overturning.figures.film_of_trajectory import film_of
from overturning.figures.page import film_page
from overturning.figures.style import DARKEST, STANDS
from overturning.motion.motion import Motion
from overturning.report.blocks import Film as FilmBlock
from overturning.report.blocks import Report, each_block
from overturning.study.cube import open_cube
from tests.expect import lacking
from tests.figures.films import falling_body, two_panels
from tests.figures.test_explore import cube, space_cube
from tests.report.browsers import PROGRAMS, answers
from tests.report.reading import BAD

NAME = "A </script><script>window.hurt = 1</script> & <b>name</b>"

FILM = """
const film = document.querySelector(".film"), data = film.dataset, seen = [];
const look = () => seen.push([data.state, Number(data.time), data.forces, data.rate]);
await until(() => data.ready === "true");
look();
film.querySelector(".film-play").click();
await until(() => data.state === "playing" && data.time > 0.2);
await until(() => data.state === "ended");
look();
const outcomes = [...document.querySelectorAll(".film-outcome")].map((one) => one.textContent);
document.activeElement.blur();
for (const key of ["Home", "ArrowRight", "f", "s"]) { press(document.body, key); look(); }
press(document.body, " ");
await until(() => data.time > 0.1);
press(document.body, " ");
const paused = data.state;
set(film.querySelector("input[type=range]"), 1.0, "input");
look();
return {seen, outcomes, paused, title: document.querySelector(".film-title").textContent, hurt: window.hurt};
"""
FALL = """
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
THREE = """
return await onPhone((page) => [...page.querySelectorAll(".film-panel")].map((one) =>
  Math.round(one.getBoundingClientRect().top)));
"""
SPACE = """
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
EXPLORER = """
await until(() => document.getElementById("explorer").dataset.ready === "true");
const said = [], look = () => said.push(document.querySelector(".said").textContent);
const choose = (name, value) => set(document.querySelector(`select[data-name=${name}]`), value, "change");
choose("record", 1);
const canvas = document.querySelector("canvas"), place = canvas.getBoundingClientRect();
for (const share of [0.1, 0.35, 0.6]) {  // every ring to the east
  const x = place.left + place.width / 2 + (place.width / 2 - 30) * share / 0.725;
  canvas.dispatchEvent(new PointerEvent("pointermove", {clientX: x, clientY: place.top + place.height / 2}));
  look(); }
const cells = document.querySelectorAll("td").length;
set(document.querySelector("input[data-name=b]"), 0, "input");
look();
canvas.focus();
press(canvas, "ArrowRight");
look();
for (const colour of ["flag", "rotation", "time"]) choose("colour", colour);
const {wide} = await onPhone(() => null);
return {said, cells, wide, title: document.title, hurt: window.hurt};
"""
LATE = """
await until(() => document.getElementById("explorer").dataset.ready === "true");
const canvas = document.querySelector("canvas"), said = [];
for (let k = 0; k < 3; k++) { press(canvas, "ArrowRight"); said.push(document.querySelector(".said").textContent); }
set(document.querySelector("select[data-name=colour]"), "time", "change");
const middle = canvas.width / 2, far = 0.35 / 0.725 * (middle - 30 * canvas.width / canvas.clientWidth);
const pixel = (east, north) => [...canvas.getContext("2d").getImageData(
  Math.round(middle + east * far), Math.round(middle - north * far), 1, 1).data].slice(0, 3);
return {late: pixel(1, 0), early: pixel(-1, 0), stands: pixel(0, -1), said,
        note: document.querySelector(".note").textContent};
"""
IN_SPACE = """
const root = document.getElementById("explorer"), canvas = document.querySelector("canvas"), said = [];
await until(() => root.dataset.ready === "true");
const look = () => said.push(document.querySelector(".said").textContent);
set(document.querySelector("input[data-name=a]"), 0, "input");
set(document.querySelector("input[data-name=b]"), 0, "input");
for (const key of ["ArrowLeft", "ArrowUp", "ArrowUp", "ArrowUp", "ArrowRight"]) { press(canvas, key); look(); }
const pictures = [];
for (const colour of ["azimuth", "rotation", "time"]) {
  set(document.querySelector("select[data-name=colour]"), colour, "change"); pictures.push(canvas.toDataURL()); }
const {wide} = await onPhone(() => null);
return {said, wide, different: new Set(pictures).size};
"""
FILM_COMMAND = """
await until(() => document.getElementById("explorer").dataset.ready === "true");
const canvas = document.querySelector("canvas"), found = [];
for (const key of ["ArrowRight", "ArrowUp", "ArrowRight"]) { press(canvas, key);
  found.push([document.querySelector(".said").textContent, document.querySelector(".film code").textContent]); }
return {found};
"""
REPORT = """
const order = () => [...document.querySelectorAll("#peaks tbody tr")].map((row) => row.cells[0].textContent);
const click = (which) => document.querySelector(`#peaks ${which}`).click();
const orders = [order()];
click("th"); click("th"); orders.push(order());
click("th:nth-child(6)"); orders.push(order());  // by PGA, as numbers
const {wide} = await onPhone(() => null, (page) => {
  page.querySelectorAll("details").forEach((one) => { one.open = true; });
  page.querySelectorAll("td").forEach((one) => one.append(" and some more")); });
const [few] = document.querySelectorAll("table.sortable"), cells = () => [...few.rows].slice(1).map((one) => one.cells);
few.tHead.rows[0].cells[1].className = "n";
cells().forEach((one, k) => { one[1].textContent = ["12,345", "2,000", "30"][k]; });
few.tHead.rows[0].cells[1].click();
const sorted = cells().map((one) => one[1].textContent);
const films = document.querySelectorAll(".film[data-ready=true]").length;
return {orders, sorted, films, wide, title: document.title, hurt: window.hurt};
"""


def late() -> xr.Dataset:
    """Blocks of a scene without mirror image that fall early, but late to the east; to the south they stand.

    Of the neighbourhoods of the second and third azimuth few members fall, and few stand; that of the fourth was not
    run.
    """
    whole = cube(records=1, heights=1, frictions=1)
    whole["overturned"][:], whole["overturning_time"][:] = 1.0, 2.0
    whole["overturned"][:, 6], whole["overturning_time"][:, 6], whole["overturning_time"][:, 3] = 0.0, np.nan, 20.0
    whole["probability_towards"][:], whole["probability_away"][:] = 0.5, 0.0
    whole["probability_towards"][:, 1], whole["probability_towards"][:, 2] = 0.001, 0.998
    whole["probability_towards"][:, 3] = whole["probability_away"][:, 3] = np.nan
    whole["azimuth"].attrs["period"] = 360.0
    return whole


@pytest.fixture(scope="module", params=["chromium", pytest.param("firefox", marks=pytest.mark.long)])
def said(
    request: pytest.FixtureRequest, rendered: tuple[str, bytes], hostile: Path, tmp_path_factory: Any
) -> dict[str, Any]:
    """Return the results of each page in each browser."""
    film = two_panels()
    time = np.arange(0, 1.2, 0.01)
    motion = Motion(7.0 * np.sin(2 * np.pi * time), 3.0 * np.sin(2 * np.pi * time), sampling_interval=0.01)
    path = falling_body(motion)
    with open_cube(hostile / "cube.nc", element=None) as opened:
        hostile_explorer = explorer_page(explorer_data(opened))
    pages = {
        "film": (film_page(two_panels(duration=1.2, title=NAME)), FILM),
        "fall": (film_page(two_panels(forces=False)), FALL),
        "three": (film_page(Film("three", 0.0, 0.02, (*film.panels, film.panels[0]))), THREE),
        "space": (film_page(film_of([path], motion, "title")), SPACE),
        "explorer": (explorer_page(explorer_data(cube())), EXPLORER),
        "late": (explorer_page(explorer_data(late())), LATE),
        "in space": (explorer_page(explorer_data(space_cube())), IN_SPACE),
        "command": (hostile_explorer, FILM_COMMAND),
        "report": (rendered[0], REPORT),
    }
    profile: Path = tmp_path_factory.mktemp("browser") / "profile"
    return answers(request.param, pages, profile)


@pytest.mark.browser
def test_a_film_plays_and_obeys_its_keys(said: dict[str, Any]) -> None:
    film = said["film"]
    assert film["title"] == NAME
    assert "hurt" not in film
    assert film["outcomes"][1] == "stands"
    assert film["paused"] == "paused"
    assert film["seen"] == [
        ["paused", 0, "false", "1"],
        ["ended", 1.2, "false", "1"],
        ["paused", 0, "false", "1"],
        ["paused", 0.02, "false", "1"],
        ["paused", 0.02, "true", "1"],
        ["paused", 0.02, "true", "0.5"],
        ["paused", 1.0, "true", "0.5"],
    ]


@pytest.mark.browser
def test_the_canvas_shows_the_fall(said: dict[str, Any]) -> None:
    """The block's colour leaves its first place and comes to the right of it."""
    fall = said["fall"]
    assert fall["before"][0] > 1000 > fall["before"][1]
    assert fall["after"][1] > 5 * fall["after"][0]
    assert fall["outcome"].startswith("falls towards N60")
    assert fall["boxes"] == 0


@pytest.mark.browser
def test_three_panels_side_by_side_on_a_phone(said: dict[str, Any]) -> None:
    assert len(said["three"]["seen"]) == 3
    assert len(set(said["three"]["seen"])) == 1
    assert said["three"]["wide"] <= 390


@pytest.mark.browser
def test_dragging_and_keys_turn_a_body_in_space(said: dict[str, Any]) -> None:
    assert said["space"]["different"] == 3
    assert said["space"]["outcome"].startswith("falls towards")


@pytest.mark.browser
def test_explorer_shows_the_values_of_the_cube(said: dict[str, Any]) -> None:
    whole, around = cube(), said["explorer"]

    def expected(azimuth: int, ratio: int) -> str:
        flag = float(whole["overturned"][1, azimuth, 0, ratio, 1])
        return {1.0: "falls towards", -1.0: "falls towards", 0.0: "stands"}.get(flag, "no outcome was found")

    # 90° is the fourth azimuth; then the slider goes to the first B/H, and a key to the next azimuth.
    places = [("E", 3, 0), ("E", 3, 1), ("E", 3, 2), ("E", 3, 0), ("S60°E", 4, 0)]
    for text, (name, azimuth, ratio) in zip(around["said"], places, strict=True):
        assert text.startswith(f"Motion along {name}, B/H = {float(whole['b_over_h'][ratio]):g}: ")
        assert expected(azimuth, ratio) in text
    assert around["cells"] == 6, "no ring beyond the outermost"
    assert around["title"].startswith("</script><script>window.hurt")
    assert "hurt" not in around
    assert around["wide"] <= 390


@pytest.mark.browser
def test_the_latest_fall_does_not_look_like_a_block_that_stands(said: dict[str, Any]) -> None:
    """It had the very colour. No probability is said to be 0 or 100 % that is neither, or not known."""
    page = said["late"]
    assert page["stands"] == [round(255 * part) for part in to_rgb(STANDS)]
    assert page["early"] == pytest.approx([round(255 * part) for part in to_rgb(DARKEST)], abs=40)
    assert max(abs(a - b) for a, b in zip(page["late"], page["stands"], strict=True)) > 60
    *some, not_run = page["said"]
    assert not_run.endswith("20.00 s."), "of its neighbourhood nothing"
    for text, words in zip(some, ("less than 1 %", "more than 99 %"), strict=True):
        assert f"with a probability of {words}" in text
        assert "with 0 %" in text
    assert "the scene faces" in page["note"]
    assert "towards which the block falls" not in page["note"]


@pytest.mark.browser
def test_the_explorer_in_space_stays_on_its_map(said: dict[str, Any]) -> None:
    whole, around = space_cube(), said["in space"]

    def expected(orientation: int, ratio: int) -> str:
        fell = float(whole["overturned"][0, orientation, 0, ratio, 0, 1])
        return "the body falls towards" if fell else "the body stands"

    # No orientation before the first, no ring beyond the first without falls.
    places = [("N", 0, 0), ("N", 0, 1), ("N", 0, 2), ("N", 0, 2), ("N15°E", 1, 2)]
    for text, (name, orientation, ratio) in zip(around["said"], places, strict=True):
        assert text.startswith(f"Facing {name}, B/H = {float(whole['b_over_h'][ratio]):.4g}: ")
        assert expected(orientation, ratio) in text
    assert around["wide"] <= 390
    assert around["different"] == 3


@pytest.mark.browser
def test_the_explorer_shows_the_command_of_the_selected_cell(said: dict[str, Any]) -> None:
    for sentence, command in said["command"]["found"]:
        ratio = re.search(r"B/H = ([\d.]+)", sentence)[1]
        words = rf"--azimuth [\d.]+ --height [\d.]+ --b-over-h {ratio} --friction [\d.]+ --animate fall\.html"
        assert re.fullmatch(f"overturning one --record .+ {words}", command)


@pytest.mark.browser
def test_records_beside_the_page_are_read_from_the_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(explore, "MAX_CELLS_PER_PAGE", 10)
    explore.write_explorer(cube(), tmp_path / "look around.html")
    names, options = PROGRAMS["chromium"]
    program = next((found for name in names if (found := shutil.which(name))), None) or lacking("needs Chromium")
    command = [program, *options.replace("--remote-debugging-port=0 ", "").split()]
    command[-1] += str(tmp_path / "profile")
    page = (tmp_path / "look around.html").as_uri()
    done = subprocess.run([*command, "--virtual-time-budget=5000", "--dump-dom", page], capture_output=True, timeout=60)
    assert '<main id="explorer" data-ready="true">' in done.stdout.decode()


@pytest.mark.browser
def test_the_report_sorts_plays_and_fits(said: dict[str, Any], report: Report) -> None:
    page = said["report"]
    assert page["orders"] == [["one", "two"], ["two", "one"], ["two", "one"]]
    assert page["sorted"] == ["30", "2,000", "12,345"]
    assert page["films"] == sum(isinstance(block, FilmBlock) for block in each_block(report)) >= 1
    assert page["title"] == BAD
    assert "hurt" not in page
    # On a phone nothing is wider than the screen but what scrolls by itself.
    assert page["wide"] <= 390
