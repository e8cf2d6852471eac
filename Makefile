# `make demo` and `make test` are all a newcomer needs: both set up .venv on first use.

PYTHON ?= $(shell command -v python3.11 || command -v python3)
VENV := .venv
BIN := $(VENV)/bin
DEMO := build/demo
PIP := --quiet --disable-pip-version-check --no-compile
# `make test LOCKED=1` installs the versions of this file, which a release was tested with.
LOCK := requirements/locked.txt
CONSTRAINT = $(if $(LOCKED),--constraint $(LOCK))
PIP += $(CONSTRAINT)
# What an installation is made of, beside modules: grammars, templates and texts are compiled.
PACKED = pyproject.toml runtime/pyproject.toml $(wildcard grammars/*.lark \
	src/rtgen/templates/*.j2 src/rtgen/templates/*/*.j2 src/rtgen/locale/*/LC_MESSAGES/*.po src/rtgen/compiler/backends/kit/rendering.py)
INSTALL = $(BIN)/python tests/environments.py $(CONSTRAINT)
# Tests start many processes: bytecode is written once, by the first that imports something.
unexport PYTHONDONTWRITEBYTECODE

IS_NEW_ENOUGH := import sys; sys.exit(sys.version_info < (3, 11))
VERSION := import sys; print("%d.%d" % sys.version_info[:2])

# An environment that is too old, or broken, is of no use; one of another Python than that which was
# asked for is the user's to remove.
ifneq ($(wildcard $(VENV)),)
ifneq ($(shell $(BIN)/python -c '$(IS_NEW_ENOUGH)' 2>/dev/null && echo yes),yes)
$(info $(VENV) has no Python 3.11 or later and is made anew)
$(shell rm -rf $(VENV))
else ifneq ($(filter command environment,$(firstword $(origin PYTHON))),)
ifneq ($(shell $(BIN)/python -c '$(VERSION)'),$(shell $(PYTHON) -c '$(VERSION)' 2>/dev/null))
ifeq ($(filter clean,$(MAKECMDGOALS)),)
$(error $(VENV) has another Python than $(PYTHON): run `make clean` first)
endif
endif
endif
endif

.PHONY: demo gallery test nightly dear codecs speed sanitized format lint types mypy pyright imports drift pytest waits peers test-openrtm interpreters interpreter interpreted lowest lock licences wheels release ui page pictures looks fuzz mutants soak bench clean

demo: $(VENV)/demo.stamp
	$(BIN)/rtgen generate
	mkdir -p $(DEMO)
	$(BIN)/rtgen run specs/navigation/rh3_goal.xml --plot $(DEMO)/goal.svg --csv $(DEMO)/goal.csv
	$(BIN)/rtgen run specs/navigation/rh3_path.xml --plot $(DEMO)/path.svg --csv $(DEMO)/path.csv
	$(BIN)/rtgen graph specs/navigation/rh3_goal.xml -o $(DEMO)/wiring.svg
	@echo "Pictures: $(DEMO)/goal.svg $(DEMO)/path.svg $(DEMO)/wiring.svg; trajectories: $(DEMO)/goal.csv $(DEMO)/path.csv"

# docs/gallery.md with its diagrams and pictures.
gallery: $(VENV)/test.stamp
	$(BIN)/python tests/reference/gallery.py

# Tests wait for clocks and processes now and then; what else is checked is done meanwhile.
# `make test WING=compiler` runs the tests of tests/compiler alone.
test: $(VENV)/uv.stamp
	$(MAKE) --no-print-directory -j 4 pytest waits $(if $(WING),,lint types imports drift)

# What takes longer: the random tests with other inputs, drawn by the seed of the commit (RTGEN_SEED=N sets
# another), a quarter of the tests marked `nightly` and of the fast tests on a further interpreter (RTGEN_BUDGET=1:
# all, with the coverage of lines), and what a release consists of.
nightly: export RTGEN_SEED ?= $(shell $(PYTHON) tests/seeds.py)
nightly: $(VENV)/uv.stamp $(VENV)/release.stamp page
	$(MAKE) --no-print-directory -j 4 dear codecs interpreters release

CHECKED = src runtime speed reference examples tests benchmarks requirements editors hatch_build.py mkdocs_hooks.py ui/build.py

lint: $(VENV)/test.stamp
	$(BIN)/python tests/python_form.py $(CHECKED)
	$(BIN)/ruff check $(CHECKED)

# As of one of the versions that pyproject.toml names; commits try them in turn.
types: mypy pyright

mypy: $(VENV)/test.stamp
	$(BIN)/mypy --python-version $$($(BIN)/python tests/interpreters.py --version) src runtime/src reference generated mkdocs_hooks.py editors/vscode/pack.py

pyright: $(VENV)/test.stamp
	PYRIGHT_PYTHON_IGNORE_WARNINGS=1 $(BIN)/pyright --pythonpath $(BIN)/python

imports: $(VENV)/test.stamp
	$(BIN)/lint-imports

drift: $(VENV)/test.stamp
	$(BIN)/rtgen check

# Each worker begins with a part of the files, so what tests of a file share is made once. There are more
# workers than processors, since many tests wait for programs, browsers and peers.
# Assertions that show their values take time to be compiled: only what fails has them.
pytest: $(VENV)/test.stamp page peers speed
	$(call PYTEST,build/pytest$(OF_WING),-m "not waits and not nightly" $(FOLDER),3)

# Tests that wait for clocks and processes most of their time, and need no processor meanwhile.
waits: $(VENV)/test.stamp page peers
	$(if $(WAITING),$(call PYTEST,build/pytest-waits$(OF_WING),-m "waits and not nightly" $(WAITING)))

dear: $(VENV)/test.stamp page peers speed
	$(call PYTEST,build/pytest-nightly$(OF_WING),-m "(nightly and not left_out and not postponed) or random" $(FOLDER))

# The tests of marshalling once more, with the codecs in C.
codecs: export RTGEN_CODEC = c
codecs: export PYTHONPATH = $(CURDIR)/build/speed
codecs: speed
	$(call PYTEST,build/pytest-codecs,$(MARSHALLING))

MARSHALLING = tests/compiler/types tests/fuzz/test_doors.py tests/ros2/test_marshaling.py \
	tests/runtime/corba/test_corba_anys.py tests/runtime/corba/test_corba_types.py \
	tests/runtime/system/test_data_port_buffers.py tests/runtime/system/test_latencies.py \
	tests/runtime/system/test_ports_in_c.py tests/runtime/system/test_value_checks.py tests/interop/test_cdr_constructs.py \
	tests/interop/test_cdr_omniorb.py tests/interop/test_random_types_omniorb.py \
	tests/tools/diff/test_wire_of_types.py

FOLDER = tests$(if $(WING),/$(WING))
# Failures of another wing are not tried again.
OF_WING = $(if $(WING),-$(WING))
WAITING = $(shell grep -rl --include='*.py' mark.waits $(FOLDER))

define PYTEST
$(BIN)/pytest -n $(or $(3),2) --dist worksteal --assert=plain -o cache_dir=$(1) $(2) || \
    $(BIN)/python tests/unsteady.py $$? $(1)
endef

# The OpenRTM-aist-Python of test-openrtm, soak and bench: SITE is the folder that has its package
# OpenRTM_aist and its .pth file.
OPENRTM = $(if $(SITE),OPENRTM_SITE="$(realpath $(SITE))" PYTHONPATH=$(CURDIR)/tests/openrtm/startup)

# The tests of OpenRTM on an installed one. One process: OpenRTM has one manager and one ORB in each.
test-openrtm: $(VENV)/test.stamp
	@test -d "$(SITE)/OpenRTM_aist" || \
	    { echo "make test-openrtm SITE=FOLDER: there is no $(SITE)/OpenRTM_aist" >&2; exit 2; }
	$(OPENRTM) $(BIN)/pytest tests/openrtm

# The fast tests again on another interpreter, those with peers left out.
# Each commit tries one; `tests/interpreters.py --all` tries all that this machine has.
interpreters: interpreter
	$(MAKE) --no-print-directory interpreted

# The environment of the other interpreter; one processor installs it, one that of this one.
interpreter: $(VENV)/uv.stamp
	$(BIN)/python tests/interpreters.py --install

interpreted:
	$(BIN)/python tests/interpreters.py --installed

# The same on this interpreter with the lowest versions that pyproject.toml allows.
lowest: $(VENV)/release.stamp
	$(BIN)/python tests/interpreters.py --lowest

# The newest versions that pyproject.toml allows, for each platform and interpreter.
lock: $(VENV)/release.stamp
	$(BIN)/uv pip compile --quiet --universal --upgrade --no-header --no-annotate \
	    --python-version 3.11 --extra plot --extra test --extra check --extra release --no-emit-package rtgen-runtime pyproject.toml --output-file $(LOCK)

# What rtgen and its extras require, and what its page contains, with the licence that each package states.
licences: $(VENV)/release.stamp ui
	$(BIN)/python requirements/licences.py > requirements/licences.md

# Both wheels and the bill of materials of an environment that has rtgen alone, with the packages in its
# page, in dist/. A build has
# the locked versions of its tools, which a wheel contains traces of; pip 25.3 renamed the variable.
wheels: export PIP_CONSTRAINT = $(CURDIR)/$(LOCK)
wheels: export PIP_BUILD_CONSTRAINT = $(CURDIR)/$(LOCK)
wheels: $(VENV)/release.stamp ui
	rm -rf dist build/bare
	$(BIN)/python -m pip wheel $(filter-out --no-compile,$(PIP)) --no-deps --wheel-dir dist . ./runtime
	$(PYTHON) -m venv build/bare
	$(BIN)/python -m pip --python build/bare/bin/python install $(PIP) dist/*.whl
	$(BIN)/python -m pip --python build/bare/bin/python uninstall --quiet --yes setuptools pip
	$(BIN)/cyclonedx-py environment --output-reproducible --pyproject pyproject.toml \
	    --output-file dist/rtgen.cdx.json build/bare/bin/python
	$(BIN)/python requirements/page.py dist/rtgen.cdx.json

# What a release publishes, built twice and compared, with its notes; nothing is published. `TAG=v1.2.3`:
# the version is that of the tag, and its notes are in the changelog.
release: $(VENV)/release.stamp
	$(MAKE) --no-print-directory wheels LOCKED=1
	rm -rf build/first && mv dist build/first
	$(MAKE) --no-print-directory wheels LOCKED=1
	diff --recursive build/first dist
	$(if $(TAG),test "$(TAG)" = "v$(VERSION_OF_RTGEN)" && test -z "$(FRAGMENTS)",\
	    $(BIN)/towncrier build --draft --version "$(VERSION_OF_RTGEN)")

VERSION_OF_RTGEN = $(lastword $(shell $(BIN)/rtgen --version))
FRAGMENTS = $(wildcard changelog.d/*.md)

# `make fuzz DOOR=idl SECONDS=600` explores one place where octets enter (tests/fuzz/doors, `all` for
# each), guided by coverage; `TOTAL=1000000` passes it that number of inputs, faster and without coverage;
# `TYPES=2000` checks the packages generated from that number of accepted inputs. Without DOOR:
# The random tests with thirty times their inputs, others each time: `make fuzz RTGEN_SEED=7` repeats them.
# Those of `make test` are the same each time; `make test RTGEN_SEED=7` draws others.
fuzz: SECONDS ?= 60
fuzz: export RTGEN_SEED ?= $(shell date +%s)
fuzz: export RTGEN_BUDGET ?= 30
fuzz: $(VENV)/test.stamp
ifdef DOOR
	$(BIN)/python tests/fuzz/harness.py $(filter-out all,$(DOOR)) --seconds $(SECONDS) \
	    $(if $(TOTAL),--total $(TOTAL)) $(if $(TYPES),--types $(TYPES)) $(if $(FIRST),--first $(FIRST))
else
	$(BIN)/pytest -n 2 --dist worksteal -m random
endif

# Changes of layouts, codecs, life cycle and SDO machines that their tests shall notice (mutmut has to be
# installed): `make mutants MODULE=sdo` runs one part, and goes on where the last run was stopped.
mutants: $(VENV)/test.stamp
	$(BIN)/python tests/mutants.py $(MODULE)

# Ten million calls and frames, and 24 simulated hours: `make soak SHARE=0.01 PARTS="calls rh3"` does less.
soak: SHARE ?= 1
soak: $(VENV)/test.stamp
	$(OPENRTM) $(BIN)/python tests/soak.py $(PARTS) --share $(SHARE)
# The page of `rtgen ui`, with the node of this machine, else with that of a wheel.
ui: $(VENV)/test.stamp
	$(BIN)/python ui/build.py

# The page and a Chromium for its tests, which are skipped where npm's packages cannot be had.
page: export npm_config_fetch_retries = 1
page: export npm_config_fetch_timeout = 20000
page: $(VENV)/test.stamp
	@mkdir -p build
	@$(BIN)/python ui/build.py --browser > build/page.log 2>&1 || \
	    { tail -5 build/page.log; echo "the tests of the page are skipped"; }

# Installations of ROS 2 for tests, which are skipped where its packages cannot be had.
peers: $(VENV)/test.stamp
	@mkdir -p build
	@$(BIN)/python tests/ros2_peers.py > build/peers.log 2>&1 || \
	    { tail -3 build/peers.log; echo "the tests with ROS 2 are skipped"; }

# The codecs in C, of which the tests are skipped where there is no compiler.
speed: $(VENV)/test.stamp
	@mkdir -p build
	@$(BIN)/python tests/speed.py > build/speed.log 2>&1 || \
	    { tail -3 build/speed.log; echo "the tests of the codecs in C are skipped"; }

# The codecs in C with the sanitizers of gcc, on changed octets of all types.
sanitized: SECONDS ?= 60
sanitized: $(VENV)/test.stamp
	$(BIN)/python tests/sanitized.py --seconds $(SECONDS) $(if $(FIRST),--first $(FIRST))

# The pictures of docs/ui.md.
pictures: page
	RTGEN_PICTURES=yes $(BIN)/pytest -q tests/ui/application/test_page_gallery.py

# Pictures of ten systems in their main views, in build/looks, to be looked at; and the flaws found in them.
looks: page
	RTGEN_LOOKS=build/looks $(BIN)/pytest -q tests/ui/application/test_page_systems.py

# Measures, stores the results, and makes the tables of docs/speed.md of them.
bench: SCRIPTS ?= $(shell grep -l "Arguments(__doc__" benchmarks/*.py)
bench: $(VENV)/bench.stamp
	for script in $(SCRIPTS); do $(OPENRTM) $(BIN)/python $$script --store || exit 1; done
	$(BIN)/python benchmarks/speed_page.py

format: $(VENV)/test.stamp
	$(BIN)/black --quiet $(CHECKED)
	$(BIN)/ruff check --fix $(CHECKED)

clean:
	rm -rf build dist $(VENV)

$(VENV)/bin/python:
	@$(PYTHON) -c '$(IS_NEW_ENOUGH)' 2>/dev/null || { \
	  echo "rtgen needs Python 3.11 or later, and '$(PYTHON)' is none: make PYTHON=python3.11" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)

$(VENV)/demo.stamp: $(PACKED) | $(VENV)/bin/python
	$(BIN)/python -m pip install $(PIP) --editable ./runtime --editable ".[plot]"
	touch $@

$(VENV)/test.stamp: $(PACKED) | $(VENV)/uv.stamp
	$(INSTALL) --editable ./runtime --editable ".[plot,test,check]"
	touch $@

$(VENV)/release.stamp: $(VENV)/test.stamp
	$(INSTALL) --editable ./runtime --editable ".[plot,test,check,release]"
	touch $@

$(VENV)/bench.stamp: $(PACKED) | $(VENV)/uv.stamp
	$(INSTALL) --editable ./runtime --editable ".[plot,test,check,bench]"
	touch $@

# uv installs the test environments within seconds; where it cannot be had, pip does.
$(VENV)/uv.stamp: | $(VENV)/bin/python
	-$(BIN)/python -m pip install $(PIP) "uv>=0.9"
	touch $@
