"""Which rules are meant: profiles, and rules by id, beginning of an id or name."""
from __future__ import annotations

from typing import Optional, Sequence, Union

from . import _norma

PROFILES = {"auto": 0, "render": 1, "print": 2, "generated": 3}
Names = Union[str, Sequence[str], None]


def mask_of(select: Names, ignore: Names) -> Optional[bytes]:
    """One byte for each rule, 1 if it is chosen; None: all."""
    if select is None and ignore is None:
        return None
    count = len(_norma.rules())
    chosen = _marked("select", select, count) if select is not None else bytes([1]) * count
    left_out = _marked("ignore", ignore, count) if ignore is not None else bytes(count)
    return bytes(a & (1 - b) for a, b in zip(chosen, left_out))


def _marked(name: str, names: Names, count: int) -> bytes:
    try:
        words = names if isinstance(names, str) else ",".join(names or ())
    except TypeError:
        raise TypeError(f"{name}: names of rules are needed, not {names!r}") from None
    answer = _norma.rules_select(words, bytes(count))
    if isinstance(answer, str):
        raise ValueError(f"{name}: no rule is called {answer!r}")
    return bytes(answer)
