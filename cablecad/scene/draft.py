"""The JSON Schema of a scene file, from the same tables that check one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from cablecad.scene.keys import JsonDict, Key, Table
from cablecad.scene.schema import SCENE


def scene_schema() -> JsonDict:
    """The JSON Schema (draft 2020-12) of a scene file, for editors and for checks outside of cablecad.

    It accepts every scene `load_scene` accepts. It cannot say all: that names are unique, that a material exists, and
    how many data a cable needs by its ends, is checked by `load_scene` alone.

    Returns:
        A new dict of JSON values.
    """
    inner = {table.name: _table(table) for table in _tables_in(SCENE)}
    schema: JsonDict = _in_order({"$defs": inner, **_table(SCENE)})
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def _tables_in(table: Table) -> Iterator[Table]:
    for key in table.keys.values():
        if key.kind.table is not None:
            yield key.kind.table
            yield from _tables_in(key.kind.table)


def _table(table: Table) -> JsonDict:
    return {
        "title": table.title,
        "description": table.description,
        "type": "object",
        "properties": {name: _key(key) for name, key in table.keys.items()},
        "additionalProperties": False,
        **table.rules,
    }


def _key(key: Key) -> JsonDict:
    default = {} if key.default is None else {"default": key.default}
    return {**key.kind.draft, "description": key.description, "examples": [key.example], **default, **key.keywords}


def _in_order(value: Any, above: str = "") -> Any:
    """A copy in which keywords are sorted, and the keys of tables stand in the order of their tables."""
    if isinstance(value, list):
        return [_in_order(part) for part in value]
    if isinstance(value, dict):
        names = list(value) if above == "properties" else sorted(value)
        return {name: _in_order(value[name], name) for name in names}
    return value
