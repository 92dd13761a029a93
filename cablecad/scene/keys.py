"""Kinds of values, keys and tables of a scene file, as plain data.

pydantic's core checks raw data against them; the JSON Schema is made from them (`draft`). The core alone is used, not
pydantic's models: these take longer to load and to be built than all else that one solved cable needs.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from pydantic_core import SchemaValidator

JsonDict = dict[str, Any]

_CONFIG = {"strict": True, "extra_fields_behavior": "forbid", "allow_inf_nan": False}
"""Of every table by itself: the core does not hand it on to the tables within."""


@dataclass(eq=False, repr=False)
class Kind:
    """What the value of a key may be.

    Attributes:
        core: As pydantic's core takes it (`pydantic_core.core_schema`).
        draft: As JSON Schema has it.
        table: The table it is, lists, or may be.
    """

    core: Any
    draft: JsonDict
    table: Table | None = None


@dataclass(eq=False, repr=False)
class Key:
    """A key of a table.

    Attributes:
        kind: Of its value.
        description: What it means, with its unit.
        example: Of its value.
        keywords: What JSON Schema says of it besides its kind.
        default: What its value is where it is not given; None: there is none.
    """

    kind: Kind
    description: str
    example: Any
    keywords: JsonDict = field(default_factory=dict)
    default: Any = None


@dataclass(eq=False, repr=False)
class Table:
    """A table: the keys it knows, none of which must be there.

    Attributes:
        name: Of the table among the others.
        title: What a user may call it.
        description: What it is.
        keys: By name, in the order they are described in.
        rules: What JSON Schema says of its keys together.
    """

    name: str
    title: str
    description: str
    keys: dict[str, Key]
    rules: JsonDict = field(default_factory=dict)

    @property
    def core(self) -> Any:
        """As pydantic's core takes it: a dict of the given keys alone."""
        fields = {
            name: {"type": "typed-dict-field", "required": False, "schema": key.kind.core}
            for name, key in self.keys.items()
        }
        return {"type": "typed-dict", "fields": fields, "config": _CONFIG}


def checker(table: Table) -> SchemaValidator:
    """What reads raw data as a table: strict types, finite numbers and no keys but its own."""
    return SchemaValidator(table.core)


NUMBER = Kind({"type": "float"}, {"type": "number"})
WHOLE = Kind({"type": "int"}, {"type": "integer"})
TEXT = Kind({"type": "str"}, {"type": "string"})
FLAG = Kind({"type": "bool"}, {"type": "boolean"})
VECTOR = Kind(
    {"type": "list", "items_schema": NUMBER.core, "min_length": 3, "max_length": 3},
    {"type": "array", "items": NUMBER.draft, "minItems": 3, "maxItems": 3},
)


def a_table(table: Table) -> Kind:
    """A table."""
    return Kind(table.core, {"$ref": f"#/$defs/{table.name}"}, table)


def list_of(table: Table) -> Kind:
    """An array of tables."""
    one = a_table(table)
    return Kind({"type": "list", "items_schema": one.core}, {"type": "array", "items": one.draft}, table)


def named(table: Table) -> Kind:
    """Tables by names of the author's choice."""
    one = a_table(table)
    core = {"type": "dict", "keys_schema": TEXT.core, "values_schema": one.core}
    return Kind(core, {"type": "object", "additionalProperties": one.draft}, table)


def number_or_word(word: str, problem: str) -> Kind:
    """A number, or a certain word; `problem` says what else is wrong with a value."""
    core = {"type": "union", "choices": [NUMBER.core, {"type": "literal", "expected": [word]}]}
    return Kind(_else_say(problem, core), {"anyOf": [NUMBER.draft, {"const": word, "type": "string"}]})


def index_or_table(table: Table, problem: str) -> Kind:
    """A whole number, or a table; `problem` says what is wrong with a value that is neither."""
    core = {
        "type": "tagged-union",
        "choices": {"index": _else_say(problem, WHOLE.core), "table": table.core},
        "discriminator": lambda value: "table" if isinstance(value, dict) else "index",
    }
    return Kind(core, {"oneOf": [WHOLE.draft, a_table(table).draft]}, table)


def _else_say(problem: str, core: JsonDict) -> JsonDict:
    """One mistake in plain words, whatever the types inside a union found."""
    return {
        "type": "custom-error",
        "schema": core,
        "custom_error_type": "in_words",
        "custom_error_message": problem,
    }
