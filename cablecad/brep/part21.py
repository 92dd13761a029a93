"""ISO 10303-21 text: what a STEP file is made of, as far as it concerns text, strings and references.

Strings: Open Cascade reads every form of non-ASCII text, but writes raw UTF-8, which strict readers refuse, and leaves
a backslash alone where the text around it looks like a control directive, which then reads back as something else. So
names go to Open Cascade by `shielded`, with stand-ins for what it would alter, and come out of its text by `requoted`.

Checks: Open Cascade reads a truncated file without a word, drops what it cannot resolve, and kills the process over
some values; `flaw` finds such files.
"""

from __future__ import annotations

import re

# Unicode sets 32 code points aside for use within a program; they stand for the backslash (at the place of NUL, which
# no name holds) and for the other control characters.
_FIRST_STAND_IN = 0xFDD0
_SHIELD = {0x5C: _FIRST_STAND_IN} | {code: _FIRST_STAND_IN + code for code in range(1, 0x20)}
_UNSHIELD = {stand_in: code for code, stand_in in _SHIELD.items()}
_SHIELD |= dict.fromkeys(_UNSHIELD, 0xFFFD)  # the replacement character, should a name hold a stand-in itself

_PLAIN = re.compile(rb"[ -~]*")
# What cannot stand in a string as it is: in the basic plane, and beyond it.
_ESCAPED = re.compile("[^ -~\U00010000-\U0010ffff]+|[\U00010000-\U0010ffff]+")

_BEFORE = b"\xef\xbb\xbf \t\r\n"  # what editors leave before the first word: the mark of UTF-8, and space
_COMMENT_OR_STRING = re.compile(rb"/\*.*?\*/|'[^']*'", re.DOTALL)
_DEFINED = re.compile(rb"#(\d++)\s*+=")
_REFERENCE = re.compile(rb"#(\d++)")
_DATA = re.compile(rb"ENDSEC\s*;.*?\bDATA\s*[;(]", re.DOTALL)

# Exponents of three digits; both letters, because a pattern that begins with one letter is searched ten times as fast.
_LARGE = (re.compile(rb"E\+?0*[1-9]\d\d"), re.compile(rb"e\+?0*[1-9]\d\d"))
_LARGE_REAL = re.compile(rb"(?<![\d.])\d[\d.]*[Ee]\+?0*([1-9]\d\d+)")
_GREATEST = 100  # of exponents: the square and the cube of a coordinate are finite; Open Cascade's "infinite" is 2E+100
# A list of styles in which something stands that is no entity, which Open Cascade follows without looking.
_ODD_STYLES = re.compile(
    rb"PRESENTATION_STYLE_BY_CONTEXT\s*\(\s*\((?!\s*(?:(?:#\d+|NULL_STYLE\s*\([^()]*\))\s*,?\s*)*\))"
)
# A measure that tells its kind in a part of its own, and its value in the other.
_SPLIT_KIND = (
    re.compile(rb"LENGTH_MEASURE_WITH_UNIT\s*\(\s*\)\s*MEASURE_WITH_UNIT"),
    re.compile(rb"PLANE_ANGLE_MEASURE_WITH_UNIT\s*\(\s*\)\s*\)"),
)
_SPLIT_MEASURE = re.compile(
    rb"=\s*\(\s*(?:LENGTH_MEASURE_WITH_UNIT\s*\(\s*\)\s*(MEASURE_WITH_UNIT\s*\([^;']*?\))"
    rb"|(MEASURE_WITH_UNIT\s*\([^;']*?\))\s*PLANE_ANGLE_MEASURE_WITH_UNIT\s*\(\s*\))\s*\)\s*;"
)


# --- strings --------------------------------------------------------------------------------------------------------


def quoted(text: str) -> bytes:
    r"""`text` as a string of a STEP file: ASCII in quotes, the rest as ``\X2\`` and, beyond the BMP, ``\X4\``.

    >>> quoted("it's 5 µm")
    b"'it''s 5 \\X2\\00B5\\X0\\m'"
    """
    return b"'" + _ESCAPED.sub(_directive, text.replace("\\", "\\\\").replace("'", "''")).encode("ascii") + b"'"


def _directive(run: re.Match[str]) -> str:
    codes = [ord(character) for character in run.group()]
    if codes[0] > 0xFFFF:
        return "\\X4\\" + "".join(f"{code:08X}" for code in codes) + "\\X0\\"
    # Half a surrogate pair is no character: U+FFFD says that one was lost.
    return "\\X2\\" + "".join(f"{0xFFFD if 0xD800 <= code < 0xE000 else code:04X}" for code in codes) + "\\X0\\"


def shielded(name: str) -> str:
    """`name` with stand-ins for backslashes and control characters, for Open Cascade to write.

    What is no character (half a surrogate pair, a stand-in) becomes U+FFFD.
    """
    return name.translate(_SHIELD).encode("utf-16", "surrogatepass").decode("utf-16", "replace")


