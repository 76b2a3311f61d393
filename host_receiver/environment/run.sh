#!/usr/bin/env bash
# Runs a command, in the caller's directory, with ROS 2 Jazzy and ml2_receiver importable by the `python3` it finds:
#   host_receiver/environment/run.sh python3 -m ml2_receiver run
# That is the Python of `make setup`, or without one the machine's, where ROS has been sourced.
set -euo pipefail
receiver=$(dirname "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")")
venv=$(dirname "$receiver")/build/venv
unset PYTHONHOME PYTHONSAFEPATH # another Python's, or scripts without their neighbours

if grep -qs 'include-system-site-packages = false' "$venv/pyvenv.cfg"; then
  # The wheels find their libraries themselves; those of another ROS in the caller's environment would go first.
  unset AMENT_PREFIX_PATH LD_LIBRARY_PATH PYTHONPATH _ROS_WHEELS_BOOTSTRAP_COMPLETE
  if [[ ${RMW_IMPLEMENTATION:-rmw_fastrtps_cpp} != rmw_fastrtps_cpp ]]; then
    echo "run.sh: build/venv has no $RMW_IMPLEMENTATION: rmw_fastrtps_cpp is used, which nodes on other DDS hear; those on Zenoh need --zenoh" >&2
    unset RMW_IMPLEMENTATION
  fi
elif [[ ${ROS_DISTRO:-} != jazzy && -e /opt/ros/jazzy/setup.bash ]]; then
  set +u
  # shellcheck source=/dev/null
  source /opt/ros/jazzy/setup.bash
  set -u
fi
if [[ -d $venv ]]; then
  export PATH=$venv/bin:$PATH
elif [[ ${ROS_DISTRO:-} != jazzy ]]; then
  echo "run.sh: no ROS 2 Jazzy: run \`make setup\`, or source one" >&2
  exit 1
fi
export PYTHONPATH=$receiver${PYTHONPATH:+:$PYTHONPATH}

# The commands of ml2-receiver are entry points, which Python finds in the metadata beside the packages.
metadata=$receiver/ml2_receiver.egg-info
has_metadata() { [[ $metadata/entry_points.txt -nt $receiver/pyproject.toml ]]; }
write_metadata() (
  cd "$receiver"
  exec 9<pyproject.toml
  flock 9 # several commands may start at once
  if has_metadata; then return; fi
  made=$(mktemp -d -p .)
  trap 'rm -rf "$made"' EXIT
  python3 setup.py --quiet egg_info --egg-base "$made"
  rm -rf "$metadata"
  mv "$made"/*.egg-info "$metadata"
)
has_metadata || write_metadata
exec "$@"
