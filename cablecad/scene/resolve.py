"""Typed tables to model objects: what a cable's values demand of each other, and the names that tie a scene together.

All mistakes are collected before an object is made of anything. The checks themselves belong to `cablecad.model`: here
they are told what could not be read, and their mistakes get their place in the file.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Set
from pathlib import Path
from typing import Any, TypeVar

from cablecad.errors import Mistake, SceneError
from cablecad.model import (
    SHAPE_TOLERANCE,
    Cable,
    Clamp,
    EquilibriumKey,
    Material,
    NamedPort,
    Part,
    PartPort,
    Pin,
    Port,
    Rotation,
    Scene,
    Toward,
    Vector,
    cable_mistakes,
    end_mistakes,
    material_mistakes,
    port_name_mistakes,
    scene_mistakes,
)
from cablecad.scene.schema import FORMAT
from cablecad.scene.tables import Place, Tables, read_tables

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]{1,64}")

_ORIGIN: Vector = (0.0, 0.0, 0.0)
_UP: Vector = (0.0, 0.0, 1.0)

End = Clamp | Pin | Port | PartPort | Toward

Given = Mapping[str, Any]
"""The keys given in a table."""

_Made = TypeVar("_Made")


def resolve_scene(
    data: dict[str, object], *, source: Path | None = None, found: Iterable[tuple[Place, Mistake]] = ()
) -> Scene:
    """Make the scene that raw data describe.

    Args:
        data: The top table of a scene file.
        source: The file; the paths of parts begin in its folder.
        found: Mistakes found before and their places, to be reported together with those found here.

    Raises:
        SceneError: All mistakes of `found` and of the data.
    """
    resolver = _Resolver(read_tables(data), found)
    name = resolver.top.get("name", "scene")
    tolerance = resolver.tolerance()
    materials = resolver.materials()
    parts = resolver.parts()
    cables = resolver.cables(materials)
    resolver.note((), scene_mistakes(name, tolerance, resolver.names["cables"], resolver.names["parts"]))
    mistakes = resolver.mistakes()
    if mistakes:
        raise SceneError(mistakes, source=str(source or ""))
    folder = source.parent if source is not None else Path()
    return Scene(
        name=name,
        cables=tuple(Cable(**values) for values in cables),
        parts=tuple(Part(**{**values, "step": folder / values["step"]}) for values in parts),
        tolerance=tolerance,
        source=source,
    )


def type_mistakes(data: dict[str, object], found: Iterable[tuple[Place, Mistake]] = ()) -> list[Mistake]:
    """The unknown keys of raw data and their values of a wrong type, with those of `found`; no more is looked at."""
    tables = read_tables(data)
    noted = [*found, *tables.mistakes]
    if not noted:
        return []
    resolver = _Resolver(tables, found)
    resolver.noted = noted
    return resolver.mistakes()


class _Resolver:
    """Resolves one scene table by table, and notes every mistake on the way.

    After a mistake what a method returns serves further checks only.
    """

    def __init__(self, tables: Tables, found: Iterable[tuple[Place, Mistake]]) -> None:
        self.tables = tables
        self.top = tables.scene
        self.noted: list[tuple[Place, Mistake]] = [*found, *tables.mistakes]
        self.names = {kind: self._names(kind) for kind in ("parts", "cables")}
        self.ports = self._port_names()
        counts = {kind: Counter(names) for kind, names in self.names.items()}
        self.clear_names: dict[Place, str] = {
            (kind, i): name
            for kind, names in self.names.items()
            for i, name in enumerate(names)
            if name is not None and name.isprintable() and counts[kind][name] == 1
        }
        if "format" not in self.top and not tables.is_lost("format"):
            self.note((), [Mistake("format", f"is missing; write format = {FORMAT} at the top of the file")])
        elif self.top.get("format", FORMAT) != FORMAT:
            problem = f"is not known here: write format = {FORMAT}, or use a cablecad that reads this one"
            self.note((), [Mistake("format", problem, self.top["format"])])

    def _names(self, kind: str) -> list[str | None]:
        """The name of each part or cable, None where there is none to call it by."""
        if self.tables.is_lost(kind):
            return [None]
        names = [table.get("name", "") for table in self.top.get(kind, ())]
        return [name if name.strip() else None for name in names]

    def note(self, place: Place, mistakes: Iterable[Mistake]) -> None:
        """Keep mistakes whose paths begin at `place`."""
        self.noted.extend((place, mistake) for mistake in mistakes)

    def mistakes(self) -> list[Mistake]:
        """All mistakes with their paths from the top: the scene's, then those of each material, part and cable."""
        kinds = ("materials", "parts", "cables")

        def rank(noted: tuple[Place, Mistake]) -> tuple[int, int]:
            kind, index = (*noted[0], "", "")[:2]
            return kinds.index(kind) if kind in kinds else -1, index if isinstance(index, int) else -1

        return [mistake.under(self._path(place)) for place, mistake in sorted(self.noted, key=rank)]

    def _path(self, place: Place) -> str:
        """The dotted path of a place, by name through parts and cables where the name is clear."""
        if len(place) > 1 and (name := self.clear_names.get(place[:2])) is not None:
            place = (place[0], name, *place[2:])
        return "".join(f"[{part}]" if isinstance(part, int) else f".{_as_key(part)}" for part in place)[1:]

    def tolerance(self) -> float:
        """The shape tolerance [mm]."""
        shape = self.top["tolerance"].get("shape") if "tolerance" in self.top else None
        return SHAPE_TOLERANCE if shape is None else float(shape)

    def materials(self) -> dict[str, Material | None]:
        """The materials by name, None for one with mistakes."""
        materials: dict[str, Material | None] = dict.fromkeys(self.tables.lost_at("materials"))
        for name, table in self.top.get("materials", {}).items():
            values, lost = dict(table), self.tables.lost_at("materials", name)
            problems = list(material_mistakes(values, lost))
            self.note(("materials", name), problems)
            materials[name] = None if problems or lost else Material(**values)
        return materials

    def parts(self) -> list[dict[str, Any]]:
        """The values of each part."""
        tables = enumerate(self.top.get("parts", ()))
        return [self._part(table, ("parts", i)) for i, table in tables if not self.tables.is_lost("parts", i)]

    def _part(self, table: Given, place: Place) -> dict[str, Any]:
        values = dict(table)
        self._note_missing(table, place, name="write the part's name", step="write the path of the STEP file")
        if "rotation" in values:
            turn = (*place, "rotation")
            self._note_missing(values["rotation"], turn, axis="write axis = [x, y, z]", angle_deg="write the angle")
            values["rotation"] = self._made(Rotation, values["rotation"], turn)
        if "ports" in values:
            values["ports"] = self._ports(values["ports"], place)
        self._made(Part, {"name": "part", "step": "part.step", **values}, place)
        return values

    def _ports(self, tables: list[Given], place: Place) -> list[NamedPort]:
        """The ports of a part that have no mistakes."""
        names = [table.get("name") for table in tables]
        self.note(place, port_name_mistakes(names))
        ports: list[NamedPort | None] = []
        for j, table in enumerate(tables):
            here = (*place, "ports", j)
            if not self.tables.is_lost(*here):
                self._note_missing(table, here, name="write the port's name", position="write position = [x, y, z]")
                ports.append(self._made(NamedPort, {"name": f"port {j}", "position": _ORIGIN, **table}, here))
        return [port for j, port in enumerate(ports) if port is not None and port.name not in names[:j]]

    def _port_names(self) -> dict[str, dict[str, NamedPort | None] | None]:
        """By the name of each part, its ports by name; None for ports that could not be read."""
        known: dict[str, dict[str, NamedPort | None] | None] = {}
        for i, table in enumerate(self.top.get("parts", ())):
            name = table.get("name")
            if name is not None:
                known[name] = self._ports_of(table, ("parts", i))
        return known

    def _ports_of(self, table: Given, place: Place) -> dict[str, NamedPort | None] | None:
        """A part's ports by name, one with mistakes as None; None where it cannot be told which there are."""
        tables = table.get("ports", ())
        whole = all(port.get("name") is not None for port in tables)
        if self.tables.is_lost(*place, "ports") or not whole:
            return None
        return {
            port["name"]: None if self.tables.lost_at(*place, "ports", j) else _port_or_none(port)
            for j, port in enumerate(tables)
        }

    def cables(self, materials: Mapping[str, Material | None]) -> list[dict[str, Any]]:
        """The values of each cable."""
        tables = enumerate(self.top.get("cables", ()))
        return [
            self._cable(table, ("cables", i), materials) for i, table in tables if not self.tables.is_lost("cables", i)
        ]

    def _cable(self, table: Given, place: Place, materials: Mapping[str, Material | None]) -> dict[str, Any]:
        values, lost = dict(table), self.tables.lost_at(*place)
        ends: dict[str, End | None] = {}
        for key in ("start", "end"):
            if key in values:
                ends[key] = self._end(values[key], (*place, key))
                values[key] = self._stand_in(ends[key], (*place, key))
        if isinstance(values.get("equilibrium"), dict):
            values["equilibrium"] = self._made(EquilibriumKey, values["equilibrium"], (*place, "equilibrium"))
        if "material" in values:
            name = values["material"]
            values["material"] = materials.get(name)
            if name not in materials and not self.tables.is_lost("materials"):
                self.note(place, [Mistake("material", _unknown_material(name, materials), name)])
        lost |= {key for key, value in values.items() if value is None}
        self.note(place, cable_mistakes(values, lost))
        return {**values, **ends}

    def _stand_in(self, end: End | None, place: Place) -> End | None:
        """For a named port of a part a pin or a clamp, whichever it is: that decides what data the cable needs."""
        if not isinstance(end, PartPort) or end.port is None:
            return end
        port = (self.ports.get(end.part) or {}).get(end.port)
        if port is None:
            return end
        return self._made(Port, {"position": _ORIGIN, "outward": port.outward, "straight": end.straight}, place)

    def _end(self, table: Given, place: Place) -> End | None:
        """The support at an end, or one of its kind where it has mistakes; None where not even its kind is clear."""
        values, lost = dict(table), self.tables.lost_at(*place)
        there = values.keys() | lost
        axes = [key for key in ("outward", "direction") if key in there]
        if "toward" in there:
            others = [key for key in ("position", *axes, "straight", "part", "port", "near") if key in there]
            if others:
                problem = f"goes with no other key: leave out toward, or leave out {' and '.join(others)}"
                self.note(place, [Mistake("toward", problem, values.get("toward", ...))])
                return None
            return self._made(Toward, {"direction": values.get("toward", _UP)}, place) or Toward(_UP)
        if {"part", "port", "near"} & there:
            return self._part_port(values, there, place)
        if "position" not in there:
            other = ", or toward = [x, y, z], pinned at both ends" if place[-1] == "end" else ""
            self.note(place, [Mistake("position", f"is missing; write position = [x, y, z]; or part and port{other}")])
        if len(axes) == 2:
            problem = "give either outward or direction, and not both"
            self.note(place, [Mistake("direction", problem, values.get("direction", ...))])
            values.pop("direction", None)
        values = {"position": _ORIGIN, **dict.fromkeys(axes[:1], _UP), **values}
        if "direction" in values:
            return self._made(Clamp, values, place) or Clamp(_ORIGIN, _UP)
        port = self._made(Port, values, place) or Port(_ORIGIN, _UP if axes else None)
        return port if axes else Pin(port.position)

    def _part_port(self, values: dict[str, Any], there: Set[str], place: Place) -> PartPort | None:
        """An end on a part; None where it has mistakes, for its kind is then not clear."""
        noted = len(self.noted)
        others = [key for key in ("position", "outward", "direction") if key in there]
        if others:
            problem = f"goes with part, port, near and straight only: leave out {' and '.join(others)}, or part"
            self.note(place, [Mistake("part", problem, values.get("part", ...))])
            return None
        if "part" not in there:
            self.note(place, [Mistake("part", 'is missing; write part = "NAME", the part the end is on')])
        elif not {"port", "near"} & there:
            problem = 'says nothing of the place on it: write port = "NAME" or near = [x, y, z]'
            self.note(place, [Mistake("part", problem, values.get("part", ...))])
        if not {"part", "port", "near"} & (there - values.keys()) and len(self.noted) == noted:
            end = self._made(PartPort, values, place)
            known = {name: None if ports is None else list(ports) for name, ports in self.ports.items()}
            if not self.tables.is_lost("parts") and None not in self.names["parts"]:
                self.note(place, end_mistakes(end, known))
            return end if len(self.noted) == noted else None
        return None

    def _made(self, kind: type[_Made], values: Mapping[str, Any], place: Place) -> _Made | None:
        """An object of the model, or None where its values are mistaken."""
        try:
            return kind(**values)
        except SceneError as error:
            self.note(place, error.mistakes)
            return None

    def _note_missing(self, table: Given, place: Place, **fixes: str) -> None:
        there = table.keys() | self.tables.lost_at(*place)
        self.note(place, [Mistake(key, f"is missing; {fix}") for key, fix in fixes.items() if key not in there])


def _port_or_none(table: Given) -> NamedPort | None:
    """A port of a part, or None where it has mistakes; they are noted where the part is."""
    try:
        return NamedPort(**{"position": _ORIGIN, **table})
    except SceneError:
        return None


def _unknown_material(name: str, materials: Iterable[str]) -> str:
    known = list(materials)
    from difflib import get_close_matches

    near = get_close_matches(name, known, n=1)
    if near:
        return f"no such material; did you mean {near[0]!r}?"
    return f"no such material; the file has {', '.join(known) or f'none: write [materials.{_as_key(name)}]'}"


def _as_key(text: str) -> str:
    """A key as it stands in a dotted path, quoted where TOML would and cut where it is beyond reading."""
    if _BARE_KEY.fullmatch(text):
        return text
    short = text if len(text) <= 64 else f"{text[:61]}..."
    return json.dumps(short, ensure_ascii=not short.isprintable())
