# make demo       denoise a noisy thin-lens render, chart speed against accuracy
# make test       style, import contracts, tests
# make lab        open the exercises in JupyterLab (in work/; what you changed there stays as it is)
# make lectures   build the lecture site with slides and PDFs into out/lectures
# make notebooks  execute all notebooks into out/notebooks
# make figures    make the figures of the lectures and their numbers again
# make doctor     say what works on this machine, and what to install for more
#
# Each makes .venv, installs what it needs into it once, and runs. Needed: python3 (3.11 to 3.13) with venv, make.
# uv is used where it is present. Other settings: make demo SCENE=glossy OUT=out/glossy PYTHON=python3.12,
# make figures CHAPTERS=ch02, make lab LAB_ARGS=--no-browser, make lectures SITE_ARGS=--no-pdf

PYTHON   ?= python3
SCENE    ?= dof
OUT      ?= out/$(SCENE)
LAB_ARGS ?=
SITE_ARGS ?=
TEST_ARGS ?= --numprocesses 2 --dist loadgroup --no-loadscope-reorder
CHAPTERS ?=
VENV     := .venv
BIN      := $(VENV)/bin
LAB_SETTINGS := $(VENV)/share/jupyter/lab/settings
UV       := $(shell command -v uv 2>/dev/null)
comma    := ,
# Unless you name a Python, uv may take any that fits.
UV_PYTHON := $(if $(filter file,$(origin PYTHON)),>=3.11$(comma)<3.14,$(PYTHON))

.PHONY: demo test lab lectures notebooks figures doctor bench clean

demo: $(VENV)/.installed-demo
	$(BIN)/mcdenoise compare $(SCENE) --out $(OUT)

test: $(VENV)/.installed-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports
	OMP_WAIT_POLICY=passive $(BIN)/python -m pytest $(TEST_ARGS) # two processes: threads that wait must not spin

lab: $(VENV)/.installed-lab
	$(BIN)/python -m mcdenoise.classroom.building.lab
	@mkdir -p $(LAB_SETTINGS) # so that JupyterLab does not ask to fetch news from the network
	@echo '{"@jupyterlab/apputils-extension:notification": {"fetchNews": "false", "checkForUpdates": false}}' > $(LAB_SETTINGS)/overrides.json
	$(BIN)/jupyter lab $(LAB_ARGS) work/notebooks

lectures: $(VENV)/.installed-lectures
	$(BIN)/python -m mcdenoise.classroom.publishing.site $(SITE_ARGS)

notebooks: $(VENV)/.installed-lab
	$(BIN)/python -m mcdenoise.classroom.publishing.execute

figures: $(VENV)/.installed-demo
	$(BIN)/python -m mcdenoise.study.figures $(CHAPTERS)

doctor: $(VENV)/.installed-demo
	$(BIN)/mcdenoise doctor

bench: $(VENV)/.installed-test
	$(BIN)/python -m mcdenoise.study.bench filters

clean: # work/ stays: it may hold somebody's work
	rm -rf $(VENV) out

# A stamp is written only after a whole installation, so an interrupted one starts again.
$(VENV)/.installed-demo: EXTRA :=
$(VENV)/.installed-lab: EXTRA := [notebooks]
$(VENV)/.installed-lectures: EXTRA := [lectures]
$(VENV)/.installed-test: EXTRA := [test,notebooks,lectures,grading]
$(VENV)/.installed-test: WITH := demo lab lectures # what it includes needs no installation of its own
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
	@touch $@ $(WITH:%=$(VENV)/.installed-%)
