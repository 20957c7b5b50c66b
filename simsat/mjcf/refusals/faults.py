"""What is wrong with a file, collected, so that one message says all of it."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from simsat.control.ground.errors import ModelError


class Faults:
    """The faults found so far, in order, each once."""

    def __init__(self) -> None:
        self._found: dict[str, None] = {}

    def note(self, faults: Iterable[str]) -> None:
        """Take over what a check has found."""
        self._found |= dict.fromkeys(faults)

    @contextmanager
    def noting(self) -> Iterator[None]:
        """A `ModelError` raised inside becomes a fault; what follows it inside is left out."""
        try:
            yield
        except ModelError as error:
            self._found[str(error)] = None

    def raise_if_any(self) -> None:
        """Raise one `ModelError` with every fault found, if any was."""
        found = list(self._found)
        if len(found) == 1:
            raise ModelError(found[0])
        if found:
            raise ModelError(f"{len(found)} faults:", *found)