def requoted(string: bytes) -> bytes:
    """A string out of Open Cascade's text, quotes and line breaks included, as `quoted` would have written it.

    Text that was not `shielded` keeps the directives Open Cascade gave it.
    """
    inner = string[1:-1].replace(b"\n", b"")
    if _PLAIN.fullmatch(inner):
        return b"'" + inner + b"'"
    text = inner.decode("utf-8", errors="surrogatepass")
    # Escaping first: a stand-in for a backslash must not be taken for the beginning of a directive.
    text = "".join(_escaped_run(run) for run in re.split(f"([{chr(_FIRST_STAND_IN)}])", text))
    return b"'" + text.encode("ascii") + b"'"


def _escaped_run(run: str) -> str:
    return "\\\\" if run == chr(_FIRST_STAND_IN) else _ESCAPED.sub(_directive, run.translate(_UNSHIELD))


def is_utf8(data: bytes) -> bool:
    """Whether non-ASCII bytes, which only some exporters write, can be UTF-8; else they are taken for Latin-1."""
    if data.isascii():
        return True
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return False
    return True


# --- soundness ------------------------------------------------------------------------------------------------------


def flaw(data: bytes) -> str | None:
    """What is wrong with a STEP file's text before its contents are looked at, or None.

    Finds what is no STEP file, a file cut off at its end, one that refers to entities it does not define, as after a
    cut in its middle, and values that Open Cascade would not survive. About 20 ms for each MB.
    """
    return _frame_flaw(data) or _reference_flaw(data) or _value_flaw(data)


def _frame_flaw(data: bytes) -> str | None:
    if not data.strip():
        return "is empty"
    if data.startswith((b"PK\x03\x04", b"\x1f\x8b")):
        return "is compressed; unpack it first"
    if not data.lstrip(_BEFORE).startswith(b"ISO-10303-21"):
        shown = data.lstrip()[:20].decode("ascii", errors="replace")
        return f"is not a STEP file: it begins with {shown!r}, not with ISO-10303-21"
    if data.rfind(b"END-ISO-10303-21") < 0:
        return "is cut off: END-ISO-10303-21 is missing at its end"
    if not _DATA.search(data):
        return "has no DATA section"
    return None


def _reference_flaw(data: bytes) -> str | None:
    lost = set(_REFERENCE.findall(data)) - set(_DEFINED.findall(data))
    if lost:  # seldom: only now is it worth looking at which of them stand in strings and comments
        text = _bare(data)
        lost = set(_REFERENCE.findall(text)) - set(_DEFINED.findall(text))
    if lost:
        first = min(map(int, lost))
        others = f" and {len(lost) - 1} more" if len(lost) > 1 else ""
        return f"refers to #{first}{others}, which it does not define: a piece of it is missing"
    return None


def _value_flaw(data: bytes) -> str | None:
    odd = _ODD_STYLES.search(data)
    if not odd and not any(large.search(data) for large in _LARGE):
        return None
    text = _bare(data)  # seldom, as above: many a string has E and digits
    odd = _ODD_STYLES.search(text)
    if odd:
        return f"is damaged: the styles of its entity {_entity_at(text, odd.start())[0]} are no entities"
    for real in _LARGE_REAL.finditer(text):
        if len(real[1]) <= 3 and int(real[1]) <= _GREATEST:
            continue
        name, statement = _entity_at(text, real.start())
        if b"MEASURE" not in statement:  # which is no geometry, and may well have a number that stands for none
            shown = real.group()[:40].decode("ascii")
            return f"is damaged: its entity {name} holds {shown}, and no coordinate or size is beyond 1E{_GREATEST}"
    return None


def _bare(data: bytes) -> bytes:
    """A file's text with its strings emptied and its comments gone."""
    return _COMMENT_OR_STRING.sub(b"''", data)


def _entity_at(text: bytes, place: int) -> tuple[str, bytes]:
    """Name and text of the entity that stands at a place of a `_bare` text."""
    begin = text.rfind(b";", 0, place) + 1
    statement = text[begin : text.find(b";", place)]
    name = _REFERENCE.search(statement)
    return (name.group().decode("ascii") if name else "without a name"), statement


def entity_name(data: bytes, place: int) -> str:
    """What a file calls the entity that is at a place in order, counted from 1: ``#1250``."""
    names = _DEFINED.findall(_bare(data))
    return f"#{names[place - 1].decode('ascii')}" if 0 < place <= len(names) else "of no name"


def with_whole_measures(data: bytes) -> bytes:
    """A file in which measures of lengths and angles are of one part, as Open Cascade reads them.

    Of two, as the standard also has them, it takes the unit that rests on one for mm, without a word.
    """
    if not any(kind.search(data) for kind in _SPLIT_KIND):
        return data
    return _SPLIT_MEASURE.sub(lambda measure: b"=" + (measure[1] or measure[2]) + b";", data)
