"""What a cable is in itself: its cross-section and its material."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

from cablecad.errors import Mistake
from cablecad.model.values import LARGEST, RANGES, SMALLEST, Checked, number_mistakes


@dataclass(frozen=True, slots=True)
class Section(Checked):
    """A solid circular cross-section.

    Attributes:
        diameter: Outer diameter [mm].
    """

    diameter: float

    def _mistakes(self) -> Iterator[Mistake]:
        yield from number_mistakes("diameter", self.diameter, RANGES["diameter"])

    @property
    def radius(self) -> float:
        """Outer radius [mm]."""
        return self.diameter / 2.0

    @property
    def area(self) -> float:
        """Area [mm^2]."""
        return math.pi * self.radius**2

    @property
    def second_moment(self) -> float:
        """Second moment of area about a diameter [mm^4]."""
        return math.pi * self.diameter**4 / 64.0


@dataclass(frozen=True, slots=True)
class Material(Checked):
    """What the cable is made of: by its moduli, or by the stiffnesses measured on the cable itself.

    A stranded cable is far softer than a solid rod of its diameter: measured stiffnesses are the better input.

    Attributes:
        youngs_modulus: Young's modulus of the solid circle of the cable's diameter [MPa].
        poissons_ratio: Poisson's ratio; with `youngs_modulus` it gives the torsional stiffness.
        bending_stiffness: EI as measured [N mm^2]; instead of `youngs_modulus`.
        torsional_stiffness: GJ as measured [N mm^2].
        mass_per_length: [kg/m], only to judge whether gravity may be left out.
    """

    youngs_modulus: float | None = None
    poissons_ratio: float | None = None
    bending_stiffness: float | None = None
    torsional_stiffness: float | None = None
    mass_per_length: float | None = None

    def _mistakes(self) -> Iterator[Mistake]:
        yield from material_mistakes({key: getattr(self, key) for key in self.__slots__})

    def EI(self, section: Section) -> float:
        """Bending stiffness [N mm^2]."""
        if self.bending_stiffness is not None:
            return self.bending_stiffness
        assert self.youngs_modulus is not None  # one of the two was checked to be there
        return self.youngs_modulus * section.second_moment

    def GJ(self, section: Section) -> float | None:
        """Torsional stiffness [N mm^2], or None where nothing tells it."""
        if self.torsional_stiffness is not None:
            return self.torsional_stiffness
        if self.poissons_ratio is None:
            return None
        return self.EI(section) / (1.0 + self.poissons_ratio)


def stiffness_mistakes(material: Material, diameter: float) -> Iterator[Mistake]:
    """Check that a diameter, which goes into the stiffness by its fourth power, leaves one to compute with."""
    if any(number_mistakes("diameter", diameter, RANGES["diameter"], sized=True)):
        return  # that was said
    try:
        EI = material.EI(Section(diameter))
    except OverflowError:
        EI = math.inf
    if not SMALLEST < EI < LARGEST:
        problem = f"gives with this material a bending stiffness of {EI:.3g} N mm^2, which cannot be computed with"
        yield Mistake("diameter", problem, diameter)


def material_mistakes(given: Mapping[str, object], unreadable: Collection[str] = ()) -> Iterator[Mistake]:
    """What is wrong with a material of which `given` are the readable values by field name.

    A check that needs a value of a field of `unreadable` is left out: its mistake was reported where it was read.
    """
    known = {key: value for key, value in given.items() if value is not None and key not in unreadable}
    present = {*known, *unreadable}
    for key, value in known.items():
        yield from number_mistakes(key, value, RANGES[key], sized=key != "poissons_ratio")
    stiffness = {"youngs_modulus", "bending_stiffness"} & present
    if len(stiffness) == 2:
        yield Mistake("", "give either youngs_modulus or bending_stiffness, and not both")
    elif not stiffness:
        yield Mistake("", "needs youngs_modulus [MPa], or bending_stiffness [N mm^2] as measured on the cable")
    if "poissons_ratio" in known:
        if "torsional_stiffness" in present:
            problem = "give either poissons_ratio or torsional_stiffness, and not both"
            yield Mistake("poissons_ratio", problem, known["poissons_ratio"])
        elif "youngs_modulus" not in present:
            yield Mistake(
                "poissons_ratio", "needs youngs_modulus; or give torsional_stiffness", known["poissons_ratio"]
            )
