# `make` alone lists the targets.

CARGO ?= cargo
PYTHON ?= python3
# An optional folder with more data beside this one; nothing here requires it.
SHARED ?= ../shared
# Rays of each family in `make soak`.
RAYS ?= 100000000

# How the program and the package are built. The tests use the profile and the features of Rust's own tests, so that all share
# one build of the core.
PROFILE ?= release
FEATURES := $(if $(filter dev,$(PROFILE)),--features shotline/testkit --features shotline-io/testkit)
TESTED := --workspace --exclude shotline-python --exclude shotline-benches --all-features
SHOTLINE := $(abspath $(or $(CARGO_TARGET_DIR),target))/$(if $(filter dev,$(PROFILE)),debug,$(PROFILE))/shotline
VENV := .venv
export SHOTLINE

.PHONY: help build demo test test-built instructions package wheels docs truth truth-built soak bench fuzz pictures docs-pictures clean
.NOTPARALLEL:

help: ## print this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-13s  %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

build: ## build the optimised program
	$(CARGO) build --profile $(PROFILE)

demo: build ## render pictures and measure speeds, into out/demo
	$(PYTHON) demo/demo.py --program $(SHOTLINE) --data $(SHARED)/data

test: $(VENV)/ready ## check format, lints and documentation; test the libraries and the program
	$(CARGO) fmt --check
	$(VENV)/bin/ruff format --check
	$(VENV)/bin/ruff check
	$(VENV)/bin/mypy
	$(VENV)/bin/codespell
	$(CARGO) clippy --workspace --all-targets --all-features -- -D warnings
	$(CARGO) check --quiet --locked --manifest-path fuzz/Cargo.toml --target-dir target
	$(CARGO) package --quiet --workspace --exclude shotline-python --exclude shotline-benches --no-verify --allow-dirty
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --workspace --no-deps --all-features --document-private-items
	$(CARGO) test --no-fail-fast $(TESTED)
	$(PYTHON) bench/instructions.py
	$(MAKE) test-built PROFILE=dev
	@cat out/instructions.txt

# The program that the tests of Rust have built, and the package, as their users meet them.
test-built: package
	$(VENV)/bin/python -m pytest -q -p no:cacheprovider tests python/tests
	$(MAKE) docs

package: $(VENV)/ready ## build the Python package and install it in .venv
	PATH="$(abspath $(VENV))/bin:$$PATH" pip install --quiet --disable-pip-version-check --no-build-isolation --no-deps --force-reinstall \
		--config-settings=build-args="--profile $(PROFILE) $(FEATURES)" .

docs: $(VENV)/ready-docs package ## build the documentation site in out/site
	NO_MKDOCS_2_WARNING=1 $(VENV)/bin/mkdocs build --quiet --strict

