# Ramus: `make help` lists what can be made.
#
# Every goal first installs what it needs and is missing (scripts/setup.sh).

SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help

CARGO ?= cargo
ARGS ?=
STAGES ?=
BENCH ?=
FUZZ_SECONDS ?= 60
SOAK_FRAMES ?= 324000
FUZZ ?= grammar dialect format project session journal swc vtp mesh endpoints cohort study table

CARGO_TARGET_DIR ?= $(CURDIR)/target
export CARGO_TARGET_DIR
export PATH := $(CARGO_TARGET_DIR)/tools/bin:$(PATH)

.PHONY: help
help: ## this list
	@echo 'make run               build Ramus and start it: in the headset that answers, else in a window, else on the simulated one'
	@echo 'make test              everything that CI checks'
	@echo 'make bench             the benchmarks'
	@echo 'make doc               API pages and the user guide, under target/doc and target/book'
	@echo 'make pictures          the pictures of the gallery, drawn again'
	@echo 'make fuzz              each parser under the fuzzer for FUZZ_SECONDS'
	@echo 'make soak              an hour of random hands on the simulated headset, at full speed'
	@echo 'make clean-out         removes out/, what the program made'
	@echo
	@echo 'Variables:'
	@echo '  ARGS="…"             arguments for the program: make run ARGS="doctor"'
	@echo '  STAGES="…"           only these stages of make test: $(shell scripts/test.sh --list)'
	@echo '  BENCH="…"            only benchmarks whose name has this'
	@echo '  FUZZ="…"             only these fuzz targets: $(FUZZ)'
	@echo '  FUZZ_SECONDS=60      how long each fuzz target runs'
	@echo '  RAMUS_SETUP=no       install nothing'
	@echo '  RAMUS_SHARED=DIR     the reference data that some tests compare with'
	@echo '  RAMUS_MONADO_ROOT=DIR  where the real runtime of the tests lives (target/monado-root)'
	@echo '  RAMUS_TEST_GPU=yes   run the picture tests on the graphics card, not on Mesa'"'"'s software device'

.PHONY: run
run:
	@scripts/setup.sh run
	$(CARGO) build --release --bin ramus
	@"$(CARGO_TARGET_DIR)/release/ramus" $(ARGS)

.PHONY: test
test:
	@scripts/setup.sh test
	@scripts/test.sh $(STAGES)

.PHONY: bench
bench:
	@scripts/setup.sh run
	$(CARGO) bench --workspace --benches -- $(BENCH)
	@scripts/peers.sh

.PHONY: doc
doc:
	@scripts/setup.sh doc
	RUSTDOCFLAGS='-D warnings' $(CARGO) doc --workspace --no-deps
	mdbook build docs --dest-dir "$(CARGO_TARGET_DIR)/book"
	@echo "API pages: $(CARGO_TARGET_DIR)/doc/ramus/index.html"
	@echo "the guide: $(CARGO_TARGET_DIR)/book/index.html"

.PHONY: pictures
pictures:
	@scripts/setup.sh run
	$(CARGO) build --release --bin ramus
	@scripts/gallery.sh "$(CARGO_TARGET_DIR)/release/ramus"

# Without nextest, which would end it after five minutes.
.PHONY: soak
soak:
	@scripts/setup.sh test
	RAMUS_SOAK_FRAMES=$(SOAK_FRAMES) $(CARGO) test --release --test soak -- --nocapture hours

# libFuzzer's instrumentation needs unstable compiler flags: a stable toolchain takes
# them with RUSTC_BOOTSTRAP. Finds are left in fuzz/artifacts; what the fuzzer
# learned stays in target/fuzz-corpus; fuzz/corpus has seeds of ours and, packed, the short inputs of what an hour taught it. All grammars
# are seeds for what reads grammars.
.PHONY: fuzz
fuzz:
	@scripts/setup.sh fuzz
	@for target in $(FUZZ); do \
		echo "fuzz: $$target, $(FUZZ_SECONDS) s"; \
		mkdir -p "$(CARGO_TARGET_DIR)/fuzz-corpus/$$target"; \
		[ ! -r "fuzz/corpus/$$target.tar.gz" ] || tar -xzf "fuzz/corpus/$$target.tar.gz" -C "$(CARGO_TARGET_DIR)/fuzz-corpus"; \
		seeds="fuzz/corpus/$$target"; \
		case $$target in grammar|dialect|format) seeds="$$seeds assets/grammars";; esac; \
		RUSTC_BOOTSTRAP=1 CARGO_TARGET_DIR="$(CARGO_TARGET_DIR)/fuzz" $(CARGO) fuzz run $$target \
			"$(CARGO_TARGET_DIR)/fuzz-corpus/$$target" $$seeds -- \
			-max_total_time=$(FUZZ_SECONDS) -timeout=10 -rss_limit_mb=2048 -max_len=16384 -print_final_stats=0; \
	done

.PHONY: clean-out
clean-out:
	rm -rf out
