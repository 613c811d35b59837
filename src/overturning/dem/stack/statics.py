"""Statics of a 3-D stack: contact constants, pose at rest, highest frequency, and the acceleration that moves it."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.kernel.mechanics import FLAT_LANDING_DURATION_IN_DECAY_TIMES
from overturning.dem.linear import solve_positive_definite_system
from overturning.dem.stack.landing import (
    MIN_RIM_DISTANCE_TO_DEFER_CORNER_CONTACT_TO_WIDTH,
    RIM_DISTANCE_MARKING_NO_CONTACT_DEFERRAL_M,
)
from overturning.dem.stack.tables import JOINT_TABLE_DTYPE, STONE_TABLE_DTYPE
from overturning.model.contact import MIN_WIDTH_FOR_CONSTANT_PENETRATION_M, VertexContact
from overturning.model.stack_stones import (
    ContactPatchAndMassAboveAtRest,
    StackStone,
    contact_patches_at_rest,
    polygon_side_distances_from_point,
)
from overturning.units import STANDARD_GRAVITY

MIN_FALL_TILT_THRESHOLD_OF_STONE_RAD: Final = np.pi / 3.0
"""Tilt at which a stone has fallen, rad, or the mean of 90° and the critical angle of its base, whichever is more."""


@dataclass(frozen=True)
class ContactSpringsAndPatchesOfStack:
    """Constants, penetration at rest and patch of the contact below each stone of a stack, from the lowest stone up."""

    joint_table: NDArray[np.void]  # constants, of type `JOINT_TABLE_DTYPE`, without friction; shape (joints,)
    mean_penetration_at_rest: FloatArray  # mean penetration at rest, m, shape (joints,)
    contact_patches: list[ContactPatchAndMassAboveAtRest]

    @property
    def dashpot_to_stiffness_ratios(self) -> FloatArray:
        """Ratio of the normal dashpot to the normal stiffness of each contact, s."""
        return np.asarray(self.joint_table["normal_dashpot"] / self.joint_table["normal_stiffness"])

    @property
    def nearest_side_distances_from_projected_mass_centre(self) -> FloatArray:
        """Horizontal distance of the mass centre of all stones above each contact from its nearest side, m."""
        return np.array([patch.side_distances_from_mass_centre_above.min() for patch in self.contact_patches])

    @property
    def heights_of_centre_of_all_stones_above_joints(self) -> FloatArray:
        """Height, above each contact, of the common centre of mass of all stones above the contact, m."""
        return np.array([patch.height_of_centre_of_all_mass_above for patch in self.contact_patches])


def joint_constants_of_stack(
    stones: list[StackStone], default_joint_contact_properties: VertexContact
) -> ContactSpringsAndPatchesOfStack:
    """Return the contact constants of a stack; the stiffness is M g/δ with the mass M above and penetration δ."""
    rows, patches = np.zeros(len(stones), JOINT_TABLE_DTYPE), contact_patches_at_rest(stones)
    above = np.array([patch.mass_above for patch in patches])
    width = np.array([np.ptp(patch.corners_xy_in_stack_axes, axis=0).min() for patch in patches])
    penetration = default_joint_contact_properties.static_penetration * np.minimum(
        width, MIN_WIDTH_FOR_CONSTANT_PENETRATION_M
    )
    ratio, damping = (
        np.array([own if (given := getattr(stone, name)) is None else given for stone in stones])
        for name, own in (
            ("tangential_to_normal_stiffness_of_joint_below", default_joint_contact_properties.stiffness_ratio),
            ("base_joint_damping_ratio", default_joint_contact_properties.damping_ratio),
        )
    )
    stiffness = above * STANDARD_GRAVITY / penetration
    dashpot = 2.0 * damping * np.sqrt(stiffness * above)
    rows["normal_stiffness"], rows["normal_dashpot"], rows["tangential_dashpot"] = stiffness, dashpot, dashpot
    rows["tangential_stiffness"] = ratio * stiffness
    rows["tangential_compliance_or_zero_without_spring"] = np.where(
        ratio > 0.0, 1.0 / np.maximum(rows["tangential_stiffness"], 1e-300), 0.0
    )
    rows["flat_landing_duration_s"] = FLAT_LANDING_DURATION_IN_DECAY_TIMES * dashpot / stiffness
    rows["upper_base_corner_count"] = [len(stone.base_corners_xy_from_centre_of_mass) for stone in stones]
    rows["min_rim_distance_to_defer_flat_landing_contact"] = np.where(
        [len(stone.base_corners_xy_from_centre_of_mass) > 4 for stone in stones],
        MIN_RIM_DISTANCE_TO_DEFER_CORNER_CONTACT_TO_WIDTH * width,
        RIM_DISTANCE_MARKING_NO_CONTACT_DEFERRAL_M,
    )
    table = ContactSpringsAndPatchesOfStack(rows, penetration, patches)
    _fill_in_contact_loads_at_rest(stones, table)
    return table


def stone_constants_and_initial_states_table(
    stones: list[StackStone], joint_constants: ContactSpringsAndPatchesOfStack
) -> NDArray[np.void]:
    """Return constants and initial states of a stack's stones at rest, of type `STONE_TABLE_DTYPE`, shape (stones,)."""
    table, level = np.zeros(len(stones), STONE_TABLE_DTYPE), 0.0
    pose = static_displacements_and_rotations(stones, joint_constants)
    pairs = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
    for stone, row, depth, shift, patch in zip(
        stones, table, joint_constants.mean_penetration_at_rest, pose, joint_constants.contact_patches, strict=True
    ):
        inverse = inverse_of_inertia_with_only_xz_product(stone.inertia_per_mass)
        for name, at in pairs.items():
            row[f"inertia_per_mass_{name}"], row[f"mass_times_inverse_inertia_{name}"] = (
                stone.inertia_per_mass[at],
                inverse[at],
            )
        reach = stone.nearest_base_side_distance
        row["mass"], row["centre_height"], row["upper_face_height_above_centre"], row["nearest_base_side_distance"] = (
            stone.mass,
            stone.centre_height_above_base,
            stone.upper_face_height_above_centre,
            reach,
        )
        ahead, height = side_distance_and_height_of_tipping_mass_centre(stone, patch)
        row["critical_lean_squared_sine_on_contact_at_rest"] = ahead**2 / (ahead**2 + height**2)
        row["critical_lean_squared_sine_on_whole_base"] = reach**2 / (reach**2 + stone.centre_height_above_base**2)
        tilt = max(
            MIN_FALL_TILT_THRESHOLD_OF_STONE_RAD,
            0.5 * (np.arctan2(reach, stone.centre_height_above_base) + 0.5 * np.pi),
        )
        row["fall_tilt_cosine"] = np.round(np.cos(tilt), 12)
        centre = level + stone.centre_height_above_base
        half = 0.5 * shift[3:]
        start = row["start"]
        start["x"], start["y"], start["z"] = stone.centre_of_mass_x_at_rest + shift[0], shift[1], centre + shift[2]
        start["qw"], start["qx"], start["qy"], start["qz"] = np.array([1.0, *half]) / np.sqrt(1.0 + np.sum(half**2))
        row["centre_height_at_rest"], row["max_centre_drop_without_fall"] = (
            start["z"],
            max(stone.fall_threshold_drop, 2.0 * depth),
        )
        level += stone.centre_height_above_base + stone.upper_face_height_above_centre
    return table


