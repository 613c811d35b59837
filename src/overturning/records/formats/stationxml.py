"""StationXML: gain, unit, orientation and place of the channel epoch in which a trace was recorded."""

import copy
import io
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from overturning.errors import RecordError
from overturning.records.axis_direction import (
    UNKNOWN_DIRECTION,
    AzimuthAndVerticalSense,
    direction_from_azimuth_and_dip_with_notes,
)
from overturning.records.declared_properties import DeclaredFileProperties
from overturning.records.source import SourceFile
from overturning.units import GAL, STANDARD_GRAVITY

_METRES_BY_LENGTH_UNIT: Final = {"M": 1.0, "CM": GAL, "MM": 1e-3, "UM": 1e-6, "NM": 1e-9}
_M_S2_BY_ACCELERATION_UNIT: Final = {f"{length}/S2": scale for length, scale in _METRES_BY_LENGTH_UNIT.items()} | {
    "GAL": GAL,
    "G": STANDARD_GRAVITY,
}

MAX_RELATIVE_STAGE_GAIN_DIFFERENCE: Final = 0.05
"""Largest relative difference of a channel's gain from the product of its stages; evalresp warns from there on."""

MAX_RELATIVE_VELOCITY_STAGE_GAIN_DIFFERENCE: Final = 1.0
"""Like `MAX_RELATIVE_STAGE_GAIN_DIFFERENCE`, for a velocity sensor: its stages may state gains at other frequencies."""

MAX_RELATIVE_GAIN_DIFFERENCE_WITHOUT_NOTE: Final = 0.005
"""Largest difference of a gain from its stages without a note; header peaks may differ as much from the samples."""

MAX_RELATIVE_SAMPLING_RATE_DIFFERENCE: Final = 0.01
"""Largest relative difference between the sampling rates of a trace and of its channel."""

MAX_COEFFICIENT_SUM_DIFFERENCE_FROM_1: Final = 0.02
"""Largest difference from 1 of the sum of a digital filter's coefficients without normalisation, as in evalresp."""

_UNKNOWN_ORIENTATION_PATTERN: Final = re.compile(
    r"(orientations?|azimuths?)\s+(is\s+|are\s+)?(not\s+(yet\s+)?(known|determined|measured)"
    r"|unknown|undetermined|uncertain)"
    r"|(unknown|uncertain|undetermined)\s+(sensor\s+)?(orientation|azimuth)|\b(not\s+|un)oriented\b",
    re.IGNORECASE,
)


def normalise_unit(unit_text: str) -> str:
    """Return a uniform spelling of a unit, in upper case: ``M/S2`` for ``m/s**2`` or ``meter/second^2``."""
    word = re.sub(r"MET(?:ER|RE)S?", "M", re.sub("SEC(?:OND)?S?", "S", unit_text.upper().replace("²", "2")))
    word = re.sub(r"[\s(){}^]|\*\*", "", word.replace("CENTI", "C").replace("MILLI", "M").replace("NANO", "N"))
    word = re.sub(r"(?<=M)[*.·]?S-2$", "/S2", word)
    word = re.sub(r"(?<=M)[*.·]?S-1$", "/S", word)
    return re.sub(r"/S/S$|/S\*S$", "/S2", word)


def acceleration_unit_in_m_s2(unit: str) -> float | None:
    """Return the factor from a unit of acceleration to m/s²; None for any other unit."""
    return _M_S2_BY_ACCELERATION_UNIT.get(normalise_unit(unit))


def is_metre_per_second(unit: str) -> bool:
    """Return True if the unit is metres per second."""
    return normalise_unit(unit) == "M/S"


def is_acceleration_or_metre_per_second_unit(unit: str) -> bool:
    """Return True if a unit is one of acceleration, or metres per second."""
    return acceleration_unit_in_m_s2(unit) is not None or is_metre_per_second(unit)


def read_stationxml_inventory(stationxml_files: Sequence[SourceFile]) -> Any:
    """Read all StationXML files into one inventory, None without files; raise a RecordError for a damaged file."""
    import obspy

    inventory = None
    for file in stationxml_files:
        try:
            one = obspy.read_inventory(io.BytesIO(file.data), format="STATIONXML")
        except Exception as problem:  # lxml and obspy raise many kinds; each means that the file is damaged
            raise RecordError(f"{file.name}: damaged StationXML ({problem}); get it again") from problem
        inventory = one if inventory is None else inventory + one
    return inventory


