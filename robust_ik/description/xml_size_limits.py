"""Limits on the contents of an XML file, checked on its bytes before any parser reads it.

Parsers of XML need time and memory for every element, and for the attributes of one element in the square of their
number; 50 MB of the smallest elements are twelve million. To count brackets takes some hundredths of a second.
"""

from __future__ import annotations

import codecs
import re
from dataclasses import dataclass

from robust_ik.errors import UrdfError

_LONG = re.compile(rb"<[^<!?/][^<]{3000,}")
_START_TAG = re.compile(rb"<(?:[^<>\"']++|\"[^\"]*+(?:\"|\Z)|'[^']*+(?:'|\Z))*+")
_DECLARATION = re.compile(rb"<\?xml[^>]{0,200}?encoding\s*=\s*[\"']([^\"']{1,100})")
_BEFORE = b"\xef\xbb\xbf\xff\xfe\x00 \t\r\n"
"""Byte order marks and blanks."""


@dataclass(frozen=True)
class XmlBounds:
    """Limits on a kind of file.

    Attributes:
        kind: The kind of file, for messages.
        elements: Most elements in all.
        of: Most elements of a name, as (name, number); longer names that begin so count too.
        attributes: Most attributes of one element.
        tag: Most bytes of one start tag, with all its attributes.
    """

    kind: str
    elements: int
    of: tuple[tuple[str, int], ...] = ()
    attributes: int = 500
    tag: int = 100_000

    def check(self, xml: str | bytes) -> None:
        """Raises if a file is beyond a limit, whatever else is wrong with it; bytes must pass `keeps_brackets` first.

        Raises:
            UrdfError: It is.
        """
        data = xml if isinstance(xml, bytes) else xml.encode("utf-8", "surrogatepass")
        data = data.replace(b"\0", b"")  # without its zeros, UTF-16 has the same brackets
        brackets = data.count(b"<")
        elements = brackets - sum(data.count(other) for other in (b"</", b"<!", b"<?"))
        if elements > self.elements:
            raise UrdfError(f"it has {elements} elements; {self.kind} of over {self.elements} is refused")
        if brackets > 10 * self.elements:
            raise UrdfError(f"it has {brackets} tags and comments; {self.kind} of over {10 * self.elements} is refused")
        for name, most in self.of:
            if (count := data.count(f"<{name}".encode())) > most:
                raise UrdfError(f"it has {count} elements <{name}>; {self.kind} of over {most} is refused")
        for found in _LONG.finditer(data):
            self._check_tag(found[0])

    def _check_tag(self, text: bytes) -> None:
        start = _START_TAG.match(text[: self.tag + 1])
        tag = text if start is None else start[0]
        what = f"an element <{tag[1:60].decode('ascii', 'replace').split()[0]}>" if tag[1:60].split() else "an element"
        if len(tag) > self.tag:
            raise UrdfError(f"{what} has a start tag of over {self.tag} bytes")
        if tag.count(b"=") > self.attributes:
            raise UrdfError(f"{what} has about {tag.count(b'=')} attributes; over {self.attributes} are refused")


URDF = XmlBounds("a URDF", 200_000, of=(("joint", 8_000), ("link", 10_000), ("mesh", 5_000)))
"""The largest robots, humanoids with hands and sensors, have some 4,000 elements, 220 joints and 130 meshes."""
SRDF = XmlBounds("an SRDF", 200_000)
"""All pairs of 600 links fit into it."""
COLLADA = XmlBounds("a COLLADA file", 60_000)
"""The largest real ones, with hundreds of parts, have some 8,000 elements: triangles are numbers in one element."""


def keeps_brackets(data: bytes) -> bool:
    """Whether a bracket is the byte of ASCII in the encoding that the file has; not so in UTF-7 and EBCDIC."""
    if not data.lstrip(_BEFORE).startswith(b"<"):
        return False
    declared = _DECLARATION.search(data[:400].replace(b"\0", b""))
    if declared is None:
        return True
    plain = bytes(range(32, 127))
    try:
        name = codecs.lookup(declared[1].decode("ascii")).name
        return name.startswith(("utf-16", "utf-32")) or (name != "utf-7" and plain.decode(name) == plain.decode())
    except (LookupError, UnicodeError, TypeError, ValueError):
        return False
