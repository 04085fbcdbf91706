"""Certificates: exact proofs that a list of singular configurations is complete, and a checker that trusts none.

```python
proof = certify(robot, corank=1)    # a case split in rational arithmetic; proof.status
verdict = check(proof.to_json())    # other kinematics, no computer algebra, numbers modulo large primes
for leaf in leaves(proof):
    print(leaf)                     # q2 = 0° and q3 = 90°
word(proof, verdict)                # "certified" only if the checker accepted
```

`certify(robot, 1, thorough=False)` starts no process and counts its work in steps, so that the same arm gives the same
proof to the letter. Joints turn or slide; a sliding joint is fixed at a length, "joint3 = 0.25 m". Joints may follow
others of their kind: turns as fast or twice as fast, slides at any rate.

The theorem is about the arm in `proof.arm`, in rational numbers; `proof.arm.changes` says how it differs from the
robot. Proving needs python-flint, checking does not.
"""

from robust_ik.certificates.certificate import Certificate, word
from robust_ik.certificates.certify import certify
from robust_ik.certificates.checker.check import Verdict, check
from robust_ik.certificates.proof.joint_relations import JointRelation
from robust_ik.certificates.proof.proof import Proof
from robust_ik.certificates.proof.proof_leaves import LeafPlace, ProofLeaf, leaves
from robust_ik.certificates.proof.untrusted_json import CertificateError

__all__ = [
    "Certificate",
    "CertificateError",
    "JointRelation",
    "LeafPlace",
    "Proof",
    "ProofLeaf",
    "Verdict",
    "certify",
    "check",
    "leaves",
    "word",
]