def side_distance_and_height_of_tipping_mass_centre(
    stone: StackStone, contact_patch: ContactPatchAndMassAboveAtRest
) -> tuple[float, float]:
    """Return the distance and height (m) of the centre of mass that tips over the nearest side of a contact.

    The distance is horizontal, from this side to the centre; the height is that above the contact. The centre is that
    of the stone on the contact. If it lies outside the contact, so that stones above hold the stone down, the common
    centre of all stones above the contact is taken.
    """
    base = stone.nearest_base_side_distance
    side = float(
        polygon_side_distances_from_point(contact_patch.corners_xy_in_stack_axes, stone.centre_of_mass_x_at_rest).min()
    )
    if side <= 0.0:
        return float(
            contact_patch.side_distances_from_mass_centre_above.min()
        ), contact_patch.height_of_centre_of_all_mass_above
    # Where the whole base rests on the face below, its sides are those of the patch but for rounding.
    return (side if side < base * (1.0 - 1e-9) else base), stone.centre_height_above_base


def base_x_relative_to_support_centre_at_rest(stone_table_by_stack: NDArray[np.void]) -> FloatArray:
    """Return x (m) of each stone's base at rest, along its support from its support's centre, shape (stacks, stones).

    `stone_table_by_stack` has the type `overturning.dem.stack.tables.STONE_TABLE_DTYPE`. The lean at rest of stones
    that stand off centre is taken into account.
    """
    start = stone_table_by_stack["start"]
    lean = 2.0 * np.arctan2(start["qy"], start["qw"])
    below = [np.concatenate([np.zeros_like(column[:, :1]), column[:, :-1]], axis=1)
             for column in (start["x"], start["z"], lean)]  # fmt: skip
    apart, above, tilt = (column - under for column, under in zip((start["x"], start["z"], lean), below, strict=True))
    return np.cos(below[2]) * apart - np.sin(below[2]) * above - stone_table_by_stack["centre_height"] * np.sin(tilt)


