#!/usr/bin/env bash
# Links build/native/device/libml2sensors.so, the file that goes into the AAR, for x86_64-linux-android29 without an
# NDK: freestanding C, declarations of our own (include/) and stub libraries of bionic (bionic/*.txt lists all that may
# be used of it). build/native/linux/ receives what lets a Linux process load that same file: libraries of bionic's
# names that only need the system's, and a liblog that prints. Equal sources give equal bytes. Other folders than these
# two: link.sh DEVICE LINUX.
set -euo pipefail
# shellcheck source=/dev/null
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../../config/errors.sh"
cd "$(dirname "$0")/../.."

out=${1:-build/native/device}
linux=${2:-build/native/linux}
stubs=$out/stubs
target=(clang --target=x86_64-linux-android29 -std=gnu11 -nostdlib -shared -fPIC -fuse-ld=lld)

mkdir -p "$stubs" "$linux"
for list in native/device/bionic/*.txt; do
  name=$(basename "$list" .txt).so
  sed 's/.*/void &(void) {}/' "$list" |
    "${target[@]}" -fno-builtin -w -Wl,-soname,"$name" -o "$stubs/$name" -x c -
done

sources=(native/sdk/*.c native/sources/*.c native/codecs/*.c native/openxr/*.c)
# Khronos' header alone, without the other headers of this machine beside it.
mkdir -p "$out/khronos"
ln -sfn "$(pkg-config --variable=includedir openxr)/openxr" "$out/khronos/openxr"
includes=(-isystem native/device/include -isystem "$out/khronos")
if compgen -G 'native/jni/*.c' >/dev/null; then
  jdk=${JAVA_HOME:-$(dirname "$(dirname "$(readlink -f "$(command -v javac)")")")}
  sources+=(native/jni/*.c)
  includes+=(-isystem "$jdk/include" -isystem "$jdk/include/linux")
fi
# The build of native/CMakeLists.txt takes warnings of these sources as errors.
"${target[@]}" -O2 -ffreestanding -fno-math-errno -nostdlibinc "${includes[@]}" -Wall -Wextra \
  -Wno-c2x-extensions -fvisibility=hidden -Wl,--no-undefined -Wl,--as-needed -Wl,-soname,libml2sensors.so \
  -Wl,-z,max-page-size=16384 -Wl,--hash-style=both -Wl,--pack-dyn-relocs=none -Wl,-z,relro -Wl,-z,now \
  -Wl,-z,noexecstack -Wl,-z,text -Wl,--build-id=sha1 "${sources[@]}" -L"$stubs" -lc -ldl -llog \
  -o "$out/libml2sensors.so"

# The libraries have bionic's names as sonames too, so that the loader takes those that a process has loaded already.
rm -f "$linux"/lib*.so
for name in libc.so.6 libm.so.6 libdl.so.2; do
  cc -shared -nostdlib -Wl,-soname,"${name%.*}" -Wl,--no-as-needed -o "$linux/${name%.*}" -x c /dev/null -x none -l:"$name"
done
cc -shared -fPIC -O2 -Wl,-soname,liblog.so -o "$linux/liblog.so" native/device/log.c
