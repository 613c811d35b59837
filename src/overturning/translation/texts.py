"""Translation of visible texts from English, by the tables of a language in ``tables``.

The program writes its texts in English. A table maps an English text to its translation; an English text without an
entry, such as the name of a station, stays as it is. In an entry ``{}`` stands for a number, and ``{name}`` for a text
that is translated by itself: "falls towards {azimuth} at {} s". The first entry that fits a text is used.
"""

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache, lru_cache
from importlib import resources
from itertools import combinations
from typing import Any, Final, NamedTuple, get_args

from overturning.errors import ArgumentError, MissingDataError
from overturning.study.evaluation import Language

LANGUAGES: Final[tuple[str, ...]] = get_args(Language)
"""Languages of reports, figures and pages, by their code of ISO 639-1."""

ENGLISH: Final = "en"
"""Language in which the program writes its texts."""

SEPARATORS_OF_SEPARATELY_TRANSLATED_PARTS: Final = ("; ", ", ", ": ")
"""Separators of a list: parts between them are translated by themselves if there is no entry for the whole text."""

FONT_PACKAGE_AND_NAMES_BY_LANGUAGE: Final = {
    "ja": ("fonts-noto-cjk", ("Noto Serif CJK JP", "Noto Sans CJK JP", "IPAexGothic", "IPAGothic"))
}
"""Debian package with the fonts of a language, and the names of fonts that have its characters."""

_FIRST_CJK_CHARACTER: Final = "\N{CJK RADICAL REPEAT}"
"""First character of the Unicode blocks of Chinese, Japanese and Korean."""

_PLACEHOLDER_PATTERN: Final = re.compile(r"\{(\w*)\}")
_LATIN_WORD: Final = re.compile("[A-Za-z]{2,}")
_NUMBER: Final = r"[+−–-]?\d[\d,]*(?:\.\d+)?(?:e[+−-]?\d+)?"

_language: ContextVar[str] = ContextVar("language", default=ENGLISH)


def check_language_is_known(language: str) -> None:
    """Raise an ArgumentError, with the codes of all known languages, if a language code is unknown."""
    if language not in LANGUAGES:
        raise ArgumentError(f"language {language}: no texts in this language; choose one of {', '.join(LANGUAGES)}")


@contextmanager
def use_translation_language(language: str | None) -> Iterator[None]:
    """Context manager in which texts of figures and reports are translated into a language; None is English.

    Raises
    ------
    ArgumentError
        If there is no translation into the language.
    """
    check_language_is_known(language or ENGLISH)
    token = _language.set(language or ENGLISH)
    try:
        yield
    finally:
        _language.reset(token)


def current_language() -> str:
    """Return the code of the language into which texts of figures and reports are translated."""
    return _language.get()


@cache
def read_translation_table(language: str, translation_table_name: str) -> dict[str, str]:
    """Read a translation table (``labels``, ``figures`` or ``explorer``): translations by English text."""
    import yaml

    path = resources.files("overturning").joinpath("translation", "tables", language, f"{translation_table_name}.yaml")
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml takes a tenth of the time
    table: dict[str, str] = yaml.load(path.read_text(encoding="utf-8"), loader)
    return table


def read_label_translations(language: str) -> dict[str, str]:
    """Read the translations of the names in a study's results (statistics, outcomes, …), by English name."""
    return read_translation_table(language, "labels")


@cache
def _label_and_figure_translations(language: str) -> dict[str, str]:
    """Read the translations of the texts in figures and films, and of names in results, by English text."""
    return read_label_translations(language) | read_translation_table(language, "figures")


def translate_whole_text_by_table(text: str, translation_table: Mapping[str, str]) -> str:
    """Look up the translation of a whole text in a table; return the text itself if the table lacks it."""
    found = _translation_from_table(text, tuple(translation_table.items()))
    return text if found is None else found


def translate(text: str, language: str | None = None) -> str:
    """Translate a text of a figure or film, by default into the current language; unknown parts stay English.

    Lines that the table lists only as one sentence are translated together.
    """
    language = language or current_language()
    if language == ENGLISH:
        return text
    return _translate_wrapped_text(text, tuple(_label_and_figure_translations(language).items()))


def translate_nested_texts_except_data(nested_dictionaries_and_lists: Any, language: str | None = None) -> Any:
    """Translate all texts in nested dictionaries and lists, except values of the key ``data``."""
    if isinstance(nested_dictionaries_and_lists, str):
        return translate(nested_dictionaries_and_lists, language)
    if isinstance(nested_dictionaries_and_lists, dict):
        return {
            key: one if key == "data" else translate_nested_texts_except_data(one, language)
            for key, one in nested_dictionaries_and_lists.items()
        }
    if isinstance(nested_dictionaries_and_lists, (list, tuple)):
        return [translate_nested_texts_except_data(one, language) for one in nested_dictionaries_and_lists]
    return nested_dictionaries_and_lists


def installed_fonts_of_language(language: str) -> list[str]:
    """Return the installed fonts for a language; empty if none is installed or the language needs none."""
    import typst

    _, names = FONT_PACKAGE_AND_NAMES_BY_LANGUAGE.get(language, ("", ()))
    if (
        names and names not in _INSTALLED_FONTS_CACHE
    ):  # the search takes 0.1 s; it is repeated until a font is installed
        families = set(typst.Fonts(include_system_fonts=True).families())
        if not (found := [name for name in names if name in families]):
            return []
        _INSTALLED_FONTS_CACHE[names] = found
    return list(_INSTALLED_FONTS_CACHE.get(names, ()))


