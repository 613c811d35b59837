"""Property-based round trips: any samples, written in a format and read back, are those samples in m/s²."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from overturning.motion.motion import Motion
from overturning.records.assembly import assemble
from overturning.records.formats import cosmos, csmip, csv_columns, esm, geonet, knet, miniseed, peer, sac, smc
from overturning.records.source import Declarations, SourceFile
from tests.records.record_writers import cosmos_text, csmip_text, esm_text, geonet_text, knet_text, peer_text, smc_text
from tests.records.seed_writers import write_inventory, write_mseed, write_sac

G = 9.80665
quick = settings(max_examples=30, deadline=None, suppress_health_check=list(HealthCheck))
lengths = st.integers(2, 60)


def tenths(low: int, high: int):
    return lengths.flatmap(lambda n: arrays(np.int64, (2, n), elements=st.integers(low, high))).map(lambda a: a / 10)


def read(module, text: str, name: str = "x.txt"):
    return module.read(SourceFile(name, text.encode()))


@quick
@given(
    lengths.flatmap(lambda n: arrays(np.int64, n, elements=st.integers(-(2**23), 2**23))),
    st.sampled_from([50, 100, 200]),
)
def test_knet(counts, rate):
    component = read(knet, knet_text(counts, rate=f"{rate}Hz"), "x.NS")[0]
    np.testing.assert_allclose(component.samples, counts * (2000 / 8388608 * 0.01), rtol=1e-12)
    assert component.sampling_interval == 1 / rate


@quick
@given(tenths(-99999, 99999), st.booleans())
def test_geonet(pair, corrected):
    first, second = read(geonet, geonet_text({"N00E": (0, pair[0]), "N90E": (90, pair[1])}, 0.02, corrected=corrected))
    np.testing.assert_allclose(first.samples, pair[0] * 1e-3, atol=1e-12)
    np.testing.assert_allclose(second.samples, pair[1] * 1e-3, atol=1e-12)


@quick
@given(tenths(-9999, 9999), st.sampled_from([1, 2]))
def test_csmip(pair, volume):
    scale = 1e-3 if volume == 1 else 1.0
    channels = {"90 Deg": (90, pair[0] * scale), "360 Deg": (360, pair[1] * scale)}
    first, second = read(csmip, csmip_text(channels, 100, volume=volume))
    unit = scale * (G if volume == 1 else 0.01)
    np.testing.assert_allclose(first.samples, pair[0] * unit, atol=1e-9)
    np.testing.assert_allclose(second.samples, pair[1] * unit, atol=1e-9)


@quick
@given(tenths(-9999, 9999), st.sampled_from([0.005, 0.01, 0.02]))
def test_cosmos(pair, interval):
    channels = {"340 deg": (340, pair[0]), "70 deg": (70, pair[1])}
    first, second = read(cosmos, cosmos_text(channels, interval))
    np.testing.assert_allclose(first.samples, pair[0] * 0.01, atol=1e-12)
    np.testing.assert_allclose(second.samples, pair[1] * 0.01, atol=1e-12)
    assert first.sampling_interval == pytest.approx(interval, rel=1e-9)


@quick
@given(tenths(-99999, 99999))
def test_smc(pair):
    samples = np.array([float(f"{v:.4E}") for v in pair[0]])
    component = read(smc, smc_text(samples, 200.0, "123"))[0]
    np.testing.assert_allclose(component.samples, samples * 0.01, rtol=1e-9, atol=1e-12)
    assert component.azimuth_deg == 123


@quick
@given(tenths(-99999, 99999), st.sampled_from(["new", "old", "oldest"]))
def test_peer(pair, header):
    component = read(peer, peer_text(pair[0] / 1e4, 0.005, "228", header=header))[0]
    np.testing.assert_allclose(component.samples, pair[0] / 1e4 * G, atol=1e-9)
    assert component.sampling_interval == 0.005


@quick
@given(tenths(-99999, 99999))
def test_esm(pair):
    np.testing.assert_allclose(read(esm, esm_text(pair[0], 0.01, "HNN"))[0].samples, pair[0] * 0.01, atol=1e-12)


@quick
@given(tenths(-99999, 99999), st.sampled_from([("g", G), ("gal", 0.01), ("m/s2", 1.0)]))
def test_columns(pair, unit):
    text = "".join(f"{a!r},{b!r}\n" for a, b in pair.T.tolist())
    options = Declarations(columns=f"north:{unit[0]} east:{unit[0]}", sampling_interval_s=0.01, processed=True)
    first, second = csv_columns.read(SourceFile("x.csv", text.encode()), options)
    np.testing.assert_allclose(first.samples, pair[0] * unit[1], rtol=1e-15)
    np.testing.assert_allclose(second.samples, pair[1] * unit[1], rtol=1e-15)


@quick
@given(tenths(-999, 999), st.floats(0, 360), st.booleans(), st.floats(-20, 20))
def test_turning_there_and_back(pair, azimuth, left_handed, correction):
    """Motion along a sensor's axis is what that sensor recorded, whichever way the axes run."""
    second = azimuth - 90 if left_handed else azimuth + 90
    north, east = (read(peer, peer_text(p / 100, 0.01, "0"))[0] for p in pair)
    record = assemble(
        [north, east], "x", Declarations(azimuths_deg=(azimuth, second), correction_deg=correction, trust_data=True)
    )
    motion = Motion.of(record)
    np.testing.assert_allclose(motion.along(azimuth + correction), pair[0] / 100 * G, atol=1e-8)
    np.testing.assert_allclose(motion.along(second + correction), pair[1] / 100 * G, atol=1e-8)


@quick
@given(
    # Steim2 has 30 bits for the difference of two samples.
    lengths.flatmap(lambda n: arrays(np.int32, n, elements=st.integers(-(2**28), 2**28 - 1))),
    st.sampled_from([50.0, 100.0, 200.0]),
)
def test_miniseed(tmp_path_factory, counts, rate):
    folder = tmp_path_factory.mktemp("mseed")
    metadata = write_inventory(folder / "s.xml", {"HNN": (0.0, 0.0)})
    path = write_mseed(folder / "x.mseed", {"HNN": counts}, rate=rate)
    sources = [SourceFile(p.name, p.read_bytes()) for p in (path, metadata)]
    component = miniseed.read(sources[0], Declarations(metadata=sources[1:]))[0]
    np.testing.assert_allclose(component.samples, counts / 400_000, rtol=1e-14)
    assert component.sampling_interval == pytest.approx(1 / rate)


@quick
@given(lengths.flatmap(lambda n: arrays(np.float32, n, elements=st.floats(-1e4, 1e4, width=32))), st.floats(0, 359))
def test_sac(tmp_path_factory, samples, azimuth):
    path = write_sac(tmp_path_factory.mktemp("sac") / "x.sac", samples, "HN1", azimuth, 90.0)
    component = sac.read(SourceFile("x.sac", path.read_bytes()), Declarations(unit="gal"))[0]
    np.testing.assert_array_equal(component.samples, samples.astype(np.float64) * 0.01)
    assert component.azimuth_deg == pytest.approx(azimuth, rel=1e-6)
