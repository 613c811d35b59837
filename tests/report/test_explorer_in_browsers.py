"""The explorer page works in two browsers: tests run its real script and compare it with the cube."""

import re
import shlex
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgb

from overturning.figures import explore, style
from overturning.figures.explore import explorer_page_data, explorer_page_html
from overturning.model.status import CaseStatus
from overturning.study.cube import open_cube
from overturning.translation.texts import use_translation_language
from tests.expect import skip_test_unless_skipping_is_forbidden
from tests.figures.test_explore import SCRIPT_AS_NAME, random_3d_cube, random_planar_cube
from tests.report.browsers import BROWSER_PROGRAMS, run_scripts_in_browser
from tests.translation.test_tables import untranslated_latin_words

SCRIPT_HELPERS = """
const root = document.getElementById("explorer"), canvas = document.querySelector(".map canvas");
await until(() => root.dataset.ready === "true");
const text = (name, page = document) => page.querySelector(name).textContent, answer = () => text(".sentence");
const choose = (name, value) => set(document.querySelector(`select[data-name=${name}]`), value, "change");
const slide = (name, value) => set(document.querySelector(`input[data-name=${name}]`), value, "input");
// Place on a polar map at an azimuth, degrees, and a share of the outer radius.
const place = (azimuth, share, box = canvas.getBoundingClientRect()) => {
  const far = (box.width / 2 - 30) * share, turn = azimuth / 180 * Math.PI;
  return {clientX: box.left + box.width / 2 + far * Math.sin(turn),
          clientY: box.top + box.width / 2 - far * Math.cos(turn), bubbles: true}; };
const point = (kind, azimuth, share) => canvas.dispatchEvent(
  new (kind === "click" ? MouseEvent : PointerEvent)(kind, place(azimuth, share)));
const copyAll = async () => {
  const copied = [];
  Object.defineProperty(navigator, "clipboard", {value: {writeText: async (one) => { copied.push(one); }}});
  for (const button of document.querySelectorAll("button")) if (button.textContent.startsWith("Copy")) {
    button.click();
    await until(() => button.textContent === "Copied"); }
  return copied; };
const pixels = (azimuth, share) => {
  const box = {left: 0, top: 0, width: canvas.clientWidth}, {clientX, clientY} = place(azimuth, share, box);
  const density = canvas.width / canvas.clientWidth;
  const data = canvas.getContext("2d").getImageData(
    Math.round(clientX * density) - 4, Math.round(clientY * density) - 4, 9, 9).data;
  return Array.from({length: 81}, (_, k) => [...data.slice(4 * k, 4 * k + 4)]); };
"""
ANSWER_SENTENCES_SCRIPT = """
choose("record", 1);
const seen = [];
for (const share of [0.1, 0.35, 0.6]) { point("pointermove", 90, share / 0.725); seen.push(answer()); }
const cells = document.querySelectorAll("td").length;
slide("b", 0); seen.push(answer());
press(canvas, "ArrowRight"); seen.push(answer());
for (const colour of ["outcome", "rotation", "time"]) choose("colour", colour);
const {wide} = await onPhone(() => null);
return {seen, cells, wide, title: document.title, hurt: window.hurt};
"""
CELL_PINNING_SCRIPT = """
const seen = {opening: [answer(), location.hash]};
point("pointermove", 90, 0.1); seen.hovered = [answer(), location.hash];
point("click", 90, 0.1); seen.pinned = [answer(), location.hash];
point("pointermove", 180, 0.5); seen.other = [answer(), text(".preview")];
point("pointerleave", 180, 0.5); seen.left = [answer(), text(".preview")];
const copied = await copyAll();
const {seen: again} = await onPhone((page) => text(".sentence", page), () => {}, location.hash);
const odd = "#record=r1&azimuth=32&b_over_h=lots&friction=1&colour=time";
const {seen: doubtful} = await onPhone(
  (page) => [text(".sentence", page), text(".doubts", page), page.querySelector("[data-name=colour]").value],
  () => {}, odd);
document.body.dispatchEvent(new KeyboardEvent("keydown", {key: "Escape", bubbles: true}));
seen.released = location.hash;
point("pointermove", 180, 0.5); seen.free = answer();
location.hash = "#record=r1";  // as the report has it
await until(() => document.querySelector("select[data-name=record]").value === "1");
seen.linked = [answer(), document.querySelector(".doubts").textContent];
location.hash = "#record=r1&azimuth=240&b_over_h=0.35&height=1.2&friction=0.3";
await until(() => answer().includes("S60°W"));
seen.changed = [...document.querySelectorAll("select")].map((one) => one.value);
return {...seen, copied, again, doubtful, href: location.href.split("#")[0]};
"""
KEYBOARD_CONTROL_SCRIPT = """
canvas.focus();
const seen = [];
slide("a", 11); slide("b", 0);
for (const key of ["ArrowRight", "ArrowUp", "ArrowLeft", "ArrowDown"]) {
  press(canvas, key); seen.push([canvas.getAttribute("aria-label"), answer(), location.hash]); }
return {seen, record: Number(document.querySelector("select").value),
        focus: document.activeElement === canvas, stop: canvas.tabIndex, role: canvas.getAttribute("role"),
        sliders: [...document.querySelectorAll("input")].map((one) => one.getAttribute("aria-valuetext"))};
"""
ANSWER_POSITION_ON_PHONE_SCRIPT = """
const look = (page) => {
  const window = page.defaultView, map = page.querySelector(".map canvas"), seen = [];
  const top = map.getBoundingClientRect().top + window.scrollY;
  for (const down of [0, 100, top - 20, top + map.clientHeight - 300]) {
    window.scrollTo(0, down);
    const box = page.querySelector(".answer").getBoundingClientRect(), sheet = map.getBoundingClientRect();
    seen.push({down, top: box.top, bottom: box.bottom, map: [sheet.top, sheet.bottom], high: window.innerHeight}); }
  return seen; };
return await onPhone(look);
"""
COLOUR_CONTRAST_SCRIPT = """
point("click", 90, 0.1);
point("pointermove", 180, 0.5);
const light = (colour) => {
  const [r, g, b] = colour.map((one) => one / 255).map((one) =>
    one <= 0.04045 ? one / 12.92 : ((one + 0.055) / 1.055) ** 2.4);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
const parts = (text) => text.match(/[\\d.]+/g).map(Number);
const behind = (one) => {
  for (; one; one = one.parentElement) {
    const colour = parts(getComputedStyle(one).backgroundColor);
    if (colour.length < 4 || colour[3] > 0) return colour.slice(0, 3); }
  return [255, 255, 255]; };
const worst = () => {
  let least = [Infinity, "", 0];
  for (const one of document.querySelectorAll("body *:not(script):not(option)")) {
    const own = one.matches("select") || [...one.childNodes].some((node) => node.nodeType === 3 && node.data.trim());
    if (!own || !one.getClientRects().length) continue;
    const both = [parts(getComputedStyle(one).color).slice(0, 3), behind(one)].map(light).sort((a, b) => b - a);
    const ratio = (both[0] + 0.05) / (both[1] + 0.05);
    least = ratio < least[0] ? [ratio, one.outerHTML.slice(0, 80), least[2] + 1] : [least[0], least[1], least[2] + 1]; }
  return least; };
const light_page = worst();
for (const rule of document.styleSheets[0].cssRules)
  if (rule.media && rule.media.mediaText.includes("dark")) rule.media.mediaText = "all";
document.documentElement.style.colorScheme = "dark";
return {light: light_page, dark: worst(), page: behind(document.body)};
"""
CELL_COLOURS_SCRIPT = """
slide("a", 4); slide("b", 0);  // the outline elsewhere
const [inner, middle, outer] = [0.1, 0.35, 0.6].map((ratio) => ratio / 0.725);
return {towards: pixels(30, inner), away: pixels(30, middle), stands: pixels(30, outer), some: pixels(60, outer),
        opposite: pixels(210, middle), gap: pixels(120, middle), line: pixels(30, 0.475 / 0.725),
        legend: text(".legend")};
"""
FALL_TIMES_SCRIPT = """
const seen = [];
slide("a", 0); slide("b", 1);
for (let k = 0; k < 3; k++) { press(canvas, "ArrowRight"); seen.push(answer()); }
choose("colour", "time");
const share = 0.35 / 0.725;
slide("a", 9); slide("b", 0);
const choices = [...document.querySelectorAll(".choices label")].map((one) => one.innerText.split("\\n"));
const {printColorAdjust: printed} = getComputedStyle(document.querySelector(".legend i"));
return {late: pixels(90, share), early: pixels(240, share), stands: pixels(180, share), seen,
        choices, printed, note: text("#keys"), legend: text(".legend")};
"""
ORIENTATIONS_SCRIPT = """
const seen = [], look = () => seen.push(answer());
slide("a", 0); slide("b", 0);
for (const key of ["ArrowLeft", "ArrowUp", "ArrowUp", "ArrowUp", "ArrowRight"]) { press(canvas, key); look(); }
const pictures = [];
for (const colour of ["azimuth", "rotation", "time"]) { choose("colour", colour); pictures.push(canvas.toDataURL()); }
const {wide, seen: again} = await onPhone((page) => text(".sentence", page), () => {}, location.hash);
return {seen, wide, again, different: new Set(pictures).size, hash: location.hash};
"""
FULL_CIRCLE_SCRIPT = """
slide("a", 0); slide("b", 0);
const unknown = answer();
press(canvas, "ArrowLeft");
const columns = [...document.querySelectorAll(".more th[scope=col]")].map((one) => one.textContent);
return {unknown, last: answer(), columns};
"""
SHOWN_FILM_COMMANDS_SCRIPT = """
const found = [];
for (const key of ["ArrowRight", "ArrowUp", "ArrowRight"]) {
  press(canvas, key); found.push([location.hash, text(".film code")]); }
return {found, copied: await copyAll()};
"""
ALL_TEXTS_SCRIPT = """
const shown = (page) => {
  const parts = [];
  const walk = (node) => {
    if (node.nodeType === 3) parts.push(node.data);
    else if (!["SCRIPT", "STYLE", "CODE"].includes(node.tagName)) {
      if (node.nodeType === 1) for (const name of ["aria-label", "aria-valuetext", "title", "aria-roledescription"])
        parts.push(node.getAttribute(name) || "");
      node.childNodes.forEach(walk); } };
  walk(page.body);
  return parts.join(" "); };
const drawn = [];
const write = CanvasRenderingContext2D.prototype.fillText;
CanvasRenderingContext2D.prototype.fillText = function (text, ...more) {
  drawn.push(text);
  write.call(this, text, ...more); };
const seen = [document.title];
for (const option of document.querySelector("select[data-name=colour]").options) {
  choose("colour", option.value);
  seen.push(shown(document)); }
for (const key of ["ArrowUp", "ArrowUp", "ArrowRight", "ArrowRight"]) {
  press(canvas, key); seen.push(shown(document)); }
point("pointermove", 180, 0.5); seen.push(shown(document));
location.hash = "#record=none&azimuth=x&b_over_h=7";
await new Promise((done) => setTimeout(done, 200));
seen.push(shown(document));
return {texts: seen.join(" "), drawn: drawn.join(" ")};
"""
UNTRANSLATED_NAMES = {"script", "window", "hurt", "none", "space", "report", "HTML", "html"}
"""Parts of the hostile names, and of an address, that no table translates."""
JAPANESE_PAGES = ("2-D in Japanese", "part in Japanese", "3-D in Japanese")


