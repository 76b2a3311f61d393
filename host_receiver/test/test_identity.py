import subprocess
from pathlib import Path

import pytest

from ml2_receiver.errors import KeysError
from ml2_receiver.security.contexts import session_context
from ml2_receiver.security.identity import Identity


def test_it_is_made_at_the_first_start_and_stays(tmp_path: Path) -> None:
    first = Identity.of(tmp_path / "keys")
    assert Identity.of(tmp_path / "keys") == first
    assert Identity.of(tmp_path / "others").fingerprint != first.fingerprint


def test_only_the_user_can_read_it(tmp_path: Path) -> None:
    identity = Identity.of(tmp_path / "keys")
    assert (tmp_path / "keys").stat().st_mode & 0o777 == 0o700
    assert identity.key_file.stat().st_mode & 0o777 == 0o600


def openssl(*arguments: str | Path) -> str:
    command = ["openssl", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def test_openssl_reads_it_as_protocol_md_has_it(tmp_path: Path) -> None:
    identity = Identity.of(tmp_path)
    shown = ("x509", "-noout", "-in", identity.certificate_file)
    _, _, fingerprint = openssl(*shown, "-fingerprint", "-sha256").strip().partition("=")
    assert identity.fingerprint == fingerprint.replace(":", "").lower()
    text = openssl(*shown, "-text")
    assert "NIST CURVE: P-256" in text
    assert "Signature Algorithm: ecdsa-with-SHA256" in text
    assert "Not Before: Jan  1 00:00:00 2000 GMT" in text
    assert "Not After : Dec 31 23:59:59 9999 GMT" in text
    public = openssl("pkey", "-in", identity.key_file, "-pubout")
    assert public == openssl(*shown, "-pubkey")


def test_a_key_that_others_can_read_is_refused(tmp_path: Path) -> None:
    key = Identity.of(tmp_path).key_file
    key.chmod(0o640)
    with pytest.raises(KeysError, match=f"others can read the key in {key}") as error:
        Identity.of(tmp_path)
    assert f"chmod 600 {key}" in error.value.hint


def test_a_folder_that_others_can_write_in_is_refused(tmp_path: Path) -> None:
    tmp_path.chmod(0o777)
    with pytest.raises(KeysError, match=f"others can write in {tmp_path}") as error:
        Identity.of(tmp_path)
    assert error.value.hint == f"Run `chmod go-w {tmp_path}`."


def test_a_key_of_another_certificate_is_named(tmp_path: Path) -> None:
    identity = Identity.of(tmp_path / "keys")
    for other in (Identity.of(tmp_path / "others").key_file.read_text(), "nonsense"):
        identity.key_file.write_text(other)
        with pytest.raises(KeysError, match=r"receiver.key is not the key of .*receiver.pem"):
            session_context(Identity.of(tmp_path / "keys"), [])


def test_what_is_no_certificate_is_named(tmp_path: Path) -> None:
    Identity.of(tmp_path).certificate_file.write_text("nonsense")
    with pytest.raises(KeysError, match=r"receiver.pem is not a certificate"):
        Identity.of(tmp_path)


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(KeysError, match=r"cannot use .*/file/keys: Not a directory"):
        Identity.of(tmp_path / "file" / "keys")
