"""The film: its data, its page, and the page in a real browser."""

import base64
import json
from pathlib import Path

import numpy as np
import pytest

from overturning.errors import ArgumentError
from overturning.figures.film import Film, Panel, corners, film_data, view
from overturning.figures.film_page import film_page, write_film_page
from tests.figures.chromium import browser
from tests.figures.films import BASE, block, two_panels


def unpack(packed: dict) -> np.ndarray:
    return np.frombuffer(base64.b64decode(packed["data"]), "<i2") * packed["scale"]


def test_poses_survive_packing() -> None:
    film = two_panels()
    for panel, data in zip(film.panels, film_data(film)["panels"], strict=True):
        body, packed = panel.bodies[1], data["bodies"][1]
        assert unpack(packed["position"]).reshape(-1, 2) == pytest.approx(body.position, abs=2e-5)
        assert unpack(packed["rotation"]) == pytest.approx(body.rotation, abs=1e-4)


def test_positive_rotation_turns_towards_the_right() -> None:
    body = block(np.array([0.0, 0.3]))
    standing, turned = corners(body, 0), corners(body, 1)
    assert standing[:, 1].min() == pytest.approx(0)
    assert turned[1] == pytest.approx([0.12, 0.0])  # it turns about its right lower corner
    assert turned[2, 0] > standing[2, 0]
    assert turned[0, 1] > 0


def test_the_view_holds_all_free_bodies() -> None:
    left, right, bottom, top = view(two_panels())
    assert left < -0.12
    assert right > 0.12 + 0.6  # the fallen block lies to the right of its corner
    assert bottom < 0 < 0.6 < top
    assert right < 2  # the wide base does not count


def test_a_long_film_is_small_enough() -> None:
    page = film_page(two_panels(duration=30.0))
    assert len(page.encode()) < 300_000


def test_same_bytes(tmp_path: Path) -> None:
    for name in ("a.html", "b.html"):
        write_film_page(two_panels(), tmp_path / name)
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


def test_nothing_from_outside() -> None:
    page = film_page(two_panels())
    assert "http" not in page
    assert "src=" not in page
    assert "@import" not in page


def test_fine_motion_keeps_its_peak() -> None:
    acceleration = np.zeros(4000)
    acceleration[1237] = 7.0
    panel = Panel("p", "stands", np.nan, "W", "E", (BASE, block(np.zeros(100))), acceleration, 0.0005)
    data = film_data(Film("f", 0.0, 0.02, (panel,)))
    assert unpack(data["panels"][0]["motion"]).max() == pytest.approx(700, rel=1e-3)
    assert len(unpack(data["panels"][0]["motion"])) < 250


def test_refuses() -> None:
    with pytest.raises(ArgumentError, match="at least one"):
        Film("f", 0.0, 0.02, ())
    with pytest.raises(ArgumentError, match="not finite"):
        Film("f", 0.0, 0.02, (Panel("p", "", np.nan, "W", "E", (block(np.array([0.0, np.nan])),), np.zeros(3), 0.1),))


@pytest.mark.browser
def test_in_a_browser(tmp_path: Path) -> None:
    name = "A </script><script>window.hurt = 1</script> & <b>name</b>"
    write_film_page(two_panels(duration=1.2, title=name), tmp_path / "film.html")
    with browser(tmp_path / "profile") as page:
        page.open(tmp_path / "film.html")
        page.wait("document.querySelector('.film').dataset.ready === 'true'")
        data = "document.querySelector('.film').dataset"
        assert page.evaluate("window.hurt") is None
        assert page.evaluate("document.querySelector('.film-title').textContent") == name
        assert page.evaluate(f"{data}.state") == "paused"
        # It plays when asked to, and stops by itself at the end.
        page.click(".film-play")
        page.wait(f"{data}.state === 'playing' && Number({data}.time) > 0.2")
        page.wait(f"{data}.state === 'ended'")
        assert float(page.evaluate(f"{data}.time")) == pytest.approx(1.2)
        assert page.evaluate("document.querySelectorAll('.film-outcome')[1].textContent") == "stands"
        # Keyboard: on a page with one film without a click on it.
        page.evaluate("document.activeElement.blur()")
        page.press("Home")
        assert float(page.evaluate(f"{data}.time")) == 0
        page.press("ArrowRight")
        assert float(page.evaluate(f"{data}.time")) == pytest.approx(0.02)
        page.press("f", "KeyF", "f")
        assert page.evaluate(f"{data}.forces") == "true"
        page.press("s", "KeyS", "s")
        assert page.evaluate(f"{data}.rate") == "0.5"
        page.press(" ", "Space", " ")
        page.wait(f"Number({data}.time) > 0.1")
        page.press(" ", "Space", " ")
        assert page.evaluate(f"{data}.state") == "paused"
        # Scrubbing.
        page.evaluate(
            "(() => { const s = document.querySelector('.film input[type=range]'); s.value = 1.0;"
            " s.dispatchEvent(new Event('input')); })()"
        )
        assert float(page.evaluate(f"{data}.time")) == pytest.approx(1.0)
        assert page.complaints == []


@pytest.mark.browser
def test_three_panels_side_by_side_on_a_phone(tmp_path: Path) -> None:
    film = two_panels()
    write_film_page(Film("three", 0.0, 0.02, (*film.panels, film.panels[0])), tmp_path / "film.html")
    with browser(tmp_path / "profile") as page:
        page.call("Emulation.setDeviceMetricsOverride", width=390, height=800, deviceScaleFactor=1, mobile=True)
        page.open(tmp_path / "film.html")
        page.wait("document.querySelector('.film').dataset.ready === 'true'")
        tops = page.evaluate(
            "[...document.querySelectorAll('.film-panel')].map(p => Math.round(p.getBoundingClientRect().top))"
        )
        assert len(set(tops)) == 1
        assert len(tops) == 3
        assert page.evaluate("document.documentElement.scrollWidth") <= 390


@pytest.mark.browser
def test_the_canvas_shows_the_fall(tmp_path: Path) -> None:
    """The block's colour leaves its first place and comes to the right of it."""
    write_film_page(two_panels(forces=False), tmp_path / "film.html")
    count = (
        "(() => { const c = document.querySelector('canvas'), d = c.getContext('2d').getImageData(0, 0, c.width, "
        "c.height).data; let left = 0, right = 0; for (let i = 0; i < d.length; i += 4) if (d[i] === 0xc9 && d[i + 1] "
        "=== 0xc4) { if ((i / 4) % c.width < c.width * 0.4) left++; else right++; } return [left, right]; })()"
    )
    with browser(tmp_path / "profile") as page:
        page.open(tmp_path / "film.html")
        page.wait("document.querySelector('.film').dataset.ready === 'true'")
        assert page.evaluate("document.querySelectorAll('.film-controls input[type=checkbox]').length") == 0
        before = page.evaluate(count)
        page.evaluate("document.querySelector('.film').focus()")
        page.press("End")
        after = page.evaluate(count)
        assert before[0] > 1000 > before[1]
        assert after[1] > 5 * after[0]
        assert page.evaluate("document.querySelector('.film-outcome').textContent").startswith("falls towards N60")
        assert all(
            "readback" in complaint for complaint in page.complaints
        )  # the test reads pixels, the player does not


def test_data_is_plain_json() -> None:
    text = json.dumps(film_data(two_panels()))
    assert "NaN" not in text
