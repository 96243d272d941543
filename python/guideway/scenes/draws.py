"""Random whole numbers that are the same on every machine and with every version of Python."""

from __future__ import annotations

from collections.abc import MutableSequence, Sequence
from typing import TypeVar

_T = TypeVar("_T")
_MASK = (1 << 64) - 1


class Draws:
    """SplitMix64: a counter whose bits are mixed. Whole numbers alone, so that no rounding can differ.

    ``seed`` is any whole number from 0, ``stream`` tells apart what is drawn from one seed.
    """

    def __init__(self, seed: int, stream: str = "") -> None:
        self._state = 0
        for byte in (*seed.to_bytes(max(8, (seed.bit_length() + 7) // 8), "little"), *stream.encode()):
            self._state = self.bits() ^ byte

    def bits(self) -> int:
        """64 random bits."""
        self._state = (self._state + 0x9E3779B97F4A7C15) & _MASK
        z = self._state
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & _MASK
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & _MASK
        return z ^ (z >> 31)

    def below(self, count: int) -> int:
        """A whole number from 0 to ``count`` - 1; the bias is below ``count`` / 2^64."""
        return (self.bits() * count) >> 64

    def between(self, low: int, high: int) -> int:
        """A whole number from ``low`` to ``high``, both included."""
        return low + self.below(high - low + 1)

    def choice(self, items: Sequence[_T]) -> _T:
        """One of ``items``."""
        return items[self.below(len(items))]

    def shuffle(self, items: MutableSequence[_T]) -> None:
        """Brings ``items`` into a random order, in place."""
        for last in range(len(items) - 1, 0, -1):
            other = self.below(last + 1)
            items[last], items[other] = items[other], items[last]
