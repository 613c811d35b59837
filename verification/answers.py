"""`python -m verification.answers`: what the shipped studies found, in the words of their reports, into README.md.

Needs the results of the studies named below and of config/fine-map.yaml, from `make run STUDY=…`.
"""

import shutil
from pathlib import Path
from typing import Final

from overturning.report.results import Results, open_results
from overturning.report.sections.answer import ANSWERS
from overturning.study.load import load_study
from verification.tables import ROOT, publish, wrapped

SENTENCES: Final = {
    "near-fault": slice(0, 2), "in-space": slice(0, 4), "three-tier": slice(1, 3), "waiau": slice(1, 3),
}  # fmt: skip
"""Sentences of the answer that are told of each study."""

PICTURES: Final = {"rinaldi.svg": "fine-map", "rinaldi-in-space.svg": "in-space"}
"""Drawings of docs/images, and the study whose map of Rinaldi they are."""

_FIXED: Final = "Primary statistic, fixed beforehand: "


def found(results: Results, name: str) -> str:
    """The question of a study and what answers it, as an item of a list in Markdown."""
    sentences, _ = ANSWERS[results.study.asks](results)
    plain = (one.removeprefix(_FIXED) for one in sentences[SENTENCES[name]])
    answer = " ".join(f"{one[:1].upper()}{one[1:]}" for one in plain).replace("\u00a0", " ")
    return wrapped(f"*{results.study.question}* {answer} ([config/{name}.yaml](config/{name}.yaml))", "- ")


def main() -> None:
    """Write what was found, and copy the maps, which show it."""
    items = []
    for name in SENTENCES:
        study = load_study(ROOT / "config" / f"{name}.yaml")
        with open_results(ROOT / "results" / name, study) as results:
            items.append(found(results, name))
    for picture, study_name in PICTURES.items():
        drawn: Path = ROOT / "results" / study_name / "figures" / "polar" / "rinaldi.svg"
        shutil.copyfile(drawn, ROOT / "docs" / "images" / picture)
    publish({"found": "\n".join(items)})


if __name__ == "__main__":
    main()
