"""What becomes of made-up records: files read, spoilt and refused, steps, pulses, earthquakes, the record table."""

import re
import warnings
from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from datetime import UTC, datetime, timedelta
from functools import partial
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from overturning.errors import OverturningError
from overturning.records import component, processing, pulses, source, steps
from overturning.records.assembly import assemble, iso
from overturning.records.catalogue import METADATA, RecordEntry, find_paths, read_catalogue, utc_moment
from overturning.records.check import check_paths, describe, is_no_record
from overturning.records.component import Component, StatedPeak
from overturning.records.earthquakes import earthquakes_of
from overturning.records.fdsn import Request
from overturning.records.formats import fema_p695
from overturning.records.formats.table import FORMATS
from overturning.records.read import group_components, read, read_files, read_path, read_record
from overturning.records.record import Record, drift, provenance, state_of, summary
from overturning.records.site import Site
from overturning.records.source import Declarations, SourceFile
from overturning.records.store import read_motion, read_unprocessed, write_motion
from tests.kept import Answers, interface_of, keys_of, plain, refusals
from tests.records.malformed_corpus import WHOLE, corpus, on_lines
from tests.records.record_writers import (
    cosmos_text,
    csmip_text,
    geonet_text,
    knet_text,
    peer_text,
    smc_text,
    write_knet_set,
)
from tests.records.seed_writers import write_inventory, write_mseed, write_sac
from tests.records.world_writers import bhrc_text, counts_text, cwa_text, nsmn_text, renadic_text, unam_text, usc_text
from tests.records.written import FORMS

LENIENT = Declarations(unit="gal")


def read_of(files: list[SourceFile], declared: Declarations = LENIENT) -> Record | str:
    """The record of files, or why they are refused."""
    try:
        return assemble(read_files(files, declared), "x", declared)
    except OverturningError as problem:
        return str(problem)


def told(files: list[SourceFile], declared: Declarations = LENIENT) -> str:
    """All that is read of files, or why they are refused."""
    return str(plain(read_of(files, declared)))


def other_numbers(form: str) -> Iterator[tuple[str, Callable[[str], bytes]]]:
    """Each line of a header with other digits: what it states is another thing, or nothing."""
    for line in range(WHOLE[form][1]):
        for digits in ("1", "7"):
            name = f"header line {line + 1} of {digits}"
            yield name, on_lines(lambda ls, i=line, d=digits: [*ls[:i], re.sub(r"\d", d, ls[i]), *ls[i + 1 :]])


def of_spoilt(form: str) -> dict[str, Any]:
    """Four digits of a hash for each way in which a file may be spoilt: what becomes of it."""
    (first, whole), *others = WHOLE[form][0].items()
    rest, found = [SourceFile(name, text.encode()) for name, text in others], {}
    for name, change in (*corpus(form), *other_numbers(form)):
        found[name] = sha256(told([SourceFile(first, change(whole)), *rest]).encode()).hexdigest()[:4]
    return {"what becomes of each": " ".join(found.values())}


def of_formats() -> dict[str, Any]:
    """What is read of a whole file of each format, and said of it."""
    found: dict[str, Any] = {"formats": [[item.name, item.title] for item in FORMATS]}
    with TemporaryDirectory() as folder:
        for form, written in FORMS.items():
            (place := Path(folder) / form).mkdir()
            dice = np.random.default_rng(8)
            samples = [np.round(dice.normal(0, 500, 203)) for _ in range(3)]
            for name, text in written.files(*samples).items():
                (place / name).write_text(text, encoding="utf-8")
            declared = written.declared or Declarations()
            said = [describe(finding) for finding in check_paths([place], declared)]
            one = read_path(sorted(place.iterdir()), declared)
            found[form] = {"record": one, "said": said, "text": repr(one), "provenance": provenance(one)}
    return found


