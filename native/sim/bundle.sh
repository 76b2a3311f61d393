#!/usr/bin/env bash
# Fills build/native/bundle with all native code of the simulated headset, for a process that sets no library path: the
# library that goes into the AAR, bionic's names, the simulation, an OpenXR loader and what these need of this system
# beside its C and C++ libraries. `order` lists the libraries as they are to be loaded: each after those that it needs.
set -euo pipefail
# shellcheck source=/dev/null
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../../config/errors.sh"
cd "$(dirname "$0")/../.."

native=build/native
bundle=$native/bundle
simulation=$native/host/sim/libperception.magicleap.so
PATH=$PATH:/sbin # where Debian has ldconfig, for root alone
loader=$(ldconfig -p | sed -n 's/.*libopenxr_loader\.so\.1 .*=> //p' | head -n 1)

# needs LIBRARY: what it needs that not every Linux has, by path.
needs() {
  ldd "$1" | sed -n 's|.*=> \(/.*/lib\([^ ]*\)\) (.*|\2 \1|p' | grep -vE '^(c|m|dl|pthread|rt|stdc\+\+|gcc_s)\.so' | cut -d ' ' -f 2
}

rm -rf "$bundle"
mkdir -p "$bundle"
mapfile -t files < <(needs "$simulation"; echo "$simulation"; echo "$native/host/sim/libinput.magicleap.so"; ls "$native"/host/sim/jni/*.so
                     needs "$loader"; echo "$loader"; ls "$native"/linux/*.so)
for file in "${files[@]}"; do
  strip -o "$bundle/$(basename "$file")" "$(readlink -f "$file")"
  basename "$file" >>"$bundle/order"
done
cp "$native/device/libml2sensors.so" "$bundle" # the very bytes
printf '{"file_format_version": "1.0.0", "runtime": {"library_path": "%s"}}\n' "$(basename "$simulation")" \
  >"$bundle/openxr_runtime.json"
