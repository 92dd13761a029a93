"""Units of a STEP file, looked at before shapes are made of it: whole, and leading to the metre and the radian.

Open Cascade takes a unit it cannot follow for mm, or for m, and says nothing: the part would be 25.4 or 1000 times too
large or too small. So every unit a shape is given in is followed here, from its context, by way of conversions, to the
unit of SI. A conversion that rests on another one, of which Open Cascade follows the first alone, is made one of SI.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from typing import Protocol, runtime_checkable

from OCP.Standard import Standard_Transient
from OCP.StepBasic import (
    StepBasic_ConversionBasedUnit,
    StepBasic_MeasureWithUnit,
    StepBasic_NamedUnit,
    StepBasic_SiUnit,
    StepBasic_SiUnitName,
    StepBasic_UncertaintyMeasureWithUnit,
)

_LENGTH = "LengthUnit"
_SI = {_LENGTH: StepBasic_SiUnitName.StepBasic_sunMetre, "PlaneAngleUnit": StepBasic_SiUnitName.StepBasic_sunRadian}
"""The quantities shapes are given in, each with its unit of SI."""


@runtime_checkable
class _WithUnits(Protocol):
    """A context that assigns units; Open Cascade's such classes share no base."""

    def NbUnits(self) -> int: ...
    def UnitsValue(self, num: int, /) -> StepBasic_NamedUnit: ...


@runtime_checkable
class _WithUncertainties(Protocol):
    def NbUncertainty(self) -> int: ...
    def UncertaintyValue(self, num: int, /) -> StepBasic_UncertaintyMeasureWithUnit: ...


def has_length(context: Standard_Transient) -> bool:
    """Whether a context says what its lengths are in; Open Cascade takes them for mm where it does not."""
    return any(_quantity(unit) == _LENGTH for unit in _units(context))


def settle_units(
    context: Standard_Transient, failed: Collection[Standard_Transient]
) -> tuple[Standard_Transient, str] | None:
    """Follow every unit of a context to SI, and make conversions that rest on others rest on SI.

    Args:
        context: Of a shape.
        failed: Entities of which Open Cascade could not read everything.

    Returns:
        The first entity that is not as it must be, and what is wrong with it; or None.
    """
    if context in failed:
        return context, "its units cannot be read"
    for unit in _units(context):
        wrong = _settle(unit, failed)
        if wrong:
            return wrong
    if isinstance(context, _WithUncertainties):
        for i in range(1, context.NbUncertainty() + 1):
            if context.UncertaintyValue(i) in failed:
                return context.UncertaintyValue(i), "its value or its unit cannot be read"
    return None


def _units(context: Standard_Transient) -> Iterator[StepBasic_NamedUnit]:
    if isinstance(context, _WithUnits):
        for i in range(1, context.NbUnits() + 1):
            yield context.UnitsValue(i)


def _settle(unit: StepBasic_NamedUnit, failed: Collection[Standard_Transient]) -> tuple[Standard_Transient, str] | None:
    quantity = _quantity(unit)
    passed: list[StepBasic_MeasureWithUnit] = []
    factor, base = 1.0, unit
    while isinstance(base, StepBasic_ConversionBasedUnit):
        if base in failed:
            return base, "its factor or its name cannot be read"
        measure = base.ConversionFactor()
        if measure in failed or not isinstance(measure, StepBasic_MeasureWithUnit):
            return base, "its factor is no measure that can be read"
        if measure in passed:
            return base, "its factor leads back to itself"
        value, under = measure.ValueComponent(), measure.UnitComponent().Value()
        if not (math.isfinite(value) and value > 0.0):
            return base, f"its factor is {value:g}, not above 0"
        if (quantity in _SI or _quantity(under) in _SI) and _quantity(under) != quantity:
            return base, f"its factor is in {_quantity(under) or 'nothing'}, not in {quantity}"
        if not isinstance(under, StepBasic_NamedUnit):
            return None  # of a quantity no shape is given in
        passed.append(measure)
        factor, base = factor * value, under
    if base in failed:
        return base, "its prefix or its name cannot be read"
    name = base.Name() if isinstance(base, StepBasic_SiUnit) else None
    if (quantity in _SI or name == _SI[_LENGTH]) and name != _SI.get(quantity):
        shown = "of no size" if name is None else f"the {str(name).rpartition('sun')[2].lower()}"
        return base, f"a {quantity} is {shown}"
    if len(passed) > 1:
        passed[0].SetValueComponent(factor)
        passed[0].SetUnitComponent(passed[-1].UnitComponent())
    return None


def _quantity(unit: object) -> str:
    """``LengthUnit`` of a StepBasic_SiUnitAndLengthUnit; the kind's own name where that is not of two."""
    return type(unit).__name__.rpartition("And")[2].removeprefix("StepBasic_") if unit is not None else ""