def of_kinds() -> dict[str, Any]:
    """What is read of kinds of files that a format has beside its usual one."""
    dice, g = np.random.default_rng(9), 980.665
    a, b, c = (np.round(dice.normal(0, 90, 240), 3) for _ in range(3))
    turned, level = {"N28W": (332, a), "S62W": (242, b)}, {"360": a, "90": b}
    of_cosmos = partial(cosmos_text, {"340 deg": (340, a), "70 deg": (70, b)}, 0.01)
    of_csmip = partial(csmip_text, {"90 Deg": (90, a / g), "360 Deg": (360, b / g), "Up": (0, c / g)}, 200)
    of_usc, three = {"N28W": a / g, "S62W": b / g}, {"N00E": a, "V": c, "N90E": b}
    one = {
        "GeoNet, early": geonet_text(turned, 0.02, prepended=50),
        "GeoNet, no magnitude": geonet_text(turned, 0.02, magnitude=-1),
        **{f"USC, narrow {narrow}": usc_text(of_usc | {"VERT": c / g}, narrow=narrow) for narrow in (True, False)},
        "USC, down": usc_text(of_usc | {"DOWN": c / g}, np.arange(240) * 0.02),
        **{f"COSMOS in {unit}": of_cosmos(unit=unit) for unit in (2, 4, 5)},
        "COSMOS, raw": cosmos_text({"H1": (340, a), "H2": (70, b), "Vert": (402, c)}, 0.01, kind="Raw"),
        "counts": counts_text(np.round(a), np.round(b), microvolts=1000.0, volts_per_g=2.5, gain=4.0),
        **{f"CSMIP, volume {volume}": of_csmip(volume=volume) for volume in (1, 2)},
        **{f"CWA {order}": cwa_text(a, b, c, sequence=f"Time {order}") for order in ORDERS},
        **{f"BHRC {at}": bhrc_text({"L": a / g, "V": c / g, "T": b / g}, azimuths=(at, at + 90)) for at in (10, 250)},
        **{f"UNAM {first}": unam_text(three, first=first) for first in ("07:19:20.50", "", "23:59:59")},
        "UNAM, late": unam_text({"N00E": a, "+V": c, "N90W": b}, interval=0.02),
        "RENADIC": renadic_text({"NS": a / g, "EW": b / g}, trigger=""),
        "NSMN": nsmn_text(a, b, c, interval=0.005),
    }
    several: dict[str, dict[str, str]] = {
        f"SMC {kind}": {f"{n}.smc": smc_text(x, 200.0, n, kind=kind) for n, x in level.items()}
        for kind in ("1 UNCORRECTED ACCELEROGRAM", "2 CORRECTED ACCELEROGRAM", "3 VELOCITY")
    }
    several["SMC, down"] = {
        f"{n}.smc": smc_text(x, 200.0, n, vertical=at) for n, x, at in (("360", a, 90), ("90", b, 90), ("dn", c, 180))
    }
    for sense in (0, 180, 90):
        parts = (("360", a, 90), ("90", b, 90), ("vert", c, sense))
        several[f"SMC, {sense}"] = {f"{n}.smc": smc_text(x, 200.0, n, vertical=at) for n, x, at in parts}
    for head in ("new", "old", "oldest"):
        several[f"PEER {head}"] = {f"{n}.AT2": peer_text(x / g, 0.005, n, header=head) for n, x in level.items()}
    of_knet: dict[str, dict[str, Any]] = {
        "magnitude": {"magnitude": ""},
        "fast": {"rate": "200Hz"},
        "memo": {"memo": "x"},
    }
    of_knet["scaled"] = {"scale": (3920, 6182761)}
    for name, more in of_knet.items():
        pairs = (("NS", "N-S", a), ("EW", "E-W", b))
        several[f"K-NET, {name}"] = {f"T.{n}": knet_text(1000 * x, direction=d, **more) for n, d, x in pairs}
    files = {name: {"x.dat": text} for name, text in one.items()} | several
    sets = ("nearfield_pulse:10", "nearfield_no_pulse:3", "farfield:1", "farfield:99", "x:1", "farfield:a")
    return {
        name: read_of([SourceFile(file, text.encode()) for file, text in texts.items()])
        for name, texts in files.items()
    } | {"FEMA": [read_of_fema(name) for name in sets]}


ORDERS = ("U(+); N(+); E(+)", "E(+);N(+);U(+)", "N(+); E(+)", "U(-); N(+); E(+)")


def read_of_fema(name: str) -> Any:
    try:
        return fema_p695.read(name)
    except OverturningError as problem:
        return str(problem)


def part(axis: str, azimuth: float | None = None, up: int = 0, count: int = 400, **more: Any) -> Component:
    dice = np.random.default_rng(len(axis) + count)
    samples = more.pop("samples", np.round(dice.normal(0, 1, count) * np.hanning(count), 6))
    given = {"sampling_interval": 0.01, "file": f"{axis}.x", "sha256": axis, "format": "test", "processed": True} | more
    return Component(samples, axis=axis, azimuth_deg=azimuth, vertical=up, **given)


NORTH, EAST, UP = part("N", 0.0), part("E", 90.0), part("Z", up=1)
START = datetime(2001, 2, 3, 4, 5, 6, tzinfo=UTC)


def made(*components: Component, stated: dict[str, Any] | None = None, **declared: Any) -> Callable[[], Record]:
    return lambda: assemble(components, "made", Declarations(**declared), **(stated or {}))