def cube_of_early_late_and_no_falls_by_azimuth() -> xr.Dataset:
    """Return a planar cube in which blocks fall at 2 s, but at 20 s along 90° and not at all along 180°.

    The azimuth has a period of 360°. The ensemble gives fall probabilities of 0.1 % at the second azimuth and 99.8 %
    at the third; at the fourth it was not run.
    """
    whole = random_planar_cube(records=1, heights=1, frictions=1)
    whole["overturned"][:], whole["overturning_time"][:] = 1.0, 2.0
    whole["overturned"][:, 6], whole["overturning_time"][:, 6], whole["overturning_time"][:, 3] = 0.0, np.nan, 20.0
    whole["probability_towards"][:], whole["probability_away"][:] = 0.5, 0.0
    whole["probability_towards"][:, 1], whole["probability_towards"][:, 2] = 0.001, 0.998
    whole["probability_towards"][:, 3] = whole["probability_away"][:, 3] = np.nan
    whole["azimuth"].attrs["period"] = 360.0
    return whole


def cube_with_known_outcome_by_b_over_h() -> xr.Dataset:
    """Return a cube of three planes: blocks of the smallest B/H fall towards the azimuth, of the next away from it.

    Blocks of the largest B/H stand, but along 60° 40 % of their ensemble runs fall away from the azimuth.
    """
    whole = random_planar_cube(records=1, heights=1, frictions=1).isel(azimuth=[0, 1, 2])
    for name, values in (
        ("overturned", (1, -1, 0)),
        ("probability_towards", (1, 0, 0)),
        ("probability_away", (0, 1, 0)),
    ):
        whole[name][:] = np.reshape(values, (1, 1, 1, 3, 1))
    whole["overturning_time"][:] = np.where(whole["overturned"] != 0, 5.0, np.nan)
    whole["probability_away"][0, 2, 0, 2, 0] = 0.4
    return whole


