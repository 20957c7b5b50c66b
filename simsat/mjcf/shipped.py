"""The spacecraft that come with the project, one folder each."""

import os.path  # whose questions answer no where Path's raise: names too long, with a NUL
from pathlib import Path

from simsat.control.ground.errors import ModelError

MODELS = (Path(__file__).parents[1] / "models").resolve()


PARTS = "parts"  # its files are no spacecraft, they are included


def find_model(model: Path | str) -> Path:
    """The file that `--model` names: a path, or a name in models/ (`shipped_models`).

    Raises `ModelError` on a name that none of them has.
    """
    model = Path(model)
    if os.path.isfile(model) or len(model.parts) != 1 or model.suffix:
        return model
    files = _files()
    if model.name not in files:
        names = ", ".join(files)
        raise ModelError(f"no model '{model}'; there are: {names}, or name an MJCF file")
    return files[model.name]


def shipped_models() -> tuple[str, ...]:
    """Names of the spacecraft in models/, variants (`kepler_two_wheel`) included."""
    return tuple(_files())


def about(name: str) -> str:
    """What a shipped spacecraft is, in a few words: the heading of its name in its folder's README,
    `# NAME: WORDS`, or `## NAME: WORDS` for a variant."""
    for line in (_files()[name].parent / "README.md").read_text(encoding="utf-8").splitlines():
        heading, colon, words = line.lstrip("#").partition(":")
        if line.startswith("#") and colon and heading.strip() == name:
            return words.strip()
    return ""


def _files() -> dict[str, Path]:
    """The spacecraft's files by their names, sorted."""
    files = (path for path in MODELS.glob("*/*.xml") if path.parent.name != PARTS)
    return {path.stem: path for path in sorted(files, key=lambda path: path.stem)}