# Zig links against the functions of an old system, so that the wheel runs on new ones too.
wheels: $(VENV)/ready-wheels ## build the wheel of the Python package for manylinux2014 in out/wheels, and try it without Rust
	rm -rf out/wheels
	PATH="$(abspath $(VENV))/bin:$$PATH" maturin build --release --locked --zig --compatibility manylinux2014 --out out/wheels
	$(VENV)/bin/auditwheel show out/wheels/*.whl
	$(VENV)/bin/python tests/try_wheel.py out/wheels/*.whl

# The tests of Rust build what is measured.
instructions: ## count the instructions of small casts, and write them into bench/instructions.tsv (REASON=, where they have grown)
	$(CARGO) test --no-run $(TESTED)
	$(PYTHON) bench/instructions.py --write --reason "$(REASON)"

ifneq ($(wildcard $(SHARED)/truth/run.py),)
truth: build truth-built ## score the program against the full truth sets, if present

# The program as it is: that of the tests has assertions too.
truth-built: $(VENV)/ready
	$(VENV)/bin/python $(SHARED)/truth/run.py --bin $(SHOTLINE) --out out/truth --family all --query crossings closest any count
	$(VENV)/bin/python $(SHARED)/truth/score.py out/truth
else
truth truth-built:
	@echo "truth: skipped, there is no $(SHARED)/truth; make test scores the selection in testdata/truth"
endif

soak: ## compare RAYS=100000000 rays of each family with slow checks that share no code with the solvers (an hour)
	SHOTLINE_SOAK=$(RAYS) $(CARGO) test --release -p shotline --features testkit --test soak -- --nocapture --test-threads 1

bench: build $(VENV)/ready ## measure rays per second: combinations, and meshes compared with Embree if available
	$(VENV)/bin/python bench/run.py --bin $(SHOTLINE)

# Seconds for each target of `make fuzz`.
FUZZ_SECONDS ?= 60
FUZZ_TARGETS ?= $(notdir $(basename $(wildcard fuzz/fuzz_targets/*.rs)))

fuzz: ## fuzz every reader and random combinations, FUZZ_SECONDS=60 each (needs cargo-fuzz)
	for target in $(FUZZ_TARGETS); do \
		mkdir -p out/fuzz/$$target && RUSTC_BOOTSTRAP=1 $(CARGO) fuzz run --sanitizer none $$target out/fuzz/$$target fuzz/corpus/$$target \
			-- -max_total_time=$(FUZZ_SECONDS) -timeout=5 -rss_limit_mb=2048 -dict=fuzz/json.dict || exit 1; \
	done

pictures: build ## render the pictures of the README and of the flake again (minutes)
	for scene in section tori instances quadrics; do \
		$(SHOTLINE) render scenes/$$scene.json -o docs/pictures/$$scene.png --size 720x540 --samples 48 --lighting soft || exit 1; \
	done
	$(SHOTLINE) render scenes/flake.json -o docs/pictures/flake.png --size 640x480 --samples 8
	$(SHOTLINE) slice scenes/section.json -o docs/pictures/slice-valve.png --plane y=0 --by material
	$(SHOTLINE) render scenes/section.json -o docs/pictures/edges-valve.png --size 400x300 --edges --view iso --background white
	$(SHOTLINE) render scenes/section.json -o docs/pictures/hatch-valve.png --size 400x300 --zoom 1.3 --background white --edges \
		--eye=-7,-12,6 --target 0,0,0.4 --clip 0,-1,0,-0.05 --hatch --hide ground --hide 'cut*'
	$(SHOTLINE) shoot scenes/section.json --from=-5,1,1.2 --dir=1,0,-0.1 --picture docs/pictures/shoot-valve.png --size 400x300
	$(SHOTLINE) render scenes/section.json -o docs/pictures/section-xray.png --size 720x540 --samples 16 --look xray

docs-pictures: build package ## render the pictures of the documentation again, with the bunny if present (minutes)
	$(PYTHON) demo/work.py --program $(SHOTLINE) --data $(SHARED)/data
	$(VENV)/bin/python docs/gallery.py
	$(VENV)/bin/python docs/solids.py
	$(VENV)/bin/python docs/tutorials.py
	$(VENV)/bin/python docs/lecture.py

clean: ## remove everything that was built
	$(CARGO) clean
	rm -rf out $(VENV)

$(VENV)/ready: tests/requirements.txt
	$(PYTHON) -m venv $(VENV)
	$(VENV)/bin/python -m pip install --quiet --disable-pip-version-check --no-cache-dir -r $<
	touch $@

$(VENV)/ready-wheels: tests/requirements-wheels.txt $(VENV)/ready
	$(VENV)/bin/python -m pip install --quiet --disable-pip-version-check --no-cache-dir -r $<
	touch $@

$(VENV)/ready-docs: docs/requirements.txt $(VENV)/ready
	$(VENV)/bin/python -m pip install --quiet --disable-pip-version-check --no-cache-dir -r $<
	touch $@
