"""Byte-stable STEP: the text Open Cascade writes, rewritten so that equal contents give equal bytes in any process.

What Open Cascade leaves to chance, and what becomes of it:

* The order of styles and layers follows addresses in memory. Entities reachable from the product structure keep
  Open Cascade's order, which follows the document. The others are values hung on them (colours, layers): each gets a
  digest of its text, in which references are final numbers or digests in turn. Equal ones are merged, so there are no
  ties; lists that are sets are sorted by digest.
* Entities are numbered anew by one walk from the roots, so that no number depends on what was dropped or moved. Open
  Cascade counts the same way, but for styles: where the walk would only confirm its numbers it is left out, and their
  text stays as it is.
* Ids of occurrences come from a counter of the whole process. Ids of occurrences and products become their names, with
  a count behind a name that was there before.
* Line breaks depend on the length of numbers. Here an entity is a line.

And what a reader would stumble over: text becomes ASCII, reals get the fewest digits that are the same double (Open
Cascade's default keeps 13, which at 1 m is 1e-9 mm; ask it for `reals.REAL_FORMAT`). `entities` does that, in numpy,
and finds what refers to what; here is the walk. The geometry itself is not touched.

Measured: 13 ms for each MB of a hundred cables, 14 of an assembly; half of it goes into reals of 17 digits.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from hashlib import blake2b

import numpy as np

from cablecad.brep.entities import HASH_IN_STRING, INITIALS, Entities, read_entities
from cablecad.brep.reals import Places, reals

_DATA = b"DATA;\n"
_STRING = rb"'[^']*(?:''[^']*)*'"
_BREAK = re.compile(rb"\n *")
_REFERENCE = re.compile(rb"#\d+")
_SCHEMA = re.compile(rb"FILE_SCHEMA\s*\(.*?\)\s*\)\s*;", re.DOTALL)
_NAMED = re.compile(rb"#\d+=(PRODUCT|NEXT_ASSEMBLY_USAGE_OCCURRENCE)\(%s,'([^']*(?:''[^']*)*)'" % _STRING)
_NAMED_INITIALS = tuple(kind[:INITIALS] for kind in (b"PRODUCT(", b"NEXT_ASSEMBLY_USAGE_OCCURRENCE("))
# Presentations and layers list what they hold; the order says nothing.
_SET = re.compile(
    rb"((?:MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION|PRESENTATION_LAYER_ASSIGNMENT)\((?:%s,)+\()"
    rb"([#\d,]*)(\).*)" % _STRING
)
_OVERRIDING = b"OVER_RIDING_STYLED_ITEM("

# Roots of the product structure; all other roots are values hung on it.
_STRUCTURE = (
    b"APPLICATION_PROTOCOL_DEFINITION(",
    b"SHAPE_DEFINITION_REPRESENTATION(",
    b"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(",
    b"PRODUCT_RELATED_PRODUCT_CATEGORY(",
)

# Colours pass through single precision, and powers of it: the seventh digit is noise that may differ between machines.
_SHADES = (b"COLOUR_RGB(", b"SURFACE_STYLE_TRANSPARENT(")
_REAL = re.compile(rb"\d+\.\d*(?:E[+-]\d+)?")


def canonical(text: bytes, header: bytes) -> bytes:
    """Rewrite a STEP text of Open Cascade's byte-stably, under another header.

    Args:
        text: The whole exchange structure, its reals written in `reals.REAL_FORMAT`.
        header: FILE_DESCRIPTION and FILE_NAME, a line each; FILE_SCHEMA is kept.

    Raises:
        GeometryError: A real is not finite.
    """
    begin, end = text.index(_DATA) + len(_DATA), text.rindex(b"ENDSEC;")
    schema = _SCHEMA.search(text, 0, begin)
    head = b"ISO-10303-21;\nHEADER;\n%s\n%s\nENDSEC;\nDATA;\n" % (
        header.rstrip(b"\n"),
        _BREAK.sub(b"", schema.group()) if schema else b"FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));",
    )
    lines = _Numbering(read_entities(text, begin, end)).lines()
    # One join: a copy of a long text takes a tenth of all this.
    return b"".join([head, *lines, b"ENDSEC;\nEND-ISO-10303-21;\n"]).replace(HASH_IN_STRING, b"#")


def _shade(real: re.Match[bytes]) -> bytes:
    return reals([round(float(real.group()), 6)])[0]


class _Numbering:
    """New numbers for all entities, and their lines.

    Attributes:
        order: The entities, in the order of their new numbers, but for those that stand first anyway.
        numbers: New number of each entity; 0: none.
        same: Entity to the equal one it is merged into.
        bodies: Text of each value that was looked at.
    """

    def __init__(self, entities: Entities) -> None:
        self.entities = entities
        self.same: dict[int, int] = {}
        self.bodies: dict[int, bytes] = {}
        self._members: dict[int, list[int]] = {}
        self._digests: dict[int, bytes] = {}
        self._first: dict[bytes, int] = {}

        referred = np.zeros(len(entities), bool)
        referred[entities.targets] = True
        structure, values = self._sorted_out(np.flatnonzero(~referred).tolist())
        followed = _followed(entities)
        settled = _settled(followed, entities.starts, structure)
        self.order: list[int] = []
        self.numbers = np.zeros(len(entities), np.intp)
        self.numbers[:settled] = np.arange(1, settled + 1)
        self._settled = settled
        for root in structure:
            self._number(root, followed)
        for root in sorted({self._value(root) for root in values}, key=self._rank):
            self._number(root, entities.targets)

    def _body(self, entity: int) -> bytes:
        """The text of an entity, with references as they are in the file."""
        return self.bodies.get(entity) or self.entities.line(entity).partition(b"=")[2][:-1]

    def _references(self, entity: int, targets: Places | None = None) -> list[int]:
        """What an entity refers to, in the order of its text or of other `targets`."""
        if entity in self._members:
            return self._members[entity]
        starts = self.entities.starts
        targets = self.entities.targets if targets is None else targets
        references: list[int] = targets[starts[entity] : starts[entity + 1]].tolist()
        return references

    def _sorted_out(self, roots: list[int]) -> tuple[list[int], list[int]]:
        """The roots of the product structure, and the others."""
        bodies = {root: self._body(root) for root in roots}
        occurrences = {
            self._references(root)[1]  # what is placed
            for root, body in bodies.items()
            if body.startswith(b"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(")
        }
        structure: list[int] = []
        values: list[int] = []
        for root, body in bodies.items():
            # The shape of an occurrence, unlike that of a product, only serves to colour the occurrence.
            colours = body.startswith(b"SHAPE_DEFINITION_REPRESENTATION(") and self._references(root)[0] in occurrences
            (structure if body.startswith(_STRUCTURE) and not colours else values).append(root)
        return structure, values

    def _number(self, root: int, targets: Places) -> None:
        """Number what can be reached from `root` and has no number yet, depth first, by these references."""
        waiting = [root]
        while waiting:
            entity = waiting.pop()
            entity = self.same.get(entity, entity)
            if not self.numbers[entity]:
                self.order.append(entity)
                self.numbers[entity] = self._settled + len(self.order)
                waiting += reversed(self._references(entity, targets))

    def _value(self, entity: int) -> int:
        """The first met of all entities equal to this one, which from now on stands for them."""
        if self.numbers[entity]:
            return entity
        if entity in self.same:
            return self.same[entity]
        body = self._body(entity)
        if body.startswith(_SHADES):
            body = _REAL.sub(_shade, body)
        held = _SET.fullmatch(body)
        if held:
            before, listed, after = held.groups()
            references, count = self._references(entity), listed.count(b"#")
            members = sorted({self._value(member) for member in references[:count]}, key=self._rank)
            self._members[entity] = members + references[count:]
            body = before + b",".join(b"#%d" % member for member in members) + after
        self.bodies[entity] = body
        contents = [self._content(self._value(reference)) for reference in self._references(entity)]
        digest = blake2b(digest_size=16)
        for part in _woven(_REFERENCE.split(body), contents):
            digest.update(b"%d:" % len(part) + part)
        first = self._first.setdefault(digest.digest(), entity)
        self._digests[first] = digest.digest()
        self.same[entity] = first
        return first

    def _content(self, entity: int) -> bytes:
        """What stands for an entity in the digests of others: its new number, or its own digest."""
        return b"#%d" % self.numbers[entity] if self.numbers[entity] else self._digests[entity]

    def _rank(self, entity: int) -> tuple[bool, bytes]:
        """Where an entity stands in a set: a style before those that override one."""
        return self._body(entity).startswith(_OVERRIDING), self._content(entity)

    def lines(self) -> Iterator[bytes | memoryview]:
        """The text of the entities in the order of their numbers: a line, or many that are as they were."""
        numbers = self.numbers
        for entity, first in self.same.items():
            numbers[entity] = numbers[first]
        order = np.append(np.arange(self._settled), np.array(self.order, np.intp))
        new: dict[int, bytes] = {}
        for entity in self._changed(order):
            references = [b"#%d" % number for number in numbers[self._references(entity)].tolist()]
            text = b"".join(_woven(_REFERENCE.split(self._body(entity)), references))
            new[entity] = b"#%d=%s;" % (numbers[entity], text)
        ids: dict[bytes, dict[bytes, int]] = {}
        initials = self.entities.initials[order]
        for entity in order[np.logical_or.reduce([initials == kind for kind in _NAMED_INITIALS])].tolist():
            line = new.get(entity) or self.entities.line(entity)
            named = _NAMED.match(line)
            if named:
                kind, name = named.groups()
                identifier = _unused(name, ids.setdefault(kind, {}))
                new[entity] = b"#%d=%s('%s','%s'%s" % (numbers[entity], kind, identifier, name, line[named.end() :])
        yield from self._with_new(order, new)

    def _changed(self, order: Places) -> list[int]:
        """The entities whose lines are no longer right: as a rule only styles, for Open Cascade counts the same way."""
        entities = self.entities
        moved = self.numbers != entities.numbers
        changed = moved.copy()
        owners = np.repeat(np.arange(len(moved)), np.diff(entities.starts))
        changed[owners[moved[entities.targets]]] = True
        changed[list(self.bodies)] = True
        found: list[int] = order[changed[order]].tolist()
        return found

    def _with_new(self, order: Places, new: dict[int, bytes]) -> Iterator[bytes | memoryview]:
        """The lines in order, with new ones in the place of old."""
        text, bounds = memoryview(self.entities.text), self.entities.bounds
        is_new = np.zeros(len(self.entities), bool)
        is_new[list(new)] = True
        alone = is_new[order]
        first = np.flatnonzero(np.append(True, (np.diff(order) != 1) | alone[1:] | alone[:-1]))
        begins, ends = order[first], order[np.append(first[1:], len(order)) - 1] + 1
        for entity, begin, end in zip(begins.tolist(), bounds[begins].tolist(), bounds[ends].tolist(), strict=True):
            yield b"%s\n" % new[entity] if entity in new else text[begin:end]


def _followed(entities: Entities) -> Places:
    """References in the order in which the walk through the product structure follows them: that of the text.

    Those of a complex entity are followed as Open Cascade counts them: of a context the units come before the
    uncertainty, which stands before them.
    """
    targets = entities.targets.copy()
    counts = np.diff(entities.starts)
    owners = np.repeat(np.arange(len(counts)), counts)
    own = np.flatnonzero((entities.initials.astype("S1") == b"(")[owners])
    targets[own] = targets[own][np.lexsort((targets[own], owners[own]))]
    return targets


def _settled(targets: Places, starts: Places, roots: list[int]) -> int:
    """How many entities, from the first on, the walk from the roots would meet in the order they stand in.

    The walk goes on to the first reference not met before of that entity, last met, which has one. With k entities
    met in order, the one behind them is next if it is

    * of the last of them that refers to it the first reference that is not among them, and
    * none of those between refers to what is not among them;

    or if none of the k refers to what is not among them, and it is the next root. Who refers to one twice is taken to
    do so where he does last, so that there may be a few less than that.

    Args:
        targets: What entities refer to, by one after the other, in the order in which the walk follows them.
        starts: Where in `targets` those of each entity begin, and where the last one's end.
        roots: What nothing refers to, as far as the walk begins there; in the order of the file.
    """
    count = len(starts) - 1
    own = np.arange(count)
    owners = np.repeat(own, np.diff(starts))
    ahead = targets > owners
    last = np.full(count, -1)  # of those before an entity the last that refers to it
    last[targets[ahead]] = owners[ahead]
    wrong = last < 0
    wrong[roots] = False
    # Its references before this one lead no further than this one.
    far = np.maximum.accumulate(owners * count + targets)
    wrong[targets[(last[targets] == owners) & (owners * count + targets < far)]] = True
    # Of all between an entity and its furthest reference none is referred to from before only: the least of `last` over
    # them, by rows of 1, 2, 4 ... entities.
    reach = own.copy()
    np.maximum.at(reach, owners, targets)
    spans = np.flatnonzero(reach > own)
    behind, row, least = reach[spans], 1, last
    while len(spans):
        fits = behind - spans < 2 * row
        first, end = spans[fits] + 1, behind[fits] + 1
        crossed = np.minimum(least[first], least[end - row]) < first - 1
        for begin, stop in zip(first[crossed].tolist(), end[crossed].tolist(), strict=True):
            wrong[begin + int(np.argmax(last[begin:stop] < begin - 1))] = True
        spans, behind = spans[~fits], behind[~fits]
        if len(spans):
            least = np.minimum(least[:-row], least[row:])
        row *= 2
    settled = int(np.argmax(np.append(wrong, True)))
    # The walk starts anew where none of those before refers to one behind.
    closed = np.flatnonzero(np.maximum.accumulate(reach[:settled]) == own[:settled])
    return int(closed[-1]) + 1 if len(closed) else 0


def _woven(parts: list[bytes], references: list[bytes]) -> list[bytes]:
    """Parts of a text with what stands between them."""
    woven = [b""] * (2 * len(parts) - 1)
    woven[::2], woven[1::2] = parts, references
    return woven


def _unused(name: bytes, used: dict[bytes, int]) -> bytes:
    """`name`, with a count behind it where it was used before; `used` holds the count to begin with."""
    identifier = name
    while identifier in used:
        used[name] += 1
        identifier = b"%s.%d" % (name, used[name])
    used[identifier] = 1
    return identifier
