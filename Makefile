.DEFAULT_GOAL := help
.NOTPARALLEL:
SHELL := bash
# A pipe fails with any of its programs.
.SHELLFLAGS := -o pipefail -c

DURATION ?= 15
SEED ?= 1
FAULTS ?= 500
run := host_receiver/environment/run.sh
settings := host_receiver/pyproject.toml
# NumPy's threads spin while they wait for each other, which takes nine tenths of its time on a busy machine.
pytest := $(run) env OPENBLAS_NUM_THREADS=1 python3 -m pytest --config-file $(settings) --rootdir .
python := host_receiver/ml2_receiver host_receiver/ml2_tools host_receiver/demo host_receiver/test config native/tests/codecs native/tests/openxr native/tests/scene native/tests/sdk tests/conformance tests/dist tests/docs tests/fuzz tests/aar tests/unity tests/interop tests/end_to_end tests/validation tests/view tests/bench
# Seconds that a test waits for what has to come. It only ends a hang; a slower machine may set more.
export ML2S_TEST_LIMIT_S ?= 120
# A test that waits for several things has ten times as long.
export PYTEST_TIMEOUT = $(ML2S_TEST_LIMIT_S)0
beside := --numprocesses 2 --dist worksteal
headsets_at_a_time ?= 2
slowest := --durations 20 --durations-min 0.5
# Runs targets of this file beside each other.
at_a_time = MAKE='$(submake)' config/at_a_time.sh $(1)
# A line that names MAKE itself would be run under `make -n`, too.
submake = $(MAKE) --no-print-directory
# Runs what follows `--` unless the inputs before it have the content that they had when it last succeeded.
if_changed = @config/if_changed.sh
if_unchecked = $(if_changed) build/checked/$@
comma := ,
# The native library and its tests with sanitizers: folder, sanitizers, options of the build. Clang takes two thirds of GCC's time.
define sanitized
cmake -S native -B build/native/$(1) -G Ninja -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++ -DML2S_SANITIZE=$(2)
$(fixed_addresses) cmake --build build/native/$(1) --parallel 2 $(3)
endef
# Ubuntu's kernels choose addresses at random where sanitizers of clang before 18 have their own memory.
fixed_addresses = $(shell setarch --addr-no-randomize true && echo setarch --addr-no-randomize)
# With this variable set, each Python process would compile all modules anew.
unexport PYTHONDONTWRITEBYTECODE
maven_options := --no-transfer-progress -Dtest.timeout_s=$(PYTEST_TIMEOUT) $(if $(CI),--batch-mode)
maven := config/kotlin/maven.sh $(maven_options)
# Java takes the home from the list of users.
ifeq ($(MAKELEVEL),0)
export MAVEN_OPTS := -Duser.home=$(HOME) $(MAVEN_OPTS)
endif
# Tools sort, decode and print alike in each user's shell, also in one without a locale.
export LC_ALL := C.UTF-8
# C and C++ are compiled once for equal sources; what needs no precompiled header, also for other clones.
export CMAKE_C_COMPILER_LAUNCHER := $(shell command -v ccache)
export CMAKE_CXX_COMPILER_LAUNCHER := $(CMAKE_C_COMPILER_LAUNCHER)
export CCACHE_BASEDIR := $(CURDIR)
export CCACHE_NOHASHDIR := true
# Without these, ccache leaves what needs a precompiled header to the compiler.
export CCACHE_SLOPPINESS := pch_defines,time_macros
# Nothing to be done where all is there.
set_up = $(if $(shell host_receiver/environment/setup.sh --check $(1) && echo yes),,@host_receiver/environment/setup.sh $(1))
kotlin := pom.xml .mvn ml2-sensors-aar
# Folders of sources, too: they tell of files that are gone.
kotlin_files := $(shell find $(kotlin) -name target -prune -o \( -type f -o -path '*/src*' \) ! -name '*.md' -print)
packaged := build/.maven-packaged
class_archive := build/.class-archive
simulated_headset := build/.headset-packaged
bundle := build/native/bundle/order
# For what comes after `build`: takes its classes as they are.
compiled := -Dphase.compile=none -Dphase.test-compile=none -Dmaven.clean.skip
# For programs of seconds: the second compiler and parallel collection cost more than they save.
java := java -XX:TieredStopAtLevel=1 -XX:+UseSerialGC
# HotSpot's second compiler, too, which hashes 300 MB in a third of the time.
all_compilers := -XX:TieredStopAtLevel=4
device_library := build/native/device/libml2sensors.so
simulation := build/native/host/.built
aar := ml2-sensors-aar/aar
benchmark := ml2-sensors-aar/benchmark
three := host_receiver/ml2_tools/viewing/page/three.min.js
javascript := build/javascript/.installed
packed := build/.aar-packed
app := ml2-sensors-aar/app
library := ml2-sensors-aar
headset := ml2-sensors-aar/simulator
packed_app := build/.apk-packed
cyclonedx := build/cyclonedx/bin/cyclonedx-py
ktlint_version := $(shell sed -n 's|.*<ktlint.version>\(.*\)</.*|\1|p' pom.xml)
ktlint_jar := build/ktlint/ktlint-cli-$(ktlint_version)-all.jar
detekt_version := $(shell sed -n 's|.*<detekt.version>\(.*\)</.*|\1|p' pom.xml)
detekt_jar := build/detekt/detekt-cli-$(detekt_version)-all.jar
# Names files: for a pattern, ktlint walks the whole checkout and fails where another check removes a file meanwhile.
ktlint := git ls-files -co --exclude-standard '*.kt' | xargs $(java) -jar $(ktlint_jar) --relative
# Removes stamps that tell of folders `target` which are gone: by hand, say.
forget_without = $(if $(filter-out $(wildcard $(2:%=%/target)),$(2:%=%/target)),$(shell rm -f $(1)))
modules := $(patsubst %/pom.xml,%,$(wildcard $(library)/pom.xml $(library)/*/pom.xml))
$(call forget_without,$(packaged) $(class_archive),$(filter-out $(aar),$(modules)))
$(call forget_without,$(simulated_headset),$(library) $(headset))
$(call forget_without,$(packed),$(aar))
$(call forget_without,$(packed_app),$(app))

help: ## List the targets
	@awk -F ':.*## ' '/^[a-z0-9-]+:.*## / {printf "make %-17s %s\n", $$1, $$2}' Makefile

setup: ## Install what the receiver needs: Debian packages, and Python 3.12 with ROS 2 Jazzy in build/venv
	$(call set_up,receiver)

# Installs what other targets need too, by the groups of debian-packages.txt: setup-headset+lint.
setup-%:
	$(call set_up,receiver $(subst +, ,$*))

build: setup-headset+app native $(packaged) ## Compile and package the Kotlin library, the simulated headset and the app's classes

$(packaged): $(bundle) $(kotlin_files)
	$(if_changed) $@ $(kotlin) build/native/bundle -- config/kotlin/package.sh $(maven_options)

# Saves a fifth of the processor time of each start of the simulated headset, of which the tests have hundreds.
$(class_archive): $(packaged)
	$(if_changed) $@ $(kotlin) build/native/bundle -- config/kotlin/class_archive.sh $(headset)/target/ml2-headset.jsa

# Builds the part of `build` that a demo needs, in half the time: no tests, no app.
$(simulated_headset): $(bundle) $(kotlin_files)
	$(if_changed) $@ $(kotlin) build/native/bundle -- $(maven) package -Dmaven.test.skip -pl $(library),$(headset)

native: setup-headset $(device_library) $(simulation) $(bundle) ## Build the native library as it ships, and the simulated device it runs on here

$(device_library): $(shell find native/codecs native/device native/generated native/jni native/openxr native/sdk native/sources -type f)
	native/device/link.sh
	native/device/check.sh

$(simulation): $(shell find native -name '*.[ch]' -o -name '*.cpp' -o -name CMakeLists.txt)
	cmake -S native -B build/native/host -G Ninja
	cmake --build build/native/host --target ml2sim ml2sim_input ml2sim_jni ml2sim_openh264 ml2sim_control ml2sim_partial scene_shots
	@touch $@

$(bundle): native/sim/bundle.sh $(device_library) $(simulation)
	native/sim/bundle.sh

aar: setup-headset $(packed) ## Pack the library for Android and for Unity: build/aar

$(packed): $(packaged) $(device_library)
	$(if_changed) $@ $(kotlin) build/native/bundle -- $(maven) --quiet package $(compiled) -DskipTests -pl $(aar) -am

apk: setup-headset+android aar $(packed_app) ## Build the headset's app: build/apk [KEYSTORE=file of your own, its password in KEYSTORE_PASSWORD]

$(packed_app): $(packed) $(if $(KEYSTORE),setup) # which is always done: a key of your own is not remembered
	$(if $(KEYSTORE),,$(if_changed) $@ $(kotlin) build/aar --) $(maven) --quiet package $(compiled) -DskipTests -Papk -pl $(app) -am \
	  $(if $(KEYSTORE),-Dkeystore="$(abspath $(KEYSTORE))" -Dkeystore.password=env:KEYSTORE_PASSWORD)
	$(if $(KEYSTORE),@rm -f $@)

unity-package: setup-headset+test aar ## Pack the Unity package: build/unity
	$(run) python3 config/unity_tarball.py

dist: setup-headset+android+test unity-package ## Put what a release holds into build/dist, with checksums and bills of materials [KEYSTORE as for apk]
	$(call at_a_time,apk cyclonedx)
	$(if_changed) build/.bills $(filter %pom.xml,$(kotlin_files)) -- env MAVEN_OPTS="$(all_compilers) $$MAVEN_OPTS" $(maven) --quiet package $(compiled) -DskipTests \
	  -pl $(library),$(app),$(headset) -am org.cyclonedx:cyclonedx-maven-plugin:makeBom
	$(run) python3 config/dist.py --cyclonedx $(cyclonedx)

cyclonedx: setup $(cyclonedx)

$(cyclonedx):
	$(run) python3 -m venv $(@D)/..
	$(@D)/pip install --quiet cyclonedx-bom==7.5.0

demo: setup-headset $(if $(wildcard $(packaged)),$(packaged),$(simulated_headset)) ## Watch a simulated headset arrive in ROS 2 [DURATION=seconds] [CONFIG=file] [REPLAY=EuRoC folder] [LINK=Mbit/s between them, as root]
	$(run) python3 host_receiver/demo --duration $(DURATION) \
	  $(if $(CONFIG),--config "$(CONFIG)") $(if $(REPLAY),--replay "$(REPLAY)") $(if $(LINK),--link $(LINK))

check: setup-headset+test+csharp+lint build $(javascript) ## Check style, and run the fast tests of what changed since they last passed
	$(call at_a_time,lint check-python check-native check-kotlin check-unity)

check-python:
	$(if_unchecked) config host_receiver tests/conformance tests/docs *.md docs -- $(pytest) $(beside) -m 'not processes' \
	  host_receiver/test tests/conformance/test_wire.py tests/conformance/test_cdr_oracles.py

check-native:
	$(if_unchecked) native -- $(submake) fast-native

fast-native:
	$(call sanitized,address,address$(comma)undefined)
	$(fixed_addresses) ctest --test-dir build/native/address --timeout $(PYTEST_TIMEOUT) --parallel 2 --output-on-failure --exclude-regex sim_tests

check-kotlin:
	$(if_unchecked) $(kotlin) build/native/bundle config/streams.yaml tests/conformance/vectors -- \
	  $(maven) --quiet test $(compiled) -pl ml2-sensors-aar -Dtest='!**/capture/*Test,!**/fuzz/*Test,!MalformedVectorTest,!**/pacing/Link*Test'

check-unity:
	$(if_unchecked) unity_package build/native/bundle tests/unity tests/unity_project tests/conformance/vectors -- tests/unity/run.sh

# The longest first, and the browser's many threads not beside native tests with sanitizers. Of targets that run beside
# each other, each has two tests at a time, which often wait. That of whole headsets and receivers has one, whose
# processes fill a processor. With more, they would only wait for each other.
test: shared-memory setup-headset+test+csharp+view build $(class_archive) $(javascript) ## Run the tests of everything but a release's packages
	headsets_at_a_time=1 $(call at_a_time,test-together test-python test-native test-kotlin test-view test-conformance test-unity)
	$(submake) test-alone

# ROS nodes exchange images by it. Without enough, they wait in vain.
shared-memory:
	@test "$$(df --output=avail --block-size=1M /dev/shm | tail -n 1)" -ge 500 || { echo "/dev/shm has less than 500 MB free, which tests with ROS need: in a container, raise --shm-size" >&2; exit 1; }

test-python: shared-memory setup-test $(javascript) ## Test the receiver
	$(pytest) $(slowest) $(beside) host_receiver/test

$(javascript): $(wildcard host_receiver/test/javascript/package*.json)
	mkdir -p $(@D)
	cp $^ $(@D)
	npm ci --prefix $(@D) --no-audit --no-fund
	@touch $@

test-native: setup-headset+test native ## Test the native library and its simulations, with sanitizers
	$(call sanitized,address,address$(comma)undefined)
	$(fixed_addresses) ctest --test-dir build/native/address --timeout $(PYTEST_TIMEOUT) --parallel 2 --output-on-failure
	$(call sanitized,thread,thread,--target threaded)
	$(fixed_addresses) ctest --test-dir build/native/thread --timeout $(PYTEST_TIMEOUT) --parallel 2 --output-on-failure --label-regex threaded
	$(pytest) native/tests

test-kotlin: build ## Test the Kotlin library and the simulated headset
	$(maven) verify $(compiled) -pl '!$(aar),!$(benchmark)'

test-conformance: build ## Test every language against the shared vectors
	$(pytest) $(beside) tests/conformance

test-release: setup-headset+android+test native dist ## Test what a release holds: the Android packages and the app, the Unity package, the wheel
	$(pytest) --numprocesses 2 --dist loadfile tests/aar tests/dist

test-unity: setup-headset+csharp native ## Test the Unity package with mono, and that it is complete
	tests/unity/run.sh
	$(pytest) tests/unity

test-e2e: test-together test-alone ## Test headset, receiver and ROS 2 together, as processes

test-together: shared-memory build $(class_archive)
	$(pytest) $(slowest) --numprocesses $(headsets_at_a_time) --dist loadscope -m 'not alone' tests/end_to_end tests/validation

test-alone: shared-memory build $(class_archive)
	$(pytest) $(slowest) -m alone tests/end_to_end tests/validation

page-library: ## Bundle three.js for the page of `ml2-receiver view`, after a change in config/three
	config/three/bundle.sh $(three)

test-view: shared-memory setup-headset+test+view build $(class_archive) ## Test the page of `ml2-receiver view` in Chromium, which is installed if it is missing; screenshots in build/reports
	config/three/bundle.sh build/three/three.min.js
	cmp build/three/three.min.js $(three)
	$(pytest) $(slowest) tests/view

api: setup-headset+csharp ## Rewrite the lists of what is public, to be committed with what changed it
	REWRITE_API=1 $(maven) --quiet test -pl ml2-sensors-aar,ml2-sensors-aar/simulator -Dtest=PublicApiTest
	REWRITE_API=1 $(pytest) native/tests/sdk host_receiver/test/test_public_api.py
	REWRITE_API=1 tests/unity/run.sh -run:Ml2Sensors.Tests.PublicApiTests

lint: setup-headset+lint $(ktlint_jar) $(detekt_jar) ## Check style, types, scripts, generated files and documents
	$(call at_a_time,lint-python lint-kotlin lint-native lint-documents)

lint-python:
	$(if_unchecked) $(python) $(settings) build/venv/.setup-inputs -- $(submake) ruff mypy

ruff:
	$(run) ruff check --config $(settings) $(python)
	$(run) ruff format --check --config $(settings) $(python)

mypy:
	for folder in $(python); do $(run) mypy --config-file $(settings) $$folder || { echo "mypy: wrong in $$folder" >&2; exit 1; }; done

lint-kotlin:
	$(if_unchecked) $(kotlin) -- $(submake) ktlint detekt

ktlint:
	$(ktlint)

detekt:
	$(java) -jar $(detekt_jar) --config ml2-sensors-aar/detekt.yml --input ml2-sensors-aar/src/main/kotlin

lint-native:
	git ls-files -co --exclude-standard 'native/*.[ch]' 'native/*.cpp' 'tests/*.c' | xargs clang-format --dry-run -Werror

lint-documents:
	$(run) python3 config/generate.py --check
	$(run) python3 config/figures.py --check
	$(run) python3 tests/conformance/generate_vectors.py --verify
	$(run) python3 -m pip check
	$(pytest) --quiet tests/docs
	git grep --untracked -lE '^#!/usr/bin/env (-S .+ )?bash' | xargs shellcheck

format: setup-headset+lint $(ktlint_jar) ## Lay out Python and Kotlin as lint wants them
	$(run) ruff check --fix --config $(settings) $(python)
	$(run) ruff format --config $(settings) $(python)
	git ls-files -co --exclude-standard 'native/*.[ch]' 'native/*.cpp' 'tests/*.c' | xargs clang-format -i
	$(ktlint) --format

$(ktlint_jar):
	$(maven) dependency:copy --non-recursive -DoutputDirectory="$(CURDIR)/$(@D)" \
	  -Dartifact=com.pinterest.ktlint:ktlint-cli:$(ktlint_version):jar:all

$(detekt_jar):
	$(maven) dependency:copy --non-recursive -DoutputDirectory="$(CURDIR)/$(@D)" \
	  -Dartifact=io.gitlab.arturbosch.detekt:detekt-cli:$(detekt_version):jar:all

bench: build ## Measure against bare loops, and [PEER=checkout of ROS-TCP-Endpoint]; results in build/bench
	$(run) env PEER="$(PEER)" tests/bench/run.sh

fuzz: build ## Look for bytes of peers that our readers mistake, DURATION seconds for each reader
	$(call at_a_time,fuzz-python fuzz-kotlin)

fuzz-python: setup
	$(run) tests/fuzz/run.sh $(DURATION)

fuzz-kotlin: build
	ml2-sensors-aar/fuzz.sh $(DURATION)

audit: setup ## Ask a public database for vulnerabilities of what the receiver needs
	$(run) python3 -m venv build/audit
	build/audit/bin/pip install --quiet pip-audit
	build/audit/bin/pip-audit --strict -r host_receiver/environment/requirements.txt

links: build ## Everything raw over links of 300, 100, 50 and 30 Mbit/s for DURATION seconds each, as root: how late are inertial samples? Result in build/bench/links.json
	$(run) env PYTHONPATH=host_receiver:host_receiver/demo:host_receiver/test:tests/end_to_end python3 tests/end_to_end/links.py $(DURATION)

interop: setup ## Have hiroz, an implementation of ROS 2 on Zenoh, read our topics. Needs cargo; the first build takes five minutes
	cargo build --manifest-path tests/interop/Cargo.toml --target-dir build/interop
	$(pytest) tests/interop

soak: build ## Full load for DURATION seconds: does anything grow? Result in build/bench/soak.json
	$(run) env PYTHONPATH=host_receiver:host_receiver/demo:host_receiver/test:tests/end_to_end python3 tests/bench/soak.py $(DURATION)

harsh: harsh-android ## Faults at random, by SEED: FAULTS of Android's classes, then of device and link for DURATION seconds. Does all come back, and does nothing grow? Result in build/reports/harsh.json
	$(run) env PYTHONPATH=host_receiver:host_receiver/demo:host_receiver/test:tests/end_to_end python3 tests/end_to_end/harsh.py $(DURATION) $(SEED)

harsh-android: build ## The part of harsh with Android's classes, in virtual time
	$(maven) --quiet test $(compiled) -pl $(library),$(library)/android-test -am \
	  -Dtest=HarshTest,UnityCloseTest,VendorNeverReturnsTest \
	  -Dsurefire.failIfNoSpecifiedTests=false -Dharsh.faults=$(FAULTS) -Dharsh.seed=$(SEED)

validate: build ## Trajectories from images alone, against the headset's and the true ones, and 20 calibrated inertial units, with noise; SEED draws two walks and the units; result in build/validate (20 minutes, on an idle machine)
	$(run) env PYTHONPATH=host_receiver:host_receiver/demo:host_receiver/test:tests/end_to_end python3 tests/validation/validate.py $(SEED)
	$(run) env PYTHONPATH=host_receiver:host_receiver/demo:host_receiver/test:tests/end_to_end python3 tests/validation/imu_calibration.py $(SEED)

image-quality: build ## What JPEG costs: matches and structure from motion of raw images, and of the same compressed; result in build/bench/image_quality.json (half an hour, on an idle machine)
	$(run) env PYTHONPATH=host_receiver:host_receiver/demo:host_receiver/test:tests/end_to_end python3 tests/validation/image_quality.py

clean: ## Remove everything that was made, the Python environment included
	rm -rf build
	find . -name target -type d -prune -exec rm -r {} +

.PHONY: $(shell sed -n 's/^\([a-z0-9][a-z0-9-]*\):.*/\1/p' Makefile)
