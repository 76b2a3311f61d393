#!/usr/bin/env bash
# Runs Jazzer on each compiled FuzzTarget for so many seconds; what it has found interesting stays in target/fuzz.
set -euo pipefail
# shellcheck source=/dev/null
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../config/errors.sh"
cd "$(dirname "${BASH_SOURCE[0]}")"

seconds=$1
mvn -q -f .. dependency:build-classpath -pl ml2-sensors-aar \
    -Dmdep.outputFile=target/fuzz-classpath -Dmdep.includeScope=test
classpath=target/test-classes:target/classes:$(<target/fuzz-classpath)
# Without the second compiler and parallel collection, three times as many inputs are tried in two seconds, and as many
# in half a minute.
for reader in FRAMES BODIES OPENINGS ORDER PAIRING MESSAGES URI; do
    corpus=target/fuzz/$reader
    mkdir -p "$corpus"
    touch "$corpus.began"
    echo "fuzzing $reader for $seconds s"
    java -XX:TieredStopAtLevel=1 -XX:+UseSerialGC -cp "$classpath" com.code_intelligence.jazzer.Jazzer \
        --target_class=dev.ml2sensors.fuzz.JazzerTarget --target_args="$reader $corpus" \
        --instrumentation_includes='dev.ml2sensors.**' --reproducer_path=target/fuzz \
        "$corpus" -max_total_time="$seconds" -max_len=8192 -artifact_prefix="$corpus-" -print_final_stats=1 \
        2>"$corpus.log" || {
        tail -n 30 "$corpus.log" >&2
        echo "fuzz: $reader fails for $PWD/$(find target/fuzz -name "$reader-*" -newer "$corpus.began")" >&2
        exit 1
    }
    grep -E 'stat::number_of_executed_units|DONE' "$corpus.log"
done
