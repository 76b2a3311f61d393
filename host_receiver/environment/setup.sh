#!/usr/bin/env bash
# Usage: setup.sh [--check] [GROUP...]
#
# Installs what is missing: the Debian packages of the groups (debian-packages.txt; without any, those of the receiver),
# and in build/venv a Python 3.12 with ROS 2 Jazzy, the one in /opt/ros/jazzy or else PyPI's wheels. Does nothing while
# what it reads is as it was when it last succeeded; with --check it only fails if there is something to install.
set -euo pipefail
# shellcheck source=/dev/null
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../../config/errors.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
unset _ROS_WHEELS_BOOTSTRAP_COMPLETE # inherited from a Python with the wheels, it would hide the libraries of ours
unset PYTHONHOME # of another Python
export PIP_USER=0 # whoever has it on by default means it for other folders than build/venv

environment=host_receiver/environment
mkdir -p build || { echo "setup: cannot make the folder build in $PWD: give your user access to it" >&2; exit 1; }
venv=$(readlink -f build/venv)
stamp=$venv/.setup-inputs
ros_from_apt=false
if [[ -e /opt/ros/jazzy/setup.bash ]]; then ros_from_apt=true; fi

main() {
  local is_check=false list missing=()
  if [[ ${1:-} == --check ]]; then
    is_check=true
    shift
  fi
  if (($# == 0)); then set -- receiver; fi
  if [[ $* != receiver && ! -w ${HOME:-} ]]; then
    $is_check || fail "cannot write to your home folder ${HOME:-}, where Maven, ccache and npm keep what they load: put HOME=FOLDER before the command"
    exit 1
  fi
  if [[ " $* " == *" headset "* && $(uname -m) != x86_64 ]]; then
    $is_check || fail "the simulated headset runs on x86-64, this processor is $(uname -m): what needs no headset works, make setup and host_receiver/ml2-receiver"
    exit 1
  fi
  list=$(missing_packages "$@") || exit 1
  if [[ -n $list ]]; then mapfile -t missing <<<"$list"; fi
  if ((${#missing[@]} == 0)) && is_current; then return; fi
  if $is_check; then exit 1; fi
  exec 9>build/.setup-lock
  flock 9 # targets of make may run beside each other
  if ((${#missing[@]})); then echo "[1/4] Debian packages: ${missing[*]}"; fi
  install_packages "${missing[@]}"
  if is_current; then return; fi
  rm -f "$stamp"
  echo "[2/4] Python 3.12 environment in build/venv"
  venv_is_usable || make_venv
  if $ros_from_apt; then
    echo "[3/4] Python packages (150 MB, about a minute)"
    pip_install requirements.txt requirements-dev.txt
    echo "[4/4] messages: part of /opt/ros/jazzy"
  else
    echo "[3/4] ROS 2 Jazzy wheels and Python packages (200 MB)"
    install_fast requirements.txt requirements-dev.txt requirements-ros.txt messages/build-requirements.txt
    echo "[4/4] messages that have no wheel (about 30 seconds)"
    "$environment/messages.sh" "$venv"
  fi
  inputs >"$stamp"
}

is_current() {
  [[ -x $venv/bin/python && -f $stamp && $(inputs) == "$(<"$stamp")" ]]
}

missing_packages() {
  local group package name groups
  for group in "$@"; do
    grep -qE "[ ,]$group(,|\$)" "$environment/debian-packages.txt" ||
      fail "no group $group: receiver, headset, test, csharp, lint, app, android and view are"
  done
  while read -r package name groups; do
    for group in "$@"; do
      if [[ $package == \#* || ,$groups, != *,"$group",* ]]; then continue; fi
      if ! command -v "$name" >/dev/null && ! compgen -G "$name" >/dev/null; then echo "$package"; fi
      break
    done
  done <"$environment/debian-packages.txt"
  $ros_from_apt || return 0
  for name in diagnostic_msgs ffmpeg_image_transport_msgs foxglove_msgs nav_msgs rclpy rmw_fastrtps_cpp sensor_msgs std_srvs test_msgs tf2_msgs vision_msgs; do
    if [[ ! -d /opt/ros/jazzy/share/$name ]]; then echo "ros-jazzy-${name//_/-}"; fi
  done
}

inputs() {
  {
    echo "$venv" $ros_from_apt
    find "$environment" host_receiver/pyproject.toml host_receiver/setup.* -type f -print0 | sort -z | xargs -0 sha256sum
  } | sha256sum
}

apt_has() { [[ $(apt-cache search --names-only "^${1//+/\\+}\$") ]]; }

check_that_apt_has_python() {
  if [[ $* == *python3.12* ]] && ! apt_has python3.12-venv; then
    fail "ROS 2 Jazzy needs Python 3.12, which apt does not have here: pyenv install 3.12, then run this again"
  fi
}

install_packages() {
  local missing=("$@") become=() absent=() package
  if ! "$environment/find_python.sh" >/dev/null; then missing+=(python3.12-dev python3.12-venv); fi
  if ((${#missing[@]} == 0)); then return; fi
  command -v apt-get >/dev/null || fail "install these (named as in Debian) and run this again: ${missing[*]}"
  if ((EUID != 0)); then become=(sudo -n); fi
  if ((EUID != 0)) && ! sudo -n true; then
    if apt_has python3-venv; then check_that_apt_has_python "${missing[@]}"; fi # not before apt has read its lists
    fail "run this, then this again: sudo apt-get install ${missing[*]}"
  fi
  "${become[@]}" apt-get update -qq -o APT::Update::Error-Mode=any ||
    fail "apt-get cannot read its lists of packages: mend what it says above (network, disk), then run this again"
  check_that_apt_has_python "${missing[@]}"
  "${become[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "${missing[@]}" && return
  for package in "${missing[@]}"; do
    apt_has "$package" || absent+=("$package")
  done
  ((${#absent[@]} == 0)) ||
    fail "apt does not have ${absent[*]} here, as on Debian 12: install that in another way, or run targets that do without (make help)"
  fail "apt-get did not install them: mend what it says above (network, disk), then run this again"
}

venv_is_usable() { # not after a move, nor after ROS came from apt or went
  [[ -x $venv/bin/python ]] &&
    grep -qF "$venv/bin/python" "$venv/bin/pip" 2>/dev/null &&
    grep -q "include-system-site-packages = $ros_from_apt" "$venv/pyvenv.cfg"
}

make_venv() {
  local options=(--clear)
  if $ros_from_apt; then options+=(--system-site-packages); fi
  "$("$environment/find_python.sh")" -m venv "${options[@]}" "$venv" ||
    fail "no Python environment in $venv: mend what it says above (disk, access), then run this again"
}

# With uv, which takes a tenth of pip's time. It does not see packages of the system, and reads no settings of pip; where
# packages come only through these, pip installs.
install_fast() {
  "$venv/bin/python" -m pip install --quiet --disable-pip-version-check uv==0.13.9 ||
    fail "pip cannot install: mend what it says above (network, disk), then run this again"
  if ! "$venv/bin/uv" pip install --quiet --python "$venv/bin/python" "${@/#/--requirement=$environment/}"; then
    echo "uv could not install them: pip does, which takes about a minute"
    pip_install "$@"
  fi
}

pip_install() {
  local options=("${@/#/--requirement=$environment/}")
  if [[ ! -t 1 ]]; then options+=(--quiet); fi
  "$venv/bin/python" -m pip install --disable-pip-version-check "${options[@]}" ||
    fail "pip cannot install: mend what it says above (network, disk), then run this again"
}

fail() {
  echo "setup: $*" >&2
  exit 1
}

main "$@"
