"""A function of arrays that remembers its last call."""

from collections.abc import Callable
from typing import Generic, TypeVar

import numpy as np

Result = TypeVar("Result")


class LastCall(Generic[Result]):
    """Caches the last call of a function of arrays.

    A live screen linearises the same hover repeatedly with other gains, where the part of the plant
    does not change.
    """

    def __init__(self, function: Callable[..., Result]) -> None:
        self._function = function
        self._result: tuple[bytes, Result] | None = None

    def __call__(self, *arrays: np.ndarray) -> Result:
        key = b"".join(array.tobytes() for array in arrays)
        if self._result is None or self._result[0] != key:
            self._result = (key, self._function(*arrays))
        return self._result[1]

    def forget(self) -> None:
        """Clear the cache."""
        self._result = None