def of_assembly() -> dict[str, Any]:
    at = [replace(one, start=START + timedelta(seconds=s)) for one, s in ((NORTH, 0), (EAST, 0.034), (UP, 0.5))]
    late, very_late = (
        replace(EAST, start=START + timedelta(seconds=0.5)),
        replace(EAST, start=START + timedelta(seconds=0.51)),
    )
    loud = np.append(NORTH.samples, np.full(60, 3.0))
    wholes: dict[str, Callable[[], Record]] = {
        "plain": made(NORTH, EAST, UP),
        "turned": made(part("a", 30.0), part("b", 115.0), part("v", up=-1)),
        "starts": made(*at),
        "cut": made(NORTH, part("E", 90.0, count=380), UP),
        "half a second": made(at[0], late),
        "down": made(NORTH, EAST, part("V"), vertical_sense="down"),
        "declared": made(part("H1"), part("H2"), azimuths_deg=(10.0, 100.0), correction_deg=355.0, trust_data=True),
        "otherwise": made(NORTH, EAST, azimuths_deg=(5.0, 95.0)),
        "sense not known": made(NORTH, EAST, part("V")),
        "left out": made(NORTH, EAST, part("VERT"), vertical_sense="none"),
        "unit": made(replace(NORTH, unit="g"), EAST, unit="gal", processed=False, sampling_interval_s=0.02),
        "interval": made(NORTH, EAST, sampling_interval_s=0.010009),
        "another interval": made(NORTH, EAST, sampling_interval_s=0.01002),
        "borehole": made(*(replace(one, sensor="borehole", station="S") for one in (NORTH, EAST)), sensor="borehole"),
        "raw": made(*(replace(one, processed=False, samples=one.samples + 2.0) for one in (NORTH, EAST))),
        "roof": made(replace(NORTH, location="3rd floor"), EAST),
        "film": made(part("N", 0.0, film=True), part("E", 90.0, count=300, film=True)),
        "one file": made(part("N", 0.0, sha256="s"), part("E", 90.0, count=340, sha256="s")),
        "stated": made(NORTH, EAST, stated={"station": "T", "event": "E"}),
        "peaks": made(replace(NORTH, peak=StatedPeak(float(abs(NORTH.samples).max()) * 1.004)), EAST),
        "coarse peak": made(replace(NORTH, peak=StatedPeak(round(float(abs(NORTH.samples).max()), 1), 0.1)), EAST),
        "told": made(
            replace(
                NORTH,
                origin=START,
                event="Q",
                station="S",
                latitude=1.0,
                longitude=2.0,
                notes=("a",),
                extra={"x": 1, "declared": ["d"]},
            ),
            EAST,
        ),
    }
    trusted = {"trust_data": True}
    stations = [replace(NORTH, station="A b"), replace(EAST, station="a  B")]
    refused = refusals(
        made(NORTH),
        made(NORTH, EAST, EAST),
        made(UP, UP, NORTH, EAST),
        made(),
        made(NORTH, part("E", 89.0), part("X", 90.0)),
        made(NORTH, part("H")),
        made(part("G"), part("H")),
        made(part("G"), part("H"), azimuths_deg=(1.0,)),
        made(NORTH, part("X", 64.0)),
        made(NORTH, part("X", 65.0)),
        made(NORTH, part("X", 115.0)),
        made(NORTH, part("X", 116.0)),
        made(at[0], very_late),
        made(at[0], late, at[2]),
        made(NORTH, replace(EAST, sampling_interval=0.01000002)),
        made(NORTH, replace(EAST, sampling_interval=0.010000005)),
        *(made(NORTH, part("E", 90.0, count=n), **more) for n in (351, 350, 349, 340) for more in ({}, trusted)),
        made(part("N", 0.0, samples=loud, sha256="s"), part("E", 90.0, count=380, sha256="s")),
        made(part("N", 0.0, samples=loud, sha256="s"), part("E", 90.0, count=380, sha256="s"), **trusted),
        *(
            made(replace(NORTH, peak=StatedPeak(float(abs(NORTH.samples).max()) * k, d, after_mean=m, line=3)), EAST)
            for k, d, m in (
                (1.0049, 0, False),
                (1.0051, 0, False),
                (1.1, 0.4, False),
                (1.1, 0.9, True),
                (0, 0, False),
                (0.5, 0, True),
            )
        ),
        made(replace(NORTH, peak=StatedPeak(9.0)), EAST, **trusted),
        made(*(replace(one, samples=0 * one.samples) for one in (NORTH, EAST))),
        made(*(replace(one, samples=60 * one.samples, unit="gal") for one in (NORTH, EAST))),
        made(*stations),
        made(stations[0], replace(EAST, station="C")),
        made(stations[0], replace(EAST, station="C"), **trusted),
        made(NORTH, replace(EAST, processed=False)),
        made(replace(NORTH, event="a"), replace(EAST, event="b")),
        made(replace(NORTH, location="00"), replace(EAST, location="10")),
        *(
            lambda samples=samples, interval=interval: part(
                "N", 0.0, samples=np.array(samples), sampling_interval=interval
            )
            for samples, interval in (
                ([0.0], 0.01),
                ([0, np.nan], 0.01),
                ([0, 1.0], 1e-5),
                ([0, 1.0], 0.9e-5),
                ([0, 1.0], 1.0),
                ([0, 1.0], 1.01),
            )
        ),
    )
    groups = [
        [c.axis for c in group]
        for group in group_components(
            [
                *(replace(one, station="S") for one in (NORTH, EAST)),
                replace(UP, station="T"),
                replace(NORTH, station="S", start=START),
                replace(NORTH, station="S"),
                NORTH,
                EAST,
                part("N", 0.0, file="f"),
                part("E", 90.0, file="f", sha256="N"),
                part("N", 0.0, file="f"),
            ]
        )
    ]
    return {
        **{name: make() for name, make in wholes.items()},
        "refused": refused,
        "groups": groups,
        "times": [iso(one.start) for one in (*at, NORTH)],
    }


