#!/usr/bin/env bash
# Packages the Kotlin modules. Compiles only what changed, and what uses it.
#
# Kotlin's Maven plugin compiles incrementally, but does not see that classes of another module, or the main classes of
# a test, changed. So a cache is removed, and what it was for is compiled whole, when the interface of those changed.
set -euo pipefail
# shellcheck source=/dev/null
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../errors.sh"
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

library=ml2-sensors-aar
package=(package --threads 2 -DskipTests -pl "!$library/aar")
version=$(sed -n 's|.*<kotlin.version>\(.*\)</.*|\1|p' pom.xml)
compiler=~/.m2/repository/org/jetbrains

# The first build writes no caches, which would take longer: a clone is often built only once.
if [[ ! -d $library/target/test-classes || ! -d $compiler/kotlin/kotlin-build-tools-impl/$version ]]; then
  exec config/kotlin/maven.sh "$@" "${package[@]}"
fi
kotlin_jars=$(find "$compiler" -name "*-$version.jar" -o -name 'kotlinx-coroutines-core-jvm*.jar' -o -name 'annotations*.jar' |
  paste -sd :)
incremental=("$@" --quiet -Dkotlin.compiler.incremental=true -Dmaven.clean.skip)

# The rest of a line is a command for when the inputs before `--` differ from the last time.
if_changed() {
  config/if_changed.sh "build/kotlin/$1" "${@:2}" >/dev/null
}

# A whole compilation leaves the classes of removed sources.
remove_stale() {
  local target
  for target in "$library/target" "$library"/*/target; do
    [[ -d $target/kotlin-ic/compile ]] || rm -rf "$target/classes"
    [[ -d $target/kotlin-ic/test ]] || rm -rf "$target/test-classes"
  done
}

all=("$library/target/kotlin-ic" "$library"/*/target/kotlin-ic)
robolectric=("$library"/{android-test,app}/target/kotlin-ic/test)

mkdir -p build/kotlin
if_changed .poms pom.xml .mvn "$library"/pom.xml "$library"/*/pom.xml -- rm -rf "${all[@]}"
remove_stale
config/kotlin/maven.sh "${incremental[@]}" compile -pl $library
java -XX:TieredStopAtLevel=1 -cp "$kotlin_jars" config/kotlin/Abi.java $library/target/classes build/kotlin/library
if_changed .library build/kotlin/library -- rm -rf $library/target/kotlin-ic/test "${all[@]:1}"
if_changed .library-tests $library/src/test -- rm -rf "${robolectric[@]}"
if_changed .simulator $library/simulator/src/main -- rm -rf $library/simulator/target/kotlin-ic/test "${robolectric[@]}"
if_changed .app $library/app/src/main -- rm -rf $library/app/target/kotlin-ic/test
remove_stale
config/kotlin/maven.sh "${incremental[@]}" "${package[@]}"
