# config=release|debug|asan|tsan|cover picks flags and build/<config>/. `make help` lists the targets.
config ?= release
B := build/$(config)

CC ?= gcc
CXX ?= g++
# libcurl: its header alone, since it is loaded at run time.
PKGS := libcjson draco sqlite3 libcurl nettle zlib libseccomp
VERSION := 0.1.0

WARN := -Wall -Wextra -Wshadow -Wpointer-arith -Wcast-qual -Wformat=2 -Wundef -Werror=format-security
CWARN := $(WARN) -Wstrict-prototypes -Wmissing-prototypes -Wvla
# Of these what the machine and both compilers take: asked once, the answer is kept in build/probed.
HARDEN := -fstack-protector-strong -fstack-clash-protection -fPIE -fcf-protection -mbranch-protection=standard
LDHARDEN := -pie -Wl,-z,relro -Wl,-z,now -Wl,-z,noexecstack
# Programs that only run here are linked by gold: a test in 0.13 s of CPU, where ld takes 0.35 s.
LDFAST := -fuse-ld=gold
ASKED := 'HARDEN=$(HARDEN)' 'LDHARDEN=$(LDHARDEN)' 'LDFAST=$(LDFAST)'
# What one tree has compiled another does not compile again, where ccache is installed: paths are mapped, so that a clone in
# another folder finds it. VORONOID_CACHE holds at most 2 GB; results of static analysis stand beside (tests/lint/static.sh).
export VORONOID_CACHE ?= $(or $(XDG_CACHE_HOME),$(HOME)/.cache)/voronoid
export CCACHE_DIR := $(VORONOID_CACHE)/ccache
export CCACHE_BASEDIR := $(CURDIR)
export CCACHE_MAXSIZE := 1900M
CCACHE := $(shell command -v ccache)
MAPPED := -ffile-prefix-map=$(CURDIR)=.
PROBED := build/probed/$(subst /,_,$(subst $() ,_,$(CC)+$(CXX)))
-include $(PROBED)

flags.release := -O3 -g -D_FORTIFY_SOURCE=3 $(HARDEN)
flags.debug := -O0 -g3 $(HARDEN)
# -g1 names functions and lines, which is all that a report has.
flags.asan := -O2 -g1 -fno-omit-frame-pointer -fsanitize=address,undefined -fno-sanitize-recover=undefined
flags.tsan := -O2 -g1 -fno-omit-frame-pointer -fsanitize=thread
flags.cover := -O0 -g --coverage
flags.arm64 := $(flags.release) $(if $(SYSROOT),--sysroot=$(SYSROOT))
flags.fuzz := -O1 -g1 -fno-omit-frame-pointer -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined
flags := $(flags.$(config))
ifeq ($(flags),)
$(error config=$(config) is not one of release, debug, asan, tsan, cover)
endif

# Headers of the machine that compiles are no use to arm64.
PKG_FLAGS := $(if $(filter-out arm64,$(config)),$(shell pkg-config --cflags $(PKGS) 2>/dev/null))
# Same bytes on every machine: no contraction into fused multiply-add.
COMMON := $(flags) $(MAPPED) -ffp-contract=off -fno-math-errno -pthread -I. -isystem build/headers -MMD -MP -DVOR_VERSION='"$(VERSION)"' $(PKG_FLAGS)
ALL_CFLAGS := -std=c11 -D_POSIX_C_SOURCE=200809L -D_DEFAULT_SOURCE $(CWARN) $(COMMON) $(CFLAGS)
ALL_CXXFLAGS := -std=c++17 $(WARN) $(COMMON) $(CXXFLAGS)
# FLANN and libmicrohttpd are loaded at run time, too. Their -dev packages, whose headers may stand in build/headers alone
# (docker/install.sh), bring HDF5, MPI, boost and GnuTLS, which we do not call.
LIBS := $(shell pkg-config --libs $(filter-out libcurl,$(PKGS)) 2>/dev/null) -lm -lstdc++
TEST_LIBS := $(shell pkg-config --libs check 2>/dev/null)
LINK := $(CXX) $(flags) $(if $(filter release debug arm64,$(config)),$(LDHARDEN)) -pthread $(LDFLAGS)
LINK_TEST := $(LINK) $(if $(filter-out arm64,$(config)),$(LDFAST))

