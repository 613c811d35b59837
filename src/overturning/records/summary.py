"""Processing steps in words, for people."""

from collections.abc import Mapping
from typing import Any


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
        case "scale":
            return f"times {step['factor']:g}"
        case other:
            return str(other)