def of_axes() -> dict[str, Any]:
    words = [
        "N",
        "n-s",
        "EW",
        "S",
        "West",
        "UP",
        "+Z",
        "-z",
        "Down",
        "V",
        "Vert",
        "N28W",
        "S90E",
        "S 10 W",
        "N90E",
        "N91E",
        "N 0.5 E",
        "270",
        "360",
        "361",
        "360 Deg",
        "45.5 degrees",
        "12°",
        "1000",
        "H1",
        "",
        "RAD",
        "90 deg.",
        "0",
    ]
    texts = [
        "",
        "depth 3 m",
        "depth: 3.1m",
        "10 ft deep",
        "9.5 ft below",
        "downhole",
        "bore-hole",
        "bore hole",
        "12 feet depth",
        "depth of the sensor 5 m",
    ]
    places = [
        "Location: Roof",
        "Location:  3rd  floor ",
        "10th level",
        "1st floor",
        "Ground",
        "second story",
        "free field",
        "Deck 2",
        "21st Fl",
    ]
    agree = [
        component.agreed(a, b, OverturningError)
        for a, b in (("N", (0.9, 0)), ("?", (5.0, 0)), ("N", (None, 0)), ("Up", (None, 1)), ("N", (359.5, 0)))
    ]
    return {
        "axes": {word: list(component.parse_axis(word)) for word in words},
        "senses": [component.is_vertical_of_unknown_sense(word) for word in (*words, "1: 402", "+V.")],
        "channels": [list(component.channel_axis(code)) for code in ("HNZ", "N", "bhe", "HN1", "")],
        "agreed": agree,
        "codes": [list(component.coded_azimuth(code)) for code in (0, 0.5, 1, 359, 360, 361, -1, 400)],
        "sensors": [[component.sensor_at(depth, text) for text in texts] for depth in (None, 3.0, 3.01)],
        "places": [[component.stated_location(text), component.in_a_structure(text)] for text in places],
        "odds": refusals(
            *(
                lambda a=a, b=b: component.agreed(a, b, OverturningError)
                for a, b in (("N", (1.0, 0)), ("N", (1.1, 0)), ("N", (None, -1)), ("Up", (None, -1)), ("Up", (90.0, 0)))
            )
        ),
    }


LINES = (
    "sine amplitude_gal=300 period_s=1 azimuth_deg=60",
    "cosine amplitude_gal=200 period_s=0.5 cycles=2.5 azimuth_deg=-100 before_s=0 after_s=0.5",
    "ricker amplitude_gal=300 period_s=0.7",
    "mavroeidis-papageorgiou amplitude_gal=250 period_s=0.8 gamma=1.7 phase_deg=40 azimuth_deg=200",
    "constant amplitude_gal=100 duration_s=0.4 sampling_interval_s=0.01",
    "noise amplitude_gal=90 duration_s=4 low_hz=0.4 high_hz=12 seed=3",
    "noise amplitude_gal=90 duration_s=2",
)
BAD = (
    "",
    "square amplitude_gal=1",
    "sine amplitude_gal=300",
    "sine amplitude_gal=300 period_s=1 period_s=2",
    "sine amplitude_gal=300 period_s",
    "noise amplitude_gal=90 duration_s=0.06 low_hz=1 high_hz=9 sampling_interval_s=0.001",
    "noise amplitude_gal=9 duration_s=3 high_hz=50.1",
    "noise amplitude_gal=9 duration_s=3 high_hz=50",
    "ricker amplitude_gal=1 period_s=0.015",
    "ricker amplitude_gal=1 period_s=0.016",
    "sine amplitude_gal=1 period_s=0.05",
    "sine amplitude_gal=1 period_s=0.019 cycles=10",
    "constant amplitude_gal=1 duration_s=0.049",
    "constant amplitude_gal=1 duration_s=0.05",
    "constant amplitude_gal=0 duration_s=1",
    "constant amplitude_gal=x duration_s=1",
)


def of_pulses() -> dict[str, Any]:
    return {line: pulses.pulse_record(pulses.parse_pulse(line)) for line in LINES} | {
        "refused": refusals(*(lambda line=line: pulses.pulse_record(pulses.parse_pulse(line)) for line in BAD)),
        "lengths": [[one.length, one.shortest] for one in map(pulses.parse_pulse, LINES)],
    }


def recorded(interval: float = 0.01, count: int = 2000, **more: Any) -> Record:
    """Noise for some seconds, then a stronger motion, on an offset, which the shock leaves another one."""
    dice, time = np.random.default_rng(count), np.arange(count) * interval
    strong = np.where(time < 5.0, 0.003, np.exp(-((time - 8.0) ** 2) / 5.0) + 0.003)
    parts = [
        np.round(strong * np.convolve(dice.normal(size=count), np.ones(5) / 5, "same") + 0.02, 9) for _ in range(3)
    ]
    parts[0] += np.where(time > 8.0, 0.01, 0.0)
    given = {"start": "2001-02-03T04:05:06Z", "extra": {"format": "test"}} | more
    return Record("one", parts[0], parts[1], parts[2], interval, **given)


STEPS: tuple[dict[str, Any], ...] = (
    {"step": "remove_mean"},
    {"step": "remove_mean", "first_s": 3.0},
    {"step": "detrend"},
    {"step": "detrend", "order": 4},
    {"step": "taper", "length_s": 1.5},
    {"step": "highpass", "corner_hz": 0.2},
    {"step": "highpass", "corner_hz": "auto", "order": 3},
    {"step": "lowpass", "corner_hz": 20.0, "order": 4},
    {"step": "baseline", "fit_from_s": 12.0},
    {"step": "baseline", "fit_from_s": 12.0, "t1_s": 6.0, "t2_s": 9.0},
    {"step": "resample", "sampling_interval_s": 0.02},
    {"step": "resample", "sampling_interval_s": 0.01},
    {"step": "resample", "sampling_interval_s": 0.0075},
    {"step": "cut", "start_s": 2.0},
    {"step": "cut", "start_s": 2.0, "end_s": 9.0},
    {"step": "scale", "factor": 0.5},
)


def stepped(*given: dict[str, Any], of: Record | None = None) -> Record:
    return processing.process(of or recorded(), TypeAdapter(steps.Steps).validate_python(given))