def cube_of_full_circle_with_unstable_cells() -> xr.Dataset:
    """Return a 3-D cube of the full circle of orientations; cases of the first one have the status unstable."""
    whole = random_3d_cube().assign_coords(orientation=np.arange(0, 360, 60))
    whole["overturned"][:, 0] = np.nan
    status = xr.full_like(whole["overturned"], CaseStatus.SIMULATED, dtype=np.int8)
    status[:, 0] = CaseStatus.UNSTABLE
    return whole.assign(status=status)


@pytest.fixture(scope="module", params=["chromium", pytest.param("firefox", marks=pytest.mark.long)])
def explorer_script_results(
    request: pytest.FixtureRequest, results_with_hostile_names: Path, tmp_path_factory: Any
) -> dict[str, Any]:
    """Return the results of the explorer scripts in one browser, by page name."""
    with open_cube(results_with_hostile_names / "cube.nc", element=None) as opened:
        command = explorer_page_html(explorer_page_data(opened))
    plain = explorer_page_html(explorer_page_data(random_planar_cube()), "report.html")
    pages = {
        "sentences": (plain, ANSWER_SENTENCES_SCRIPT),
        "pinning": (plain, CELL_PINNING_SCRIPT),
        "keys": (plain, KEYBOARD_CONTROL_SCRIPT),
        "phone": (plain, ANSWER_POSITION_ON_PHONE_SCRIPT),
        "contrast": (plain, COLOUR_CONTRAST_SCRIPT),
        "painted": (explorer_page_html(explorer_page_data(cube_with_known_outcome_by_b_over_h())), CELL_COLOURS_SCRIPT),
        "late": (
            explorer_page_html(explorer_page_data(cube_of_early_late_and_no_falls_by_azimuth())),
            FALL_TIMES_SCRIPT,
        ),
        "in space": (explorer_page_html(explorer_page_data(random_3d_cube())), ORIENTATIONS_SCRIPT),
        "stack": (
            explorer_page_html(explorer_page_data(random_3d_cube().expand_dims(element=["shaft"]))),
            ORIENTATIONS_SCRIPT,
        ),
        "full turn": (
            explorer_page_html(explorer_page_data(cube_of_full_circle_with_unstable_cells())),
            FULL_CIRCLE_SCRIPT,
        ),
        "command": (command, SHOWN_FILM_COMMANDS_SCRIPT),
    }
    if request.param == "chromium":  # one start of the browser for all
        with use_translation_language("ja"):
            for name, data in zip(
                JAPANESE_PAGES,
                (random_planar_cube(), cube_with_known_outcome_by_b_over_h(), random_3d_cube()),
                strict=True,
            ):
                pages[name] = (explorer_page_html(explorer_page_data(data), "report.html"), ALL_TEXTS_SCRIPT)
    profile: Path = tmp_path_factory.mktemp("browser") / "profile"
    return run_scripts_in_browser(
        request.param, {name: (page, SCRIPT_HELPERS + own) for name, (page, own) in pages.items()}, profile
    )


