"""Contact law: springs and dashpots at each corner, as settings of a study and with their constants."""

import math
from typing import Final, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from overturning.arrays import ArrayLike, FloatArray
from overturning.errors import ArgumentError
from overturning.model.solid import RigidSolid
from overturning.quantities import DampingInNSPerM, StiffnessInNPerM
from overturning.units import STANDARD_GRAVITY
from overturning.validation import StrictModel, make_constructor_raise_argument_errors

DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO: Final = 1e-7
"""Default δ/B of a 2-D block, which with `DEFAULT_CONTACT_DAMPING_RATIO` behaves like a rigid one (docs/method.md)."""

DEFAULT_3D_STATIC_PENETRATION_TO_WIDTH_RATIO: Final = 2e-6
"""Default δ/B of a 3-D body. A stiffer contact does not make its falls more certain (docs/design-notes.md)."""

DEFAULT_CONTACT_DAMPING_RATIO: Final = 3.0
"""Default damping ratio ξ. A landing corner does not rebound, as in Housner's model (docs/method.md)."""

MIN_WIDTH_FOR_CONSTANT_PENETRATION_M: Final = 1.0
"""Width B above which the static penetration of a 3-D body stays constant, m.

The elastic displacement before slip is a length, and would otherwise grow with the body."""

MIN_PENETRATION_TO_ROUNDING_ERROR_RATIO: Final = 1e5
"""Least ratio of static penetration δ to the rounding error of a coordinate: the static force has five digits."""


MAX_CONTACT_DAMPING_RATIO: Final = 1e6
"""Largest damping ratio ξ: with more, a landing lasts so long that a case takes minutes."""


class ContactSettings(StrictModel):
    """Settings of the springs and dashpots at a corner: normal stiffness, tangential/normal ratio, and damping."""

    stiffness: Literal["auto"] | StiffnessInNPerM = Field(
        default="auto",
        description="normal spring K_n per corner (2-D: and metre of depth), N/m; auto: static penetration of 1e-7 B "
        "(2-D) or 2e-6 B (3-D)",
    )
    stiffness_ratio: float = Field(default=1.0, ge=0, description="tangential over normal stiffness, K_s/K_n")
    damping_ratio: float | None = Field(
        default=None,
        ge=0,
        le=MAX_CONTACT_DAMPING_RATIO,
        description=f"damping ratio ξ of heave of the supported weight; {DEFAULT_CONTACT_DAMPING_RATIO:g} if neither "
        "this nor `damping` is given",
    )
    damping: DampingInNSPerM | None = Field(
        default=None, ge=0, description="dashpot h per corner (2-D: and metre of depth) instead of the ratio, N·s/m"
    )

    @model_validator(mode="after")
    def _check_damping_and_stiffness(self) -> Self:
        """Raise a ValueError if both a damping ratio and a dashpot are given, or the stiffness is not positive."""
        if self.damping_ratio is not None and self.damping is not None:
            raise ValueError("damping_ratio and damping are both given; keep one")
        if self.stiffness != "auto" and self.stiffness <= 0:
            raise ValueError(f"stiffness {self.stiffness:g} N/m; it must be above 0, or auto")
        return self

    def with_defaults(self, default_settings: Self) -> Self:
        """Return these settings completed by defaults; a given damping ratio or dashpot replaces both defaults."""
        damping = {"damping_ratio", "damping"}
        replaced = self.model_fields_set | (damping if self.model_fields_set & damping else set())
        kept = default_settings.model_dump(exclude=replaced)
        return type(self)(**kept | self.model_dump(include=self.model_fields_set))