_INSTALLED_FONTS_CACHE: dict[tuple[str, ...], list[str]] = {}
"""Cache of the installed fonts, by the font names that were searched for."""


def font_language_of_text(text: str) -> str:
    """Return the language whose fonts a figure text needs: Japanese for Japanese letters, else the current language."""
    return "ja" if any(character >= _FIRST_CJK_CHARACTER for character in text) else current_language()


def check_font_is_installed(language: str, name_of_file_that_needs_font: str) -> None:
    """Raise an error with the Debian package to install if a file needs a missing font of a language."""
    if language in FONT_PACKAGE_AND_NAMES_BY_LANGUAGE and not installed_fonts_of_language(language):
        raise MissingDataError(
            f"{name_of_file_that_needs_font}: no font for the language {language}; install the Debian package "
            f"{FONT_PACKAGE_AND_NAMES_BY_LANGUAGE[language][0]}"
        )


class _TranslationPattern(NamedTuple):
    """Table entry with placeholders: a regular expression for the English text, and its translation."""

    pattern: "re.Pattern[str]"
    placeholder_names: tuple[str, ...]  # of the fields in the English text; "" for a number
    translation: str


@lru_cache(maxsize=8)
def _exact_and_pattern_translations(
    translation_table_entries: tuple[tuple[str, str], ...],
) -> tuple[dict[str, str], list[_TranslationPattern]]:
    """Return the translations in a table by English text, and patterns for the texts with placeholders."""
    found = []
    for english, translation in translation_table_entries:
        fixed, names = _PLACEHOLDER_PATTERN.split(english)[::2], tuple(_PLACEHOLDER_PATTERN.findall(english))
        if names:
            parts = [r"\s+".join(map(re.escape, re.split(r"\s+", part))) for part in fixed]
            fields = (f"(?P<{name}>[^;:]*?[^;:,])" if name else f"({_NUMBER})" for name in names)
            pattern = parts[0] + "".join(field + part for field, part in zip(fields, parts[1:], strict=True))
            found.append(_TranslationPattern(re.compile(pattern), names, translation))
    return dict(translation_table_entries), found


@lru_cache(maxsize=4096)
def _translation_from_table(text: str, translation_table_entries: tuple[tuple[str, str], ...]) -> str | None:
    """Look up the translation of a text in a table, exactly or by a pattern with placeholders; None if absent."""
    exact, entries = _exact_and_pattern_translations(translation_table_entries)
    if text in exact:
        return exact[text]
    if (joined := " ".join(text.split("\n"))) in exact:  # a line that was broken
        return exact[joined]
    for entry in entries:
        if match := entry.pattern.fullmatch(text):
            numbers = [one for one, name in zip(match.groups(), entry.placeholder_names, strict=True) if not name]
            named = {
                name: _translate_text_lines(one, translation_table_entries) for name, one in match.groupdict().items()
            }
            return entry.translation.format(*numbers, **named)
    return None


def _translate_wrapped_text(text: str, translation_table_entries: tuple[tuple[str, str], ...]) -> str:
    """Translate a text of several lines; lines are joined if this leaves fewer English words.

    The translation table has whole sentences, not the lines of a wrapped one. The sentence may also be a part of a
    list, as in "stands; leans to 62 % of the angle at which it would topple at" with the next line "rest".
    """
    lines, best = text.split("\n"), _translate_text_lines(text, translation_table_entries)
    for start, end in combinations(range(len(lines) + 1), 2):
        if not _LATIN_WORD.search(best):
            break
        if end - start > 1 and all(line.strip() for line in lines[start:end]):
            joined = [*lines[:start], " ".join(lines[start:end]), *lines[end:]]
            found = _translate_text_lines("\n".join(joined), translation_table_entries)
            if len(_LATIN_WORD.findall(found)) < len(_LATIN_WORD.findall(best)):
                best = found
    return best


def _translate_text_lines(text: str, translation_table_entries: tuple[tuple[str, str], ...]) -> str:
    """Translate a text line by line; lines that have one entry in the table together are translated together."""
    lines, translated, start = text.split("\n"), list[str](), 0
    while start < len(lines):
        for end in range(start + 1, len(lines) + 1):
            if (found := _translation_from_table("\n".join(lines[start:end]), translation_table_entries)) is not None:
                translated.append(found)
                break
        else:
            end = start + 1
            translated.append(_translate_list_parts(lines[start], translation_table_entries))
        start = end
    return "\n".join(translated)


def _translate_list_parts(text: str, translation_table_entries: tuple[tuple[str, str], ...]) -> str:
    """Translate the parts of a list such as "a, b"; return it unchanged if no part is in the table."""
    for separator in SEPARATORS_OF_SEPARATELY_TRANSLATED_PARTS:
        parts = text.split(separator)
        if len(parts) > 1:
            translated = [_translate_text_lines(part, translation_table_entries) for part in parts]
            if translated != parts:
                return dict(translation_table_entries).get(separator, separator).join(translated)
    return text
