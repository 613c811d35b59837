"""Say of files what they are: records that can be read, with what was found and compared, or the reason why not."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from overturning.errors import OverturningError
from overturning.motion.integration import peaks
from overturning.records.assembly import VerticalSense, assemble
from overturning.records.component import Component, largest
from overturning.records.grouping import group_components
from overturning.records.options import ReadOptions
from overturning.records.read import read_files
from overturning.records.record import Record
from overturning.records.source import SourceFile, read_source


@dataclass(frozen=True)
class Finding:
    """What was found of one record."""

    files: tuple[str, ...]
    components: tuple[Component, ...] = ()  # its axes; empty where the file cannot be read
    record: Record | None = None  # where it can be read
    reason: str = ""  # why not, otherwise


def check_paths(
    paths: Iterable[Path],
    *,
    options: ReadOptions | None = None,
    azimuths_deg: Sequence[float] | None = None,
    trust_data: bool = False,
    vertical_sense: VerticalSense | None = None,
) -> list[Finding]:
    """Read files and folders, sort their components into records, and check each; options as in `assemble`.

    Files that cannot be read come first, then records in the order of their files.
    """
    sources, findings = _sources(paths)
    options = (options or ReadOptions()).with_metadata_of(sources)
    components: list[Component] = []
    for source in sources:
        if source in options.metadata:
            continue
        try:
            components += read_files([source], None, options)
        except OverturningError as problem:
            findings.append(Finding((source.name,), reason=str(problem)))
    for group in group_components(components):
        files = tuple(dict.fromkeys(c.file for c in group))
        name = Path(files[0]).name.split(".")[0].lower()
        try:
            record = assemble(
                group, record_id=name, azimuths_deg=azimuths_deg, trust_data=trust_data, vertical_sense=vertical_sense
            )
        except OverturningError as problem:
            findings.append(Finding(files, tuple(group), reason=str(problem)))
        else:
            findings.append(Finding(files, tuple(group), record))
    return findings


def _sources(paths: Iterable[Path]) -> tuple[list[SourceFile], list[Finding]]:
    sources, findings = [], []
    for path in paths:
        members = sorted(p for p in path.iterdir() if p.is_file()) if path.is_dir() else [path]
        if not members:
            findings.append(Finding((path.name,), reason=f"{path}: an empty folder"))
        for member in members:
            try:
                sources.append(read_source(member))
            except OverturningError as problem:
                findings.append(Finding((member.name,), reason=str(problem)))
    return sources, findings


def describe(finding: Finding) -> str:
    """A finding as a few lines of text."""
    head = ", ".join(finding.files)
    record = finding.record
    if record is None:
        axes = "".join(f"\n  {_axis(c)}" for c in finding.components)
        return f"{head}\n  refused: {finding.reason}{axes}"
    pga, pgv, pgd = peaks(record.horizontal, record.sampling_interval)
    place = "" if record.latitude is None else f" ({record.latitude:.4f}, {record.longitude:.4f})"
    what = [x for x in (record.station + place, record.event, record.start or "start not stated") if x.strip()]
    kind = "processed by its agency" if record.extra.get("processed") else "raw"
    lines = [
        head,
        f"  {record.extra['format']}, {kind}: {'; '.join(what)}",
        f"  {record.north.size} samples every {record.sampling_interval:g} s, "
        f"{'with' if record.up is not None else 'without'} vertical component",
        *(f"  {_axis(c)}" for c in finding.components),
        f"  north and east: PGA {pga * 100:.1f} Gal, PGV {pgv * 100:.1f} cm/s, PGD {pgd * 100:.1f} cm as the file is",
    ]
    return "\n".join(lines)


def _axis(component: Component) -> str:
    sense = {1: "up", -1: "down", 0: "direction unknown"}[component.vertical]
    direction = f"azimuth {component.azimuth_deg:g}" if component.azimuth_deg is not None else sense
    text = f"{component.axis}: {direction}, {component.samples.size} samples, peak {largest(component) * 100:.4g} Gal"
    peak = component.peak
    if peak is None:
        return text + ", header states none"
    difference = abs(largest(component) - peak.value) / peak.value if peak.value else 0.0
    return text + f", header {peak.value * 100:.4g} Gal ({difference * 100:.2f} % apart)"
