"""The page of `ml2-receiver view`, and who may open it."""

import json
import re

import pytest

from ml2_tools.viewing.access import Token, is_own_host, is_own_origin
from ml2_tools.viewing.page_files import HEADERS, page_files

THREE = "/three.min.js"


@pytest.mark.parametrize("host", ["127.0.0.1:8700", "localhost:1", "localhost", "[::1]:8700"])
def test_hosts_of_this_machine(host: str) -> None:
    assert is_own_host([host])
    assert is_own_origin([f"http://{host}"], [host])


@pytest.mark.parametrize(
    "hosts",
    [[], ["evil.example"], ["localhost.evil.example"], ["127.0.0.1", "evil.example"], ["0:80"]],
)
def test_other_hosts_are_refused(hosts: list[str]) -> None:
    assert not is_own_host(hosts)
    assert not is_own_origin([f"http://{it}" for it in hosts], hosts)


@pytest.mark.parametrize("origin", ["http://localhost:2", "https://localhost:1", "null"])
def test_other_origins_are_refused(origin: str) -> None:
    assert not is_own_origin([origin], ["localhost:1"])


def test_only_the_token_opens() -> None:
    token = Token()
    assert token.opens(json.dumps({"token": token.text}))
    assert token.text != Token().text
    for wrong in ("", "[", "[" * 4000, "1", '"token"', '{"token": 1}', '{"token": "\\ud800"}'):
        assert not token.opens(wrong)
    assert not token.opens(json.dumps({"token": token.text[:-1]}))
    assert not token.opens(b"\xff")


def test_the_page_refers_to_its_own_files_only() -> None:
    files = {path: content.decode() for path, (_, content) in page_files().items()}
    assert {"/", "/main.js", "/style.css"} <= files.keys()
    # The name of a namespace is no address that is opened.
    bundle = files[THREE].replace("http://www.w3.org/1999/xhtml", "")
    own = {path: text for path, text in files.items() if path != THREE}
    for path, text in own.items():
        found = re.findall(r"""(?:src|href|from|import)\s*[=(]?\s*["']([^"']+)["']""", text)
        assert {f"/{it.removeprefix('./')}" for it in found} <= files.keys(), path
    for path, text in (own | {THREE: bundle}).items():
        assert not re.search(r"url\(|@import|\bhttps?:", text), path
    addresses = [it for text in own.values() for it in re.findall(r"\w+://[^/`\"']*", text)]
    assert addresses == ["ws://${location.host}"]


def test_the_licence_of_three_is_beside_it() -> None:
    _, licence = page_files()["/three.LICENSE.txt"]
    assert licence.startswith(b"The MIT License\n\nCopyright")
    assert b"SPDX-License-Identifier: MIT" in page_files()[THREE][1]


def test_the_page_has_no_code_or_style_in_its_html() -> None:
    _, html = page_files()["/"]
    assert not re.search(rb"<style|style=|\son\w+=|<script(?![^>]*\ssrc=)", html)


def test_the_policy_allows_the_own_server_only() -> None:
    policy = dict(it.split(maxsplit=1) for it in HEADERS["Content-Security-Policy"].split("; "))
    assert policy.pop("default-src") == "'none'"
    assert set(policy.values()) <= {"'self'", "'none'"}
