"""The spacecraft that come with the project, one folder each."""

import os.path  # whose questions answer no where Path's raise: names too long, with a NUL
from pathlib import Path

from simsat.control.ground.errors import ModelError

MODELS = (Path(__file__).parents[1] / "models").resolve()


def find_model(model: Path | str) -> Path:
    """The file that `--model` names: a path, or a folder's name in models/.

    Raises `ModelError` on a name that none of them has.
    """
    model = Path(model)
    if os.path.isfile(model) or len(model.parts) != 1 or model.suffix:
        return model
    named = MODELS / model / f"{model.name}.xml"
    if not os.path.isfile(named):
        names = ", ".join(shipped_models())
        raise ModelError(f"no model '{model}'; there are: {names}, or name an MJCF file")
    return named


def shipped_models() -> tuple[str, ...]:
    """Names of the spacecraft in models/."""
    return tuple(
        sorted(path.stem for path in MODELS.glob("*/*.xml") if path.stem == path.parent.name)
    )


def about(name: str) -> str:
    """What a shipped spacecraft is, in a few words: the title of its README after the name."""
    title = (MODELS / name / "README.md").read_text(encoding="utf-8").partition("\n")[0]
    return title.partition(":")[2].strip()
