"""Refusals of files larger than any spacecraft, before MuJoCo reads them.

It takes time with the square of what a file makes, `<replicate>` worse, and hears no signal
meanwhile: 20,000 bodies keep it busy for 20 s, 300,000 for an hour.
"""

import math
import os
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

ELEMENTS_MAX = 5000  # read in a second; a spacecraft with all its panels and parts has hundreds
BYTES_MAX = 50_000_000  # of XML
PLACES_MAX = 100_000  # that an attribute of <size> asks for
CELLS_MAX = 30_000_000  # of a picture or of heights
CELLS = {"texture": ("width", "height"), "hfield": ("nrow", "ncol")}


def too_large(path: Path) -> Iterator[str]:
    """What makes a model file too large. Files that are no XML are left to MuJoCo's own message."""
    found = Elements(path.parent)
    found.read(path, 1)
    if found.total > ELEMENTS_MAX:
        most, count = found.counts.most_common(1)[0]
        yield (
            f"it makes {found.total:,} elements, {count:,} of them <{most}>: at most "
            f"{ELEMENTS_MAX:,} are read (<replicate> counts as often as it repeats)"
        )
    yield from found.oversized


class Elements:
    """What a file makes, with everything that it includes, attaches and repeats."""

    def __init__(self, folder: Path):
        self._folder = folder  # which MuJoCo looks for included files in
        self._open: list[Path] = []
        self.counts: Counter[str] = Counter()
        """Elements by tag."""
        self.oversized: list[str] = []
        """Attributes that ask for too much."""

    @property
    def total(self) -> int:
        """Elements of all tags."""
        return self.counts.total()

    def read(self, path: Path, times: int) -> None:
        """Count a file that is put in so many times."""
        path = next((p for p in (self._folder / path, path) if os.path.isfile(p)), path)
        if path in self._open or self.total > ELEMENTS_MAX or not os.path.isfile(path):
            return
        if os.path.getsize(path) > BYTES_MAX:
            self.oversized.append(f"'{path.name}' is larger than {BYTES_MAX / 1e6:.0f} MB")
            return
        try:
            root = ET.parse(path).getroot()
        except (ET.ParseError, ValueError, LookupError, OSError):
            return
        self._open.append(path)
        models = {m.get("name"): m.get("file", "") for m in root.iter("model")}
        for child in root:
            self._count(child, times, models)
        self._open.pop()

    def _count(self, element: ET.Element, times: int, models: dict[str | None, str]) -> None:
        if self.total > ELEMENTS_MAX:
            return
        self._weigh(element)
        if element.tag in ("include", "attach"):
            file = element.get("file") or models.get(element.get("model"))
            if file:
                self.read(Path(file), times)
            return
        if element.tag == "replicate":
            times *= _product(element, ("count",))
        else:
            self.counts[element.tag] += times
        for child in element:
            self._count(child, times, models)

    def _weigh(self, element: ET.Element) -> None:
        if element.tag == "size":
            for name in element.attrib:
                self._refuse_more(element, (name,), PLACES_MAX)
        elif element.tag in CELLS:
            self._refuse_more(element, CELLS[element.tag], CELLS_MAX)

    def _refuse_more(self, element: ET.Element, names: tuple[str, ...], most: int) -> None:
        asked = _product(element, names)
        if asked > most:
            told = " ".join(f"{name}='{element.get(name)}'" for name in names)
            self.oversized.append(f"<{element.tag} {told}> makes {asked:,}: at most {most:,}")


def _product(element: ET.Element, names: tuple[str, ...]) -> int:
    """Of whole numbers; what is none counts as one, MuJoCo says what is wrong with it."""
    values = (element.get(name, "").strip() for name in names)
    return math.prod(int(v) if v.isdecimal() and len(v) < 20 else 1 for v in values)
