"""The prose of a small study as a whole; the numbers in it stand as #, they are tested where they are made."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from overturning.report.blocks import Code, Film, Report, Row, Section, Table, each_block
from overturning.report.build import build_report
from overturning.report.results import Results
from overturning.settings import Population
from overturning.study.convergence import Convergence
from overturning.surveys.population import population_rates
from tests.report.reading import NUMBER, of_study, texts
from tests.report.test_exactness import FOUND

PROSE = Path(__file__).with_name("prose.txt")


def prose(report: Report) -> str:
    """Titles, sentences, captions and headings of tables in their order, a line each."""
    lines = []
    for block in each_block(report):
        if isinstance(block, Section):
            lines.append(f"\n# {block.title}")
        elif isinstance(block, Table):
            lines.append("| ".join(block.heads).strip())
        elif not isinstance(block, Code | Film | Row) and not hasattr(block, "blocks"):
            lines += [text for text in texts(block) if text]
    kept = (line.replace("\u00a0", " ") for line in lines if "numpy" not in line)  # not the versions of packages
    return NUMBER.sub("#", "\n".join(kept)).strip() + "\n"


def test_the_prose_of_a_small_study(opened: Results, one_record: Callable[..., Results], tmp_path: Path) -> None:
    results, stones = one_record(8), Population(stones=64)
    made = replace(
        of_study(results, population=stones, title="Tiny"),
        convergence=Convergence.model_validate(FOUND),
        populations={"nominal": population_rates(results.cube, stones)},
        illustrative=[],
    )
    found = prose(build_report(made))
    (tmp_path / PROSE.name).write_text(found, encoding="utf-8")
    assert found == PROSE.read_text(encoding="utf-8"), f"where this is meant: cp {tmp_path / PROSE.name} {PROSE}"
