"""Every place that the glossary names exists, and no word is explained twice."""

import re
from collections import Counter

from tests.places import ROOT

GLOSSARY = (ROOT / "docs" / "glossary.md").read_text()
ROWS = re.findall(r"^\| ([^|]+) \| [^|]+ \| `([^`]+)` \|$", GLOSSARY, re.MULTILINE)


def test_every_place_exists() -> None:
    assert len(ROWS) > 40
    assert [place for _, place in ROWS if not (ROOT / place).exists()] == []


def test_every_row_is_read_and_no_term_comes_twice() -> None:
    tables = [line for line in GLOSSARY.splitlines() if line.startswith("| ")]
    heads = sum(line.startswith(("| term |", "| --- |")) for line in tables)
    assert len(ROWS) == len(tables) - heads
    terms = Counter(term for terms, _ in ROWS for term in terms.split(", "))
    assert [term for term, count in terms.items() if count > 1] == []
