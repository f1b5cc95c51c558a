# make demo   denoise a noisy thin-lens render, chart speed against accuracy
# make test   style, import contracts, tests
#
# Either makes .venv, installs what it needs into it once, and runs. Needed: python3 (3.11 to 3.13) with venv, make.
# uv is used where it is present. Other settings: make demo SCENE=glossy OUT=out/glossy PYTHON=python3.12

PYTHON ?= python3
SCENE  ?= dof
OUT    ?= out/$(SCENE)
VENV   := .venv
BIN    := $(VENV)/bin
UV     := $(shell command -v uv 2>/dev/null)
comma  := ,
# Unless you name a Python, uv may take any that fits.
UV_PYTHON := $(if $(filter file,$(origin PYTHON)),>=3.11$(comma)<3.14,$(PYTHON))

.PHONY: demo test bench clean

demo: $(VENV)/.installed-demo
	$(BIN)/mcdenoise compare $(SCENE) --out $(OUT)

test: $(VENV)/.installed-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports
	$(BIN)/python -m pytest

bench: $(VENV)/.installed-test
	$(BIN)/python -m mcdenoise.study.bench filters

clean:
	rm -rf $(VENV) out

# A stamp is written only after a whole installation, so an interrupted one starts again.
$(VENV)/.installed-demo: EXTRA :=
$(VENV)/.installed-test: EXTRA := [test]
$(VENV)/.installed-%: pyproject.toml
ifeq ($(UV),)
	@$(PYTHON) -c 'import sys; sys.exit(0 if (3, 11) <= sys.version_info[:2] <= (3, 13) else \
	  "mcdenoise needs Python 3.11 to 3.13, $(PYTHON) is " + sys.version.split()[0] + ". Try: make PYTHON=python3.12 $(MAKECMDGOALS)")'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --disable-pip-version-check --editable '.$(EXTRA)'
else
	$(UV) venv --allow-existing --python '$(UV_PYTHON)' $(VENV)
	$(UV) pip install --python $(BIN)/python --editable '.$(EXTRA)'
endif
	@touch $@