def inverse_of_inertia_with_only_xz_product(inertia_tensor: FloatArray) -> FloatArray:
    """Return the inverse of an inertia tensor in which only the x–z product of inertia is not zero."""
    (xx, _, xz), (_, yy, _), (_, _, zz) = inertia_tensor
    area = xx * zz - xz * xz
    return np.array([[zz / area, 0.0, -xz / area], [0.0, 1.0 / yy, 0.0], [-xz / area, 0.0, xx / area]])


def kernel_rows_of_face_corners(face_corners_xy: FloatArray) -> FloatArray:
    """Return the corners of a convex face, given as (n, 2) in m, as kernel rows with the fields of `FaceCorner`."""
    side = np.roll(face_corners_xy, -1, axis=0) - face_corners_xy
    length = np.sqrt((side**2).sum(axis=1))
    normal = np.stack([side[:, 1], -side[:, 0]], axis=1) / length[:, None]
    reach = (normal * face_corners_xy).sum(axis=1)
    share = 0.5 * (length + np.roll(length, 1)) / length.sum()
    return np.column_stack([face_corners_xy, normal, reach, share])


def _relative_displacement_matrix_at_corner(
    stones: list[StackStone], joint_index: int, corner_xy: FloatArray
) -> FloatArray:
    """Return the 3 × 6n matrix from n stones' motions to the relative displacement of two stones at a corner.

    The motion of a stone is its displacement (m) and its rotation (rad); `corner_xy` has the horizontal position, m.
    """
    matrix = np.zeros((3, 6 * len(stones)))
    for index, sign in ((joint_index, 1.0), (joint_index - 1, -1.0)):
        if index >= 0:
            stone = stones[index]
            x = corner_xy[0] - stone.centre_of_mass_x_at_rest
            y = corner_xy[1]
            z = -stone.centre_height_above_base if index == joint_index else stone.upper_face_height_above_centre
            matrix[:, 6 * index : 6 * index + 6] += [
                [sign, 0.0, 0.0, 0.0, sign * z, -sign * y],
                [0.0, sign, 0.0, -sign * z, 0.0, sign * x],
                [0.0, 0.0, sign, sign * y, -sign * x, 0.0],
            ]
    return matrix


def scaled_stiffness_matrix_of_stack_at_rest(
    stones: list[StackStone],
    joint_constants: ContactSpringsAndPatchesOfStack,
    unit_mass_scale_factors: FloatArray,
    corner_carries_load_by_joint: list[NDArray[np.bool_]] | None = None,
) -> FloatArray:
    """Return the stiffness matrix of a stack at rest, shape (6 n, 6 n), scaled on both sides to a unit mass matrix.

    `corner_carries_load_by_joint`, one array per joint, is False for corners of the patches that carry no load.
    """
    matrix = np.zeros((unit_mass_scale_factors.size, unit_mass_scale_factors.size))
    for k, patch in enumerate(joint_constants.contact_patches):
        for number, (corner, weight) in enumerate(
            zip(patch.corners_xy_in_stack_axes, patch.corner_stiffness_shares, strict=True)
        ):
            normal = weight * joint_constants.joint_table["normal_stiffness"][k]
            tangential = weight * joint_constants.joint_table["tangential_stiffness"][k]
            if corner_carries_load_by_joint is None or corner_carries_load_by_joint[k][number]:
                each = _relative_displacement_matrix_at_corner(stones, k, corner) * unit_mass_scale_factors
                matrix += np.einsum("ij,i,ik->jk", each, np.array([tangential, tangential, normal]), each)
    return matrix


def scale_factors_for_unit_mass_diagonal(stones: list[StackStone]) -> FloatArray:
    """Return the factors that scale a stack's unknowns to a mass matrix with unit diagonal, shape (6 n,)."""
    return np.concatenate([
        1.0 / np.sqrt(stone.mass * np.array([1.0, 1.0, 1.0, *np.diag(stone.inertia_per_mass)])) for stone in stones
    ])  # fmt: skip


def eigenvalue_bound_factor_for_inertia_products(stones: list[StackStone]) -> float:
    """Return an upper bound of the factor by which products of inertia raise a stack's highest ω².

    `scale_factors_for_unit_mass_diagonal` leaves these products out. With the largest ρ = |I_xz|/√(I_xx I_zz) of all
    stones, the least eigenvalue of the scaled mass matrix is 1 − ρ, and the factor is 1/(1 − ρ). It is 1 for
    stones whose outlines are symmetric.
    """
    correlation = [
        abs(stone.inertia_per_mass[0, 2]) / math.sqrt(stone.inertia_per_mass[0, 0] * stone.inertia_per_mass[2, 2])
        for stone in stones
    ]
    return 1.0 / (1.0 - max(correlation))


