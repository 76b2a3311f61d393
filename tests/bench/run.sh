#!/usr/bin/env bash
# `make bench`: each path beside a bare loop over the same bytes, in one run; results in build/bench.
set -euo pipefail
# shellcheck source=/dev/null
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../../config/errors.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

benchmark=ml2-sensors-aar/benchmark/target
mkdir -p build/bench
cut -d' ' -f1 /proc/loadavg >build/bench/load_average_before.txt
echo "[1/16] sender: encode and gathering write against a bare gathering write; receiving: decoding a point cloud (JMH, a minute)"
java -cp "$benchmark/*:$benchmark/lib/*" dev.ml2sensors.benchmark.MainKt build/bench/sender.json build/bench/decoder.json >build/bench/sender.log
echo "[2/16] sender: TLS against plaintext"
java -cp "$benchmark/*:$benchmark/lib/*" dev.ml2sensors.benchmark.TlsKt build/bench/sender_tls.json >build/bench/sender_tls.log
echo "[3/16] capture: native frame to socket against one copy and one gathering write (20 s)"
cc -shared -fPIC -O2 -ffreestanding -Wl,--version-script=tests/bench/copies.map -o build/bench/libcopies.so tests/bench/copies.c
LD_LIBRARY_PATH=build/native/linux:build/native/host/sim LD_PRELOAD=build/bench/libcopies.so ML2S_COPIES=build/bench/copies.txt \
  java -cp "$benchmark/*:$benchmark/lib/*" dev.ml2sensors.benchmark.CaptureKt \
  build/native/device/libml2sensors.so build/bench/capture.json >build/bench/capture.log
cc -O2 -o build/bench/device tests/bench/device.c -Lbuild/native/host/sim -l:libperception.magicleap.so
LD_LIBRARY_PATH=build/native/host/sim build/bench/device >build/bench/device.txt 2>>build/bench/capture.log
python3 tests/bench/finish_capture.py build/bench
echo "[4/16] receiver: against a bare loop of recv_into and raw publish${PEER:+, and against ROS-TCP-Endpoint}"
[[ -n ${PEER:-} ]] || echo "      not against ROS-TCP-Endpoint: that wants PEER=<a checkout of it>"
PYTHONPATH=${PYTHONPATH:+$PYTHONPATH:}host_receiver/test python3 tests/bench/receiver_bench.py build/bench/receiver.json 500 7 2>build/bench/receiver.log
echo "[5/16] receiver: with 0, 1 and 3 subscribers (30 s)"
PYTHONPATH=${PYTHONPATH:+$PYTHONPATH:}host_receiver/test python3 tests/bench/subscribers_bench.py 500 2>build/bench/subscribers.log
echo "[6/16] TLS: receiving with it and without (20 s)"
PYTHONPATH=${PYTHONPATH:+$PYTHONPATH:}host_receiver/test python3 tests/bench/tls_bench.py build/bench/tls.json 500 7 2>build/bench/tls.log
echo "[7/16] lazy streams: from a new subscription to its first image (20 s)"
PYTHONPATH=${PYTHONPATH:+$PYTHONPATH:}host_receiver/test python3 tests/bench/lazy_bench.py >build/bench/lazy.log 2>&1
echo "[8/16] recording: against a bare write of the same bytes (20 s, 1 GB of disk at most)"
python3 tests/bench/recording_bench.py
echo "[9/16] products: clouds, registered depth and rectified images (10 s)"
PYTHONPATH=${PYTHONPATH:+$PYTHONPATH:}host_receiver/test python3 tests/bench/products_bench.py
echo "[10/16] recovery: finding each other, and again after a fault, and wills (4 minutes)"
PYTHONPATH=${PYTHONPATH:+$PYTHONPATH:}host_receiver:host_receiver/demo:host_receiver/test:tests/end_to_end python3 tests/bench/recovery_bench.py 9
echo "[11/16] full load, the same with TLS, the first while recording, and four headsets (4 minutes)"
PYTHONPATH=${PYTHONPATH:+$PYTHONPATH:}host_receiver:host_receiver/demo:host_receiver/test:tests/end_to_end python3 tests/bench/full_load.py 60
echo "[12/16] memory: slots and buffers of a headset that sends everything (a minute)"
PYTHONPATH=${PYTHONPATH:+$PYTHONPATH:}host_receiver:host_receiver/demo:host_receiver/test:tests/end_to_end python3 tests/bench/memory_bench.py 30
echo "[13/16] compressed images: sizes, and the time of the encoders (a minute)"
PYTHONPATH=${PYTHONPATH:+$PYTHONPATH:}host_receiver:host_receiver/demo:host_receiver/test:tests/end_to_end python3 tests/bench/codecs_bench.py 30
echo "[14/16] Zenoh: CPU, the longest put, and a thin link (2 minutes; the link as root)"
PYTHONPATH=${PYTHONPATH:+$PYTHONPATH:}host_receiver:host_receiver/demo:host_receiver/test:tests/end_to_end python3 tests/bench/zenoh_bench.py build/bench/zenoh.json 500 30
echo "[15/16] the page of view, which shows everything to a client, and what it costs the others (4 minutes)"
PYTHONPATH=${PYTHONPATH:+$PYTHONPATH:}host_receiver:host_receiver/demo:host_receiver/test:tests/end_to_end python3 tests/bench/view_bench.py 30
echo "[16/16] the way back: 1000 messages per second to the app, then large ones, beside all sensors with TLS (6 minutes)"
PYTHONPATH=${PYTHONPATH:+$PYTHONPATH:}host_receiver:host_receiver/demo:host_receiver/test:tests/end_to_end python3 tests/bench/downlink_bench.py 60
echo "       and a frame in 3000 transforms per second (a minute)"
PYTHONPATH=${PYTHONPATH:+$PYTHONPATH:}host_receiver:host_receiver/demo:host_receiver/test:tests/end_to_end python3 tests/bench/transforms_bench.py 30
if [[ -n ${PEER:-} ]]; then
  echo "       the way back against ROS-TCP-Endpoint (2 minutes)"
  PYTHONPATH=${PYTHONPATH:+$PYTHONPATH:}host_receiver:host_receiver/demo:host_receiver/test:tests/end_to_end python3 tests/bench/downlink_endpoint_bench.py build/bench/downlink_endpoint.json "$PEER" 10 5 2>build/bench/downlink_endpoint.log
fi
python3 tests/bench/show.py build/bench/*.json
python3 tests/bench/performance_page.py
