"""The report of a study, from its findings and figures to files."""

import tempfile
from dataclasses import dataclass
from pathlib import Path

from overturning.errors import ResultError
from overturning.figures.drawn_case import IllustrativeCaseWithFigures, read_illustrative_case_list
from overturning.figures.page import film_html_element
from overturning.files import atomic_write
from overturning.findings.collect import read_findings
from overturning.findings.opening import open_study_results
from overturning.report.drawings import (
    names_of_shown_figures_by_record,
    svg_path_by_study_figure_name,
    write_report_only_figures,
    write_translated_figures,
)
from overturning.report.page import render_report_html_page
from overturning.report.paper import compile_report_pdf
from overturning.report.render import (
    ReportMedia,
    parse_markdown_and_number_figures_and_tables,
    render_template_as_markdown,
)
from overturning.study.schema import Study
from overturning.translation.texts import (
    check_language_is_known,
    read_label_translations,
    translate,
    translate_whole_text_by_table,
    use_translation_language,
)

FINDINGS_FILE_NAME = "findings.json"
"""Name of the findings of a study, in its folder of results."""

EXPLORER_FILE_NAME = "explore.html"
"""Name of the page of `overturning explore`, next to the report."""


@dataclass(frozen=True)
class TextsAboutReportFilm:
    """Texts that the report shows about a film: name, title, block, panel headings and outcomes, and selection rule.

    The rule states how the case was chosen.
    """

    name: str
    title: str
    block_description: str
    panel_headings_and_outcomes: tuple[tuple[str, str], ...]
    selection_rule: str


def _report_film_texts(
    film_id_with_number: str, illustrative_case: IllustrativeCaseWithFigures
) -> TextsAboutReportFilm:
    """Return the texts that the report shows about the film of an illustrative case, in the current language."""
    panels = zip(
        map(translate, illustrative_case.panel_headings), map(translate, illustrative_case.panel_outcomes), strict=True
    )
    return TextsAboutReportFilm(
        film_id_with_number,
        translate(illustrative_case.title),
        translate(illustrative_case.block_and_motion_description),
        tuple(panels),
        illustrative_case.selection_rule,
    )


def write_report(
    results_folder: Path,
    html_path: Path,
    pdf_path: Path | None = None,
    study_with_question_and_surveys: Study | None = None,
    language: str | None = None,
) -> None:
    """Write the report of a study's results as an HTML page and, if wanted, as PDF; equal results give equal bytes.

    Parameters
    ----------
    results_folder : Path
        Folder of the results.
    html_path, pdf_path : Path
        HTML page, and PDF (None: no PDF), that are written.
    study_with_question_and_surveys : Study, optional
        Study from which title, question, surveys, population and settings of figures are taken; not given: the study
        that is stored in `results_folder`.
    language : str, optional
        Language of the templates, one of `overturning.translation.texts.LANGUAGES`; not given: that of the study.

    Raises
    ------
    ResultError
        If a result or a figure is missing, or if there are no templates of the language.
    """
    with (
        open_study_results(results_folder, study_with_question_and_surveys) as opened,
        tempfile.TemporaryDirectory() as drawings,
    ):
        found, language = read_findings(results_folder / FINDINGS_FILE_NAME), language or opened.study.language
        check_language_is_known(language)
        figures = svg_path_by_study_figure_name(results_folder / "figures")
        figures |= write_report_only_figures(opened, found, Path(drawings))
        folder = results_folder / "figures" / "illustrative"
        cases = {f"film-{number}": case for number, case in enumerate(read_illustrative_case_list(folder), 1)}
        figures |= {f"{name}-strip": folder / case.film_strip_file_name for name, case in cases.items()}
        if missing := [file for file in figures.values() if not file.is_file()]:
            raise ResultError(f"{missing[0]}: no such figure; run the figures of the study first")
        figures = write_translated_figures(figures, Path(drawings) / language, language)
        with use_translation_language(language):
            films = {
                name: film_html_element(case.film, figures[f"{name}-strip"], translate(case.strip_alt))
                for name, case in cases.items()
            }
            facts = [_report_film_texts(name, case) for name, case in cases.items()]
        media = ReportMedia(
            films=facts,
            figure_names_by_record=names_of_shown_figures_by_record(figures, [one.id for one in found.records]),
            explorer_address=EXPLORER_FILE_NAME,
            station_map_names=sorted(name for name in figures if name.startswith("maps/")),
            has_posterior_figures=bool(opened.inferred_motions),
            has_rose_of_all_falls="rose" in figures and bool(found.cases.share_overturned),
        )
        title = translate_whole_text_by_table(found.study.title, read_label_translations(language))
        tree = parse_markdown_and_number_figures_and_tables(render_template_as_markdown(found, language, media))
        with atomic_write(html_path) as part:
            page = render_report_html_page(tree, title, language, figures, films)
            part.write_text(page, encoding="utf-8")
        if pdf_path is not None:
            pages = compile_report_pdf(tree, title, language, figures)
            with atomic_write(pdf_path) as part:
                part.write_bytes(pages)