@dataclass(frozen=True)
class ChannelEpoch:
    """StationXML channel during the period (epoch) in which a trace begins, with its gain and direction."""

    obspy_channel: Any
    input_unit: str  # unit of the ground motion as the StationXML writes it, such as M/S**2
    gain_in_counts_per_unit: float  # negative where the polarity is reversed
    direction: AzimuthAndVerticalSense
    is_orientation_unknown: bool  # whether a text of the channel says that its orientation is not known
    notes: tuple[str, ...]
    contradictions_accepted_with_trust_data: tuple[str, ...]  # contradictions that --trust-data goes on over

    @property
    def trusted_contradictions_metadata(self) -> dict[str, tuple[str, ...]]:
        """Return contradictions in the StationXML that the user accepts, as metadata of a component; {} if none."""
        return (
            {"trusted": self.contradictions_accepted_with_trust_data}
            if self.contradictions_accepted_with_trust_data
            else {}
        )


def find_channel_epoch(
    obspy_trace: Any, obspy_inventory: Any, source_file: SourceFile, user_declared_properties: DeclaredFileProperties
) -> ChannelEpoch:
    """Return gain, unit and direction of a trace's channel from the StationXML epoch in which the trace begins.

    Raises a RecordError if the StationXML has no epoch, several different ones, no gain, or a gain that contradicts
    its stages. With ``trust_data``, different epochs (the latest is used) and contradicting stages are accepted.
    """
    name = f"{source_file.name}: channel {obspy_trace.id}"
    trusted: list[str] = []

    def refuse_or_store_contradiction(contradiction_text: str, remedy: str) -> None:
        """Raise a RecordError for a contradiction; if the user trusts the data, only store the contradiction."""
        if not user_declared_properties.trust_data:
            raise RecordError(f"{name} {contradiction_text}; {remedy}, or say --trust-data")
        trusted.append(f"{name} {contradiction_text}")

    channel = _channel_at_trace_start(obspy_trace, obspy_inventory, name, refuse_or_store_contradiction)
    rate, stated = float(obspy_trace.stats.sampling_rate), float(channel.sample_rate or 0.0)
    if stated and abs(rate / stated - 1.0) > MAX_RELATIVE_SAMPLING_RATE_DIFFERENCE:
        refuse_or_store_contradiction(
            f"is sampled at {rate:g} Hz, but at {stated:g} Hz in the StationXML", "get the StationXML of that time"
        )
    gain, unit = _channel_gain_in_counts_per_unit_and_unit(channel, name)
    notes = _channel_gain_mismatch_notes(channel.response, gain, unit, name, refuse_or_store_contradiction)
    _check_first_stage_unit(channel.response, unit, refuse_or_store_contradiction)
    direction, unknown, inclined = _channel_direction_unknown_text_and_notes(channel, name)
    notes += inclined
    if unknown:
        notes += (f"{name}: the StationXML says {unknown!r}, so its azimuth is not taken",)
    if gain < 0:
        notes += (f"{name} has a negative gain, {gain:g}, in the StationXML: its polarity is taken as reversed",)
    return ChannelEpoch(channel, unit, gain, direction, bool(unknown), notes, tuple(trusted))


def _channel_at_trace_start(
    obspy_trace: Any,
    obspy_inventory: Any,
    file_and_channel_label: str,
    report_contradiction_and_remedy: Callable[[str, str], None],
) -> Any:
    """Return the StationXML channel at a trace's start; report a contradiction if several differ or it changes."""
    fitting = _channels_active_at_time(obspy_trace, obspy_inventory, obspy_trace.stats.starttime)
    if not fitting:
        why = f"at {obspy_trace.stats.starttime} is not in the StationXML given"
        raise RecordError(f"{file_and_channel_label} {why}; get it with level=response for that channel and time")
    channel = fitting[-1]
    if len({_channel_properties_affecting_record(one) for one in fitting}) > 1:
        listed = " and ".join(
            f"{_gain_and_direction_text(one)} from {str(one.start_date or 'ever')[:10]} on" for one in fitting
        )
        report_contradiction_and_remedy(
            f"has {len(fitting)} epochs in the StationXML that fit {obspy_trace.stats.starttime} and differ: {listed}",
            "end the one that was over, in the StationXML",
        )
    later = _channels_active_at_time(obspy_trace, obspy_inventory, obspy_trace.stats.endtime)
    if later and all(
        _channel_properties_affecting_record(one) != _channel_properties_affecting_record(channel) for one in later
    ):
        report_contradiction_and_remedy(
            f"changes in the StationXML while it records: {_gain_and_direction_text(channel)}, "
            f"then {_gain_and_direction_text(later[-1])} from "
            f"{str(later[-1].start_date)[:19]} on",
            "cut the file there",
        )
    return channel


def _channel_gain_in_counts_per_unit_and_unit(obspy_channel: Any, file_and_channel_label: str) -> tuple[float, str]:
    """Return the gain of a StationXML channel, counts per unit, and its unit; a RecordError if it has no gain."""
    sensitivity = getattr(obspy_channel.response, "instrument_sensitivity", None)
    if sensitivity is None or sensitivity.value is None:
        raise RecordError(
            f"{file_and_channel_label} has no gain in the StationXML; get it with level=response for that channel and "
            "time"
        )
    gain, unit = float(sensitivity.value), (sensitivity.input_units or "").strip().upper()
    if not np.isfinite(gain) or gain == 0:
        raise RecordError(f"{file_and_channel_label} has a gain of {gain}; correct the StationXML")
    return gain, unit


