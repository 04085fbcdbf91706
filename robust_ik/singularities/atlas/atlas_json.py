"""Writes and reads atlases as JSON: plain numbers and words, one version number, nothing that could be run."""

from __future__ import annotations

import json
from dataclasses import asdict, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from robust_ik.certificates import Certificate, CertificateError, Proof
from robust_ik.certificates.proof import read_json
from robust_ik.checks import Array
from robust_ik.errors import LoadError, RobustIKError
from robust_ik.kinematics.twist_rows import checked_rows
from robust_ik.runtime.files import read_file
from robust_ik.runtime.output_files import write_file
from robust_ik.singularities.atlas.atlas_checks import reread
from robust_ik.singularities.atlas.atlas_record import AtlasRecord, Settings
from robust_ik.singularities.atlas.corank_search import judged
from robust_ik.singularities.atlas.evidence import Completeness, Evidence
from robust_ik.singularities.atlas.search_state import state_of
from robust_ik.singularities.conditions.angle_sums import Angle
from robust_ik.singularities.conditions.robot_facts import RobotFacts
from robust_ik.singularities.conditions.trig_relations import Factor, Relation
from robust_ik.singularities.families.stratum import Condition, Stratum
from robust_ik.singularities.geometry.screw_chain import ScrewChain
from robust_ik.singularities.lost_motion.along_a_stratum import lost_along

FORMAT, VERSION = "robust_ik singularity atlas", 4
ROWS_LEFT_OUT = 3
"""The version before: it left out rows that an arm could not all move, and its coranks are of those that it kept."""
LARGEST_FILE = 64_000_000
"""Most bytes of a file. Chosen: the Panda's atlas with its proofs has 4 MB; this is small beside memory."""
BROKEN = (ValueError, KeyError, TypeError, AttributeError, IndexError, ArithmeticError, RecursionError, RobustIKError)
"""Exceptions from reading a file whose values are not those of an atlas."""
CHAIN_ARRAYS = ("rotations", "offsets", "tip", "mixing", "lower", "upper", "period")


def save(atlas: AtlasRecord, path: str | Path) -> Path:
    """Writes an atlas; lost motion is written as words only, and computed again when the atlas is read."""
    return write_file(path, json.dumps(to_plain(atlas), ensure_ascii=False, allow_nan=False, indent=1) + "\n")


