"""What was done to a record, in words, for people."""

from collections.abc import Mapping
from typing import Any

from overturning.records.assembly import peaks_of
from overturning.records.record import Record


def summary(step: Mapping[str, Any]) -> str:
    """A step that was applied to a record, as it is written down, in a few words: ``high-pass 0.1 Hz, order 2``."""
    match step["step"]:
        case "common_window":
            sizes = ", ".join(f"{axis}: {count}" for axis, count in step["samples"].items())
            return f"cut to the common {step['kept']} samples ({sizes}), {step['left_out_s']:g} s left out"
        case "highpass" | "lowpass" as kind:
            reason = f" ({step['chosen']})" if "chosen" in step else ""
            return f"{kind.replace('pass', '-pass')} {step['corner_hz']:g} Hz, order {step['order']}{reason}"
        case "remove_mean":
            return "mean removed" if step["first_s"] is None else f"mean of the first {step['first_s']:g} s removed"
        case "detrend":
            return f"polynomial of order {step['order']} removed"
        case "taper":
            return f"taper {step['length_s']:g} s"
        case "baseline":
            return f"baseline {step['scheme']}, fit from {step['fit_from_s']:g} s"
        case "resample":
            return f"resampled to {step['sampling_interval_s']:g} s"
        case "cut":
            return f"cut from {step['start_s']:g} s" + ("" if step["end_s"] is None else f" to {step['end_s']:g} s")
        case "site":
            layers = ", ".join(f"{one['thickness_m']:g} m of {one['velocity_m_s']:g} m/s" for one in step["layers"])
            told = f" ({step['chosen']})" if "chosen" in step else ""
            return f"through {layers} over {step['rock']['velocity_m_s']:g} m/s, record {step['motion']}{told}"
        case "scale":
            return f"times {step['factor']:g}"
        case other:
            return str(other)


def state_of(record: Record) -> str:
    """Raw or processed, and by whom."""
    if not record.extra.get("processed"):
        return "raw" + (", response of a velocity sensor removed" if record.extra.get("removed") == "response" else "")
    by = record.extra.get("processed_by")
    if by:
        return f"processed by {by}"
    return "processed, as declared" if "processed" in record.extra.get("declared", ()) else "processed"


def account(record: Record) -> dict[str, Any]:
    """All that a reader of the results has to know of how a processed record came about, as plain data.

    ``data`` (raw or processed, and by whom), ``agency`` (its processing), ``steps`` (as `process` writes them down),
    ``peaks`` (largest PGA, PGV and PGD of north and east before and after, SI), ``start``, ``duration_s`` (of what is
    computed), ``declared`` and ``trusted``.
    """
    effects = [step["effect"] for step in record.processing]
    now = peaks_of(record.horizontal, record.sampling_interval)
    return {
        "data": state_of(record),
        "agency": record.extra.get("agency_processing", ""),
        "steps": list(record.processing),
        "peaks": {name: [effects[0][name][0] if effects else peak, peak] for name, peak in now.items()},
        "start": record.start or "",
        "duration_s": round(record.duration, 6),
        "declared": list(record.extra.get("declared") or ()),
        "trusted": list(record.extra.get("trusted") or ()),
    }