def _channel_gain_mismatch_notes(
    obspy_response: Any,
    channel_gain_in_counts_per_unit: float,
    input_unit: str,
    file_and_channel_label: str,
    report_contradiction_and_remedy: Callable[[str, str], None],
) -> tuple[str, ...]:
    """Return a note if a channel's gain differs by over 0.5 % from the product of its stage gains; else ().

    Above 5 % (velocity sensors: 100 %), report a contradiction instead.
    """
    made, difference = _total_stage_gain_and_relative_difference(obspy_response, channel_gain_in_counts_per_unit)
    stated = f"has a gain of {channel_gain_in_counts_per_unit:g} in the StationXML, whose stages make {made:g}"
    if difference > (
        MAX_RELATIVE_VELOCITY_STAGE_GAIN_DIFFERENCE
        if is_metre_per_second(input_unit)
        else MAX_RELATIVE_STAGE_GAIN_DIFFERENCE
    ):
        report_contradiction_and_remedy(stated, "find out which is right")
    elif difference > MAX_RELATIVE_GAIN_DIFFERENCE_WITHOUT_NOTE:
        used = "the stages" if is_metre_per_second(input_unit) else f"{channel_gain_in_counts_per_unit:g}"
        return (f"{file_and_channel_label} {stated}, a difference of {100 * difference:.2g} %; computed with {used}",)
    return ()


def _check_first_stage_unit(
    obspy_response: Any, input_unit: str, report_contradiction_and_remedy: Callable[[str, str], None]
) -> None:
    """Report a contradiction if a channel's input is acceleration and its first stage's velocity, or vice versa."""
    first = (obspy_response.response_stages or [None])[0]
    other = (getattr(first, "input_units", None) or "").strip().upper()
    differ = (acceleration_unit_in_m_s2(input_unit) is None) != (acceleration_unit_in_m_s2(other) is None)
    if differ and is_acceleration_or_metre_per_second_unit(other):
        report_contradiction_and_remedy(
            f"is in {input_unit} in the StationXML, whose first stage is in {other}", "find out which is right"
        )


def inventory_has_channel_of_trace(obspy_trace: Any, obspy_inventory: Any) -> bool:
    """Return True if the StationXML describes the channel of a trace, for any period."""
    codes = obspy_trace.stats
    return any(
        (network.code, station.code, channel.location_code, channel.code)
        == (codes.network, codes.station, codes.location, codes.channel)
        for network in obspy_inventory
        for station in network
        for channel in station
    )


def _total_stage_gain_and_relative_difference(
    obspy_response: Any, channel_gain_in_counts_per_unit: float
) -> tuple[float, float]:
    """Return the total gain of a response's stages, and its relative difference from the channel's gain.

    Stages may state their gains at other frequencies than the channel. The total gain is either the product of the
    stated stage gains or that of the stage gains at the channel's frequency, whichever is closer to the channel's gain.
    Without stages, or if a stage has no gain, the total gain is NaN and the difference 0.
    """
    stages = obspy_response.response_stages or ()
    stated = np.array([float(stage.stage_gain or 0.0) for stage in stages])
    if not stated.size or not stated.all():
        return np.nan, 0.0
    frequency = obspy_response.instrument_sensitivity.frequency
    shifted = stated * [_gain_at_channel_over_at_stage_frequency(stage, frequency) for stage in stages]
    products = float(stated.prod()), float(shifted.prod())
    pairs = [
        (
            made,
            max(abs(made / channel_gain_in_counts_per_unit - 1.0), abs(channel_gain_in_counts_per_unit / made - 1.0)),
        )
        for made in products
    ]
    return min(pairs, key=lambda pair: pair[1])


_LAPLACE_VARIABLE_AT_1_HZ_BY_FUNCTION_TYPE: Final = {"LAPLACE (RADIANS/SECOND)": 2.0 * np.pi, "LAPLACE (HERTZ)": 1.0}
"""Imaginary part of the Laplace variable at 1 Hz, by type of transfer function."""