def outcome_words_of_random_cube_case(azimuth: int, ratio: int, record: int = 1) -> str:
    """Return the words for the outcome of a case of `random_planar_cube()`, at its first height and last friction."""
    flag = float(random_planar_cube()["overturned"][record, azimuth, 0, ratio, 1])
    return {1.0: "falls towards", -1.0: "falls towards", 0.0: "stands"}.get(flag, "no outcome was found")


def mean_colour(pixels: list[list[int]]) -> np.ndarray:
    """Return the mean colour of pixels (red, green, blue, opacity)."""
    return np.mean(pixels, axis=0)


@pytest.mark.browser
def test_explorer_sentences_match_the_outcomes_in_the_cube(explorer_script_results: dict[str, Any]) -> None:
    around = explorer_script_results["sentences"]
    # 90° is the fourth azimuth; then the slider goes to the first B/H, and a key to the next azimuth.
    places = [("E", 3, 0), ("E", 3, 1), ("E", 3, 2), ("E", 3, 0), ("S60°E", 4, 0)]
    for text, (name, azimuth, ratio) in zip(around["seen"], places, strict=True):
        assert text.startswith(f"Motion along {name}, B/H = {float(random_planar_cube()['b_over_h'][ratio]):g}: ")
        assert outcome_words_of_random_cube_case(azimuth, ratio) in text
    assert around["cells"] == 6, "no ring beyond the outermost"
    assert around["title"].startswith("</script><script>window.hurt")
    assert "hurt" not in around
    assert around["wide"] <= 390