SRC := $(sort $(shell find core proto server -name '*.c' -o -name '*.cc'))
# What fuzzers read with calls nothing else: a further file is named here when the link asks for it.
FUZZED := core/base/% core/cloud/% core/spec% core/report% proto/% server/base/address.c server/base/option.c \
    server/base/clock.c server/base/disk.c server/base/uuid.c server/http/forwarded.c server/http/request_check.c \
    server/api/handlers/range.c
MAIN_SRC := server/main.c server/cli/pages.c
LIB_SRC := $(if $(filter fuzz,$(config)),$(filter $(FUZZED),$(SRC)),$(filter-out $(MAIN_SRC),$(SRC)))
obj = $(addprefix $(B)/,$(addsuffix .o,$(basename $(1))))
LIB := $(B)/libvoronoid.a
BIN := $(B)/voronoid
MAIN := $(call obj,$(MAIN_SRC))

# A C file in a test room is a test program; of tests/support it gets what it calls. ThreadSanitizer is spared the rooms, and the
# scripts of documents, that check what is computed and not how threads meet; AddressSanitizer the papers' figures, README and
# whole scans, which take long runs of the code that the other tests run; both the page in its browser.
TEST_ROOMS := unit property golden oracle paper
SUPPORT := $(B)/tests/libsupport.a
TEST_SRC := $(sort $(foreach room,$(TEST_ROOMS),$(wildcard tests/$(room)/*.c)))
# The tests in tests/kinds add rows to the tables of requests: the files that hang on these are compiled once more.
KINDS_OBJ := $(addprefix $(B)/kinds/,$(addsuffix .o,core/spec core/spec/tables core/spec/kinds core/spec/shown proto/json/json_spec \
    proto/json/json_process))
KINDS_BIN := $(addprefix $(B)/,$(basename $(wildcard tests/kinds/*.c)))
# Those in tests/counted have core compiled once more, to count what it does.
COUNTED_OBJ := $(addprefix $(B)/counted/,$(addsuffix .o,$(basename $(filter-out core/base/parallel.c,$(filter core/%,$(SRC))))))
COUNTED_BIN := $(addprefix $(B)/,$(basename $(wildcard tests/counted/*.c)))
# And tests/poison drives a binary with processes that crash: these files alone list processes.
POISON_OBJ := $(addprefix $(B)/poison/,$(addsuffix .o,core/spec/tables core/engine server/api/routes tests/poison/poison))
POISON_SCRIPTS := $(if $(filter release,$(config)),tests/poison/poison.t)
POISON_BIN := $(if $(POISON_SCRIPTS),$(B)/tests/poison/voronoid)
TEST_BIN := $(addprefix $(B)/,$(basename $(TEST_SRC))) $(KINDS_BIN) $(COUNTED_BIN)
# Of the laws these are read off the build; the others read the sources and are `make quick`.
BINARY_LAWS := tests/lint/engine.t tests/lint/hardening.t tests/lint/openapi.t
SOURCE_LAWS := $(sort $(filter-out $(BINARY_LAWS),$(wildcard tests/lint/*.t)))
TEST_SCRIPTS := $(sort $(wildcard tests/http/*.t tests/cli/*.t tests/golden/*.t) $(BINARY_LAWS) $(wildcard tests/page/*.t)) $(POISON_SCRIPTS)
TESTS := $(TEST_SCRIPTS) $(TEST_BIN)

# What sanitizers run, by what can go wrong; SANITIZE=all: everything but what only reads the build, and the page in its browser.
# AddressSanitizer: what reads strangers' bytes, what fails allocations, HTTP, and each process once. Tests that judge figures stay
# with the release build. ThreadSanitizer: the server's programs, in which threads meet, and every method
# at three threads.
SANITIZE ?= some
ENGINE_INSIDE = $(shell grep -lE 'include "core/(geom|input|metrics|opt|seeds|cvt|kmeans|lop|mesh|remesh|output|baselines)/' $(TEST_SRC))
DRIVERS := $(addprefix tests/,property/methods_interrupted.c property/methods_threads.c unit/stages_test.c)
THREADED := tests/unit/base_parallel.c tests/property/methods_threads.c
# Their threads are those of job_service_jobs and store_model; what they judge is files, and figures.
FILES_JUDGED := damage_test memory_estimate_test self_test_test serve_disk storage_full store_work job_service_artefacts job_service_crash
MET := life events events_many events_poll cancel daemon slow auth signals again
RELEASE_ALONE := $(BINARY_LAWS) $(wildcard tests/page/*.t)
SANITIZED.asan.all = $(filter-out $(RELEASE_ALONE),$(TEST_SCRIPTS)) $(TEST_SRC)
SANITIZED.tsan.all = $(SANITIZED.asan.all)
SANITIZED.asan.some = $(filter-out tests/http/readme.t,$(wildcard tests/http/*.t)) \
    $(addprefix tests/cli/,convert.t faces.t measure.t resample.t) $(filter-out $(ENGINE_INSIDE),$(filter tests/unit/%,$(TEST_SRC))) \
    $(wildcard tests/property/*_roundtrip.c tests/kinds/*.c) $(addprefix tests/property/,ply_number.c engine_memory.c store_model.c) $(DRIVERS)
SANITIZED.tsan.some = $(MET:%=tests/http/%.t) $(filter-out $(FILES_JUDGED:%=tests/unit/%.c),$(shell grep -lE 'include "server/' $(TEST_SRC))) \
    $(wildcard $(THREADED))
ifneq ($(filter asan tsan,$(config)),)
SANITIZED := $(sort $(SANITIZED.$(config).$(SANITIZE)))
TESTS := $(filter %.t,$(SANITIZED)) $(addprefix $(B)/,$(basename $(filter %.c,$(SANITIZED))))
TEST_BIN := $(filter $(B)/%,$(TESTS))
endif
# These take longest, or wait most: they begin first, and no core is idle at the end.
TEST_LONG := %/methods_interrupted %/methods_threads tests/http/bytes.t tests/page/page.t \
    tests/http/slow.t tests/http/readme.t tests/cli/remote.t tests/golden/golden.t %/mesh_test %/job_service_artefacts %/growth
BENCH_SRC := $(sort $(wildcard tests/by_hand/bench/*.c))
BENCH_BIN := $(addprefix $(B)/,$(basename $(BENCH_SRC))) $(addprefix $(B)/tests/by_hand/bench/,wlop orient front ear register mls)

.DELETE_ON_ERROR:
# Objects that only rules by pattern name are kept. Of other files none is listed: what is missing is made, even if nothing is newer.
.SECONDARY: $(patsubst %.c,$(B)/%.o,$(wildcard tests/*/*.c tests/by_hand/*/*.c)) $(KINDS_OBJ) $(POISON_OBJ) $(COUNTED_OBJ) $(KINDS_BIN:$(B)/%=$(B)/kinds/%.o)
GOALS := all help demo test tests check gate gate-long soak golden same zoo torture bench fuzz proxy cross arm64 lint quick static contract format image install uninstall clean
.PHONY: $(GOALS)

# Every core is used unless -j says otherwise. Of several goals typed together one ends before the next begins.
JOBS ?= $(shell nproc)
ifeq ($(MAKELEVEL),0)
MAKEFLAGS += -j$(JOBS)
ifneq ($(word 2,$(filter $(GOALS),$(MAKECMDGOALS))),)
.NOTPARALLEL:
endif
endif

all: $(BIN) ## build the binary (default)

help: ## list the targets
	@awk -F':.*## ' '/^[a-z0-9-]+:.*## /{printf "  %-9s %s\n", $$1, $$2}' $(MAKEFILE_LIST)
	@echo '  config=release|debug|asan|tsan|cover picks flags and build/<config>/'

$(PROBED): Makefile docker/probe.sh
	@docker/probe.sh $@ '$(CC)' '$(CXX)' $(ASKED)

$(B)/%.o: %.c
	@mkdir -p $(@D)
	@echo "  CC   $<"
	@$(CCACHE) $(CC) $(ALL_CFLAGS) $(OWN_CFLAGS) -c $< -o $@

$(B)/%.o: %.cc
	@mkdir -p $(@D)
	@echo "  CXX  $<"
	@$(CCACHE) $(CXX) $(ALL_CXXFLAGS) -c $< -o $@

# What names the version is compiled again where that may have changed.
$(call obj,$(shell grep -rl VOR_VERSION --include='*.c' core proto server)): Makefile

# Which engine this is: a digest of its sources.
ENGINE_SRC := $(sort $(shell find core -name '*.[ch]'))
$(B)/server/base/build.o: $(ENGINE_SRC)
$(B)/server/base/build.o: OWN_CFLAGS = -DVOR_ENGINE='"$(shell cat $(ENGINE_SRC) | sha256sum | cut -c-12)"'

# The topics of the help are embedded by the assembler, which tells nobody.
$(B)/server/base/topics.o: $(wildcard server/cli/help/*.txt)

# The page's files: each of build/web is gzipped and embedded, and named in a table with its digest.
# A file of server/web is taken as it is, unless a rule makes it of several.
WEB := build/web
BUNDLES := page.js cloud_worker.js stream.js
ASSETS := index.html page.css icon.svg docs.css docs.js openapi.json openapi.yaml $(BUNDLES)
THREE := /usr/share/javascript/three
$(B)/server/api/handlers/page.o: $(WEB)/assets.inc $(ASSETS:%=$(WEB)/%.gz)

$(WEB)/%: server/web/%
	@mkdir -p $(@D)
	@cp $< $@

# The contract for programs that read no YAML. What converts it runs here, whatever we build for.
HOST_CC ?= gcc

$(WEB)/yaml_to_json: docker/yaml_to_json.c
	@mkdir -p $(@D)
	@$(HOST_CC) -O1 $(CWARN) $< -o $@ -lyaml

$(WEB)/openapi.yaml: openapi.yaml
	@mkdir -p $(@D)
	@cp $< $@

$(WEB)/openapi.json: openapi.yaml $(WEB)/yaml_to_json
	@$(WEB)/yaml_to_json <$< >$@

# Modules, and of three.js what they use, become one file; its licence stays in it.
$(BUNDLES:%=$(WEB)/%): $(WEB)/%: server/web/% $(wildcard server/web/*.js)
	@mkdir -p $(@D)
	@echo "  WEB  $@"
	@esbuild $< --bundle --minify --format=esm --target=es2020 --log-level=warning --legal-comments=eof --charset=utf8 \
	    --alias:three=$(THREE)/three.module.js --alias:orbit-controls=$(THREE)/examples/jsm/controls/OrbitControls.js --outfile=$@

$(ASSETS:%=$(WEB)/%.gz): %.gz: %
	@gzip -9nc $< >$@

$(WEB)/assets.inc: Makefile $(ASSETS:%=$(WEB)/%.gz)
	@for name in $(ASSETS); do \
	    echo "ASSET($$(echo "$$name" | tr -c 'a-z0-9\n' _), \"$$name\", \"$$(sha256sum <$(WEB)/$$name.gz | cut -c-64)\")"; \
	done >$@

# The engine for other programs: its objects can be in a shared library, and of their functions only those are seen outside that
# core/voronoid.h declares. They are compiled anew where they may be older than that.
CORE := $(call obj,$(filter core/%,$(SRC)))
$(CORE): OWN_CFLAGS = -fPIC -fvisibility=hidden
$(CORE): docker/voronoid.pc
EMBEDDED := $(addprefix $(B)/lib/libvoronoid.,so.0 a)

$(B)/lib/voronoid.o: $(CORE)
	@mkdir -p $(@D)
	@$(LD) -r $^ -o $@
	@sed -n 's/^VOR_API.*\(vor_[a-z_]*\)(.*/\1/p' core/voronoid.h >$(@D)/declared
	@objcopy --keep-global-symbols=$(@D)/declared $@

$(B)/lib/libvoronoid.so.0: $(B)/lib/voronoid.o
	@echo "  LINK $@"
	@$(CC) $(flags) -shared -pthread -Wl,-z,relro,-z,now,-z,noexecstack,-soname,$(@F) $(LDFLAGS) $^ -o $@ -l:libflann.so.1.9 -lm

$(B)/lib/libvoronoid.a: $(B)/lib/voronoid.o
	@rm -f $@
	@$(AR) rcs $@ $^

$(LIB): $(call obj,$(LIB_SRC))
	@rm -f $@
	@$(AR) rcs $@ $^

# Manual and completions are made of the tables by a program of its own, then embedded. For arm64 those of the release build.
PAGES := $(addprefix $(if $(filter arm64,$(config)),build/release,$(B))/pages/voronoid.,1 8 bash zsh fish)
$(B)/server/cli/pages.o: $(PAGES)
$(B)/server/cli/pages.o: OWN_CFLAGS = -Wa,-I$(dir $(firstword $(PAGES)))

ifneq ($(config),arm64)
$(B)/docker/pages/pages: $(call obj,$(wildcard docker/pages/*.c)) $(LIB)
	@echo "  LINK $@"
	@$(LINK_TEST) $^ -o $@ $(LIBS)

$(B)/pages/voronoid.%: $(B)/docker/pages/pages $(wildcard docker/pages/voronoid.*)
	@mkdir -p $(@D)
	@{ cat $(wildcard docker/pages/voronoid.$*) /dev/null && $< $*; } >$@
endif

$(BIN): $(MAIN) $(LIB)
	@echo "  LINK $@"
	@$(LINK) $^ -o $@ $(LIBS)

$(SUPPORT): $(call obj,$(sort $(wildcard tests/support/*.c)))
	@rm -f $@
	@$(AR) rcs $@ $^

$(B)/tests/%: $(B)/tests/%.o $(SUPPORT) $(LIB)
	@echo "  LINK $@"
	@$(LINK_TEST) $^ -o $@ $(TEST_LIBS) $(LIBS)

# These know which place of the product asks for memory.
$(addprefix $(B)/tests/,unit/stages_test property/methods_interrupted property/methods_resumed property/methods_threads): \
    TEST_LIBS += -Wl,--wrap=vor_malloc,--wrap=vor_calloc,--wrap=vor_realloc
$(B)/tests/unit/job_service_recover: TEST_LIBS += -Wl,--wrap=vor_job_create,--wrap=vor_store_reap,--wrap=vor_store_waiting,--wrap=vor_store_hand_back
$(B)/tests/unit/job_service_jobs: TEST_LIBS += -Wl,--wrap=vor_store_get,--wrap=vor_store_events

# What other programs make of the same.
$(B)/tests/oracle/lbfgs_liblbfgs: TEST_LIBS += -llbfgs

define with_rows
$(B)/$(1)/%.o: %.c
	@mkdir -p $$(@D)
	@echo "  CC   $$<"
	@$(CCACHE) $(CC) $(ALL_CFLAGS) -DVOR_EXTENSIONS='"tests/$(1)/rows.h"' -c $$< -o $$@
endef
$(foreach room,kinds poison,$(eval $(call with_rows,$(room))))

$(B)/tests/kinds/%: $(B)/kinds/tests/kinds/%.o $(KINDS_OBJ) $(SUPPORT) $(LIB)
	@mkdir -p $(@D)
	@echo "  LINK $@"
	@$(LINK_TEST) $^ -o $@ $(TEST_LIBS) $(LIBS)

$(B)/counted/%.o: %.c
	@mkdir -p $(@D)
	@echo "  CC   $<"
	@$(CCACHE) $(CC) $(ALL_CFLAGS) -O1 -fsanitize-coverage=trace-pc -c $< -o $@

$(B)/tests/counted/%: $(B)/tests/counted/%.o $(COUNTED_OBJ) $(SUPPORT) $(LIB)
	@echo "  LINK $@"
	@$(LINK_TEST) $^ -o $@ $(TEST_LIBS) $(LIBS)

$(B)/tests/poison/voronoid: $(MAIN) $(POISON_OBJ) $(LIB)
	@mkdir -p $(@D)
	@echo "  LINK $@"
	@$(LINK) $^ -o $@ $(LIBS)

# What only the benchmark needs: no test harness in its programs, and the peer built as its users would build it.
$(B)/tests/by_hand/bench/edges: $(B)/tests/support/vt_mesh.o
$(B)/tests/by_hand/bench/%: $(B)/tests/by_hand/bench/%.o $(LIB)
	@echo "  LINK $@"
	@$(LINK) $^ -o $@ $(LIBS)

$(addprefix $(B)/tests/by_hand/bench/,wlop orient front ear): $(B)/tests/by_hand/bench/%: tests/by_hand/bench/%.cc tests/by_hand/bench/peer.h
	@mkdir -p $(@D)
	@echo "  CXX  $<"
	@$(CCACHE) $(CXX) -std=c++17 -O3 -DNDEBUG -I. $< -o $@ -lmpfr -lgmp

# PCL without its -dev package's 385: its headers stand in build/headers.
PCL := registration features filters search sample_consensus kdtree octree common
$(addprefix $(B)/tests/by_hand/bench/,register mls): $(B)/tests/by_hand/bench/%: tests/by_hand/bench/%.cc
	@mkdir -p $(@D)
	@echo "  CXX  $<"
	@$(CCACHE) $(CXX) -std=c++17 -O3 -DNDEBUG -isystem build/headers -isystem build/headers/pcl-1.13 -isystem /usr/include/eigen3 $< \
	    -o $@ $(PCL:%=-l:libpcl_%.so.1.13)

-include $(shell find $(B) -name '*.d' 2>/dev/null)

# The goals below install what they need first, so their work is a make of its own: pkg-config is asked anew.
demo: ## install what is missing, build, and send a real scan through the daemon (CLOUD=file: your own cloud)
	@docker/install.sh build demo
	@$(MAKE) --no-print-directory all
	@tests/demo/demo.sh $(BIN) $(if $(CLOUD),'$(CLOUD)')

gate: ## install what is missing, and run the checks that every change must pass; build/gate/steps has the seconds of each
	+@tests/support/gate.sh

gate-long: ## like gate, but with everything: soak, all tests under sanitizers, a minute of each fuzzer, arm64, torture
	+@tests/support/gate.sh long

test: ## install what is missing, build, and run every test (V=1 is verbose)
	@docker/install.sh build test page
	@$(MAKE) --no-print-directory check

tests: all $(TEST_BIN) ## build every test program

check: all $(if $(filter release,$(config)),$(EMBEDDED)) $(POISON_BIN) $(TEST_BIN) ## run every test with what is installed
	@VORONOID=$(BIN) tests/support/check.sh $(B) $(JOBS) $(filter $(TEST_LONG),$(TESTS)) $(filter-out $(TEST_LONG),$(TESTS))

soak: ## run test with more seeds and larger clouds, and every golden case at 1, 2, 3 and 8 threads
	@VT_SOAK=1 $(MAKE) --no-print-directory test

golden: all ## write the figures of the golden cases again and show what changed (BOUNDS=1: their bounds; ONLY=regex of cases)
	@tests/golden/renew.py $(BIN) build/golden $(if $(BOUNDS),bounds,figures) $(if $(ONLY),'$(ONLY)')

# A tree of the revision is built and kept until another one is asked for.
BASE ?= HEAD

same: all ## compare results of the golden cases byte for byte with revision BASE (default HEAD); a difference fails (ONLY=regex)
	@base=$$(git rev-parse --verify '$(BASE)^{commit}') && tree=build/same/$$base && \
	if [ ! -x $$tree/$(BIN) ]; then \
	    rm -rf build/same && mkdir -p $$tree && git archive $$base | tar -x -C $$tree && $(MAKE) --no-print-directory -C $$tree all; \
	fi && tests/golden/same.py $$tree/$(BIN) $(BIN) build/same/results $(if $(ONLY),'$(ONLY)')

zoo: all ## every case of seeds 1 to 5 of ../shared/yardstick/zoo.py, and the scoreboard (SEEDS=a-b, FAMILIES=regex; SHORT=1: what the gate runs; RENEW=1 keeps what is right)
	@VORONOID=$(BIN) JOBS=$(JOBS) tests/zoo/score.py $(if $(SHORT),,long) $(if $(SEEDS),seeds=$(SEEDS)) $(if $(FAMILIES),'families=$(FAMILIES)') $(if $(RENEW),renew)

torture: ## install what is missing, build, and measure what the daemon withstands (LONG=1, SEED=n, COUNT=n, ONLY=regex of programs)
	@docker/install.sh build test torture $(if $(LONG),lint)
	@$(MAKE) --no-print-directory all $(POISON_BIN)
	@tests/by_hand/torture/run.pl $(if $(LONG),--long) $(if $(SEED),--seed $(SEED)) $(if $(COUNT),--count $(COUNT)) $(BIN)

bench: ## install what is missing, build, and measure: tables and plots in build/bench (RUNS=n, ONLY=regex of rows)
	@docker/install.sh build bench page $(if $(findstring peers,$(ONLY)),peers)
	@$(MAKE) --no-print-directory all $(BENCH_BIN)
	@tests/by_hand/bench/bench.sh $(BIN)

# Fuzzers are linked with a tree of their own: clang's libFuzzer, AddressSanitizer and UBSan.
FUZZ_SECONDS ?= -
FUZZ := $(patsubst tests/fuzz/%_fuzz.c,%,$(wildcard tests/fuzz/*_fuzz.c))

fuzz: ## replay the kept corpus of every reader, then fuzz those that changed, or all for FUZZ_SECONDS=n each
	@$(MAKE) --no-print-directory config=fuzz CC=clang CXX=clang++ $(FUZZ:%=build/fuzz/tests/fuzz/%_fuzz)
	@tests/fuzz/run.sh build/fuzz $(FUZZ_SECONDS) $(JOBS) $(FUZZ)

build/fuzz/tests/fuzz/%_fuzz: build/fuzz/tests/fuzz/%_fuzz.o build/fuzz/libvoronoid.a
	@echo "  LINK $@"
	@$(CXX) $(flags.fuzz) -fsanitize=fuzzer -pthread $^ -o $@ $(LIBS)

proxy: ## install what is missing, build, and run the help's examples for nginx, haproxy and caddy in front of the daemon
	@docker/install.sh build test
	@$(MAKE) --no-print-directory all
	@tests/proxy/fetch.sh build/proxy
	@VORONOID=$(BIN) prove -v tests/proxy/snippets.t

# Objects alone: libraries of arm64 are not asked for.
FOR_ARM64 := config=arm64 CC=aarch64-linux-gnu-gcc CXX=aarch64-linux-gnu-g++ AR=aarch64-linux-gnu-ar

SCALE_TESTS := unit/blob_any unit/store_rows unit/store_queue unit/store_tenants unit/job_service_crash property/store_model

scale: ## install what is missing, build, and run the tests of jobs in PostgreSQL and of files in S3, with servers that are started here
	@docker/install.sh build test scale
	@$(MAKE) --no-print-directory all $(addprefix $(B)/tests/,$(SCALE_TESTS))
	@VORONOID=$(BIN) prove -j3 tests/scale/postgres.t tests/scale/s3.t tests/scale/replicas.t

cross: ## install what is missing, and compile core and proto for arm64; a warning fails
	@docker/install.sh build cross
	@$(MAKE) --no-print-directory $(FOR_ARM64) CFLAGS=-Werror CXXFLAGS=-Werror objects

ARM64_BIN := $(addprefix build/arm64/,voronoid tests/arm64/decode tests/golden/engine_bytes \
    $(basename $(wildcard tests/unit/*.c tests/property/*_roundtrip.c)))

arm64: ## install what is missing, cross-compile for arm64, run the unit tests under qemu, compare with amd64 (ONLY=regex)
	@docker/install.sh build test cross arm64
	@$(MAKE) --no-print-directory all build/release/tests/arm64/decode
	@tests/arm64/root.sh build/arm64-root
	@$(MAKE) --no-print-directory $(FOR_ARM64) SYSROOT=$(CURDIR)/build/arm64-root $(ARM64_BIN)
	@tests/arm64/run.sh build/release build/arm64 build/arm64-root $(JOBS) $(ARM64_BIN)

.PHONY: objects
objects: $(call obj,$(filter core/% proto/%,$(SRC)))

lint: ## install what is missing, and check the sources: `quick`, `static`, and checks of the binary
	@docker/install.sh build test lint
	@$(MAKE) --no-print-directory quick
	@$(MAKE) --no-print-directory all
	@VORONOID=$(BIN) prove -j$(JOBS) --exec '' $(BINARY_LAWS)
	@$(MAKE) --no-print-directory static

quick: ## check the sources in seconds: formatting, includes, sizes, texts, shell and YAML
	@tests/lint/format.sh
	@prove -j$(JOBS) --exec '' $(SOURCE_LAWS)

static: ## clang-tidy, gcc -fanalyzer and cppcheck over the sources of the product that changed since they last passed
	@tests/lint/static.sh

contract: ## check openapi.yaml with redocly, spectral and TypeScript, which npm installs under build/
	@{ command -v node && command -v npm; } >/dev/null || docker/install.sh contract
	@docker/install.sh build
	@$(MAKE) --no-print-directory all
	@tests/contract/contract.sh $(BIN) build/contract

format: ## clang-format every C file
	clang-format -i $(shell find core proto server docker tests -name '*.[ch]' -o -name '*.cc')

image: all ## make the contents of the container image in build/rootfs, and try them
	@docker/rootfs.sh $(BIN) build/rootfs
	@docker/try.sh build/rootfs

PREFIX ?= /usr/local
SHARE := $(B)/pages
root := $(DESTDIR)$(PREFIX)
# Where a debugger looks for the symbols of a binary that is stripped.
SYMBOLS := .debug/voronoid.debug
INSTALLED := bin/voronoid bin/$(SYMBOLS) share/man/man1/voronoid.1 share/man/man8/voronoid.8 \
    share/bash-completion/completions/voronoid lib/systemd/system/voronoid.service share/zsh/site-functions/_voronoid \
    share/fish/vendor_completions.d/voronoid.fish share/doc/voronoid/LICENSE include/voronoid.h lib/pkgconfig/voronoid.pc \
    lib/libvoronoid.a lib/libvoronoid.so.0 lib/libvoronoid.so

install: all $(EMBEDDED) ## copy binary (stripped, its symbols beside it), library, manual and completions to DESTDIR/PREFIX (/usr/local)
	install -d $(root)/bin/.debug
	objcopy --only-keep-debug $(BIN) $(root)/bin/$(SYMBOLS)
	objcopy --strip-unneeded --add-gnu-debuglink=$(root)/bin/$(SYMBOLS) $(BIN) $(root)/bin/voronoid
	chmod 0644 $(root)/bin/$(SYMBOLS)
	install -D -m 0644 $(SHARE)/voronoid.1 $(root)/share/man/man1/voronoid.1
	install -D -m 0644 $(SHARE)/voronoid.8 $(root)/share/man/man8/voronoid.8
	install -D -m 0644 $(SHARE)/voronoid.bash $(root)/share/bash-completion/completions/voronoid
	install -D -m 0644 $(SHARE)/voronoid.zsh $(root)/share/zsh/site-functions/_voronoid
	install -D -m 0644 $(SHARE)/voronoid.fish $(root)/share/fish/vendor_completions.d/voronoid.fish
	install -d $(root)/lib/systemd/system
	sed 's|/usr/local/bin|$(PREFIX)/bin|' docker/voronoid.service >$(root)/lib/systemd/system/voronoid.service
	install -D -m 0644 core/voronoid.h $(root)/include/voronoid.h
	install -d $(root)/lib/pkgconfig
	sed 's|/usr/local|$(PREFIX)|;s|VERSION|$(VERSION)|' docker/voronoid.pc >$(root)/lib/pkgconfig/voronoid.pc
	objcopy --strip-debug $(B)/lib/libvoronoid.a $(root)/lib/libvoronoid.a
	objcopy --strip-unneeded $(B)/lib/libvoronoid.so.0 $(root)/lib/libvoronoid.so.0
	ln -sf libvoronoid.so.0 $(root)/lib/libvoronoid.so
	install -D -m 0644 LICENSE $(root)/share/doc/voronoid/LICENSE

uninstall: ## remove what install has copied
	rm -f $(addprefix $(root)/,$(INSTALLED))
	rmdir $(root)/share/doc/voronoid $(root)/bin/.debug 2>/dev/null || true

clean: ## remove build/
	rm -rf build
