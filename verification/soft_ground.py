"""`python -m verification.soft_ground`: write the effect of soft ground (config/soft-ground.yaml) into the docs.

Requires `results/soft-ground`, from `make soil run STUDY=config/soft-ground.yaml`.
"""

from typing import Final

import pandas as pd

from overturning.report.blocks import Answer, Paragraph, Table
from overturning.report.results import Results, open_results
from overturning.report.sections.ground import ground
from overturning.study.load import load_study
from overturning.study.scenes import NOMINAL, variant_settings
from verification.tables import RESULTS, ROOT, markdown, publish, wrap_text, write_csv

STUDY: Final = ROOT / "results" / "soft-ground"


def rates(results: Results) -> pd.DataFrame:
    """Return fall rate and axis of every record on every ground, for each amplitude."""
    rows = []
    for ground_name, found in results.populations.items():
        table = found[["fall_rate", "fall_axis", "fall_resultant"]].to_dataframe().reset_index()
        table.insert(0, "ground", "rock" if ground_name == NOMINAL else ground_name)
        rows.append(table.drop(columns=["record", "event"], errors="ignore"))
    return pd.concat(rows)


def periods(results: Results) -> str:
    """Return the fundamental periods of the variants, in order."""
    found = []
    for name in results.study.variants:
        site = variant_settings(results.study, name).site
        if site is not None:
            found.append(4 * sum(one.thickness_m / one.velocity_m_s for one in site.layers))
    return ", ".join(f"{one:.2f} s" for one in found)


def bodies(results: Results) -> dict[str, str]:
    """Return the tables and sentences of the report as Markdown, by marker."""
    section = ground(results)
    assert section is not None
    (answer,) = (block for block in section.blocks if isinstance(block, Answer))
    (table,) = (block for block in section.blocks if isinstance(block, Table))
    converged = next(block for block in section.blocks if isinstance(block, Paragraph))
    text = f"{converged.text} Fundamental periods at small strain: {periods(results)}."
    return {
        "soft-ground": markdown(table.heads, table.rows),
        "soft-ground-answer": "\n".join(wrap_text(sentence, "- ") for sentence in answer.sentences),
        "soft-ground-convergence": wrap_text(text),
    }


def main() -> None:
    """Write verification/results/soft-ground.csv and the page."""
    study = load_study(ROOT / "config" / "soft-ground.yaml")
    with open_results(STUDY, study) as results:
        write_csv(rates(results), RESULTS / "soft-ground.csv")
        publish(bodies(results))


if __name__ == "__main__":
    main()
