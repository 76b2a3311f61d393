#!/usr/bin/env bash
# Builds tf2_msgs' type support against the ROS 2 wheels in an environment and installs it there: tf2_msgs.sh VENV
set -euo pipefail
venv=$(readlink -f "$1")
source=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/tf2_msgs
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
if ! {
  cmake -S "$source" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX="$venv" \
    -DBUILD_TESTING=OFF -DPython3_EXECUTABLE="$venv/bin/python" -DPython3_FIND_VIRTUALENV=ONLY &&
    cmake --build "$build" && cmake --install "$build"
} >"$build/log" 2>&1; then
  cat "$build/log" >&2
  exit 1
fi
