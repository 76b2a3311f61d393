#!/usr/bin/env bash
# `make bench`: each path beside a bare loop over the same bytes, in one run; results in build/bench.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

benchmark=ml2-sensors-aar/benchmark/target
mkdir -p build/bench
echo "[1/8] sender: encode and gathering write against a bare gathering write (JMH, a minute)"
java -cp "$benchmark/*:$benchmark/lib/*" dev.ml2sensors.benchmark.MainKt build/bench/sender.json >build/bench/sender.log
echo "[2/8] sender: TLS against plaintext"
java -cp "$benchmark/*:$benchmark/lib/*" dev.ml2sensors.benchmark.TlsKt build/bench/sender_tls.json >build/bench/sender_tls.log
echo "[3/8] capture: native frame to socket against one copy and one gathering write (20 s)"
cc -shared -fPIC -O2 -ffreestanding -Wl,--version-script=tests/bench/copies.map -o build/bench/libcopies.so tests/bench/copies.c
LD_LIBRARY_PATH=build/native/linux:build/native/host/sim LD_PRELOAD=build/bench/libcopies.so ML2S_COPIES=build/bench/copies.txt \
  java -cp "$benchmark/*:$benchmark/lib/*" dev.ml2sensors.benchmark.CaptureKt \
  build/native/device/libml2sensors.so build/bench/capture.json >build/bench/capture.log
cc -O2 -o build/bench/device tests/bench/device.c -Lbuild/native/host/sim -l:libperception.magicleap.so
LD_LIBRARY_PATH=build/native/host/sim build/bench/device >build/bench/device.txt 2>>build/bench/capture.log
python3 tests/bench/finish_capture.py build/bench
echo "[4/8] receiver: against a bare loop of recv_into and raw publish"
PYTHONPATH=${PYTHONPATH:+$PYTHONPATH:}host_receiver/test python3 tests/bench/receiver_bench.py 2>build/bench/receiver.log
echo "[5/8] lazy streams: from a new subscription to its first image (20 s)"
python3 tests/bench/lazy_bench.py >build/bench/lazy.log 2>&1
echo "[6/8] recording: against a bare write of the same bytes (20 s, 1 GB of disk at most)"
python3 tests/bench/recording_bench.py
echo "[7/8] products: clouds, registered depth and rectified images (10 s)"
python3 tests/bench/products_bench.py
echo "[8/8] full load, the same while recording, and four headsets (3 minutes)"
PYTHONPATH=${PYTHONPATH:+$PYTHONPATH:}host_receiver:tests/end_to_end python3 tests/bench/full_load.py 60
python3 tests/bench/show.py build/bench/*.json
