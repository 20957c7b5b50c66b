"""Tables in Markdown whose cells say what they say: text of the user's own is never markup."""

import re
from collections.abc import Iterable, Sequence
from itertools import pairwise

MARKUP = re.compile(r"[\\|`*<>&~#]|(?<![^\W_])_|_(?![^\W_])|(?<=\])\(")
"""What Markdown would not print as it is: an underscore inside a word it prints."""

ESCAPED = re.compile(r"\\([!-/:-@\[-`{-~])")


def markdown_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table with a line per row, each ended by a newline."""
    lines = [[literal(cell) for cell in head], ["---"] * len(head)]
    lines += [[literal(cell) for cell in row] for row in rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def literal(text: str) -> str:
    """Markdown on one line that reads as the text."""
    return MARKUP.sub(lambda found: "\\" + found[0], " ".join(text.split()))


def plain(markdown: str) -> str:
    """The text that `literal` made Markdown of."""
    return ESCAPED.sub(r"\1", markdown)


def cells(line: str) -> list[str]:
    """The texts of a table's line."""
    inner = re.sub(r"\\.", lambda found: "\x00" * len(found[0]), line)  # bars that don't divide
    bars = [k for k, character in enumerate(inner) if character == "|"]
    parts = [line[a + 1 : b] for a, b in pairwise(bars)]
    return [plain(part.strip()) for part in parts]
