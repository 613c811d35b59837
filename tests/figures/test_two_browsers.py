"""Films and the explorer do in Firefox what they do in Chromium."""

from pathlib import Path

import numpy as np
import pytest

from overturning.dem.body.trajectory import trajectory_in_space
from overturning.figures.explore import explorer_data, explorer_page
from overturning.figures.film_of_trajectory import film_of
from overturning.figures.film_page import write_film_page
from overturning.motion.motion import Motion
from tests.figures.chromium import browser
from tests.figures.films import two_panels
from tests.figures.firefox import answers
from tests.figures.test_explore import cube

WAIT = """
const until = async (holds) => {
  for (let i = 0; i < 400 && !holds(); i++) await new Promise((done) => setTimeout(done, 50));
  if (!holds()) throw new Error(`did not come true: ${holds}`); };
"""
PRESS = (
    "const press = (key) => film.dispatchEvent(new KeyboardEvent('keydown', {key, bubbles: true, cancelable: true}));"
)
FILM = f"""{WAIT}
const film = document.querySelector('.film'), seen = [];
{PRESS}
const look = () => seen.push({{...film.dataset}});
await until(() => film.dataset.ready === 'true');
look();
press('ArrowRight'); look(); press('f'); look(); press('s'); look(); press('Home'); look();
press('s'); film.querySelector('.film-play').click();
await until(() => film.dataset.state === 'ended');
look();
const words = [...document.querySelectorAll('.film-outcome')].map((outcome) => outcome.textContent);
const canvas = document.querySelector('canvas');
const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
const inked = pixels.data.filter((value, index) => index % 4 === 0 && value === 0xc9).length > 500;
return {{seen, words, inked, wide: document.documentElement.scrollWidth <= innerWidth}};
"""
EXPLORER = f"""{WAIT}
const explorer = document.getElementById('explorer');
await until(() => explorer.dataset.ready === 'true');
const choose = (name, value) => {{ const box = document.querySelector(`select[data-name=${{name}}]`); box.value = value;
  box.dispatchEvent(new Event('change')); }};
choose('record', 1);
const canvas = document.querySelector('canvas'), place = canvas.getBoundingClientRect(), said = [];
for (let part = 0.5; part < 1; part += 0.005) {{
  canvas.dispatchEvent(new PointerEvent('pointermove', {{bubbles: true, clientX: place.x + part * place.width,
    clientY: place.y + place.height / 2}}));
  const now = document.querySelector('.said').textContent;
  if (now !== said.at(-1)) said.push(now);
}}
return {{said, title: document.title}};
"""


@pytest.mark.browser
def test_they_agree(tmp_path: Path) -> None:
    pages = {tmp_path / "film.html": FILM, tmp_path / "space.html": FILM, tmp_path / "explore.html": EXPLORER}
    film, space, explorer = pages
    write_film_page(two_panels(duration=0.6), film)
    time = np.arange(0, 1.2, 0.01)
    motion = Motion(7.0 * np.sin(2 * np.pi * time), 3.0 * np.sin(2 * np.pi * time), sampling_interval=0.01)
    path = trajectory_in_space(motion, orientation_deg=10.0, height=0.6, b_over_h=0.25, friction=0.8)
    write_film_page(film_of([path], motion, "title"), space)
    explorer.write_text(explorer_page(explorer_data(cube())), encoding="utf-8")

    found = []
    with browser(tmp_path / "chromium") as one:
        for page, script in pages.items():
            one.open(page)
            found.append(one.evaluate(f"(async () => {{ {script} }})()"))
        assert all("readback" in complaint for complaint in one.complaints)  # the script reads pixels, no page does
    assert answers(pages, tmp_path / "firefox") == found

    plane, solid, around = found
    assert plane["inked"]
    assert plane["wide"]
    assert plane["words"][1] == "stands"
    assert [float(at["time"]) for at in plane["seen"]] == pytest.approx([0, 0.02, 0.02, 0.02, 0, 0.6])
    assert solid["seen"][-1]["state"] == "ended"
    assert len(around["said"]) > 3
