"""Audit what weavesim depends on, as it is installed here: bounds, versions, licences. Needs no network.

    python scripts/releasing/audit.py                       # exit code 1 if anything is wrong
    python scripts/releasing/audit.py --vulnerabilities     # asks for known ones too, by pip-audit and a network

Every requirement of pyproject.toml, and what that requires in turn, is looked at where it is installed. A package whose
licence is not known to this file is a problem until somebody has read the licence.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Annotated, Any

import typer
from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parents[2]
# Licences that ask for no more than their text; and those that bind only changes of their own files.
PERMISSIVE = re.compile(
    r"\b(?:MIT|BSD|0BSD|ISCL?|Apache|PSF|Python Software Foundation|Zlib|CC0|MIT-CMU|HPND|Unlicense)\b", re.IGNORECASE
)
OWN_FILES_ONLY = re.compile(r"\b(?:MPL|Mozilla)", re.IGNORECASE)
COPYLEFT = re.compile(r"\b(?:[AL]?GPL|GNU)", re.IGNORECASE)
# Read one by one: what the metadata do not say in a form that is known, and why the package may be used.
READ: dict[str, str] = {
    "usd-core": "TOST 1.0: the Apache License 2.0 with another clause on trademarks",
    "docutils": "public domain and BSD; the one file under GPL is a mode for an editor, which is not imported",
    "bpy": "GPL: Blender, an extra of the tests that look at a film in it; weavesim never imports it",
    "pyelftools": "public domain; tests read compiled kernels with it",
    "nvidia-cuda-cuobjdump": "NVIDIA's own: a tool that tests start, never part of what is installed by default",
    "nvidia-cuda-nvdisasm": "NVIDIA's own: a tool that tests start, never part of what is installed by default",
}


@dataclass(frozen=True)
class Found:
    """An installed package.

    Attributes:
        name, version: of it.
        extra: of weavesim that brings it; "" for none.
        licence: what its metadata say.
    """

    name: str
    version: str
    extra: str
    licence: str


def requirements(project: dict[str, Any]) -> Iterator[tuple[Requirement, str]]:
    """Direct requirements of weavesim with the extra that asks for them."""
    for text in project["dependencies"]:
        yield Requirement(text), ""
    for extra, texts in project["optional-dependencies"].items():
        for text in texts:
            if not text.startswith("weavesim["):
                yield Requirement(text), extra


def bound_problems(wanted: list[tuple[Requirement, str]]) -> Iterator[str]:
    """Requirements without a least version, or from elsewhere than an index."""
    for requirement, extra in wanted:
        where = f" (extra {extra})" if extra else ""
        if requirement.url:
            yield f"{requirement.name}{where}: from {requirement.url}, not from an index"
        elif not any(one.operator in (">=", "==", "~=") for one in requirement.specifier):
            yield f"{requirement.name}{where}: no least version"


def installed(wanted: list[tuple[Requirement, str]]) -> tuple[list[Found], list[str], list[str]]:
    """Packages that are installed for the requirements, those that are not, and versions that are refused."""
    found: dict[str, Found] = {}
    missing: list[str] = []
    refused: list[str] = []
    waiting = list(wanted)
    while waiting:
        requirement, extra = waiting.pop(0)
        name = re.sub(r"[-_.]+", "-", requirement.name).lower()
        if (requirement.marker and not requirement.marker.evaluate({"extra": ""})) or name == "weavesim":
            continue
        try:
            package = distribution(name)
        except PackageNotFoundError:
            missing += [name] if name not in missing else []
            continue
        if not requirement.specifier.contains(package.version, prereleases=True):
            refused.append(f"{name} {package.version} is installed, {requirement.specifier} is required")
        if name not in found:
            found[name] = Found(name, package.version, extra, licence_of(package.metadata))
            waiting += [(Requirement(text), extra) for text in package.requires or ()]
    return list(found.values()), missing, refused


def licence_of(metadata: Any) -> str:
    """Licence by expression, by classifiers, or by the first line of its text."""
    if expression := metadata.get("License-Expression"):
        return str(expression)
    classifiers = [
        one.split("::")[-1].strip() for one in metadata.get_all("Classifier") or () if one.startswith("License")
    ]
    first = (metadata.get("License") or "").strip().split("\n")[0][:60]
    return " / ".join(classifiers) or first


def licence_problem(package: Found) -> str:
    """What speaks against the licence of a package; empty if nothing does."""
    if package.name in READ:
        return ""
    if COPYLEFT.search(package.licence):
        return f"{package.name}: {package.licence!r} may bind what imports it"
    if PERMISSIVE.search(package.licence) or OWN_FILES_ONLY.search(package.licence):
        return ""
    return (
        f"{package.name}: the licence {package.licence!r} is not known: read it, and enter it in {Path(__file__).name}"
    )


def vulnerabilities() -> tuple[int, str]:
    """Exit code and words of pip-audit: 0 none known, 1 some, 2 not asked."""
    command = [sys.executable, "-m", "pip_audit", "--skip-editable", "--progress-spinner", "off"]
    done = subprocess.run(command, capture_output=True, text=True)
    said = (done.stdout + done.stderr).strip()
    if "No module named pip_audit" in said:
        return 2, "known vulnerabilities: not asked, pip-audit is missing (pip install pip-audit)"
    if done.returncode and re.search(r"ConnectionError|ServiceError|Max retries|Name or service|timed out", said):
        return 2, "known vulnerabilities: not asked, there is no network"
    return int(bool(done.returncode)), said


def main(
    ask: Annotated[bool, typer.Option("--vulnerabilities", help="ask for known vulnerabilities as well")] = False,
) -> None:
    """Audit the dependencies."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = list(requirements(project))
    found, missing, refused = installed(wanted)
    problems = [*bound_problems(wanted), *refused, *filter(None, map(licence_problem, found))]
    print(f"{len(found)} packages, of which {sum(not one.extra for one in found)} are needed to run weavesim")
    if missing:
        print(f"not installed, and not looked at: {', '.join(missing)}")
    if ask:
        code, said = vulnerabilities()
        print(said)
        problems += ["known vulnerabilities"] if code == 1 else []
    print("\n".join(problems), file=sys.stderr)
    if problems:
        raise typer.Exit(1)


if __name__ == "__main__":
    typer.run(main)