def of_steps() -> dict[str, Any]:
    found: dict[str, Any] = {}
    for given in STEPS:
        one = stepped(given)
        found[str(given)] = {"record": one, "said": [summary(step) for step in one.processing], "drift": drift(one)}
    common, site = (
        {"step": "common_window", "samples": {"N": 5, "E": 4}, "kept": 4, "left_out_s": 0.01},
        {"layers": [{"thickness_m": 3, "velocity_m_s": 200}]},
    )
    site |= {"step": "site", "rock": {"velocity_m_s": 760}, "motion": "within", "chosen": "x"}
    others = [
        common,
        site,
        {"step": "other"},
        {**site, "step": "site"},
        {"step": "highpass", "corner_hz": 0.1, "order": 2, "chosen": "why"},
    ]
    quiet, short = recorded(count=900), recorded(count=300)
    corners = [
        recorded(),
        recorded(0.005, 3000),
        quiet,
        short,
        stepped({"step": "cut", "start_s": 4.0}),
        recorded(0.02, 900),
    ]
    two = stepped(
        {"step": "remove_mean"}, {"step": "highpass", "corner_hz": 0.3}, {"step": "highpass", "corner_hz": 0.1}
    )
    states = [
        recorded(extra=extra)
        for extra in (
            {"processed": True},
            {"processed": True, "processed_by": "X"},
            {"processed": True, "declared": ["processed"]},
            {"removed": "response"},
        )
    ]
    return found | {
        "said": [summary(step) for step in others],
        "corners": [list(processing.choose_corner(one)) for one in corners],
        "default": processing.process(recorded(), None),
        "of a short one": processing.process(short, None),
        "left alone": processing.process(states[0], None).processing,
        "two": two,
        "provenance": provenance(two),
        "states": [state_of(one) for one in (recorded(), *states)],
        "text": repr(two),
        "offsets": [
            steps._offset(np.concatenate([np.full(150, a), np.full(300, b), np.full(150, c)]), 0.01)
            for a, b, c in ((1, 9, 2), (-1, 2, -3), (1, 0, -1), (0, 3, 1), (-1, -9, -2))
        ],
        "early": drift(recorded(count=5)),
        "synthetic": drift(recorded(extra={"format": "synthetic"})),
    }


def of_refused_steps() -> dict[str, Any]:
    numbers: dict[str, tuple[tuple[str, Any], ...]] = {
        "remove_mean": (("first_s", 0), ("first_s", 0.004), ("first_s", 0.005), ("first_s", 20.0), ("first_s", 20.02)),
        "taper": (("length_s", 0), ("length_s", 0.004), ("length_s", 10.0), ("length_s", 10.01)),
        "detrend": (("order", -1), ("order", 0), ("order", 5), ("order", 6)),
        "lowpass": (("corner_hz", "auto"), ("corner_hz", 49.9), ("corner_hz", 50.0), ("corner_hz", 0)),
        "resample": (
            ("sampling_interval_s", 0),
            ("sampling_interval_s", 1.0),
            ("sampling_interval_s", 1.01),
            ("sampling_interval_s", 0.01 * np.pi),
            ("sampling_interval_s", 9.9e-6),
            ("sampling_interval_s", 1e-5),
        ),
        "cut": (
            ("start_s", -1),
            ("start_s", 19.98),
            ("start_s", 19.99),
            ("end_s", 0),
            ("end_s", 0.01),
            ("end_s", 19.99),
            ("end_s", 20.0),
        ),
        "scale": (("factor", 0), ("factor", 1e-3), ("factor", 1e5)),
        "baseline": (("fit_from_s", 0), ("fit_from_s", 19.9), ("fit_from_s", 19.91), ("t1_s", 1), ("fit_from_s", 5)),
    }
    needed: dict[str, dict[str, Any]] = {"baseline": {"fit_from_s": 12.0}}
    given = [
        {"step": step, **needed.get(step, {}), key: value} for step, items in numbers.items() for key, value in items
    ]
    more = [
        {"step": "baseline", "fit_from_s": 9.0, "t1_s": a, "t2_s": b}
        for a, b in ((1, 1), (1, 9), (1, 9.1), (0, 0.5), (-1, 1), (1, 0))
    ]
    more += [{"step": "cut", "start_s": 3.0, "end_s": end} for end in (3.0, 3.005, 3.01)]
    more += [{"step": "highpass", "corner_hz": 1.0, "order": order} for order in (0, 1, 8, 9)] + [
        {"step": "x"},
        {"step": "taper"},
        {"stop": "cut"},
    ]
    order = ({"step": "highpass", "corner_hz": "auto"}, {"step": "cut", "start_s": 1.0})
    return refusals(
        *(lambda one=one: stepped(one) for one in (*given, *more)),
        lambda: stepped(*order),
        lambda: stepped(*order[::-1]),
    )


EVENTS = (
    ("Kobe 1995", "1995-01-16T20:46:52Z", (34.6, 135.0), ""),
    ("KOBE 1995", "1995-01-16T20:47:52Z", (34.6, 135.9), ""),
    ("Kobe, Japan 1/16/1995", None, None, ""),
    ("Northridge", "1994-01-17T12:31:00Z", None, ""),
    ("Northridge", "1994-01-17T12:32:01Z", None, ""),
    ("", None, None, ""),
    ("", None, None, ""),
    ("Northrige 1994", None, None, ""),
    ("Tottori", None, None, "id1"),
    ("Other", None, None, "id1"),
    ("Tottori", None, None, "id2"),
    ("Kaikoura 2016", "2016-11-13T11:02:56Z", (-42.7, 173.0), ""),
    ("Kaikoura 2016", "2016-11-13T11:02:57Z", (-42.7, 174.3), ""),
    ("Loma Prieta 18 Oct 1989", None, None, ""),
    ("Loma Prieta 10-18-89", None, None, ""),
    ("Loma Prieta 17 Oct 1989", None, None, ""),
    ("kobe 1995", None, None, ""),
    ("Chi-Chi 1", None, None, ""),
    ("Chi-Chi 2", None, None, ""),
    ("sine pulse", None, None, ""),
    ("sine pulse", None, None, ""),
)


