#!/usr/bin/env bash
# Compiles the Unity package with mono against stubs of Unity's types, and runs its tests on the native library.
set -euo pipefail
# shellcheck source=/dev/null
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../../config/errors.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

package=unity_package
stubs=$package/Tests/Stubs~
out=build/unity
json=/usr/lib/cli/Newtonsoft.Json-5.0/Newtonsoft.Json.dll
nunit=/usr/lib/cli/nunit.framework-2.6.3/nunit.framework.dll

main() {
  mkdir -p "$out"
  cp "$json" "$nunit" "$out"
  compile UnityEngine "$stubs/UnityEngine"
  compile Ml2Sensors.Runtime "$package/Runtime" UnityEngine.dll Newtonsoft.Json.dll
  compile UnityEditor "$stubs/UnityEditor" UnityEngine.dll
  compile Ml2Sensors.Editor "$package/Editor" UnityEngine.dll UnityEditor.dll Ml2Sensors.Runtime.dll System.Xml.dll System.Xml.Linq.dll
  compile UnityOpenXR "$stubs/UnityOpenXR" UnityEngine.dll
  compile Ml2Sensors.OpenXR "$package/OpenXR" UnityEngine.dll UnityOpenXR.dll Ml2Sensors.Runtime.dll
  compile RosTcpConnector "$stubs/RosTcpConnector"
  compile Ml2Sensors.RosTcp "$package/RosTcp" UnityEngine.dll RosTcpConnector.dll Ml2Sensors.Runtime.dll
  compile Ml2Sensors.Samples "$package/Samples~" UnityEngine.dll Ml2Sensors.Runtime.dll
  compile Project tests/unity_project/Assets UnityEngine.dll UnityEditor.dll
  compile Ml2Sensors.Tests "$package/Tests/Editor $package/Tests/Mono~" UnityEngine.dll UnityEditor.dll Newtonsoft.Json.dll \
    Ml2Sensors.Runtime.dll Ml2Sensors.Editor.dll Ml2Sensors.RosTcp.dll RosTcpConnector.dll Ml2Sensors.Samples.dll nunit.framework.dll System.Xml.dll System.Xml.Linq.dll
  run_tests "$@"
}

compile() { # name of the assembly, its folders, its references
  local folders sources documented=() references=("${@:3}")
  read -ra folders <<<"$2"
  mapfile -t sources < <(find "${folders[@]}" -name '*.cs' | sort)
  if [[ $1 =~ ^Ml2Sensors\.(Runtime|Editor|OpenXR|RosTcp)$ ]]; then
    documented=(-doc:"$out/$1.xml") # Makes a public name without a comment an error
  fi
  # 649: only Unity sets serialized fields. 1573: a comment may leave out parameters.
  mcs -nologo -langversion:7.2 -unsafe -warnaserror+ -warn:4 -nowarn:649,1573 "${documented[@]}" -define:ENABLE_UNITY_COLLECTIONS_CHECKS,UNITY_EDITOR \
    -debug -target:library -lib:"$out" "${references[@]/#/-reference:}" -out:"$out/$1.dll" "${sources[@]}"
}

run_tests() {
  # Bionic's library names on Linux, the simulated headset, and the library of the AAR
  local native=$PWD/build/native
  export LD_LIBRARY_PATH=$native/linux:$native/host/sim:$native/device
  export ML2_FRAME_CACHE=$native/frame_cache ML2_VECTORS=$PWD/tests/conformance/vectors
  export ML2_PUBLIC_API=$PWD/$package/Api~/Ml2Sensors.Runtime.api
  nunit-console -nologo -nodots -nothread -domain:None -work="$out" "$@" "$out/Ml2Sensors.Tests.dll"
}

main "$@"
