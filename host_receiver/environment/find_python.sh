#!/usr/bin/env bash
# Prints the path of a Python 3.12 that can make environments and compile extensions: from PATH, /usr/bin or pyenv.
set -euo pipefail

fits='
import ensurepip, pathlib, sys, sysconfig
header = pathlib.Path(sysconfig.get_path("include"), "Python.h")
if sys.version_info[:2] == (3, 12) and header.is_file():
    print(sys._base_executable)
'
candidates=(python3.12 /usr/bin/python3.12)
IFS=: read -ra folders <<<"${PYENV_ROOT:-$HOME/.pyenv}/shims:$PATH"
for folder in "${folders[@]}"; do
  if [[ $folder == */shims ]]; then candidates+=("${folder%/shims}"/versions/3.12*/bin/python3.12); fi
done

for candidate in "${candidates[@]}"; do
  found=$("$candidate" -c "$fits" 2>/dev/null) || continue
  if [[ $found ]]; then
    echo "$found"
    exit
  fi
done
exit 1
