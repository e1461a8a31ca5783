"""Arrays for scripts that are written for tensors of Open3D. These are recognised by their methods; Open3D is not
imported."""

from __future__ import annotations

from typing import Any

import numpy as np

from .values import floats


class Array(np.ndarray[Any, Any]):
    """A NumPy array that also has those methods of Open3D's tensors that scripts call on the results of ray casts."""

    def numpy(self) -> np.ndarray:
        """The same numbers as a plain NumPy array; not copied."""
        return self.view(np.ndarray)

    def cpu(self) -> Array:
        """The array itself, which is in the memory of the CPU."""
        return self

    def clone(self) -> Array:
        """A copy."""
        return self.copy()

    def isfinite(self) -> Array:
        """Where the numbers are finite: bool, of the same shape."""
        return np.isfinite(self).view(Array)

    def isinf(self) -> Array:
        """Where the numbers are infinite: bool, of the same shape."""
        return np.isinf(self).view(Array)

    def isnan(self) -> Array:
        """Where the numbers are NaN: bool, of the same shape."""
        return np.isnan(self).view(Array)


def unwrapped(values: Any) -> Any:
    """The numbers of a tensor as a NumPy array; anything else as it is."""
    return values.cpu().numpy() if _is_tensor(values) else values


def array(values: Any, what: str, columns: int) -> np.ndarray:
    """Real numbers of shape (..., columns) as float64, from anything that NumPy reads or from a tensor."""
    numbers = floats(unwrapped(values), what)
    if type(numbers) is not np.ndarray:
        numbers = numbers.view(np.ndarray)
    if numbers.ndim == 0 or numbers.shape[-1] != columns:
        raise ValueError(f"{what} must have shape (..., {columns}), not {numbers.shape}")
    return numbers


def like(source: Any, result: np.ndarray) -> Any:
    """The result as a tensor of the same type as the source if that is one, otherwise as an `Array`. Numbers of float64
    become float32."""
    single = result.astype(np.float32) if result.dtype == np.float64 else result
    if _is_tensor(source):
        return type(source)(np.ascontiguousarray(single))
    return single.view(Array)


def _is_tensor(value: Any) -> bool:
    return not isinstance(value, np.ndarray) and hasattr(value, "numpy") and hasattr(value, "cpu")
