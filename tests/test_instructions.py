"""The table of instruction counts is compared and written as its readers expect; nothing is measured."""

import importlib.util

import pytest
from command import ROOT


@pytest.fixture
def instructions(tmp_path):
    spec = importlib.util.spec_from_file_location("instructions", ROOT / "bench/instructions.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.TABLE = tmp_path / "instructions.tsv"
    return module


def test_growth_fails_and_a_fall_is_named(instructions):
    known = {"box": (1000, ""), "ball": (1000, "")}
    assert instructions.compare({"box": 1049, "ball": 951}, known)[0]
    passed, verdict = instructions.compare({"box": 1051, "ball": 900}, known)
    assert not passed and "box" in verdict and "ball" not in verdict
    passed, verdict = instructions.compare({"box": 1000, "ball": 900}, known)
    assert passed and "lower those of ball" in verdict
    # A cast that is not in the table, and one that is no longer there.
    assert not instructions.compare({"box": 1000, "ball": 1000, "cone": 1}, known)[0]
    assert not instructions.compare({"box": 1000}, known)[0]


def test_growth_is_written_with_its_reason(instructions):
    instructions.write_table({"box": 1000, "ball": 1000}, {}, "")
    compiler, known = instructions.read_table()
    assert (compiler, known) == (instructions.compiler(), {"box": (1000, ""), "ball": (1000, "")})
    with pytest.raises(SystemExit, match="say why"):
        instructions.write_table({"box": 1100, "ball": 1000}, known, "")
    assert instructions.read_table()[1] == known
    instructions.write_table({"box": 1100, "ball": 900}, known, "exact")
    instructions.write_table({"box": 1101, "ball": 900}, instructions.read_table()[1], "another")
    assert instructions.read_table()[1] == {"box": (1101, "exact"), "ball": (900, "")}


def test_the_table_is_of_the_casts_of_the_program(instructions):
    text = (ROOT / "bench/instructions.tsv").read_text().splitlines()[2:]
    source = (ROOT / "crates/shotline/examples/instructions.rs").read_text()
    assert len(text) > 10 and all(f'("{row.split(chr(9))[0]}", ' in source for row in text)
