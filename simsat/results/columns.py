"""Columns of a table that carry their unit and frame in their metadata."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa

from simsat.control.ground.arrays import Array


@dataclass(frozen=True)
class Column:
    """Values of one kind."""

    values: Sequence[Any] | Array
    unit: str = ""
    """As in SI, `1` for a number without one; empty for words, or where the name says it."""
    frame: str = ""
    """body, inertial (components, or for quaternions body -> inertial), rotor; empty for none."""


def components(
    name: str, parts: Sequence[str], values: Array, unit: str = "", frame: str = ""
) -> dict[str, Column]:
    """Columns NAME_PART of an array of shape (rows, parts)."""
    return {f"{name}_{part}": Column(values[:, i], unit, frame) for i, part in enumerate(parts)}


def table(columns: Mapping[str, Column]) -> pa.Table:
    """The columns as a table; pyarrow, pandas and polars find unit and frame in field metadata."""
    arrays = [pa.array(np.asarray(column.values)) for column in columns.values()]
    fields = [
        pa.field(name, array.type, metadata=_metadata(column))
        for (name, column), array in zip(columns.items(), arrays, strict=True)
    ]
    return pa.table(arrays, schema=pa.schema(fields))


def _metadata(column: Column) -> dict[str, str]:
    return {key: text for key, text in (("unit", column.unit), ("frame", column.frame)) if text}
