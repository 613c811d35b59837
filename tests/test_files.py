"""Writing: whole or not at all, and in words a user understands where it cannot be."""

import errno
import re
from pathlib import Path
from types import SimpleNamespace

import pytest

from overturning import files
from overturning.errors import ArgumentError, ConfigError
from overturning.files import (
    atomic_write,
    check_output_path,
    check_outputs_are_separate_files,
    read_yaml_mapping,
)
from tests.expect import run_overturning_and_return_printed_text


@pytest.mark.parametrize("error", [OSError(errno.ENOSPC, "full"), RuntimeError("NetCDF: HDF error")])
def test_full_disk_error_names_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: Exception) -> None:
    monkeypatch.setattr(files.shutil, "disk_usage", lambda _: SimpleNamespace(free=1000))
    with pytest.raises(OSError, match=r"cube\.nc") as found, atomic_write(tmp_path / "cube.nc"):
        raise error
    assert found.value.errno == errno.ENOSPC
    assert list(tmp_path.iterdir()) == []


def test_command_line_reports_file_errors_in_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    def raise_read_only_file_system_error(*_: object) -> None:
        raise OSError(errno.EROFS, "Read-only file system", "config/schema.json")

    monkeypatch.setattr(
        "overturning.study.document.write_study_schemas_and_readme_tables", raise_read_only_file_system_error
    )
    text = run_overturning_and_return_printed_text("study", "document", status=1)
    assert text == "error: config/schema.json: read-only file system; choose a folder that you may write to\n"


def test_an_interrupted_command_prints_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    def raise_interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("overturning.study.document.write_study_schemas_and_readme_tables", raise_interrupt)
    assert (
        run_overturning_and_return_printed_text("study", "document", status=130)
        == "Stopped; no incomplete file was kept.\n"
    )


@pytest.mark.parametrize(
    "arguments",
    [
        ["explore", "cube.nc", "--output", "/proc/x.html"],
        ["one", "--record", "rinaldi", "--azimuth", "60", "--animate", "/proc/x.html"],
        ["backwards", "stones.csv", "--figure", "/proc/x.svg"],  # before it reads any
        ["survey", "stones.csv", "--cube", "cube.nc", "--output", "/proc/x.json"],
        ["init", "/proc/x"],
        ["study", "new", "--name", "x", "--records", "rinaldi", "--folder", "/proc/x"],
        ["members", "--study", '{"name": "x", "records": {"use": ["rinaldi"]}}', "--output", "/proc/x.csv"],
    ],
    ids=lambda words: words[0],
)
def test_an_unwritable_output_path_is_named_in_a_one_line_error(arguments: list[str]) -> None:
    """The paths lie in /proc, where no user can create a file."""
    text = run_overturning_and_return_printed_text(*arguments, status=1)
    assert text.startswith("error: "), text
    assert "/proc/x" in text
    assert len(text.splitlines()) <= 2


def test_an_output_equal_to_an_input_or_another_output_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file that is named by another path or by a symbolic link counts as the same file."""
    (tmp_path / "stones.csv").touch()
    (tmp_path / "link.csv").symlink_to(tmp_path / "stones.csv")
    monkeypatch.chdir(tmp_path)
    inputs = [tmp_path / "stones.csv", None]
    for name in ("stones.csv", "link.csv", f"../{tmp_path.name}/stones.csv"):
        with pytest.raises(ArgumentError, match=r"--output .*\.csv: an input of the command, .* name another file"):
            check_outputs_are_separate_files({"--figure": None, "--output": Path(name)}, inputs)
    with pytest.raises(ArgumentError, match=r"--rose .*a\.png: the file of --figure, too"):
        check_outputs_are_separate_files({"--figure": tmp_path / "a.png", "--rose": Path("a.png")}, inputs)
    check_outputs_are_separate_files({"--figure": Path("a.png"), "--rose": Path("b.png")}, inputs)


def test_an_output_path_needs_an_existing_folder_and_a_known_extension(tmp_path: Path) -> None:
    with pytest.raises(ArgumentError, match=r"--animate .*there is no folder .*gone; create it first"):
        check_output_path(tmp_path / "gone" / "fall.html", "--animate")
    with pytest.raises(ArgumentError, match="is a folder"):
        check_output_path(tmp_path, "--animate")
    with pytest.raises(
        ArgumentError, match=r"--animate .*fall\.avi: unknown kind of file; use the extension \.html or \.gif"
    ):
        check_output_path(tmp_path / "fall.avi", "--animate", ".html", ".gif")
    check_output_path(tmp_path / "fall.html", "--animate", ".html", ".gif")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a: 1\nb: 2\na: 3\n", "line 3: a is given twice; keep one"),
        ("a:\n  b: {c: 1, c: 2}\n", "line 2: c is given twice; keep one"),
        ("a: [10, 045]\n", "line 1: YAML reads 045 as 37; write it without leading zeros"),
        ("a: 1:30\n", "line 1: YAML reads 1:30 as 90; write it without colons"),
        ("a: 1:30.5\n", "line 1: YAML reads 1:30.5 as 90.5; write it without colons"),
    ],
)
def test_repeated_yaml_keys_and_octal_or_base_60_numbers_are_refused(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "s.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match=re.escape(f"s.yaml, {said}")):
        read_yaml_mapping(tmp_path / "s.yaml", "study", "see there")


def test_unambiguous_yaml_values_are_read(tmp_path: Path) -> None:
    text = "a: &x {b: 0, c: 0.5, d: -7, e: 1e3, f: .5, g: 1.5e+3, h: 0x10}\ni: {<<: *x, b: 1}\nj: .inf\n"
    (tmp_path / "s.yaml").write_bytes(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    data = read_yaml_mapping(tmp_path / "s.yaml", "study", "see there")
    assert data["a"] == {"b": 0, "c": 0.5, "d": -7, "e": "1e3", "f": 0.5, "g": 1500.0, "h": 16}
    assert data["i"] == data["a"] | {"b": 1}
    assert data["j"] == float("inf")
