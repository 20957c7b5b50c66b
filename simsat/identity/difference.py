"""In words: how what a result was made with differs from what is here now."""

from typing import Any

SAID = {
    "model": "the compiled model (its file, an included file or an asset was edited)",
    "profile": "the content of the profile",
    "network": "the content of --network",
    "learned.network": "the content of --learned.network",
    "orbit.tle": "the content of --orbit.tle",
    "reference.to": "the content of --reference",
}


def differences(then: dict[str, Any], now: dict[str, Any]) -> list[str]:
    """A phrase for each part of two identities that differs; what only one of them has counts."""
    phrases = [SAID[name] for name in ("model", "profile") if then.get(name) != now.get(name)]
    for group in ("networks", "files"):
        phrases += [SAID.get(name, name) for name in _unequal(then, now, group)]
    phrases += [f"the code of '{name}'" for name in _unequal(then, now, "plugins")]
    phrases += _code(_group(then, "code"), _group(now, "code"))
    for name in _unequal(then, now, "packages"):
        old, new = (_group(side, "packages").get(name) for side in (then, now))
        phrases.append(f"{name} was {old}, now {new}")
    for name in ("python", "platform"):
        if then.get(name) != now.get(name):
            phrases.append(f"{name} was {then.get(name)}, now {now.get(name)}")
    return phrases


def _unequal(then: dict[str, Any], now: dict[str, Any], group: str) -> list[str]:
    old, new = _group(then, group), _group(now, group)
    return [name for name in dict.fromkeys([*old, *new]) if old.get(name) != new.get(name)]


def _group(identity: dict[str, Any], name: str) -> dict[str, Any]:
    """A group of an identity that may come from a damaged file."""
    found = identity.get(name)
    return found if isinstance(found, dict) else {}


def _code(then: dict[str, Any], now: dict[str, Any]) -> list[str]:
    """By its source: revisions that differ only in documents and tests are the same code."""
    if then.get("sha256") == now.get("sha256"):
        return []
    return [f"simsat's own code was {_named(then)}, now {_named(now)}"]


def _named(code: dict[str, Any]) -> str:
    named = code.get("revision") or code.get("version") or "unknown"
    return f"{named} ({str(code.get('sha256'))[:8]})"
