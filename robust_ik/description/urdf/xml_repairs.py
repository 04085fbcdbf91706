"""Repairs XML that lenient readers accept and strict ones refuse, without adding or dropping an element.

The readers of Pinocchio and ROS know no namespaces, encodings or versions. What they accept is rewritten as strict XML;
what they refuse too is left for the strict parser to refuse.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from robust_ik.description.notes import Notes

MOST_CHARACTERS = 10_000_000
"""Longer texts are not repaired."""
_DECLARATION = re.compile(r"<\?xml\s[^>]*?\?>")
_FORBIDDEN = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]")
_REFERENCE = re.compile(r"&#(x[0-9a-fA-F]{1,6}|[0-9]{1,7});")
_BARE = re.compile(r"&(?!#|[A-Za-z_:][\w.:-]*;)")
_NAME = r"[^\s<>/=\"'!?&][^\s<>/=\"'&]*"
_TAG = re.compile(rf"<(/?)({_NAME})((?:[^<>\"']++|\"[^\"]*+\"|'[^']*+')*+)>")
_ATTRIBUTE = re.compile(rf"(\s*)({_NAME})(\s*=\s*)(\"[^\"]*\"|'[^']*')")
_ROOT = re.compile(rf"<{_NAME}")
_DECLARED = re.compile(rb"\s*<\?xml[^>]{0,200}encoding\s*=\s*[\"']([\w.-]+)")
_ENCODINGS = re.compile(
    r"iso-8859-([1-9]|1[013-6])|windows-125[0-8]|us-ascii|gb2312|gbk|gb18030|big5|shift_jis|euc-(jp|kr)|koi8-[ru]"
)


class _GiveUpError(Exception):
    """The text is not XML to lenient readers either."""


def decoded(data: bytes) -> tuple[str, bool]:
    """The text of bytes, and whether some of them were guessed.

    A byte order mark decides, then the declared encoding if it is known. Otherwise the text is UTF-8, and bytes that
    are not are taken as Windows-1252, which includes Latin-1.
    """
    for mark, encoding in ((b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16")):
        if data.startswith(mark):
            return data.decode(encoding, "replace"), False
    declared = _DECLARED.match(data)
    encoding = "" if declared is None else declared[1].decode("ascii", "replace").lower()
    if _ENCODINGS.fullmatch(encoding):
        return data.decode(encoding, "replace"), False
    text = data.decode("utf-8-sig", "surrogateescape")
    guessed = re.sub("[\udc80-\udcff]", _western, text)
    return guessed, guessed != text


def _western(found: re.Match[str]) -> str:
    byte = bytes([ord(found[0]) - 0xDC00])
    try:
        return byte.decode("cp1252")
    except UnicodeDecodeError:
        return byte.decode("latin-1")


def repaired(data: str | bytes, notes: Notes) -> str | None:
    """The text as strict XML without a declaration, or None if it cannot be repaired.

    Args:
        data: Text that a strict parser refused.
        notes: Repairs are added to these.
    """
    text, guessed = decoded(data) if isinstance(data, bytes) else (data, False)
    if len(text) > MOST_CHARACTERS:
        return None
    if guessed:
        notes.add("bytes that are not UTF-8 are taken as Windows-1252 (Latin-1)")
    mending = _Mending(notes)
    try:
        mended = "".join(mending.pieces(_without_forbidden(_without_head(text, notes), notes)))
    except _GiveUpError:
        return None
    return mending.declare_prefixes(mended)


def _without_head(text: str, notes: Notes) -> str:
    text = text.removeprefix("\ufeff")
    first = _DECLARATION.search(text)
    if first is not None and first.start() > 0:
        notes.add("the XML declaration <?xml …?> does not stand at the very beginning, as it must")
    if first is not None:
        note_version(first[0], notes)
    return _DECLARATION.sub("", text)


def note_version(declaration: str, notes: Notes) -> None:
    """Notes a version of XML that does not exist."""
    version = re.search(r"version\s*=\s*[\"']([^\"']*)", declaration)
    if version is not None and version[1] not in ("1.0", "1.1"):
        notes.add(f"XML version {version[1][:20]!r} is read as 1.0")


def _without_forbidden(text: str, notes: Notes) -> str:
    cleaned = _REFERENCE.sub(_allowed_reference, _FORBIDDEN.sub("", text))
    if cleaned != text:
        notes.add("control characters that XML forbids are left out")
    return cleaned


def _allowed_reference(found: re.Match[str]) -> str:
    number = int(found[1][1:], 16) if found[1].startswith("x") else int(found[1])
    allowed = number in (9, 10, 13) or 0x20 <= number < 0xD800 or 0xE000 <= number < 0x110000
    return found[0] if allowed and number not in (0xFFFE, 0xFFFF) else ""


class _Mending:
    """Rewrites markup, and collects the prefixes in it."""

    def __init__(self, notes: Notes) -> None:
        self.notes = notes
        self.started = False
        self.used: dict[str, str] = {}
        self.declared: set[str] = {"xml", "xmlns"}

    def pieces(self, text: str) -> Iterator[str]:
        """The rewritten text, tag by tag; line numbers do not change."""
        place = 0
        while (start := text.find("<", place)) >= 0:
            yield self._content(text[place:start])
            if text.startswith("<!--", start):
                place = _end(text, "-->", start + 4)
                yield self._comment(text[start:place])
            elif text.startswith("<![CDATA[", start):
                place = _end(text, "]]>", start)
                yield text[start:place]
            elif text.startswith("<?", start):
                place = _end(text, "?>", start)
                yield "\n" * text.count("\n", start, place)
            else:
                tag = _TAG.match(text, start)
                if tag is None:
                    raise _GiveUpError
                self.started = True
                place = tag.end()
                yield self._tag(*tag.groups())
        yield self._content(text[place:])

    def _comment(self, comment: str) -> str:
        if "--" in comment[4:-3] or comment.endswith("--->"):
            self.notes.add("a comment holds '--', which XML forbids")
        return "\n" * comment.count("\n")

    def _content(self, text: str) -> str:
        if not self.started and text.strip():
            self.notes.add("text before the first tag is passed over")
            return "\n" * text.count("\n")
        if "]]>" in text:
            self.notes.add("a bare ']]>' is taken as the characters")
            text = text.replace("]]>", "]]&gt;")
        return self._escaped(text)

    def _escaped(self, text: str) -> str:
        if "&" not in text or not _BARE.search(text):
            return text
        self.notes.add("a bare '&' is taken as the character")
        return _BARE.sub("&amp;", text)

    def _tag(self, closing: str, name: str, rest: str) -> str:
        body = rest.rstrip()
        empty = body.endswith("/")
        body = body[:-1] if empty else body
        if closing:
            return f"</{self._name(name, name)}{rest}>"
        attributes, place = [], 0
        while found := _ATTRIBUTE.match(body, place):
            attributes.append(self._attribute(name, *found.groups()))
            place = found.end()
        if body[place:].strip():
            raise _GiveUpError
        return f"<{self._name(name, name)}{''.join(attributes)}{body[place:]}{'/' if empty else ''}>"

    def _attribute(self, tag: str, space: str, name: str, equals: str, value: str) -> str:
        if name.startswith("xmlns:"):
            if value in ('""', "''"):
                return ""
            self.declared.add(name[6:])
        if not space:
            self.notes.add("attributes stand without a space between them")
            space = " "
        inner = self._escaped(value[1:-1])
        if "<" in inner:
            self.notes.add("a bare '<' in an attribute is taken as the character")
            inner = inner.replace("<", "&lt;")
        return f"{space}{self._name(name, f'{tag} {name}')}{equals}{value[0]}{inner}{value[0]}"

    def _name(self, name: str, shown: str) -> str:
        prefix, colon, local = name.partition(":")
        if not colon or prefix == "xmlns":
            return name
        if not prefix or not local:
            raise _GiveUpError
        self.used.setdefault(prefix, shown)
        return f"{prefix}:{local.replace(':', '.')}"

    def declare_prefixes(self, text: str) -> str:
        """The text with a declaration, in the root element, of each prefix that it uses."""
        missing = [prefix for prefix in self.used if prefix not in self.declared]
        for prefix in missing:
            self.notes.add("an XML prefix that nothing declares is part of the name", f"<{self.used[prefix]}>")
        root = _ROOT.search(text)
        if root is None or not missing:
            return text
        names = "".join(f' xmlns:{prefix}="urn:undeclared:{prefix}"' for prefix in missing)
        return f"{text[: root.end()]}{names}{text[root.end() :]}"


def _end(text: str, mark: str, start: int) -> int:
    found = text.find(mark, start)
    if found < 0:
        raise _GiveUpError
    return found + len(mark)