def of_earthquakes() -> dict[str, Any]:
    zero = np.zeros(2)
    records = []
    for number, (name, origin, place, known) in enumerate(EVENTS):
        extra: dict[str, Any] = {"origin_time": origin} if origin else {}
        extra |= {"event_id": known} if known else {}
        extra |= dict(zip(("event_latitude", "event_longitude"), place, strict=True)) if place else {}
        extra |= {"format": "synthetic"} if name == "sine pulse" else {}
        start = f"2001-01-{1 + number // 3:02d}T{10 + number % 3}:00:00Z" if number % 4 else None
        records.append(Record(f"r{number}", zero, zero, None, 0.01, event=name, extra=extra, start=start))
    told = {str(n): earthquakes_of(records[n:]) for n in (0, 2, 5, 11)}
    apart = [
        replace(records[2], record_id=f"s{m}", start=f"2001-01-01T0{m // 60}:{m % 60:02d}:00Z")
        for m in (0, 2, 3, 59, 60, 61)
    ]
    others = [replace(one, event=f"Quake {one.record_id}") for one in apart]
    many = [
        replace(records[13], record_id=f"m{k}", event=f"Place {'ab'[k % 2] * 5}{'c' * (k // 2)} 1990")
        for k in range(12)
    ]
    return told | {
        "backwards": earthquakes_of(records[::-1]).labels,
        "notes": earthquakes_of(many).notes,
        "many": len(earthquakes_of(many).doubtful),
        **{f"apart {k}": earthquakes_of([apart[0], apart[k]]) for k in range(1, 6)},
        **{f"others {k}": earthquakes_of([others[0], others[k]]).doubtful for k in range(1, 6)},
        "entries": earthquakes_of(
            [
                RecordEntry(id=f"e{k}", source="x", event="A", origin_time=f"2001-01-01T00:00:{s}")
                for k, s in enumerate(("00", "59", "30"))
            ]
        ).labels,
    }


CELLS = {
    "id": ("a", "A", "", "-a", "a_b-1"),
    "source": ("",),
    "event_id": ("x y", "x" * 60, "x" * 61),
    "origin_time": ("2016-11-13T11:02:56", "2016-11-13", "2016-11-13T11:02:56+09:00", "2016-13-13T11:02"),
    "fault_strike_deg": ("-1", "0", "360", "360.1", "x"),
    "pulse": ("true", "2", "no"),
    "magnitude": ("-1", "0", "10", "10.1"),
    "rupture_distance_km": ("-1", "0", "2000", "2001"),
    "site_class": ("a b", "C" * 20, "C" * 21),
    "vs30_m_s": ("30", "30.1", "5000", "5001"),
    "pulse_period_s": ("0", "0.1", "60", "61"),
    "wall": ("top", "foot"),
    "orientation_correction_deg": ("-361", "-360", "360", "361"),
    "magnetic_declination_deg": ("-181", "180", "181"),
    "azimuths_deg": ("0 90", "0, 90", "0", "0 90 180"),
    "unit": ("feet", "g"),
    "sampling_interval_s": ("0", "1", "1.1"),
    "vertical_sense": ("up", "left"),
    "sensor": ("roof", "borehole"),
    "trust_data": ("true",),
    "sha256": ("x", "a" * 64),
    "station_latitude_deg": ("1", "91"),
    "nothing": ("1",),
}


