import doctest
import importlib
import pathlib
import pkgutil

import pytest
import shotline

NAMES = {name: getattr(shotline, name) for name in shotline.__all__}
MODULES = [m.name for m in pkgutil.iter_modules(shotline.__path__) if m.name not in ("_native", "__main__", "dask")]


@pytest.mark.parametrize("name", ["", *MODULES])
def test_examples(name):
    module = importlib.import_module(f"shotline.{name}".rstrip("."))
    others = {known: thing for known, thing in NAMES.items() if known not in vars(module)}
    assert doctest.testmod(module, extraglobs=others).failed == 0


def test_everything_public_is_documented():
    for name in shotline.__all__:
        thing = getattr(shotline, name)
        assert name.startswith("__") or thing.__doc__, name
        for attribute, value in vars(thing).items() if isinstance(thing, type) else ():
            if not attribute.startswith("_") and (callable(value) or isinstance(value, property)):
                if not (issubclass(thing, tuple) and isinstance(value, property)):
                    assert value.__doc__, f"{name}.{attribute}"


def test_each_kind_of_solid_has_a_picture():
    """`python docs/solids.py` makes them, from an example of each kind."""
    pictures = pathlib.Path(__file__).resolve().parents[2] / "docs/pictures/solids"
    assert {path.stem for path in pictures.glob("*.png")} == set(shotline.solids.__all__)
    assert sum(path.stat().st_size for path in pictures.glob("*.png")) < 400_000
