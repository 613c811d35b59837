"""A stored comparison is read back unchanged."""

import math
from pathlib import Path

import numpy as np
import pytest

from overturning.errors import ResultError
from overturning.findings.surveys import survey_prediction_findings
from overturning.stored import write_result_as_json
from overturning.surveys.comparison import compare_survey_with_prediction
from overturning.surveys.stones import Stone
from overturning.surveys.stored_comparison import make_stored_survey_comparison, read_survey_comparison


@pytest.mark.parametrize("faces", [True, False])
def test_stored_comparison_is_read_back_byte_for_byte(
    make_cube_from_fall_rules, make_sector_fall_rule, tmp_path: Path, faces: bool
) -> None:
    shape = {"b_over_h": 0.2, "face_azimuth_deg": 60.0} if faces else {}
    found = compare_survey_with_prediction(
        [Stone(True, 45.0, has_octant_direction=True, stone_count=3, **shape)],
        make_cube_from_fall_rules(make_sector_fall_rule(60, 30)),
    )
    source, path = tmp_path / "stones.csv", tmp_path / "survey" / "1.json"
    source.write_text("octant,count\nNE,3\n", encoding="utf-8")
    write_result_as_json(make_stored_survey_comparison(source, "r0", found), path)
    first = path.read_bytes()
    back = read_survey_comparison(path)
    write_result_as_json(back, path)
    assert path.read_bytes() == first
    assert (back.survey_file_name, back.record) == ("stones.csv", "r0")
    assert len(back.sha256) == 64
    assert (back.comparison.confusion_matrix is not None) == faces
    np.testing.assert_array_equal(back.comparison.predicted_count_by_octant, found.predicted_count_by_octant)
    assert math.isnan(back.comparison.exact_azimuth_watson_u2_test.p_value)


def test_stored_comparison_has_table_comments_and_flags_few_falls(
    make_cube_from_fall_rules, make_sector_fall_rule, tmp_path: Path
) -> None:
    source = tmp_path / "stones.csv"
    source.write_text("# A churchyard,\n#\n##  in haste.\noctant,count\nNE,39\n# no remark\n", encoding="utf-8")
    for count, few in ((39, True), (40, False)):
        found = compare_survey_with_prediction(
            [Stone(True, 45.0, has_octant_direction=True, stone_count=count)],
            make_cube_from_fall_rules(make_sector_fall_rule(60, 30)),
        )
        made = survey_prediction_findings(make_stored_survey_comparison(source, "r0", found))
        assert made.survey_file_comments == ["A churchyard,", "in haste."]
        assert made.has_few_falls_in_known_direction is few


def test_files_that_are_no_stored_comparison_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ResultError, match="no result of the comparison with a survey"):
        read_survey_comparison(tmp_path / "1.json")
    (tmp_path / "1.json").write_text("{}", encoding="utf-8")
    with pytest.raises(ResultError, match="survey_file_name: this key is needed; written by another version"):
        read_survey_comparison(tmp_path / "1.json")
