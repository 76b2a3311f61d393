from dataclasses import replace

from ml2_receiver.session.admission import Admission
from ml2_receiver.session.settings import Limits

LIMITS = replace(Limits(), connections_per_address=2, failed_attempts=3, failed_attempts_per_s=0.5)


class Clock:
    now_s = 1000.0

    def __call__(self) -> float:
        return self.now_s


def test_one_address_has_so_many_connections_at_a_time() -> None:
    admission = Admission(LIMITS, Clock())
    for _ in range(2):
        assert admission.refusal("10.0.0.1") is None
        admission.opened("10.0.0.1")
    assert admission.refusal("10.0.0.1") == "it has 2 connections"
    assert admission.refusal("10.0.0.2") is None
    admission.closed("10.0.0.1")
    assert admission.refusal("10.0.0.1") is None


def test_failures_are_free_at_first_and_then_keep_to_a_rate() -> None:
    clock = Clock()
    admission = Admission(LIMITS, clock)
    for _ in range(3):
        assert admission.refusal("10.0.0.1") is None
        admission.failed("10.0.0.1")
    assert admission.refusal("10.0.0.1") == "too many failed attempts; it has to wait"
    assert admission.refusal("10.0.0.2") is None
    clock.now_s += 1.9
    assert admission.refusal("10.0.0.1") is not None
    clock.now_s += 0.1
    assert admission.refusal("10.0.0.1") is None
    admission.failed("10.0.0.1")
    assert admission.refusal("10.0.0.1") is not None
    clock.now_s += 1000
    assert admission.refusal("10.0.0.1") is None


def test_strangers_do_not_keep_out_who_shares_their_address_and_is_paired() -> None:
    clock = Clock()
    admission = Admission(Limits(), clock)
    admission.showed("10.0.0.1")
    for _ in range(20 * 60):
        assert admission.refusal("10.0.0.1") is None
        admission.failed("10.0.0.1")
        clock.now_s += 1 / 20
    for _ in range(20):
        admission.failed("10.0.0.2")
    assert admission.refusal("10.0.0.2") is not None


def test_an_address_that_showed_a_certificate_has_a_limit_for_a_day() -> None:
    clock = Clock()
    admission = Admission(Limits(), clock)
    admission.showed("10.0.0.1")
    for _ in range(100):
        assert admission.refusal("10.0.0.1") is None
        admission.failed("10.0.0.1")
    assert admission.refusal("10.0.0.1") is not None
    clock.now_s += 24 * 3600
    for _ in range(10):
        assert admission.refusal("10.0.0.1") is None
        admission.failed("10.0.0.1")
    assert admission.refusal("10.0.0.1") is not None


def test_all_addresses_of_one_ipv6_network_are_one() -> None:
    admission = Admission(LIMITS, Clock())
    for number in range(3):
        admission.failed(f"2001:db8::{number}")
    assert admission.refusal("2001:db8::ffff:1") is not None
    assert admission.refusal("2001:db8:0:1::1") is None
    assert admission.refusal("fe80::1%lo") is None


def test_it_remembers_a_thousand_addresses_and_the_newest_of_them() -> None:
    admission = Admission(LIMITS, Clock())
    for number in range(1025):
        for _ in range(3):
            admission.failed(f"10.1.{number >> 8}.{number & 255}")
    assert admission.refusal("10.1.0.0") is None
    assert admission.refusal("10.1.0.1") is not None
    assert admission.refusal("10.1.4.0") is not None
