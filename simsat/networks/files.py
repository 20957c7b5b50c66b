"""What all network files share: float64 tensors in safetensors, beside metadata that say whose."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from simsat.control.ground.arrays import Array
from simsat.control.ground.errors import ForeignNetworkError, NetworkError
from simsat.control.ground.spacecraft import Spacecraft
from simsat.results.files import write_bytes


@dataclass(frozen=True)
class NetworkFile:
    """A file's content, and what to do when it is refused."""

    path: Path
    tensors: dict[str, Array]
    metadata: dict[str, str]
    remedy: str
    """End of every message: what the user can do."""

    def refusal(self, sentence: str) -> NetworkError:
        """The error to raise: this file's name, the sentence and the remedy."""
        return NetworkError(self._message(sentence))

    def foreign(self, sentence: str) -> ForeignNetworkError:
        """The error to raise when the file is sound but belongs elsewhere."""
        return ForeignNetworkError(self._message(sentence))

    def _message(self, sentence: str) -> str:
        return f"'{self.path}' {sentence}: {self.remedy}"

    def require_names(self, tensors: set[str], metadata: set[str]) -> None:
        """Refuse a file that holds other tensors or lacks metadata."""
        if set(self.tensors) != tensors or not metadata <= set(self.metadata):
            held = ", ".join(sorted(self.tensors))
            raise self.refusal(f"is no network of this project (it holds {held})")

    def require_numbers(self, scales: tuple[str, ...]) -> None:
        """Refuse numbers that are not finite, and scales that are not above zero."""
        broken = [name for name, values in self.tensors.items() if not np.isfinite(values).all()]
        bad = broken or [name for name in scales if not np.all(self.tensors[name] > 0.0)]
        if bad:
            named = ", ".join(sorted(bad))
            raise self.refusal(
                f"holds numbers that are not finite or scales not above zero in {named}"
            )

    def positive(self, name: str, what: str, unit: str) -> float:
        """A number above zero from the metadata; refuse anything else that stands there."""
        text = self.metadata[name]
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not 0.0 < value < math.inf:
            raise self.refusal(f"states {what} of '{text}' {unit}")
        return value

    def shapes(self) -> str:
        """All shapes, for a message."""
        return ", ".join(f"{name} {values.shape}" for name, values in sorted(self.tensors.items()))

    def require_spacecraft(self, craft: Spacecraft) -> None:
        """Refuse a file that belongs to a spacecraft with other dynamics."""
        found = self.metadata.get("fingerprint", "?")
        if found != craft.fingerprint:
            raise self.foreign(
                f"was trained for the spacecraft '{self.metadata.get('spacecraft', '?')}' "
                f"({found}), not for '{craft.name}' ({craft.fingerprint})"
            )


def read_network_file(path: Path, remedy: str) -> NetworkFile:
    """A file's tensors and metadata. Raises `NetworkError` if it is no safetensors file, or holds
    something else than floating-point numbers."""
    try:
        with safe_open(path, framework="numpy") as file:
            held = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
            metadata = file.metadata() or {}
    except (SafetensorError, OSError, ValueError, TypeError, AttributeError) as error:
        raise NetworkError(
            f"'{path}' is not a readable network file ({error}): copy it again, or {remedy}"
        ) from error
    tensors = {name: values.astype(float) for name, values in held.items() if _floating(values)}
    file_of = NetworkFile(path, tensors, metadata, remedy)
    other = [f"{name} ({values.dtype})" for name, values in held.items() if name not in tensors]
    if other:
        raise file_of.refusal(f"holds no floating-point numbers in {', '.join(sorted(other))}")
    return file_of


def _floating(values: Array) -> bool:
    return bool(np.issubdtype(values.dtype, np.floating))


def write_network_file(
    path: Path, tensors: Mapping[str, Array], metadata: Mapping[str, str]
) -> None:
    """Write tensors in float64 with their metadata by way of a temporary file."""
    plain = {name: np.ascontiguousarray(values, np.float64) for name, values in tensors.items()}
    write_bytes(path, _in_order(save(plain, dict(metadata))))


def _in_order(content: bytes) -> bytes:
    """The same file with its header's names sorted: safetensors shuffles the metadata, and equal
    weights are to make equal files. Layout: length of the header (8 bytes), JSON, numbers."""
    end = 8 + int.from_bytes(content[:8], "little")
    header = json.dumps(json.loads(content[8:end]), sort_keys=True, separators=(",", ":")).encode()
    header += b" " * (-len(header) % 8)
    return len(header).to_bytes(8, "little") + header + content[end:]
