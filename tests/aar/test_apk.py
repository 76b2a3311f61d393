"""Contents of the app: manifest, signature, code, native library, and the size of each."""

import zipfile
from hashlib import sha256
from pathlib import Path

import pytest
import yaml

from apk import APK, entries, permissions
from test_dex import dex_classes, named_by_native_code
from toolchain import ROOT, Package, maven_property, run

NATIVE = "lib/x86_64/libml2sensors.so"
RESOURCES = "resources.arsc"
PAGE_BYTES = 4096
# Streaming while another app is in front, and once the headset has started.
OF_THE_SERVICE = {
    "android.permission.FOREGROUND_SERVICE",
    "android.permission.WAKE_LOCK",
    "android.permission.RECEIVE_BOOT_COMPLETED",
}


def test_aapt_reads_name_version_and_levels() -> None:
    badging = run("aapt", "dump", "badging", APK).splitlines()
    name, version = "dev.ml2sensors.app", maven_property("revision")
    assert badging[0].startswith(f"package: name='{name}' versionCode='1' versionName='{version}' ")
    assert {"sdkVersion:'29'", "targetSdkVersion:'29'", "native-code: 'x86_64'"} <= set(badging)
    assert "application-label:'ML2 Sensors'" in badging
    (launched,) = [line for line in badging if line.startswith("launchable-activity:")]
    assert launched.startswith(f"launchable-activity: name='{name}.MainActivity'")


def test_permissions_are_the_librarys_the_streams_and_the_services(library: Package) -> None:
    sections = yaml.safe_load((ROOT / "config" / "streams.yaml").read_text())["sections"].values()
    of_streams = {name for section in sections for name in section.get("permissions", [])}
    of_library = permissions(library.folder / "AndroidManifest.xml")
    assert permissions(APK) == of_streams | of_library | OF_THE_SERVICE


def test_what_others_can_reach_is_guarded() -> None:
    """aapt shows true as 0xffffffff."""
    tree = run("aapt", "dump", "xmltree", APK, "AndroidManifest.xml")
    service = tree.split("E: service")[1].split("E: receiver")[0]
    assert 'permission(0x01010006)="android.permission.DUMP"' in service
    assert "exported(0x01010010)=(type 0x12)0xffffffff" in service
    data_sync_or_connected_device = 0x1 | 0x10
    assert (
        f"foregroundServiceType(0x01010599)=(type 0x11){data_sync_or_connected_device:#x}"
        in service
    )


def test_its_signature_holds_on_android_10() -> None:
    verified = run("apksigner", "verify", "--verbose", "--min-sdk-version", "29", APK)
    assert "Verified using v3 scheme (APK Signature Scheme v3): true" in verified


def test_r8_kept_what_android_and_native_code_find_by_name(
    library: Package, tmp_path: Path
) -> None:
    with zipfile.ZipFile(APK) as archive:
        archive.extract("classes.dex", tmp_path)
    components = {"App", "MainActivity", "StreamingService", "BootReceiver"}
    kept = dex_classes(tmp_path)
    assert {f"dev/ml2sensors/app/{name}" for name in components} <= kept
    assert named_by_native_code(library) <= kept


def test_it_holds_these_files_and_no_others() -> None:
    files = {name for name in entries() if not name.startswith("res/")}
    assert files == {"AndroidManifest.xml", "classes.dex", RESOURCES, NATIVE}


def test_the_native_library_is_the_linked_one_and_can_be_mapped() -> None:
    entry = entries()[NATIVE]
    assert entry.is_stored
    assert entry.offset % PAGE_BYTES == 0
    linked = ROOT / "build" / "native" / "device" / "libml2sensors.so"
    with zipfile.ZipFile(APK) as archive:
        packed = archive.read(NATIVE)
    assert sha256(packed).digest() == sha256(linked.read_bytes()).digest()


def test_everything_stored_is_aligned() -> None:
    run("zipalign", "-c", "-p", "4", APK)
    assert entries()[RESOURCES].is_stored
    assert entries()[RESOURCES].offset % 4 == 0


@pytest.mark.parametrize(
    ("part", "budget_kb"), [("classes.dex", 540), (NATIVE, 155), (RESOURCES, 10), ("res/", 10)]
)
def test_no_part_is_larger_than_it_has_to_be(part: str, budget_kb: int) -> None:
    sizes = [it.packed_bytes for name, it in entries().items() if name.startswith(part)]
    assert 0 < sum(sizes) <= budget_kb * 1000
