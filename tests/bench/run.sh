#!/usr/bin/env bash
# `make bench`: each path beside a bare loop over the same bytes, in one run; results in build/bench.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

benchmark=ml2-sensors-aar/benchmark/target
mkdir -p build/bench
echo "[1/2] sender: encode and gathering write against a bare gathering write (JMH, a minute)"
java -cp "$benchmark/*:$benchmark/lib/*" dev.ml2sensors.benchmark.MainKt build/bench/sender.json >build/bench/sender.log
echo "[2/2] receiver: against a bare loop of recv_into and raw publish"
PYTHONPATH=${PYTHONPATH:+$PYTHONPATH:}host_receiver/test python3 tests/bench/receiver_bench.py 2>build/bench/receiver.log
python3 tests/bench/show.py build/bench/*.json
