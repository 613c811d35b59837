"""GIF and MP4."""

import os
import shutil
from pathlib import Path

import pytest
from PIL import Image

from overturning.errors import ArgumentError, MissingDataError
from overturning.figures.film_movie import write_film_movie
from tests.figures.films import two_panels


def test_gif(tmp_path: Path) -> None:
    for name in ("a.gif", "b.gif"):
        write_film_movie(two_panels(duration=0.9), tmp_path / name)
    assert (tmp_path / "a.gif").read_bytes() == (tmp_path / "b.gif").read_bytes()
    with Image.open(tmp_path / "a.gif") as picture:
        assert picture.n_frames == 16
        first = picture.convert("L").tobytes()
        picture.seek(picture.n_frames - 1)
        assert picture.convert("L").tobytes() != first
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.gif", "b.gif"]


def test_mp4(tmp_path: Path) -> None:
    if shutil.which("ffmpeg") is None:
        with pytest.raises(MissingDataError, match="ffmpeg"):
            write_film_movie(two_panels(duration=0.4), tmp_path / "a.mp4")
        assert not list(tmp_path.iterdir())
        return
    write_film_movie(two_panels(duration=0.4), tmp_path / "a.mp4")
    assert os.path.getsize(tmp_path / "a.mp4") > 1000


def test_other_endings(tmp_path: Path) -> None:
    with pytest.raises(ArgumentError, match="avi"):
        write_film_movie(two_panels(duration=0.4), tmp_path / "a.avi")
