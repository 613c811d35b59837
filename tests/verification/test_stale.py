"""Measured tables know the sources that they are of: which change makes them stale, and which does not."""

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from overturning.study import sources
from verification import stale
from verification.tables import RESULTS, ROOT

Edit = Callable[..., set[str]]


@pytest.fixture
def edit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Edit:
    """Change a text in a file of a copy of the project, and return the measures that have another hash then."""
    for name in ("src/overturning", "verification", "config", "surveys"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__", "results"))
    monkeypatch.setattr(sources, "PACKAGE", tmp_path / "src" / "overturning")
    monkeypatch.setattr(stale, "ROOT", tmp_path)

    def hashes() -> dict[str, str]:
        return {name: stale.hash_of(name) for name in stale.MEASURES}

    before = hashes()

    def edited(name: str, pattern: str, new: str) -> set[str]:
        path = tmp_path / name
        old = path.read_text(encoding="utf-8")
        text, count = re.subn(pattern, new, old, count=1, flags=re.MULTILINE)
        assert count, f"{name} has no {pattern}"
        path.write_text(text, encoding="utf-8")
        after = hashes()
        path.write_text(old, encoding="utf-8")
        return {name for name in before if before[name] != after[name]}

    return edited


@pytest.mark.long
def test_what_makes_a_table_stale_and_what_does_not(edit: Edit) -> None:
    block = {name for name, one in stale.MEASURES.items() if "block" in one.kernels}
    body = {name for name, one in stale.MEASURES.items() if "body" in one.kernels}
    found = edit("src/overturning/dem/block/state.py", r"^(MOST_FRICTION\b.*= ).*", r"\g<1>99.0")
    assert found == block, "a constant of the block's kernel"
    assert "scenes:speed" not in found
    assert "space:study" not in found
    assert (
        edit("src/overturning/dem/body/statics.py", r"matrix = np\.zeros\(\(6, 6\)\)", "matrix = np.ones((6, 6))")
        == body
    )
    assert edit("src/overturning/units.py", r"(STANDARD_GRAVITY\b.*= ).*", r"\g<1>9.8") >= block | body
    module = "src/overturning/dem/block/state.py"
    for pattern, new, what in (
        (r'\A"""', '"""Other words. ', "a docstring"),
        (r"\A", "# a comment\n\n\n", "a comment and layout"),
        (r"^(MOST_FRICTION\b.*)", r'\1\n"""Other words."""', "prose below a constant"),
    ):
        assert edit(module, pattern, new) == set(), what
    assert edit("src/overturning/dem/run.py", r"(?s)\Z", "\n\ndef f():\n    raise ValueError('one')\n")
    assert edit("src/overturning/model/cases.py", r'ArgumentError\(\s*f"', 'ArgumentError(f"Oh, ') == set(), "a message"
    cases, check = "src/overturning/model/cases.py", r"^( +)(if [^\n]+:\n +raise )"
    assert edit(cases, check, r"\1if 1 > 2:\n\1    raise ValueError\n\1\2") == set(), "a further refusal"
    assert edit(cases, check, r"\1if 1 > 2:\n\1    x = 1\n\1\2"), "what is done and not refused"
    assert edit(cases, check, r"\1if (x := 1) > 2:\n\1    raise ValueError\n\1\2"), "a refusal that sets a name"
    assert edit("src/overturning/figures/style.py", r"\Z", "\nX = 1\n") == set()
    assert edit("src/overturning/model/polyhedron.py", r"\Z", "\nX = 1\n") == set(), "bodies that no measure has"
    assert edit("src/overturning/dem/polygon/verdict.py", r"^(SAFE_TILT\b.*= ).*", r"\g<1>99.0") >= {
        "stability", "scenes:speed"
    }  # fmt: skip
    assert edit("verification/tables.py", r"\Z", "\nX = 1\n") == set(), "what only lays a table out"
    part = edit("verification/bench.py", r"t = np.arange\(60\)", "t = np.arange(61)")
    assert part == {"bench:growth"}, "a part of a script makes its own figures stale"
    assert edit("config/near-fault.yaml", r"^title: .*", "title: Other words") == set()
    assert "bench:default_study" in edit("config/near-fault.yaml", r"^height: .*", "height: [0.6]")


@pytest.mark.long
def test_a_hash_is_kept_and_is_that_of_the_begin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    results = tmp_path / "verification" / "results"
    results.mkdir(parents=True)
    (tmp_path / "docs").mkdir()
    page = tmp_path / "docs" / "measurements.md"
    page.write_text("<!-- machine:begin -->\n<!-- machine:end -->\n", encoding="utf-8")
    with stale.measuring("scenes:speed", results):
        monkeypatch.setattr(stale, "hash_of", lambda _: "of sources changed meanwhile")
    assert "scenes:speed" in stale.stale(results)
    monkeypatch.undo()
    assert "scenes:speed" not in stale.stale(results)
    assert "scenes:kernels" in stale.stale(results)
    with pytest.raises(ZeroDivisionError), stale.measuring("scenes:kernels", results):
        raise ZeroDivisionError
    assert stale.kept(results)["measure"].tolist() == ["scenes:speed"], "what fails keeps nothing"
    assert stale.commands_of(["scenes:speed"], results)[0].startswith("python -m verification.scenes speed  # ")
    assert f"{stale.machine()}." in page.read_text(encoding="utf-8").replace("\n  ", " ")


def test_no_table_is_of_other_sources_than_todays() -> None:
    assert stale.commands_of(stale.stale()) == []


def test_no_measure_has_a_body_given_by_its_vertices() -> None:
    scripts = [path.read_text(encoding="utf-8") for path in (ROOT / "verification").rglob("*.py")]
    studies = [ROOT / name for one in stale.MEASURES.values() for name in one.inputs if name.endswith(".yaml")]
    assert not any(re.search(r"Polyhedron\b|read_mesh", text) for text in scripts)
    assert not any(re.search(r"^ *(vertices|mesh):", path.read_text(encoding="utf-8"), re.MULTILINE)
                   for path in studies if "scenes" not in path.parts)  # fmt: skip


def test_every_table_made_by_a_script_is_registered() -> None:
    texts = [page.read_text(encoding="utf-8") for page in (ROOT / "README.md", *(ROOT / "docs").rglob("*.md"))]
    marks = {mark for text in texts for mark in re.findall(r"^<!-- ([\w-]+):begin -->$", text, flags=re.MULTILINE)}
    files = {path.name for path in RESULTS.iterdir()} | {stale.KEPT}
    scripts = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "verification").rglob("*.py"))
    drawings = {path.name for path in (ROOT / "docs" / "images").iterdir() if f'"{path.name}"' in scripts}
    assert marks | files | drawings == stale.registered()
    assert set(stale.kept()["measure"]) <= set(stale.MEASURES)
    assert all(re.fullmatch("[0-9a-f]{16}", stale.hash_of(name)) for name in stale.MEASURES)
