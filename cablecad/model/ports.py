"""Ends on parts: whether a scene has the part and the port, and where they are when the part is placed.

The ports named in a scene are numbers, so that no geometry is read for them. Those given by a point near a feature are
found in the part's geometry by `cablecad.pipeline`, and come here as numbers too.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import TYPE_CHECKING

from cablecad.errors import Mistake
from cablecad.model.ends import PartPort, Port

if TYPE_CHECKING:
    from cablecad.model.ends import NamedPort
    from cablecad.model.scene import Part


def port_name_mistakes(names: Collection[str | None]) -> Iterator[Mistake]:
    """Names that more than one port of a part has; None is a name that could not be read."""
    seen: dict[str, int] = {}
    for i, name in enumerate(names):
        if name is not None and name in seen:
            problem = f"is also the name of ports[{seen[name]}]; a port's name must be unique within its part"
            yield Mistake(f"ports[{i}].name", problem, name)
        elif name is not None:
            seen[name] = i


def end_mistakes(end: object, ports: Mapping[str, Collection[str] | None]) -> Iterator[Mistake]:
    """What is wrong with the names in an end.

    Args:
        end: Anything; only a `PartPort` names a part.
        ports: By the name of each part the names of its ports, or None where they could not be read.
    """
    if not isinstance(end, PartPort):
        return
    if end.part not in ports:
        yield Mistake("part", f"no such part; {_nearest(end.part, ports, 'the scene', 'parts')}", end.part)
    elif end.port is not None and (known := ports[end.part]) is not None and end.port not in known:
        problem = f"part {end.part!r} has no such port; {_nearest(end.port, known, 'it', 'ports')}"
        yield Mistake("port", problem, end.port)


def _nearest(name: str, known: Collection[str], owner: str, kind: str) -> str:
    import difflib  # takes longer to load than most of this folder

    spelled = {one.lower(): one for one in known}
    near = difflib.get_close_matches(name.lower(), list(spelled), n=1)
    if near:
        return f"did you mean {spelled[near[0]]!r}?"
    if known:
        return f"{owner} has {', '.join(map(repr, known))}"
    header = "[[parts]]" if kind == "parts" else "[[parts.ports]]"
    return f"{owner} has none: write {header}" + ("" if kind == "parts" else ", or near = [x, y, z] in place of port")


def find_port(part: Part, name: str) -> NamedPort:
    """The port of that name; the scene has seen to it that there is one."""
    return next(port for port in part.ports if port.name == name)


def placed_port(part: Part, port: NamedPort, straight: float) -> Port:
    """A port of a part as an end in the scene.

    Raises:
        SceneError: `straight` for a port without an axis.
    """
    outward = None if port.outward is None else part.rotation.turned(port.outward)
    return Port(part.placed(port.position), outward, straight)
