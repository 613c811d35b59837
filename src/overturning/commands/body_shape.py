"""Shape of the 3-D body of `overturning one`: a prism, or a scan of a stone."""

import math
from typing import TYPE_CHECKING, Any

from overturning.commands.declared import BodyOptionsOfCommandOne

if TYPE_CHECKING:
    from overturning.model.shapes import Shape


def create_body_shape_and_scan_description_lines(
    body_options: BodyOptionsOfCommandOne, density_kg_m3: float | None
) -> "tuple[Shape, list[str]]":
    """Create the shape of a 3-D body from options; also return lines of text that describe a scan, [] without one."""
    from overturning.errors import ArgumentError
    from overturning.model.shapes import shape_from_name_or_sides

    if body_options.mesh is None:
        if body_options.mesh_unit is not None or body_options.relief is not None:
            raise ArgumentError("--mesh-unit, --relief: only for a mesh; add --mesh")
        plan: Any = body_options.plan or "rectangle"
        return shape_from_name_or_sides(int(plan) if plan.isdecimal() else plan, "--plan"), []
    if body_options.plan is not None:
        raise ArgumentError("--plan, --mesh: both given; leave one out")
    from overturning.model.mesh import UNITS_PER_METRE, read_scanned_stone
    from overturning.units import DEFAULT_STONE_DENSITY_KG_M3

    unit: Any = body_options.mesh_unit
    if unit is not None and unit not in UNITS_PER_METRE:
        raise ArgumentError(f"--mesh-unit: {unit!r}; give m, cm or mm")
    if density_kg_m3 is not None and not 0.0 < density_kg_m3 < math.inf:
        raise ArgumentError(f"--density: {density_kg_m3:g} kg/m³; it must be above 0 and finite")
    scan = read_scanned_stone(body_options.mesh, unit, body_options.relief)
    return scan.shape, scan.description_lines(DEFAULT_STONE_DENSITY_KG_M3 if density_kg_m3 is None else density_kg_m3)