def static_displacements_and_rotations(
    stones: list[StackStone], joint_constants: ContactSpringsAndPatchesOfStack
) -> FloatArray:
    """Return displacement (m) and rotation (rad) of each stone under its own weight and load, shape (stones, 6).

    A corner of a patch whose spring would pull carries nothing; the other corners then carry more.
    """
    count = len(stones)
    weight = np.zeros(6 * count)
    weight[2::6] = [-stone.mass * STANDARD_GRAVITY for stone in stones]
    scale = scale_factors_for_unit_mass_diagonal(stones)
    loaded = [np.ones(len(patch.corners_xy_in_stack_axes), np.bool_) for patch in joint_constants.contact_patches]
    level = np.zeros((count, 6))
    level[:, 2] = -np.cumsum(joint_constants.mean_penetration_at_rest)
    for _ in range(4 * count):
        shift = solve_positive_definite_system(
            scaled_stiffness_matrix_of_stack_at_rest(stones, joint_constants, scale, loaded), weight * scale
        )
        if shift is None:
            return level  # the stack finds its pose by itself
        shift = shift * scale
        depth = _penetrations_at_patch_corners(stones, joint_constants, shift)
        if all((deep[on] > 0.0).all() for deep, on in zip(depth, loaded, strict=True)):
            return np.asarray(shift.reshape(count, 6))
        loaded = [on & (deep > 0.0) for deep, on in zip(depth, loaded, strict=True)]
    return level


def _penetrations_at_patch_corners(
    stones: list[StackStone], joint_constants: ContactSpringsAndPatchesOfStack, displacements_and_rotations: FloatArray
) -> list[FloatArray]:
    """Return the penetration at the corners of each contact patch of a stack, m; negative at open corners.

    `displacements_and_rotations` holds displacement (m) and rotation (rad) of each stone, shape (6 n,).
    """
    return [
        np.array(
            [
                -(_relative_displacement_matrix_at_corner(stones, k, corner) @ displacements_and_rotations)[2]
                for corner in patch.corners_xy_in_stack_axes
            ]
        )
        for k, patch in enumerate(joint_constants.contact_patches)
    ]


def _fill_in_contact_loads_at_rest(stones: list[StackStone], joint_constants: ContactSpringsAndPatchesOfStack) -> None:
    """Set normal force, centre of pressure and mean distance of forces from that centre in each contact at rest."""
    depths = _penetrations_at_patch_corners(
        stones, joint_constants, static_displacements_and_rotations(stones, joint_constants).ravel()
    )
    for k, (row, patch, depth) in enumerate(
        zip(joint_constants.joint_table, joint_constants.contact_patches, depths, strict=True)
    ):
        force = patch.corner_stiffness_shares * row["normal_stiffness"] * np.maximum(depth, 0.0)
        share = force / force.sum()
        corners = patch.corners_xy_in_stack_axes - np.array(
            [stones[k - 1].centre_of_mass_x_at_rest if k > 0 else 0.0, 0.0]
        )
        centre = share @ corners
        row["normal_force"], (row["pressure_centre_x"], row["pressure_centre_y"]) = force.sum(), centre
        row["mean_distance_of_forces_from_pressure_centre"] = share @ np.sqrt(((corners - centre) ** 2).sum(axis=1))


def spring_energy_at_rest(stones: list[StackStone], joint_constants: ContactSpringsAndPatchesOfStack) -> float:
    """Return the energy of the normal springs of all contacts of a stack that stands at rest, J."""
    depths = _penetrations_at_patch_corners(
        stones, joint_constants, static_displacements_and_rotations(stones, joint_constants).ravel()
    )
    return sum(
        float(np.sum(0.5 * patch.corner_stiffness_shares * stiffness * np.maximum(depth, 0.0) ** 2))
        for patch, stiffness, depth in zip(
            joint_constants.contact_patches, joint_constants.joint_table["normal_stiffness"], depths, strict=True
        )
    )


def no_movement_below_acceleration_g_by_case(
    joint_constants: ContactSpringsAndPatchesOfStack, friction_by_case_and_joint: FloatArray
) -> FloatArray:
    """Return the base acceleration |a|/g below which no contact of a stack opens or slides, shape (n,).

    A contact slides at µ. It opens at the ratio of distance to height of the centre of mass of all stones above it:
    horizontal distance from the nearest side of the contact, and height above the contact.
    """
    return np.minimum(
        float(
            np.min(
                joint_constants.nearest_side_distances_from_projected_mass_centre
                / joint_constants.heights_of_centre_of_all_stones_above_joints
            )
        ),
        friction_by_case_and_joint.min(axis=1),
    )