def of_table() -> dict[str, Any]:
    found: dict[str, Any] = {}
    with TemporaryDirectory() as folder:
        path = Path(folder) / "records.tsv"

        def entries(text: str) -> dict[str, RecordEntry]:
            path.write_text(text, encoding="utf-8")
            return read_catalogue(path)

        for column, values in CELLS.items():
            for value in values:
                row = {"id": "a", "source": "b"} | {column: value}
                text = "# said\n" + "\t".join(row) + "\n" + "\t".join(row.values()) + "\n"
                said = refusals(partial(entries, text))["1"].replace(folder, "")
                found[f"{column} {value[:22]}"] = (
                    said
                    if said != "accepted"
                    else str(getattr(entries(text)["a" if column != "id" else value], column))
                )
        pair = "id\tsource\tstation_latitude_deg\tstation_longitude_deg\n"
        found["twice"] = refusals(
            lambda: entries("id\tsource\na\tb\na\tc\n"),
            lambda: entries("id\tid\na\tb\n"),
            lambda: entries(pair + "a\tb\t90\t-180\n"),
            lambda: entries(pair + "a\tb\t90\t-181\n"),
        )
        found["twice"] = {key: value.replace(folder, "") for key, value in found["twice"].items()}
        gone = {
            form: RecordEntry(id="a", format=form, source=name)
            for form, name in (("k-net", "TTR1"), ("kik-net", "TTR2"), ("auto", "x.dat y"), ("peer", "example:none"))
        }
        found["gone"] = refusals(
            *(lambda one=one: read_record(one, Path(folder)) for one in gone.values()),
            lambda: find_paths(gone["kik-net"].model_copy(update={"sensor": "borehole"}), Path(folder)),
        )
        found["gone"] = {key: value.replace(folder, "") for key, value in found["gone"].items()}
    entry = RecordEntry(
        id="a",
        source="b",
        magnitude=6.0,
        wall="foot",
        orientation_correction_deg=3.0,
        magnetic_declination_deg=-1.0,
        azimuths_deg=(0, 90),
        unit="g",
    )
    pulse = RecordEntry(
        id="p",
        format="synthetic",
        source=LINES[0],
        station="S",
        event="E",
        fault_strike_deg=10,
        pulse=True,
        pulse_period_s=1.0,
        epicentre_latitude_deg=1,
        epicentre_longitude_deg=2,
    )
    found |= {
        "metadata": entry.metadata,
        "declared": entry.declarations,
        "of samples": [entry.declarations.of_samples, entry.declarations.of_axes],
        "names": METADATA,
        "pulse": read_record(pulse, "."),
    }
    wrong = [
        pulse.model_copy(update={"unit": "g"}),
        pulse.model_copy(update={"sha256": "a" * 64}),
        entry.model_copy(update={"format": "x"}),
    ]
    found["wrong"] = refusals(
        *(lambda one=one: read_record(one, ".") for one in wrong),
        lambda: utc_moment("2001"),
        lambda: Declarations(unit="feet"),
        lambda: Declarations(sensor="x"),  # type: ignore[arg-type]
        lambda: Declarations(columns="a:g", format="sac"),
        lambda: Declarations(columns="a:g", format="csv"),
    )
    return found


COLUMNS = (
    "time:s north:gal east:gal up:gal",
    "time:ms skip N90E:g 180:m/s2 down:mg",
    "north:gal east:gal",
    "north east",
    "",
    "a,b",
    "time:h north:g",
    "north:gal,east:gal",
)


def of_columns() -> dict[str, Any]:
    numbers = np.round(np.random.default_rng(2).normal(0, 50, (30, 3)), 3)
    time = np.arange(30) * 0.01
    rows = [[f"{t:.3f}", *map(str, row)] for t, row in zip(time, numbers.tolist(), strict=True)]
    files = {
        "commas": "time,n,e,u\n" + "\n".join(map(",".join, rows)) + "\n",
        "semicolons": "# said\n" + "\n".join(map(";".join, rows)) + "\n",
        "blanks": "\n".join(map(" ".join, rows)) + "\n",
        "five": "\n".join(
            "\t".join([f"{1000 * t:.1f}", "x", *row[1:]]) for t, row in zip(time, rows, strict=True)
        ).replace("x", "1")
        + "\n",
        "two": "\n".join(",".join(row[1:3]) for row in rows) + "\n",
        "decimal commas": "\n".join(";".join(row).replace(".", ",") for row in rows) + "\n",
        "uneven": "\n".join(map(",".join, [*rows[:9], *rows[10:]])) + "\n",
        "no end": "\n".join(map(",".join, rows)),
        "one": ",".join(rows[0]) + "\n",
        "mixed": ",".join(rows[0]) + "\n" + "\n".join(map(";".join, rows[1:])) + "\n",
        "words": "a,b,c,d\n" * 2 + ",".join(rows[0]) + "\n",
        "nan": "\n".join(map(",".join, [*rows[:9], ["0.09", "nan", "1", "2"], *rows[10:]])) + "\n",
    }
    found = {}
    for name, text in files.items():
        for columns in COLUMNS:
            for interval in (None, 0.01, 0.0101):
                declared = Declarations(
                    columns=columns, sampling_interval_s=interval, processed=True, format="csv", trust_data=True
                )
                found[f"{name}, {columns}, {interval}"] = sha256(
                    told([SourceFile("x.csv", text.encode())], declared).encode()
                ).hexdigest()[:6]
    undeclared = Declarations(columns=COLUMNS[0])
    return found | {
        "undeclared": told([SourceFile("x.csv", files["commas"].encode())], undeclared),
        "read": told(
            [SourceFile("x.csv", files["commas"].encode())], Declarations(columns=COLUMNS[0], processed=False)
        ),
    }


