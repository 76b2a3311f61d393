#!/usr/bin/env bash
# Builds the type support of messages that have no wheel, those of messages/, against the ROS 2 wheels in an environment
# and installs it there: messages.sh VENV. Does nothing for a package that is there.
set -euo pipefail
# shellcheck source=/dev/null
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../../config/errors.sh"
venv=$(readlink -f "$1")
sources=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/messages
site_packages=$("$venv/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
include=$("$venv/bin/python" -c 'import sysconfig; print(sysconfig.get_path("include"))')
build=$(mktemp -d)
trap 'rm -r "$build"' EXIT

# The wheels' CMake files name the Python of the machine that built them.
built_with=/opt/python/cp312-cp312
find "$venv/share" -name '*.cmake' -exec sed -i \
  -e "s|$built_with/include/python3.12|$include|g" -e "s|$built_with/lib/python3.12/site-packages|$site_packages|g" {} +

export AMENT_PREFIX_PATH=$venv CMAKE_PREFIX_PATH=$venv PATH=$venv/bin:$PATH
libraries=("$site_packages"/ros_*.libs)
LD_LIBRARY_PATH=$venv/lib:$(IFS=: && echo "${libraries[*]}")
export LD_LIBRARY_PATH
unset PYTHONPATH

build_package() {
  local name=$1
  if "$venv/bin/python" -c "import $name.msg" 2>/dev/null; then return; fi
  if ! {
    cmake -S "$sources/$name" -B "$build/$name" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX="$venv" \
      -DBUILD_TESTING=OFF -DPython3_EXECUTABLE="$venv/bin/python" -DPython3_FIND_VIRTUALENV=ONLY &&
      cmake --build "$build/$name" && cmake --install "$build/$name"
  } >"$build/$name.log" 2>&1; then
    cat "$build/$name.log" >&2
    return 1
  fi
}

builds=()
for package in "$sources"/*/; do
  build_package "$(basename "$package")" &
  builds+=($!)
done
for pid in "${builds[@]}"; do wait "$pid"; done
