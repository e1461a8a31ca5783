"""The recipe of the conda package says the same as `pyproject.toml` and `Cargo.toml`."""

import re

import tomllib
from command import ROOT

RECIPE = (ROOT / "conda/recipe.yaml").read_text()
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())


def stated(key: str) -> str:
    """The value of a key, or of a requirement, in the recipe."""
    return re.search(rf"^ *(?:- )?{key}:? *\"?([^\"\n]*)", RECIPE, re.MULTILINE).group(1)


def test_the_recipe_agrees_with_the_project():
    project = PROJECT["project"]
    assert stated("version") == tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"]
    assert f">={stated('python_min')}" == project["requires-python"]
    assert f"numpy{stated('numpy')}" in project["dependencies"]
    assert f"maturin{stated('maturin')}" in PROJECT["build-system"]["requires"]
    assert stated("license") == project["license"]
    assert stated("summary") == project["description"]
    assert stated("repository") == project["urls"]["Repository"]


def test_the_recipe_names_licences_that_the_source_distribution_has():
    files = stated("license_file").strip("[]").split(", ")
    assert set(files) - {"THIRDPARTY.yml"} <= set(PROJECT["project"]["license-files"])
