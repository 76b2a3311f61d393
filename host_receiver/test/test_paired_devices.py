import json
import ssl
from pathlib import Path

import pytest

from command_line import refusal
from ml2_receiver.errors import PairingError
from ml2_receiver.security.paired_devices import PairedDevices
from ml2_receiver.transport.access import PairedOnly
from tls_device import Certificate


@pytest.fixture
def warnings() -> list[str]:
    return []


@pytest.fixture
def devices(tmp_path: Path, warnings: list[str]) -> PairedDevices:
    return PairedDevices(tmp_path / "keys", warnings.append)


@pytest.fixture
def certificate(tmp_path: Path) -> Certificate:
    return Certificate(tmp_path / "one", "one")


def test_who_was_added_is_there_for_every_process(
    devices: PairedDevices, certificate: Certificate, tmp_path: Path
) -> None:
    assert devices.load() == []
    added = devices.add("Zoë's ML2", "id", certificate.der)
    assert PairedDevices(tmp_path / "keys").load() == [added]
    assert devices.fingerprints() == {certificate.fingerprint}
    assert (added.name, added.device_id, added.certificate) == ("Zoë's ML2", "id", certificate.der)


def test_a_name_that_is_taken_gets_a_number(
    devices: PairedDevices, certificate: Certificate, tmp_path: Path
) -> None:
    others = [Certificate(tmp_path / str(it), "other").der for it in range(2)]
    names = [devices.add("ML2", "id", it).name for it in (certificate.der, *others)]
    assert names == ["ML2", "ML2 (2)", "ML2 (3)"]


def test_a_device_that_pairs_again_is_there_once(
    devices: PairedDevices, certificate: Certificate
) -> None:
    devices.add("ML2", "id", certificate.der)
    devices.add("ML2", "id", certificate.der)
    assert [it.name for it in devices.load()] == ["ML2"]


@pytest.mark.parametrize("is_by_name", [True, False])
def test_one_is_removed_by_name_or_fingerprint(
    devices: PairedDevices, certificate: Certificate, is_by_name: bool
) -> None:
    devices.add("ML2", "id", certificate.der)
    devices.remove("ML2" if is_by_name else certificate.fingerprint)
    assert devices.load() == []


def test_one_that_is_not_there_cannot_be_removed(
    devices: PairedDevices, certificate: Certificate
) -> None:
    with pytest.raises(PairingError, match="no paired device 'x'; paired: none"):
        devices.remove("x")
    devices.add("ML2", "id", certificate.der)
    with pytest.raises(PairingError, match="no paired device 'x'; paired: 'ML2'"):
        devices.remove("x")


@pytest.mark.parametrize(
    "change",
    [
        {"certificate": "d"},
        {"certificate": ssl.DER_cert_to_PEM_cert(b"0")},
        {"name": 5},
        {"other": "key"},
        "",
        "[]",
        "{}",
    ],
)
def test_a_damaged_file_is_named_and_keeps_only_its_device_out(
    devices: PairedDevices,
    warnings: list[str],
    certificate: Certificate,
    tmp_path: Path,
    change: str | dict[str, object],
) -> None:
    whole = devices.add("whole", "id", Certificate(tmp_path / "two", "two").der)
    devices.add("ML2", "id", certificate.der)
    file = tmp_path / "keys" / "devices" / f"{certificate.fingerprint}.json"
    text = change if isinstance(change, str) else json.dumps(json.loads(file.read_text()) | change)
    file.write_text(text)
    assert devices.load() == [whole]
    assert warnings[0].startswith(f"{file} is not a paired device: ")
    assert warnings[0].endswith("Remove it, and pair the headset again: `ml2-receiver pair`.")
    assert PairedOnly(tmp_path / "keys").allows(whole.fingerprint)


def test_keys_that_are_no_folder_are_an_error(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.touch()
    assert f"cannot use {file}/devices: Not a directory" in refusal(
        "devices", "--paired", "--keys", file
    )


def test_a_file_under_another_name_is_not_believed(
    devices: PairedDevices, warnings: list[str], certificate: Certificate, tmp_path: Path
) -> None:
    devices.add("ML2", "id", certificate.der)
    file = tmp_path / "keys" / "devices" / f"{certificate.fingerprint}.json"
    file.rename(file.with_name(f"{'0' * 64}.json"))
    assert devices.load() == []
    assert "has another certificate than its name says" in warnings[0]
