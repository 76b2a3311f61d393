from pathlib import Path

import pytest

from ml2_receiver.errors import KeysError, PairingError
from ml2_receiver.security.paired_devices import PairedDevices
from tls_device import Certificate


@pytest.fixture
def devices(tmp_path: Path) -> PairedDevices:
    return PairedDevices(tmp_path / "keys")


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
    "text", ["", "[]", "{}", '{"name": "a", "device_id": "b", "paired": "c", "certificate": "d"}']
)
def test_a_damaged_file_is_named(
    devices: PairedDevices, certificate: Certificate, tmp_path: Path, text: str
) -> None:
    devices.add("ML2", "id", certificate.der)
    file = tmp_path / "keys" / "devices" / f"{certificate.fingerprint}.json"
    file.write_text(text)
    with pytest.raises(KeysError, match=f"{file} is not a paired device"):
        devices.load()


def test_a_file_under_another_name_is_not_believed(
    devices: PairedDevices, certificate: Certificate, tmp_path: Path
) -> None:
    devices.add("ML2", "id", certificate.der)
    file = tmp_path / "keys" / "devices" / f"{certificate.fingerprint}.json"
    file.rename(file.with_name(f"{'0' * 64}.json"))
    with pytest.raises(KeysError, match="has another certificate than its name says"):
        devices.load()
