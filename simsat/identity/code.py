"""Which code, packages and machine compute: stated beside every result.

The hash of the source files decides whether two results come from the same code, in a checkout and
as an installed package alike; version and git revision say in words which it was.
"""

import functools
import hashlib
import importlib.metadata
import os
import platform
import subprocess
from pathlib import Path
from typing import Any

SOURCE = Path(__file__).resolve().parents[1]  # simsat/, with control and learning inside
SUFFIXES = (".py", ".c", ".h")
TRAINING = "learning"  # the room that no flight passes through
FLYING_PACKAGES = ("mujoco", "casadi", "numpy", "scipy")
TRAINING_PACKAGES = (*FLYING_PACKAGES, "torch")
ATMOSPHERE_PACKAGE = "pymsis"  # where the density model is nrlmsis
FIELD_PACKAGE = "ppigrf"  # where a field is igrf
ORBIT_PACKAGE = "sgp4"  # where the orbit comes from elements


def computing(
    packages: tuple[str, ...] = FLYING_PACKAGES, training: bool = False
) -> dict[str, Any]:
    """Code, versions of the packages that compute, Python and platform, as plain JSON."""
    return {
        "code": {
            "version": version("simsat"),
            "revision": revision(),
            "sha256": source_hash(training),
        },
        "packages": {name: version(name) for name in packages},
        "python": platform.python_version(),
        "platform": " ".join([platform.system(), platform.machine(), *platform.libc_ver()]),
    }


@functools.cache
def source_hash(training: bool) -> str:
    """SHA-256 over names and contents of the source files; those of training only if asked for."""
    digest = hashlib.sha256()
    for name, path in sorted(_sources(training)):
        content = path.read_bytes()
        digest.update(f"{name} {len(content)} ".encode() + content)
    return digest.hexdigest()


def _sources(training: bool) -> list[tuple[str, Path]]:
    found = []
    for folder, inner, files in os.walk(SOURCE, followlinks=True):
        if Path(folder) == SOURCE and not training:
            inner.remove(TRAINING)
        paths = [Path(folder) / file for file in files if file.endswith(SUFFIXES)]
        found += [(path.relative_to(SOURCE).as_posix(), path) for path in paths]
    return found


def version(name: str) -> str | None:
    """An installed package's version."""
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None


@functools.cache
def revision() -> str | None:
    """The git revision of the checkout that this code lies in, "-dirty" if files were edited since;
    None for an installed package, also if a checkout of something else is around it."""
    if _git("ls-files", "--error-unmatch", Path(__file__).name) is None:
        return None
    return _git("describe", "--always", "--dirty", "--abbrev=40", "--exclude=*")


def _git(*arguments: str) -> str | None:
    here = Path(__file__).resolve().parent
    try:
        answer = subprocess.run(
            ["git", *arguments], cwd=here, capture_output=True, text=True, check=False
        )
    except OSError:
        return None
    return answer.stdout.strip() if answer.returncode == 0 else None
