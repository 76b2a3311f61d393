#!/usr/bin/env bash
# Checks that build/native/device/libml2sensors.so needs and shows nothing but what it should, and that linking it anew
# gives the same bytes.
set -euo pipefail
# shellcheck source=/dev/null
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../../config/errors.sh"
cd "$(dirname "$0")/../.."

library=build/native/device/libml2sensors.so
failures=0

# expect WHAT FOUND ALLOWED: every line of FOUND is one of ALLOWED.
expect() {
  local surplus
  surplus=$(comm -23 <(sort -u <<<"$2" | sed '/^$/d') <(sort -u <<<"$3"))
  if [[ -n $surplus ]]; then
    printf '%s: %s, which is not expected\n' "$1" "${surplus//$'\n'/ }" >&2
    failures=$((failures + 1))
  fi
}

dynamic=$(readelf -dW "$library")
symbols=$(readelf -W --dyn-syms "$library")
needed=$(sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' <<<"$dynamic")
undefined=$(awk '$7 == "UND" && $8 {print $8}' <<<"$symbols")
exported=$(awk '$1 ~ /:$/ && $7 != "UND" && $7 != "Ndx" {print $8}' <<<"$symbols")
# All functions that clang reads in the header, exported or not.
documented=$(grep -o ' ml2s_[a-z_0-9]*(' native/api/ml2s.api | tr -d ' (')
if compgen -G 'native/jni/*.c' >/dev/null; then
  documented+=$'\nJNI_OnLoad'
fi

expect 'needed library' "$needed" $'libc.so\nlibm.so\nlibdl.so\nliblog.so'
expect 'undefined symbol' "$undefined" "$(cat native/device/bionic/*.txt)"
expect 'exported symbol' "$exported" "$documented"
expect 'missing export' "$documented" "$exported"
expect 'relocation of code' "$(grep -o TEXTREL <<<"$dynamic" || (($? == 1)))" ''
again=$(mktemp -d)
trap 'rm -rf "$again"' EXIT
native/device/link.sh "$again/device" "$again/linux"
expect 'other bytes' "$(sha256sum <"$again/device/libml2sensors.so")" "$(sha256sum <"$library")"
exit $((failures > 0))
