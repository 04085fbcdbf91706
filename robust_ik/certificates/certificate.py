"""Certificate: the proofs of several coranks of one arm, as one value and one file."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from robust_ik.certificates.checker.check import Verdict, check
from robust_ik.certificates.proof.proof import Proof
from robust_ik.certificates.proof.untrusted_json import CertificateError, a_list, an_object, read_json
from robust_ik.checks.public_arguments import checked
from robust_ik.runtime.files import read_file
from robust_ik.runtime.output_files import write_file

FORMAT, VERSION = "robust_ik certificates", 1
LARGEST_FILE = 64_000_000
"""Most bytes of a file. Chosen: a hundred times what the Panda's proofs take (0.66 MB), but small beside memory."""
MOST_PROOFS = 6
"""Most proofs of a certificate: one for each corank, and a task has at most six rows."""


@dataclass(frozen=True)
class Certificate:
    """Proofs of one arm for several coranks, ascending; iterate over it to get them.

    Attributes:
        proofs: One for each corank.
    """

    proofs: tuple[Proof, ...]

    def __iter__(self) -> Iterator[Proof]:
        return iter(self.proofs)

    def __len__(self) -> int:
        return len(self.proofs)

    @checked
    def of_corank(self, corank: int) -> Proof | None:
        """The proof of one corank, or None."""
        return next((proof for proof in self.proofs if proof.corank == corank), None)

    def check(self) -> dict[int, Verdict]:
        """The checker's verdict on every proof, by corank."""
        return {proof.corank: check(proof) for proof in self.proofs}

    def to_json(self) -> str:
        """All proofs as JSON text."""
        proofs = [json.loads(proof.to_json()) for proof in self.proofs]
        return json.dumps({"format": FORMAT, "version": VERSION, "proofs": proofs}, separators=(",", ":"))

    @classmethod
    @checked
    def from_json(cls, text: str) -> Certificate:
        """Proofs from JSON text: of a certificate, or of a single proof.

        Raises:
            CertificateError: It is neither, or of another version; nothing of it is run.
        """
        try:
            data = read_json(text)
        except (ValueError, RecursionError) as error:
            raise CertificateError(f"no JSON: {str(error)[:200]}") from error
        if not isinstance(data, dict) or data.get("format") != FORMAT:
            return cls((Proof.from_json(text),))
        data = an_object(data, "the certificate", {"format", "version", "proofs"})
        if data.get("version") != VERSION:
            raise CertificateError(f"not a {FORMAT!r} of version {VERSION}")
        proofs = [Proof.from_json(json.dumps(each)) for each in a_list(data.get("proofs"), "proofs", MOST_PROOFS)]
        if len({proof.corank for proof in proofs}) < len(proofs):
            raise CertificateError("two proofs are of the same corank")
        return cls(tuple(sorted(proofs, key=lambda proof: proof.corank)))

    def save(self, path: str | Path) -> Path:
        """Writes the certificate as JSON; `robust-ik verify` reads it.

        Raises:
            InputError: The path is a folder, or something on the way to it is a file.
        """
        return write_file(path, self.to_json())

    @classmethod
    def load(cls, path: str | Path) -> Certificate:
        """Reads a file that `save` or `robust-ik certify` wrote.

        Raises:
            LoadError: There is no such file, or it cannot be read.
            CertificateError: It is no certificate.
        """
        _, content = read_file(path, LARGEST_FILE)
        return cls.from_json(content.decode("utf-8", errors="replace"))


@checked
def word(proof: Proof, verdict: Verdict | None = None) -> str:
    """A word for how certain it is that the list of leaves is complete.

    "certified" only if the checker accepted; "implicit" if a leaf only repeats the equations; "exact, unchecked" if the
    case split is complete but was not checked; else "open", "refused" or "unsupported".
    """
    if proof.status in ("unsupported", "open", "implicit"):
        return proof.status
    if verdict is None:
        return "exact, unchecked"
    return "certified" if verdict.accepted else "refused"
