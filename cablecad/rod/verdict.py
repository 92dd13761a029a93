"""What to say of a solved shape: the rules it breaks, of the tube itself and of the user, and what to be warned of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from cablecad.model import Cable
from cablecad.rod.stability import Judged


@dataclass(frozen=True)
class Violation:
    """One broken rule.

    Attributes:
        rule: "curvature" (kappa r >= 1) and "self_gap" (< 0) make the tube cut into itself; "min_bend_radius" is the
            user's own.
        message: What is broken, with the numbers, and what to do.
    """

    rule: Literal["curvature", "self_gap", "min_bend_radius"]
    message: str

    @property
    def spoils_tube(self) -> bool:
        """Whether no valid solid can be made."""
        return self.rule != "min_bend_radius"


def find_violations(
    cable: Cable, bend_radius_min: float | None, at: float | None, self_gap: float | None
) -> tuple[Violation, ...]:
    """The rules that a centreline with this least bend radius [mm] (at arclength `at`) and self-gap [mm] breaks."""
    found = []
    radius = cable.diameter / 2.0
    if bend_radius_min is not None and bend_radius_min <= radius:
        found.append(
            Violation(
                "curvature",
                f"curvature: the least bend radius {bend_radius_min:.6g} mm at s = {at:.6g} mm is not more than the "
                f"cable's own radius {radius:.6g} mm, so its inner side folds over; "
                "take a thinner cable or a wider bend",
            )
        )
    if self_gap is not None and self_gap < 0.0 and not cable.allow_contact:
        found.append(
            Violation(
                "self_gap",
                f"self_gap: parts of the cable overlap by {-self_gap:.6g} mm; take a thinner cable, another length or "
                "another equilibrium, or set allow_contact = true to let it cut itself",
            )
        )
    rule = cable.min_bend_radius
    if rule is not None and bend_radius_min is not None and bend_radius_min < rule:
        found.append(
            Violation(
                "min_bend_radius",
                f"min_bend_radius: the least bend radius {bend_radius_min:.6g} mm at s = {at:.6g} mm is below the "
                f"rule of {rule:.6g} mm; make the cable longer or move its ends",
            )
        )
    return tuple(found)


def find_warnings(
    cable: Cable, stability: Judged, self_gap: float | None, weight_ratio: float | None
) -> tuple[str, ...]:
    """What a user should know of a shape that breaks no rule.

    Args:
        cable: What was asked.
        stability: Of the chosen equilibrium.
        self_gap: Of the chosen equilibrium [mm], or None.
        weight_ratio: Weight times length squared per EI, or None.
    """
    found = []
    if not stability.stable_in_plane:
        found.append("the chosen equilibrium is unstable in its plane: a real cable does not stay in it")
    elif not stability.stable_out_of_plane:
        spin = "held by both ends" if stability.spin == "clamped" else "free"
        found.append(
            f"the chosen equilibrium is unstable out of its plane (margin {stability.out_of_plane:.3g}, spin {spin}): "
            "compression and curvature outweigh its stiffness, and it lowers its energy by leaving the plane; it holds "
            "where something, such as a panel, keeps it in the plane"
        )
    if self_gap is not None and self_gap < 0.0 and cable.allow_contact:
        found.append(
            f"parts of the cable overlap by {-self_gap:.6g} mm, which allow_contact lets through: the solid cuts itself"
        )
    if weight_ratio is not None and weight_ratio > 1.0:
        found.append(
            f"gravity is not modelled, and the cable's weight times its length squared is {weight_ratio:.3g} of its "
            "bending stiffness (above 1): a real cable sags from this shape"
        )
    return tuple(found)