@pytest.mark.browser
def test_click_pins_an_explorer_cell_and_escape_releases_it(explorer_script_results: dict[str, Any]) -> None:
    found, data = explorer_script_results["pinning"], explorer_page_data(random_planar_cube())
    _, b = data["records"][data["shown"]["record"]]["clear"]
    assert f"B/H = {data['b_over_h'][b]:g}: the block falls towards" in found["opening"][0]
    assert found["opening"][1] == "", "a page that was only opened has no cell in its address"
    assert found["hovered"][0].startswith("Motion along E, B/H = 0.1: ")
    assert "azimuth" not in found["hovered"][1]
    key = data["records"][data["shown"]["record"]]["id"]
    assert found["pinned"] == [
        found["hovered"][0],
        f"#record={key}&azimuth=90&b_over_h=0.1&height=0.6&friction=1",
    ]
    assert found["other"][0] == found["pinned"][0]
    assert "Motion along S, B/H = 0.35: " in found["other"][1]
    assert found["left"] == [found["pinned"][0], ""]
    assert found["released"] == f"#record={key}&height=0.6&friction=1"
    assert found["free"].startswith("Motion along S, B/H = 0.35: ")


@pytest.mark.browser
def test_explorer_opens_the_cell_in_its_address(explorer_script_results: dict[str, Any]) -> None:
    found = explorer_script_results["pinning"]
    assert found["again"] == found["pinned"][0]
    sentence, doubts, colour = found["doubtful"]
    assert sentence.startswith("Motion along N30°E"), "the nearest azimuth"
    assert re.findall(r"[\w.]+", doubts)[:2] == ["No", "azimuth"]
    assert "32" in doubts
    assert "lots" in doubts
    assert colour == "time"
    _, shape = explorer_page_data(random_planar_cube())["records"][1]["clear"]
    assert f"B/H = {random_planar_cube()['b_over_h'].to_numpy()[shape]:g}: " in found["linked"][0], "its clear case"
    assert found["linked"][1] == ""
    assert found["changed"][:4] == ["1", "1", "0", "0"], "record, height, aspect, friction of the new address"
    assert found["copied"] == [found["href"] + found["pinned"][1]], "a cube without a study has no command to copy"


