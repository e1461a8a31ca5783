"""Licences, sources and duplicates of all dependencies, by the rules of deny.toml.

`cargo deny check` holds the same rules, and looks for known vulnerabilities besides; it needs a network and is run by the
workflow. This test reads `cargo metadata`, so that every machine that builds the project checks them."""

import json
import re
import subprocess
from functools import cache

import tomllib
from command import ROOT

RULES = tomllib.loads((ROOT / "deny.toml").read_text())
CRATES_IO = "registry+https://github.com/rust-lang/crates.io-index"


@cache
def packages():
    """Everything that any crate of the workspace may be built with."""
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--all-features"]
    return json.loads(subprocess.check_output(command, text=True, cwd=ROOT))["packages"]


def is_allowed(expression):
    """Whether a licence expression (SPDX) can be met with the allowed licences alone."""
    allowed = set(RULES["licenses"]["allow"])
    # `A/B` is how old manifests write `A OR B`.
    tokens = re.findall(r"\(|\)|[^\s()]+(?: WITH [^\s()]+)?", expression.replace("/", " OR "))

    def alternatives():
        met = terms()
        while tokens and tokens[0] == "OR":
            tokens.pop(0)
            met = terms() or met
        return met

    def terms():
        met = term()
        while tokens and tokens[0] == "AND":
            tokens.pop(0)
            met = term() and met
        return met

    def term():
        token = tokens.pop(0)
        if token != "(":
            return token in allowed
        met = alternatives()
        assert tokens.pop(0) == ")"
        return met

    return alternatives()


def test_expressions_are_understood():
    assert is_allowed("MIT OR Apache-2.0") and is_allowed("MIT/Apache-2.0")
    assert is_allowed("(MIT OR GPL-3.0-only) AND Unicode-3.0") and is_allowed("Apache-2.0 WITH LLVM-exception")
    assert not is_allowed("GPL-3.0-only") and not is_allowed("MIT AND GPL-3.0-only")


def test_licences_are_allowed():
    refused = [f"{p['name']}: {p['license']}" for p in packages() if not is_allowed(p["license"] or "none")]
    assert not refused


def test_sources_are_the_registry():
    assert not [p["name"] for p in packages() if p["source"] not in (None, CRATES_IO)]


def test_no_version_is_a_wildcard():
    own = [package for package in packages() if package["source"] is None]
    versions = [
        (p["name"], d["name"]) for p in own for d in p["dependencies"] if d["req"] == "*" and not d.get("path")
    ]
    assert not versions
