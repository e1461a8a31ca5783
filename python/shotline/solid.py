"""The base of the classes of solids."""

from __future__ import annotations

from math import isfinite
from typing import Any

from . import _native
from .nodes import Node, _set
from .values import no_attribute, number, numbers, rows

# Name, count of numbers, whether it is rows of so many, and default.
Parameter = tuple[str, int, bool, tuple[float, ...] | None]

_FLOATS = {float}


class Solid(Node):
    """A parametric solid: the base of the classes of `shotline.solids`."""

    __slots__ = ("_values",)
    _kind = ""
    _params: tuple[Parameter, ...] = ()
    _names: frozenset[str] = frozenset()
    # The names in their order, if every parameter is one number; else None.
    _scalars: list[str] | None = None

    def __init_subclass__(cls) -> None:
        cls._names = frozenset(name for name, *_ in cls._params)
        are_scalars = all(count == 1 and not is_rows for _, count, is_rows, _ in cls._params)
        cls._scalars = [name for name, *_ in cls._params] if are_scalars else None

    def __init__(self, *args: Any, **values: Any) -> None:
        # Scenes have many solids, most of which are given all of their parameters by name, and many all as floats.
        if not args and [*values] == self._scalars and _FLOATS.issuperset(map(type, values.values())):
            flat = [[value] for value in values.values()]
            if isfinite(sum(values.values())):
                _native.check_solid(self._kind, flat)
                _set(self, "_values", values)
                return
        self._set_values(args, values)

    def _set_values(self, args: tuple[Any, ...], values: dict[str, Any]) -> None:
        """The same for parameters of any kind, given in any way."""
        given = values if not args and values.keys() == self._names else self._given(args, values)
        found: dict[str, Any] = {}
        flat: list[list[float]] = []
        for name, count, is_rows, default in self._params:
            value = given[name] if name in given else _value(default or ())
            if name in given:
                value = _parameter(value, count, is_rows, name)
            found[name] = value
            flat.append(_flat(value))
        _native.check_solid(self._kind, flat)
        _set(self, "_values", found)

    def _given(self, args: tuple[Any, ...], values: dict[str, Any]) -> dict[str, Any]:
        """The parameters that are given, by name. Raises TypeError for those that are missing, unknown, or too many."""
        names = [name for name, *_ in self._params]
        given = dict(zip(names, args, strict=False))
        required = [name for name, _, _, default in self._params if default is None]
        wrong = [f"{len(args)} parameters are too many"] if len(args) > len(names) else []
        wrong += [f"{name} is given twice" for name in values if name in given]
        wrong += [f"no parameter {name!r}" for name in values if name not in names]
        wrong += [f"{name} is missing" for name in required if name not in given and name not in values]
        if any(name in ("center", "centre", "position", "origin") for name in values):
            wrong.append("solids are placed with .translate(x, y, z)")
        if wrong:
            shown = ", ".join(f"{name}={_default(default)}" for name, _, _, default in self._params)
            raise TypeError(f"{type(self).__name__}({shown}): {'; '.join(wrong)}")
        return given | values

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *(name for name, *_ in self._params)})

    def __getattr__(self, name: str) -> Any:
        try:
            return object.__getattribute__(self, "_values")[name]
        except (KeyError, AttributeError):
            raise AttributeError(no_attribute(type(self).__name__, name)) from None

    def _keys(self) -> dict[str, Any]:
        return {"kind": self._kind, **self._values}

    def _text(self) -> str:
        # Much faster than to encode the keys, and scenes have many solids.
        text = f'{{"kind": "{self._kind}"'
        for name, value in self._values.items():
            text += f', "{name}": {repr(value) if type(value) is float else _rows(value)}'
        return text

    def __repr__(self) -> str:
        shown = ", ".join(f"{n}={v}" for n, v in self._values.items())
        return f"{type(self).__name__}({shown})"


def _default(numbers: tuple[float, ...] | None) -> str:
    """The default of a parameter as text; dots if it has none."""
    if numbers is None:
        return "..."
    texts = [f"{x:g}" for x in numbers]
    return texts[0] if len(texts) == 1 else f"({', '.join(texts)})"


def _value(numbers: tuple[float, ...]) -> Any:
    return numbers[0] if len(numbers) == 1 else numbers


def _parameter(value: Any, count: int, is_rows: bool, name: str) -> Any:
    if count == 1 and not is_rows:
        plain = number(value, name)
        if isfinite(plain):
            return plain
    if is_rows:
        return rows(value, count, name)
    return _value(numbers(number(value, name) if count == 1 else value, count, name))


def _rows(value: tuple[Any, ...]) -> str:
    """Finite numbers, or rows of them, as JSON."""
    return repr([list(row) if isinstance(row, tuple) else row for row in value])


def _flat(value: Any) -> list[float]:
    """The numbers of a value: of a number, of several, or of rows."""
    if isinstance(value, float):
        return [value]
    return [x for row in value for x in row] if value and isinstance(value[0], tuple) else list(value)