@pytest.mark.browser
def test_explorer_map_is_used_with_keys_and_announces_outcomes(explorer_script_results: dict[str, Any]) -> None:
    found = explorer_script_results["keys"]
    assert (found["focus"], found["stop"], found["role"]) == (True, 0, "application")
    cells = [("0", "0.1"), ("0", "0.35"), ("330", "0.35"), ("330", "0.1")]  # the azimuth before 0° is 330°
    for (label, text, address), (azimuth, ratio) in zip(found["seen"], cells, strict=True):
        assert f"azimuth={azimuth}&b_over_h={ratio}&" in address
        assert label.endswith(text)
        assert (
            outcome_words_of_random_cube_case(int(azimuth) // 30, ["0.1", "0.35"].index(ratio), record=found["record"])
            in label
        )
    assert all(re.search("falls towards|stands|no outcome", text) for text in found["sliders"])


@pytest.mark.browser
def test_explorer_answer_stays_in_view_on_a_phone(explorer_script_results: dict[str, Any]) -> None:
    found = explorer_script_results["phone"]
    assert found["wide"] <= 390
    assert len(found["seen"]) == 4
    for one in found["seen"]:
        assert 0 <= one["top"] < one["bottom"] <= one["high"] + 0.5, one
    beside = found["seen"][2]
    assert 0 <= beside["map"][0] < beside["map"][1] <= beside["top"], "the whole map above the answer"


@pytest.mark.browser
def test_explorer_text_contrast_is_high_in_light_and_dark_mode(explorer_script_results: dict[str, Any]) -> None:
    found = explorer_script_results["contrast"]
    assert max(found["page"]) < 60, "the dark page is dark"
    for name in ("light", "dark"):
        ratio, element, count = found[name]
        assert count > 30
        assert ratio >= 4.5, (name, element)


@pytest.mark.browser
def test_explorer_colours_show_the_fall_probability_towards_the_azimuth(
    explorer_script_results: dict[str, Any],
) -> None:
    """White to dark with the probability of falls towards the azimuth; grey if none falls; blank if not run."""
    found = {name: np.array(one) for name, one in explorer_script_results["painted"].items() if name != "legend"}
    dark = 255 * np.array(to_rgb(style.PROBABILITY_COLOUR_STOPS[-1][1]))
    for name in ("towards", "opposite"):
        np.testing.assert_allclose(np.median(found[name], axis=0)[:3], dark, atol=3)
    for name in ("away", "some"):
        assert (np.median(found[name], axis=0) == 255).all(), "falls to the other side alone are white"
    grey = found["stands"][:, :3]
    assert np.ptp(grey, axis=1).max() <= 4, "no hue"
    assert mean_colour(grey).max() < 240
    assert np.ptp(grey[:, 0]) > 20, "a hatch"
    assert (found["gap"][:, 3] == 0).all(), "no fill"
    assert found["line"][:, :3].sum(axis=1).min() < 60, "black where half of the runs fall"
    assert "0.4" not in explorer_script_results["painted"]["legend"]


@pytest.mark.browser
def test_explorer_colour_scale_spans_the_fall_times_of_the_shown_record(
    explorer_script_results: dict[str, Any],
) -> None:
    """The latest fall is not coloured as a standing block; probabilities near 0 or 100 % are not printed as certain."""
    page = explorer_script_results["late"]
    early, last, stands = (np.median(page[name], axis=0)[:3] for name in ("early", "late", "stands"))
    np.testing.assert_allclose(early, 255 * np.array(to_rgb(style.PROBABILITY_COLOUR_STOPS[-1][1])), atol=3)
    assert np.ptp(stands) <= 4
    assert np.ptp(last) > 60, "a colour, not the grey of what stands"
    assert last.sum() > early.sum() + 200
    assert [float(one) for one in re.findall(r"([\d.]+) s", page["legend"])] == [2.0, 20.0]
    assert all(one in page["choices"] for one in (["record", f"{SCRIPT_AS_NAME}, E 0"], ["height", "0.6 m"]))
    assert page["printed"] == "exact", "browsers print no background colours otherwise"
    *some, not_run = page["seen"]
    assert not_run.endswith("20.00 s."), "no probability where the ensemble was not run"
    for text, words in zip(some, ("less than 1 %", "more than 99 %"), strict=True):
        assert f"with a probability of {words}" in text
        assert "with 0 %" in text
    assert "the scene faces" in page["note"]
    assert "towards which the block falls" not in page["note"]


@pytest.mark.browser
def test_explorer_of_a_3d_study_matches_the_cube(explorer_script_results: dict[str, Any]) -> None:
    whole, around = random_3d_cube(), explorer_script_results["in space"]
    record = explorer_page_data(whole)["shown"]["record"]

    def expected_sentence(orientation: int, ratio: int) -> str:
        fell = float(whole["overturned"][record, orientation, 0, ratio, 0, 1])
        return "the body falls towards" if fell else "the body stands"

    # No orientation before the first; keys lead beyond the first ring without falls, which the map then shows.
    places = [("N", 0, 0), ("N", 0, 1), ("N", 0, 2), ("N", 0, 3), ("N15°E", 1, 3)]
    for text, (name, orientation, ratio) in zip(around["seen"], places, strict=True):
        assert text.startswith(f"Facing {name}, B/H = {float(whole['b_over_h'][ratio]):.4g}: ")
        assert expected_sentence(orientation, ratio) in text
    assert around["wide"] <= 390
    assert around["different"] == 3
    assert explorer_script_results["stack"]["seen"] == [
        text.replace("the body", "the shaft") for text in around["seen"]
    ]
    assert around["again"] == around["seen"][-1]
    assert "orientation=15&b_over_h=0.4&aspect=1&friction=1" in around["hash"]


@pytest.mark.browser
def test_explorer_of_a_full_circle_wraps_and_states_why_an_outcome_is_missing(
    explorer_script_results: dict[str, Any],
) -> None:
    found = explorer_script_results["full turn"]
    assert found["unknown"] == "Facing N, B/H = 0.1: no outcome was found: the computation is unstable."
    assert found["last"].startswith("Facing N60°W, B/H = 0.1: ")
    assert found["columns"] == ["B/H", "240°", "300°", "0°"]


@pytest.mark.browser
def test_command_in_the_explorer_has_the_options_of_the_pinned_cell(explorer_script_results: dict[str, Any]) -> None:
    for address, command in explorer_script_results["command"]["found"]:
        values = dict(part.split("=") for part in address.removeprefix("#").split("&"))
        words = shlex.split(command)
        given = {words[k].removeprefix("--"): words[k + 1] for k in range(2, len(words), 2)}
        assert words[:2] == ["overturning", "one"]
        assert given["record"]
        assert (given["azimuth"], given["b-over-h"]) == (values["azimuth"], values["b_over_h"])
        assert given["animate"] == "fall.html"
        assert float(given["height"]) > 0 < float(given["friction"])
    assert explorer_script_results["command"]["copied"][-1] == explorer_script_results["command"]["found"][-1][1]


@pytest.mark.browser
@pytest.mark.parametrize("explorer_script_results", ["chromium"], indirect=True)
def test_explorer_in_japanese_has_no_english_word(explorer_script_results: dict[str, Any]) -> None:
    for name in JAPANESE_PAGES:
        found = explorer_script_results[name]
        assert not untranslated_latin_words(found["texts"]) - UNTRANSLATED_NAMES, name
        assert not untranslated_latin_words(found["drawn"]) - UNTRANSLATED_NAMES, name
        assert re.search("[ぁ-ん]", found["drawn"]), name


@pytest.mark.browser
def test_explorer_reads_record_files_next_to_the_page_from_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(explore, "MAX_CELLS_OF_SINGLE_EXPLORER_PAGE", 10)
    explore.write_explorer(random_planar_cube(), tmp_path / "look around.html")
    names, options = BROWSER_PROGRAMS["chromium"]
    program = next(
        (found for name in names if (found := shutil.which(name))), None
    ) or skip_test_unless_skipping_is_forbidden("needs Chromium")
    command = [program, *options.replace("--remote-debugging-port=0 ", "").split()]
    command[-1] += str(tmp_path / "profile")
    page = (tmp_path / "look around.html").as_uri() + "#record=r1&azimuth=90&b_over_h=0.1"
    done = subprocess.run([*command, "--virtual-time-budget=5000", "--dump-dom", page], capture_output=True, timeout=60)
    assert '<main id="explorer" data-ready="true">' in done.stdout.decode()
    assert "Motion along E, B/H = 0.1: " in done.stdout.decode()
