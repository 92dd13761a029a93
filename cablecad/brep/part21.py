"""ISO 10303-21 text: what a STEP file is made of, as far as it concerns text, strings and references.

Strings: Open Cascade reads every form of non-ASCII text, but writes raw UTF-8, which strict readers refuse, and leaves
a backslash alone where the text around it looks like a control directive, which then reads back as something else. So
names go to Open Cascade by `shielded`, with stand-ins for what it would alter, and come out of its text by `requoted`.

Checks: Open Cascade reads a truncated file without a word and drops what it cannot resolve; `flaw` finds such files.
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
_DEFINED = re.compile(rb"#(\d+)\s*=")
_REFERENCE = re.compile(rb"#(\d+)")
_DATA = re.compile(rb"ENDSEC\s*;.*?\bDATA\s*[;(]", re.DOTALL)


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


# --- completeness ---------------------------------------------------------------------------------------------------


def flaw(data: bytes) -> str | None:
    """What is wrong with a STEP file's text before its contents are looked at, or None.

    Finds what is no STEP file, a file cut off at its end, and one that refers to entities it does not define, as after
    a cut in its middle. About 15 ms for each MB.
    """
    return _frame_flaw(data) or _reference_flaw(data)


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
        text = _COMMENT_OR_STRING.sub(b"''", data)
        lost = set(_REFERENCE.findall(text)) - set(_DEFINED.findall(text))
    if lost:
        first = min(map(int, lost))
        others = f" and {len(lost) - 1} more" if len(lost) > 1 else ""
        return f"refers to #{first}{others}, which it does not define: a piece of it is missing"
    return None
