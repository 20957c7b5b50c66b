"""The rows of a study: one for each point and controller."""

from dataclasses import dataclass
from typing import Any

from simsat.campaign.study import Point
from simsat.comparison.statistics import Aggregate, aggregate


@dataclass(frozen=True)
class StudyRow:
    """One controller at one point of the study."""

    point: Point
    result: Aggregate


def study_rows(records: list[dict[str, Any]], rows: list[dict[str, Any]]) -> list[StudyRow]:
    """Aggregates by point and controller, in the order of the campaign; `rows` are the records
    made flat, in the same order."""
    groups: dict[str, list[dict[str, Any]]] = {}
    points: dict[str, Point] = {}
    for record, row in zip(records, rows, strict=True):
        groups.setdefault(row["study"], []).append(row)
        points[row["study"]] = record["point"]
    return [
        StudyRow(points[name], result)
        for name, group in groups.items()
        for result in aggregate(group)
    ]
