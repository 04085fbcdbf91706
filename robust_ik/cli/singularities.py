"""`robust-ik singularities`, `certify` and `verify`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from robust_ik.cli.shared import (
    BaseOption,
    PackageDirOption,
    RobotArgument,
    TipOption,
    WorkersOption,
    XacroOption,
    check_results,
    console,
    errors,
    load_robot,
    say_written,
)
from robust_ik.errors import InputError
from robust_ik.errors.safe_text import in_markup
from robust_ik.runtime.files import read_file
from robust_ik.runtime.progress import progress_bar

if TYPE_CHECKING:
    from robust_ik.certificates import Proof, Verdict

LARGEST_FILE = 64_000_000
"""Most bytes of a file: the same as for certificates and atlases, since it may be either."""
INTERRUPTED = 130
"""Exit status after Ctrl-C. By the convention of shells: 128 plus the number of SIGINT, 2."""


def singularities(
    robot: RobotArgument,
    tip: TipOption = None,
    corank: Annotated[int | None, typer.Option("--corank", help="Only this one; default all up to the last.")] = None,
    starts: Annotated[int, typer.Option("--starts", help="Random starts for each corank.")] = 1500,
    seed: Annotated[int, typer.Option("--seed", help="The same seed gives the same atlas.")] = 0,
    snap: Annotated[
        bool, typer.Option("--snap", help="The straight geometry is what is meant; rounded angles are no matter.")
    ] = False,
    certify: Annotated[bool, typer.Option(help="Try to prove that the lists are complete.")] = True,
    markdown: Annotated[bool, typer.Option("--markdown", help="Print the table as Markdown.")] = False,
    latex: Annotated[bool, typer.Option("--latex", help="Print the table as LaTeX.")] = False,
    json: Annotated[
        Path | None, typer.Option("--json", metavar="FILE", help="Save the atlas; SingularityAtlas.load reads it.")
    ] = None,
    html: Annotated[
        Path | None, typer.Option("--html", metavar="FILE", help="Write a page with every family in 3D and its curves.")
    ] = None,
    workers: WorkersOption = 1,
    package_dir: PackageDirOption = None,
    xacro_arg: XacroOption = None,
    base: BaseOption = "fixed",
) -> None:
    """Find every family of singular configurations: conditions, dimension, limits, what is lost, how sure that is."""
    from robust_ik.runtime.parallel import process_pool
    from robust_ik.singularities import find_singularities  # takes half a second to import: only if needed

    if markdown and latex:
        raise InputError("choose one of --markdown and --latex")
    check_results(json=json, html=html)
    arm = load_robot(robot, tip, package_dir, xacro_arg, base)
    with process_pool(workers) as pool, progress_bar(f"searching {arm.name}") as told:
        atlas = find_singularities(
            arm, corank, starts=starts, rng=seed, snap=snap, certify=certify, executor=pool, progress=told
        )
    if markdown or latex:
        print(atlas.markdown() if markdown else atlas.latex())
    else:
        console.print(atlas.table())
    if json is not None:
        say_written(atlas.save(json))
    if html is not None:
        from robust_ik.display import write_atlas_html  # takes a second to import: only if needed

        say_written(write_atlas_html(html, atlas, arm))
    if atlas.interrupted:
        errors.print("Interrupted: this is what was found until then.")
        raise typer.Exit(INTERRUPTED)


def certify(
    robot: RobotArgument,
    corank: Annotated[
        int | None,
        typer.Option("--corank", help="How much rank is lost; default all up to the first impossible."),
    ] = None,
    tip: TipOption = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE", help="Where to write the proofs, as JSON.")
    ] = None,
    time_limit: Annotated[float, typer.Option("--time-limit", help="Seconds for each corank.")] = 60.0,
    package_dir: PackageDirOption = None,
    xacro_arg: XacroOption = None,
    base: BaseOption = "fixed",
) -> None:
    """Prove where an arm is singular, exactly and completely, and have the proofs checked."""
    from robust_ik import certificates  # imports computer algebra: only if needed

    check_results(output=output)
    arm = load_robot(robot, tip, package_dir, xacro_arg, base)
    proofs: list[Proof] = []
    for each in range(1, min(len(arm.rows), arm.n) + 1) if corank is None else [corank]:
        if proofs and proofs[-1].arm is not None and each > proofs[-1].arm.rank:
            break
        with console.status(f"splitting cases of corank {each} …"):
            proof = certificates.certify(arm, each, time_limit=time_limit)
            verdict = certificates.check(proof) if proof.arm is not None else None
        proofs.append(proof)
        _tell(arm.name, proof, verdict)
        if proof.arm is None or (proof.status == "proved" and not proof.leaves):
            break
    for change in proofs[0].arm.changes if proofs[0].arm is not None else ():
        console.print(f"[dim]straightened: {in_markup(change)}[/]", soft_wrap=True)
    if output is not None:
        say_written(certificates.Certificate(tuple(proofs)).save(output))


def _tell(name: str, proof: Proof, verdict: Verdict | None) -> None:
    """Prints the result for one corank: how certain it is, the leaves, the checker's verdict."""
    from robust_ik import certificates  # only if needed

    console.print(f"[bold]{in_markup(name)}[/], corank {proof.corank}: {certificates.word(proof, verdict)}")
    for leaf in certificates.leaves(proof):
        console.print(f"  {in_markup(leaf)}", soft_wrap=True)
    reason = proof.reason if verdict is None else verdict.reason
    if reason:
        console.print(in_markup(reason), soft_wrap=True)


def verify(
    certificate: Annotated[
        Path, typer.Argument(metavar="CERTIFICATE", help="What 'certify' or 'singularities --json' wrote.")
    ],
) -> None:
    """Check proofs of where an arm is singular, without trusting what made them."""
    from robust_ik.singularities.atlas import atlas_json  # only if needed

    path, content = read_file(certificate, LARGEST_FILE)
    proofs = atlas_json.certificate_in(path, content)
    if len(proofs) == 0:
        raise InputError(f"{path} holds no proof")
    refused = 0
    for proof, verdict in zip(proofs, proofs.check().values()):
        refused += not verdict.accepted
        name = "no arm" if proof.arm is None else proof.arm.name
        says = "accepted" if verdict.accepted else "not accepted"
        console.print(f"{in_markup(name)}, corank {proof.corank}: {says}: {in_markup(verdict.reason)}", soft_wrap=True)
    if refused:
        raise typer.Exit(1)
