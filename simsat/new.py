"""Write a spacecraft file from figures: python -m simsat.new FIGURES.toml --out FILE.xml.

The figures are the whole spacecraft's, as mass tables and data sheets give them, and a list of
wheels; the file has the bus without its rotors, so that what flies is the whole again. An example
with every key: docs/your-spacecraft.md.
"""

import os.path
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro

from simsat.command import command, parse
from simsat.control.ground.errors import ModelError, OutputError
from simsat.control.ground.settings import Settings
from simsat.control.ground.spacecraft import Spacecraft, nominal
from simsat.mjcf import Model, read_model
from simsat.results.summary import describe
from simsat.writing.figures import Figures, read_figures
from simsat.writing.mjcf import spacecraft_file

AGREES = 1e-9  # of J and Js: round-off in taking rotors out and putting them back


@dataclass(frozen=True)
class NewSettings(Settings):
    """Write a spacecraft file from a mass table or an inertia tensor, and a wheel list."""

    figures: Annotated[Path, tyro.conf.Positional]
    """TOML file with mass and inertia of the whole, or its parts, and the wheels (both may be CSV
    files that it names)."""
    out: Path | None = None
    """File to write, which must not exist yet; default FIGURES with the ending .xml."""


def write_spacecraft(figures: Figures, path: Path) -> Model:
    """Write the file and read it back; what comes back is what was asked for.

    Raises `OutputError` if it exists or can't be written, `ModelError` if such a spacecraft can't
    exist or would not fly; then there is no file.
    """
    text = spacecraft_file(figures)
    if os.path.lexists(path):
        raise OutputError(f"'{path}' exists already; name a new file with --out")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        raise OutputError(f"can't write '{path}': {error.strerror}") from error
    try:
        model = read_model(path)
        _refuse_other(model.spacecraft, figures)
    except ModelError:
        path.unlink()
        raise
    return model


def _refuse_other(craft: Spacecraft, figures: Figures) -> None:
    """Raise `ModelError` if the file that was read is not the spacecraft that was asked for."""
    whole, wheels = figures.whole, figures.wheels
    for what, read, asked in (
        ("mass", np.array([craft.mass]), np.array([whole.mass])),
        ("inertia", craft.J, whole.inertia),
        ("wheel axes", craft.A, np.stack([wheel.direction for wheel in wheels], axis=1)),
        ("spin inertias", craft.Js, np.array([wheel.Js for wheel in wheels])),
    ):
        if read.shape != asked.shape or not np.allclose(
            read, asked, rtol=AGREES, atol=AGREES * float(np.abs(asked).max())
        ):
            raise ModelError(f"the {what} read back, {read.tolist()}, are not {asked.tolist()}")


def main() -> int:
    """The command line."""
    settings = parse(NewSettings, __doc__)
    path = settings.out or settings.figures.with_suffix(".xml")
    model = write_spacecraft(read_figures(settings.figures), path)
    print(describe(model, nominal(model.spacecraft)))
    print(f"\nwritten to {path}; to fly it:  python -m simsat.run --model {path}")
    return 0


if __name__ == "__main__":
    sys.exit(command(main))