def of_seed() -> dict[str, Any]:
    """MiniSEED with StationXML, and SAC with what its header may leave out."""
    dice, found = np.random.default_rng(4), dict[str, Any]()
    counts = [np.round(dice.normal(0, 40_000, 3000) * np.hanning(3000)).astype(int) for _ in range(3)]
    kinds: dict[str, dict[str, Any]] = {
        "plain": {},
        "gal": {"unit": "cm/s**2", "gain": 4000.0},
        "deep": {"depth": 100.0},
        "broadband": {"unit": "M/S", "broadband": True, "gain": 4e9},
        "gain alone": {"unit": "M/S", "gain": 4e8},
        "volts": {"unit": "V"},
        "another": {"station": "TST2"},
        "counts": {"gain": 0.0},
        "loud": {"unit": "M/S", "broadband": True, "gain": 4e6},
    }
    channels = {"HNN": (0.0, 0.0), "HNE": (90.0, 0.0), "HNZ": (0.0, -90.0)}
    bands = {
        name: {**channels}
        if name not in ("broadband", "loud", "gain alone")
        else {code.replace("N", "H", 1): at for code, at in channels.items()}
        for name in kinds
    }
    bands["plain"] = {"HN1": (30.0, 0.0), "HN2": (120.0, 0.0), "HN3": (0.0, 90.0)}
    with TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for name, kind in kinds.items():
            place = Path(folder) / name
            place.mkdir()
            data = write_mseed(place / "x.mseed", dict(zip(bands[name], counts, strict=True)))
            xml = write_inventory(place / "s.xml", bands[name], **kind)
            found[name] = read_of(
                [SourceFile(path.name, path.read_bytes()) for path in (data, xml)],
                Declarations(sensor="borehole" if name == "deep" else None),
            )
        found["without"] = read_of([SourceFile(data.name, data.read_bytes())])
        for name, more in {
            "sac": (0.0, 90.0),
            "up": (0.0, 0.0),
            "down": (0.0, 180.0),
            "not level": (0.0, 45.0),
            "none": (None, None),
            "west": (-90.0, 90.0),
        }.items():
            path = write_sac(Path(folder) / "a.sac", counts[0][:200] / 1e3, "HNN", *more)
            found[f"sac {name}"] = [
                plain(one) for one in read_files([source.read_source(path)], Declarations(unit="gal", processed=True))
            ]
        found["sac without unit"] = read_of([source.read_source(path)], Declarations())
    return found


def of_files() -> dict[str, Any]:
    """Records as a study stores them, several sensors in a folder, and what is said of each."""
    with TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        place, counts = Path(folder), [np.arange(300) % k * 3000 for k in (7, 11, 13)]
        write_knet_set(place, "TTR1", *counts, kik=2)
        write_knet_set(place, "TTR1", *counts[::-1], kik=1)
        write_knet_set(place, "TST", *counts[:2], memo="x")
        (place / "a.md").write_text("no record")
        (place / "b.dat").write_text("nothing known\n")
        said = [describe(finding).replace(folder, "") for finding in check_paths([place])]
        surface = [describe(one) for one in check_paths([place / "TTR1.NS2"], Declarations(sensor="surface"))]
        alone = [describe(one) for one in check_paths([place / "TTR1.NS1"], Declarations(sensor="surface"))]
        one = read(place / "TST.NS", processing=[{"step": "remove_mean"}])
        write_motion(one, place / "m.nc", recorded())
        write_motion(
            replace(
                recorded(),
                fault_strike_deg=3.0,
                latitude=1.0,
                longitude=2.0,
                component_azimuths_deg=(1.0, 91.0),
                licence="l",
            ),
            place / "n.nc",
        )
        kept = [
            read_motion(place / "m.nc"),
            read_unprocessed(place / "m.nc"),
            read_motion(place / "n.nc"),
            read_unprocessed(place / "n.nc"),
        ]
        wrong = refusals(
            lambda: read(place / "TST.NS", processing=[{"step": "x"}]),
            lambda: read([]),
            lambda: read(place / "TTR1.NS1"),
            lambda: read_motion(place / "b.dat"),
            lambda: read_motion(place / "gone.nc"),
        )
    return {
        "said": said,
        "surface": surface,
        "alone": alone,
        "one": one,
        "kept": kept,
        "wrong": {key: value.replace(folder, "") for key, value in wrong.items()},
        "no records": [is_no_record(Path(name)) for name in ("a.md", "a.V1", ".a", "a.XML", "a.json")],
        "K-NET": told([SourceFile("a.NS", knet_text(counts[0]).encode())]),
    }


def of_requests() -> dict[str, Any]:
    given = {"server": "s", "network": "N", "station": "S", "start": "2001-01-01", "end": "2001-01-02"}
    changes: tuple[dict[str, Any], ...] = (
        {},
        {"end": ""},
        {"start": ""},
        {"event_id": "x"},
        {"start": "", "end": "", "event_id": "x"},
        {"network": "a b"},
        {"station": "S" * 8},
        {"station": "S" * 9},
        {"before_s": 1.0},
        {"after_s": 0.0},
        {"server": "u@s"},
        {"start": "", "end": ""},
        {"channel": "HN?"},
        {"start": "", "end": "", "event_id": "x", "after_s": 9.0},
    )
    return {"fields": [item.name for item in fields(Request)]} | refusals(
        *(lambda change=change: Request(**given | change) for change in changes)
    )


ANSWERS: Answers = {
    "interface": partial(interface_of, "records"),
    "formats": of_formats,
    "kinds": of_kinds,
    "assembly": of_assembly,
    "axes": of_axes,
    "pulses": of_pulses,
    "steps": of_steps,
    "refused steps": of_refused_steps,
    "earthquakes": of_earthquakes,
    "table": of_table,
    "columns": of_columns,
    "seed": of_seed,
    "files": of_files,
    "requests": of_requests,
    "keys": partial(
        keys_of,
        *(
            getattr(pulses, name)
            for name in ("_Pulse", "Wave", "Ricker", "MavroeidisPapageorgiou", "Constant", "Noise")
        ),
        RecordEntry,
        Site,
        *(
            getattr(steps, name)
            for name in (
                "RemoveMean",
                "Detrend",
                "Taper",
                "Highpass",
                "Lowpass",
                "Baseline",
                "Resample",
                "Cut",
                "Scale",
            )
        ),
    ),
    **{f"spoilt: {form}": partial(of_spoilt, form) for form in WHOLE},
}