def load(path: str | Path) -> AtlasRecord:
    """Reads an atlas; its proofs are checked again, not trusted.

    Raises:
        RobotNotFoundError: There is no such file.
        LoadError: It is no atlas, or of a version that this package does not know.
    """
    full, content = read_file(path, LARGEST_FILE)
    try:
        data = read_json(content.decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise LoadError(f"{full} is a broken atlas: {error}") from error
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise LoadError(f"{full} is no singularity atlas")
    if data.get("version") not in (ROWS_LEFT_OUT, VERSION):
        known = f"versions {ROWS_LEFT_OUT} and {VERSION}"
        raise LoadError(f"{full} is of version {data.get('version')!r}; this package reads {known}")
    try:
        return from_plain(data)
    except BROKEN as error:
        raise LoadError(f"{full} is a broken atlas: {error}") from error


def certificate_in(path: Path, content: bytes) -> Certificate:
    """The proofs in a file that `save` or `Certificate.save` wrote, or in one of a single proof; they are not trusted.

    Raises:
        CertificateError: There are none in it.
    """
    text = content.decode("utf-8", errors="replace")
    try:
        data = read_json(text)
    except (ValueError, RecursionError) as error:
        raise CertificateError(f"{path}: no JSON: {str(error)[:200]}") from error
    if isinstance(data, dict) and data.get("format") == FORMAT:
        held = data.get("certificate")
        return Certificate(()) if held is None else Certificate.from_json(json.dumps(held))
    return Certificate.from_json(text)


def to_plain(atlas: AtlasRecord) -> dict[str, Any]:
    """The atlas as lists, dictionaries, numbers and words."""
    facts = atlas.robot
    robot = {
        "name": facts.name,
        "tip": facts.tip,
        "asked": list(facts.asked),
        "continuous": list(facts.continuous),
        "lower": _numbers(facts.lower),
        "upper": _numbers(facts.upper),
        "symbols": dict(facts.symbols),
        "chain": _chain(facts.chain),
        "given": None if facts.given is facts.chain else _chain(facts.given),
        "changes": list(facts.changes),
        "snapped": facts.snapped,
        "tool": facts.tool.tolist(),
        "exact": None if facts.exact is None else json.loads(Proof(facts.exact, 1).to_json()),
        "inexact": facts.inexact,
        "near": None if facts.near is None else _chain(facts.near),
        "near_changes": list(facts.near_changes),
        "length_scale": facts.length_scale,
        "floating": list(facts.floating),
    }
    return {
        "format": FORMAT,
        "version": VERSION,
        "robot": robot,
        "strata": [_stratum(row) for row in atlas.strata],
        "evidence": [{**asdict(each), "status": each.status.name} for each in atlas.evidence],
        "settings": asdict(atlas.settings),
        "interrupted": atlas.interrupted,
        "certificate": None if atlas.certificate is None else json.loads(atlas.certificate.to_json()),
        "nearly": [_stratum(row) for row in atlas.nearly],
    }


def from_plain(data: dict[str, Any]) -> AtlasRecord:
    """The atlas from the result of `to_plain`."""
    robot = dict(data["robot"])
    chain = _read_chain(robot["chain"])
    facts = RobotFacts(
        **{
            **robot,
            "asked": checked_rows(robot["asked"]),
            "continuous": tuple(bool(each) for each in robot["continuous"]),
            "lower": _array(robot["lower"], -np.inf),
            "upper": _array(robot["upper"], np.inf),
            "chain": chain,
            "given": chain if robot["given"] is None else _read_chain(robot["given"]),
            "changes": tuple(robot["changes"]),
            "tool": _array(robot["tool"]),
            "near": None if robot["near"] is None else _read_chain(robot["near"]),
            "near_changes": tuple(robot["near_changes"]),
            "floating": tuple(robot["floating"]),
            "exact": None if robot["exact"] is None else Proof.from_json(json.dumps(robot["exact"])).arm,
        }
    )
    certificate, near = data["certificate"], facts.nearly
    atlas = AtlasRecord(
        robot=facts,
        strata=tuple(_read_stratum(facts, each) for each in data["strata"]),
        evidence=tuple(Evidence(**{**each, "status": Completeness[each["status"]]}) for each in data["evidence"]),
        settings=Settings(**data["settings"]),
        interrupted=bool(data["interrupted"]),
        certificate=None if certificate is None else Certificate.from_json(json.dumps(certificate)),
        nearly=tuple(_read_stratum(near or facts, each) for each in data["nearly"]),
    )
    atlas = reread(atlas)
    return replace(atlas, evidence=judged(state_of(atlas)))


def _numbers(array: Array) -> Any:
    """The array as nested lists, with None for infinite numbers."""
    plain = array.astype(object)
    plain[~np.isfinite(array)] = None
    return plain.tolist()


def _array(data: Any, infinite: float = np.inf) -> Array:
    array = np.array(data, dtype=float)
    return np.where(np.isnan(array), infinite, array)


def _chain(chain: ScrewChain) -> dict[str, Any]:
    arrays = {name: _numbers(getattr(chain, name)) for name in CHAIN_ARRAYS}
    others = {each.name: getattr(chain, each.name) for each in fields(chain) if each.name not in CHAIN_ARRAYS}
    return {**{name: list(each) if isinstance(each, tuple) else each for name, each in others.items()}, **arrays}


def _read_chain(data: dict[str, Any]) -> ScrewChain:
    arrays: dict[str, Any] = {name: _array(data[name]) for name in CHAIN_ARRAYS}
    others: dict[str, Any] = {name: tuple(each) if isinstance(each, list) else each for name, each in data.items()}
    return ScrewChain(**{**others, **arrays})


def _angle(angle: Angle) -> dict[str, Any]:
    period = angle.period if angle.circular else None
    return {"joints": list(angle.joints), "signs": list(angle.signs), "period": period}


def _read_angle(data: dict[str, Any]) -> Angle:
    period = np.inf if data["period"] is None else float(data["period"])
    return Angle(tuple(int(j) for j in data["joints"]), tuple(int(s) for s in data["signs"]), period)


def _relation(relation: Relation) -> dict[str, Any]:
    terms = [[{"angle": _angle(f.angle), "kind": f.kind, "order": f.order} for f in term] for term in relation.terms]
    return {
        "terms": terms,
        "coefficients": relation.coefficients.tolist(),
        "residual": relation.residual,
        "points": relation.points,
    }


def _read_relation(data: dict[str, Any]) -> Relation:
    terms = tuple(
        tuple(Factor(_read_angle(f["angle"]), str(f["kind"]), float(f["order"])) for f in term)
        for term in data["terms"]
    )
    return Relation(terms, _array(data["coefficients"]), float(data["residual"]), int(data["points"]))


def _stratum(row: Stratum) -> dict[str, Any]:
    plain = {each.name: getattr(row, each.name) for each in fields(row)}
    conditions = [{"angle": _angle(c.angle), "values": list(c.values), "words": c.words} for c in row.conditions]
    return {
        **plain,
        "conditions": conditions,
        "relations": [_relation(each) for each in row.relations],
        "samples": row.samples.tolist(),
        "margin": row.margin if np.isfinite(row.margin) else None,
        "lost": None if row.lost is None else str(row.lost),
    }


def _read_stratum(facts: RobotFacts, data: dict[str, Any]) -> Stratum:
    read = data["conditions"]
    conditions = (Condition(_read_angle(c["angle"]), tuple(map(float, c["values"])), c["words"]) for c in read)
    samples = _array(data["samples"])
    return Stratum(
        **{
            **data,
            "conditions": tuple(conditions),
            "relations": tuple(_read_relation(each) for each in data["relations"]),
            "equations": tuple(data["equations"]),
            "free": tuple(data["free"]),
            "curve": tuple(data["curve"]),
            "samples": samples,
            "margin": np.inf if data["margin"] is None else float(data["margin"]),
            "inside": tuple(tuple(map(float, each)) for each in data["inside"]),
            "lost": lost_along(facts.chain, facts.tool, int(data["corank"]), samples),
        }
    )
