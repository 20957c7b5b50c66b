"""Values, files and code that nobody should give, drawn from a seed."""

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

NUMBERS = (
    "0", "1", "-1", "0.5", "2", "24", "1e-9", "1e-300", "5e-324", "1e9", "1e300", "1e400", "-1e400",
    "nan", "-nan", "inf", "-inf", "Infinity", "1e", "0x10", "1_000", "٣", "１", "1,5", "--1", "+3",
    "9" * 40, "9" * 5000, "-0.0", "1/3", "1e-400", "true", "None", "9223372036854775808", "1j",
)  # fmt: skip
WORDS = (
    "", " ", "\n", "\t", "a b", "nmpc", "pinn", "paper", "two_wheel", "none", "auto", "chosen",
    "ä", "日本", "🛰", "\u202e", "\x00", "\x1b[31m", "\udcff", "é" * 300, "a" * 70_000, "-", "--",
    "---", "=", "{}", "[]", "()", "$HOME", "${x}", "%s", "%n", "{{x}}", "'", '"', "\\", "/", "//",
    ".", "..", "../..", "/dev/null", "/proc/self/mem", "~", "*", "|", ";", "&", "<script>", "a\nb",
    "CON", "nul:", "a:b", "json:loads", "os:abort", ":", "a:", ":b", "a.b:c", "a..b:c", "sys:exit",
    "builtins:int", "math:pi", "numpy.random:rand", "__main__:x", "simsat:fly",
)  # fmt: skip


def number(rng: random.Random) -> str:
    """A number, or what looks like one."""
    if rng.random() < 0.3:
        return repr(rng.choice([1, -1]) * rng.random() * 10.0 ** rng.randint(-20, 20))
    return rng.choice(NUMBERS)


def word(rng: random.Random) -> str:
    """Text: short, long, empty, of any script, with what shells and terminals take for commands."""
    if rng.random() < 0.25:
        return "".join(chr(rng.choice([rng.randint(1, 127), rng.randint(128, 0xD7FF)]))
                       for _ in range(rng.randint(1, 12)))  # fmt: skip
    return rng.choice(WORDS)


def value(rng: random.Random) -> str:
    """Either."""
    return number(rng) if rng.random() < 0.6 else word(rng)


def argument(text: str) -> str:
    """The text as a command line can hold it: no NUL."""
    return text.replace("\x00", "")


def mangled(content: bytes, rng: random.Random) -> bytes:
    """Bytes cut, flipped, doubled, swapped, or with something else among them."""
    data = bytearray(content)
    for _ in range(rng.randint(1, 4)):
        at = rng.randrange(len(data) + 1)
        kind = rng.randrange(7)
        if kind == 0:
            del data[at:]
        elif kind == 1 and data:
            data[at % len(data)] ^= 1 << rng.randrange(8)
        elif kind == 2:
            data[at:at] = bytes(rng.randrange(256) for _ in range(rng.randint(1, 20)))
        elif kind == 3:
            del data[at : at + rng.randint(1, 30)]
        elif kind == 4:
            data[at:at] = data[: rng.randint(0, 60)]
        elif kind == 5:
            data[at:at] = value(rng).encode("utf-8", "surrogateescape")
        else:
            data[at:at] = rng.choice(
                [b"\x00", b"\xef\xbb\xbf", b"\xff\xfe", b"\r", b'"', b",", b";", b"\n\n"]
            )
    return bytes(data)


def kept(path: Path, content: bytes) -> str:
    """The path of a file with this content."""
    path.write_bytes(content)
    return str(path)


Draw = Callable[[random.Random, Path], Any]