@make_constructor_raise_argument_errors
class Contact(ContactSettings):
    """Contact law of a block: springs and dashpots at each corner, per metre of depth.

    Parameters
    ----------
    stiffness : float or "auto"
        Normal stiffness K_n of a corner, N/m. "auto" chooses K_n such that the static penetration
        δ = m g / (2 K_n) is `static_penetration` · B.
    stiffness_ratio : float
        Tangential over normal stiffness K_s/K_n.
    damping_ratio : float, optional
        Damping ratio ξ of heave on both corners; the dashpot is h = 2 ξ √(K_n m / 2).
        `DEFAULT_CONTACT_DAMPING_RATIO` if neither this nor `damping` is given.
    damping : float, optional
        Dashpot h, N·s/m.
    static_penetration : float
        δ/B for ``stiffness="auto"``.

    Raises
    ------
    ArgumentError
        If a value is outside its bounds, if both `damping_ratio` and `damping` are given, or both a stiffness and a
        static penetration.
    """

    static_penetration: float = Field(
        default=DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO,
        gt=0,
        description="stiffness auto: static penetration as a share of the width of the contact",
    )

    @model_validator(mode="after")
    def _check_stiffness_and_penetration_not_both_given(self) -> Self:
        """Raise a ValueError if both a stiffness and a static penetration are given."""
        if self.stiffness != "auto" and self.static_penetration != DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO:
            raise ValueError(
                f"static_penetration {self.static_penetration:g} and stiffness {self.stiffness:g} N/m are both given; "
                "keep one: the penetration is that of stiffness auto"
            )
        return self

    def corner_stiffness_and_damping_per_mass(
        self, width: ArrayLike, height: ArrayLike, density: float
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return normal and tangential stiffness (1/s²) and dashpot (1/s) at each corner, over the block's mass.

        Blocks are 1 m deep.

        Parameters
        ----------
        width, height : array_like
            Width B and height H, m.
        density : float
            Density, kg/m³.

        Returns
        -------
        normal, tangential : ndarray
            K_n/m and K_s/m, 1/s².
        dashpot : ndarray
            h/m, 1/s.
        """
        width = np.asarray(width, dtype=np.float64)
        mass = density * width * np.asarray(height, dtype=np.float64)
        if self.stiffness == "auto":
            normal = STANDARD_GRAVITY / (2.0 * self.static_penetration * width)
        else:
            normal = float(self.stiffness) / mass
        if self.damping is not None:
            dashpot = self.damping / mass
            if (dashpot > 2.0 * MAX_CONTACT_DAMPING_RATIO * np.sqrt(0.5 * normal)).any():
                largest = float((2.0 * MAX_CONTACT_DAMPING_RATIO * np.sqrt(0.5 * normal) * mass).min())
                raise ArgumentError(
                    f"damping: {self.damping:g} N·s/m; it must be at most {largest:.3g}, a damping ratio of "
                    f"{MAX_CONTACT_DAMPING_RATIO:g}"
                )
        else:
            ratio = DEFAULT_CONTACT_DAMPING_RATIO if self.damping_ratio is None else self.damping_ratio
            dashpot = 2.0 * ratio * np.sqrt(0.5 * normal)
        return normal, self.stiffness_ratio * normal, dashpot


@make_constructor_raise_argument_errors
class VertexContact(StrictModel):
    """Contact law of a 3-D body: springs and dashpots at each vertex.

    Parameters
    ----------
    static_penetration : float
        δ/B, where δ = m g / (n K_n) is the static penetration if n vertices share the weight
        (`RigidSolid.assumed_weight_sharing_point_count`), and B is twice the least distance between an edge of
        the base and the point below the centre, at most `MIN_WIDTH_FOR_CONSTANT_PENETRATION_M`.
    stiffness_ratio : float
        K_s/K_n for each of the two tangential springs.
    damping_ratio : float
        Damping ratio ξ of heave on these n vertices; the dashpot is h = 2 ξ √(K_n m / n).

    Raises
    ------
    ArgumentError
        If a value is outside its bounds.
    """

    static_penetration: float = Field(default=DEFAULT_3D_STATIC_PENETRATION_TO_WIDTH_RATIO, gt=0)
    stiffness_ratio: float = Field(default=1.0, ge=0)
    damping_ratio: float = Field(default=DEFAULT_CONTACT_DAMPING_RATIO, ge=0, le=MAX_CONTACT_DAMPING_RATIO)

    def corner_stiffness_and_damping_per_mass(self, body: RigidSolid) -> tuple[float, float, float]:
        """Return normal and shear stiffness of a vertex per body mass, 1/s², and its dashpot per body mass, 1/s."""
        points = body.assumed_weight_sharing_point_count
        normal = STANDARD_GRAVITY / (
            points
            * self.static_penetration
            * min(2.0 * body.min_base_edge_distance_from_centre, MIN_WIDTH_FOR_CONSTANT_PENETRATION_M)
        )
        return normal, self.stiffness_ratio * normal, 2.0 * self.damping_ratio * math.sqrt(normal / points)


def check_static_penetration_exceeds_rounding(
    normal_stiffness_per_mass_by_case: FloatArray, height_by_case: FloatArray, largest_block_displacement: float
) -> None:
    """Raise an `ArgumentError` if a contact is so stiff that double precision cannot resolve its static penetration.

    Parameters
    ----------
    normal_stiffness_per_mass_by_case : ndarray
        Normal stiffness per mass K_n/m, 1/s².
    height_by_case : ndarray
        Height H, m.
    largest_block_displacement : float
        Largest displacement of the block, m.

    Raises
    ------
    ArgumentError
        If δ = m g / (2 K_n) is below `MIN_PENETRATION_TO_ROUNDING_ERROR_RATIO` · ε · max(H, largest displacement),
        with ε the machine epsilon.
    """
    penetration = STANDARD_GRAVITY / (2.0 * normal_stiffness_per_mass_by_case)
    bound = (
        MIN_PENETRATION_TO_ROUNDING_ERROR_RATIO
        * np.finfo(np.float64).eps
        * np.maximum(height_by_case, largest_block_displacement)
    )
    if (penetration < bound).any():
        worst = int(np.argmin(penetration / bound))
        raise ArgumentError(
            f"stiffness: static penetration {penetration.flat[worst]:.3g} m is below {bound.flat[worst]:.3g} m, "
            f"the least that float64 resolves for a block {height_by_case.flat[worst]:g} m high; choose a softer "
            "contact"
        )