def _gain_at_channel_over_at_stage_frequency(
    obspy_response_stage: Any, channel_gain_frequency_hz: float | None
) -> float:
    """Return a response stage's gain at the frequency of the channel's gain over that at the stage's frequency.

    The ratio is 1 for a stage without analogue poles and zeros, or if one of the two frequencies is not stated, or the
    gain at one of them is zero or infinite.
    """
    scale = _LAPLACE_VARIABLE_AT_1_HZ_BY_FUNCTION_TYPE.get(
        getattr(obspy_response_stage, "pz_transfer_function_type", "")
    )
    if scale is None or not channel_gain_frequency_hz or not obspy_response_stage.stage_gain_frequency:
        return 1.0
    laplace = 1j * scale * np.array([channel_gain_frequency_hz, obspy_response_stage.stage_gain_frequency])
    zeros, poles = (
        np.polynomial.polynomial.polyvalfromroots(laplace, np.asarray(roots, dtype=complex))
        for roots in (obspy_response_stage.zeros, obspy_response_stage.poles)
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        here, stated = np.abs(zeros / poles)
    return float(here / stated) if np.isfinite([here, stated]).all() and here > 0 and stated > 0 else 1.0


def normalise_filter_coefficient_sums_with_notes(
    obspy_response: Any, file_and_channel_label: str
) -> tuple[Any, tuple[str, ...]]:
    """Return a response with FIR coefficients scaled to the sum 1, and a note for each changed filter.

    evalresp would scale the same filters, but print a line on the terminal for each. Sums within 2 % of 1 are kept, and
    so are symmetric filters, of which the StationXML states only half of the coefficients.
    """
    normalised, notes = copy.deepcopy(obspy_response), []
    for stage in normalised.response_stages:
        name = "coefficients" if getattr(stage, "symmetry", "") == "NONE" else "numerator"
        coefficients = [float(one) for one in getattr(stage, name, None) or ()]
        total = sum(coefficients)
        if (
            not total
            or getattr(stage, "denominator", None)
            or abs(total - 1.0) <= MAX_COEFFICIENT_SUM_DIFFERENCE_FROM_1
        ):
            continue
        setattr(stage, name, [one / total for one in coefficients])
        what = f"the coefficients of its filter in stage {stage.stage_sequence_number} have the sum {total:g}"
        notes.append(f"{file_and_channel_label}: {what} in the StationXML; they are divided by it")
    return normalised, tuple(notes)


def _channels_active_at_time(obspy_trace: Any, obspy_inventory: Any, time_utc: Any) -> list[Any]:
    """Return the StationXML channels of a trace that were active at a time, ordered by their start."""
    codes = obspy_trace.stats
    found = [
        channel
        for network in obspy_inventory
        if network.code == codes.network and network.is_active(time=time_utc)
        for station in network
        if station.code == codes.station and station.is_active(time=time_utc)
        for channel in station
        if (channel.code, channel.location_code) == (codes.channel, codes.location) and channel.is_active(time=time_utc)
    ]
    return sorted(found, key=lambda channel: channel.start_date.timestamp if channel.start_date else -np.inf)


def _channel_properties_affecting_record(obspy_channel: Any) -> tuple[Any, ...]:
    """Return a channel's properties that affect a record, to test whether two epochs of the channel differ."""
    response = obspy_channel.response
    sensitivity = getattr(response, "instrument_sensitivity", None)
    stages = [
        (type(stage).__name__, stage.stage_gain, str(getattr(stage, "poles", "")), str(getattr(stage, "zeros", "")))
        for stage in getattr(response, "response_stages", None) or ()
    ]
    gain = (sensitivity.value, normalise_unit(sensitivity.input_units or "")) if sensitivity else None
    return (
        gain,
        tuple(stages),
        obspy_channel.azimuth,
        obspy_channel.dip,
        obspy_channel.depth,
        obspy_channel.latitude,
        obspy_channel.longitude,
    )


def _gain_and_direction_text(obspy_channel: Any) -> str:
    """Return the gain, azimuth and dip of a channel as text for messages."""
    sensitivity = getattr(obspy_channel.response, "instrument_sensitivity", None)
    gain = f"gain {sensitivity.value:g}" if sensitivity and sensitivity.value is not None else "no gain"
    return f"{gain}, azimuth {obspy_channel.azimuth}, dip {obspy_channel.dip}"


def _channel_direction_unknown_text_and_notes(
    obspy_channel: Any, file_and_channel_label: str
) -> tuple[AzimuthAndVerticalSense, str, tuple[str, ...]]:
    """Return the direction of a channel, the StationXML text that declares it unknown (or ""), and notes.

    A RecordError names a channel that is neither horizontal nor vertical.
    """
    direction, notes = direction_from_azimuth_and_dip_with_notes(
        obspy_channel.code, obspy_channel.azimuth, obspy_channel.dip, file_and_channel_label
    )
    if direction[1]:
        return direction, "", notes
    texts = [obspy_channel.description, *(comment.value for comment in obspy_channel.comments)]
    texts += [obspy_channel.sensor.description] if obspy_channel.sensor else []
    unknown = next((text for text in texts if text and _UNKNOWN_ORIENTATION_PATTERN.search(text)), "")
    return UNKNOWN_DIRECTION if unknown else direction, unknown, notes
