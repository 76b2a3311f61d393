from dataclasses import replace

from ml2_receiver.session.address_limits import AddressLimits
from ml2_receiver.session.settings import Limits

LIMITS = replace(Limits(), connections_per_address=2, failed_attempts=3, failed_attempts_per_s=0.5)


class Clock:
    now_s = 1000.0

    def __call__(self) -> float:
        return self.now_s


def test_one_address_has_so_many_connections_at_a_time() -> None:
    limits = AddressLimits(LIMITS, Clock())
    for _ in range(2):
        assert limits.refusal("10.0.0.1") is None
        limits.opened("10.0.0.1")
    assert limits.refusal("10.0.0.1") == "it has 2 connections"
    assert limits.refusal("10.0.0.2") is None
    limits.closed("10.0.0.1")
    assert limits.refusal("10.0.0.1") is None


def test_failures_are_free_at_first_and_then_keep_to_a_rate() -> None:
    clock = Clock()
    limits = AddressLimits(LIMITS, clock)
    for _ in range(3):
        assert limits.refusal("10.0.0.1") is None
        limits.failed("10.0.0.1")
    assert limits.refusal("10.0.0.1") == "too many failed attempts; it has to wait"
    assert limits.refusal("10.0.0.2") is None
    clock.now_s += 1.9
    assert limits.refusal("10.0.0.1") is not None
    clock.now_s += 0.1
    assert limits.refusal("10.0.0.1") is None
    limits.failed("10.0.0.1")
    assert limits.refusal("10.0.0.1") is not None
    clock.now_s += 1000
    assert limits.refusal("10.0.0.1") is None


def test_strangers_do_not_keep_out_who_shares_their_address_and_is_paired() -> None:
    clock = Clock()
    limits = AddressLimits(Limits(), clock)
    limits.showed("10.0.0.1")
    for _ in range(20 * 60):
        assert limits.refusal("10.0.0.1") is None
        limits.failed("10.0.0.1")
        clock.now_s += 1 / 20
    for _ in range(20):
        limits.failed("10.0.0.2")
    assert limits.refusal("10.0.0.2") is not None


def test_an_address_that_showed_a_certificate_has_a_limit_for_a_day() -> None:
    clock = Clock()
    limits = AddressLimits(Limits(), clock)
    limits.showed("10.0.0.1")
    for _ in range(100):
        assert limits.refusal("10.0.0.1") is None
        limits.failed("10.0.0.1")
    assert limits.refusal("10.0.0.1") is not None
    clock.now_s += 24 * 3600
    for _ in range(10):
        assert limits.refusal("10.0.0.1") is None
        limits.failed("10.0.0.1")
    assert limits.refusal("10.0.0.1") is not None


def test_all_addresses_of_one_ipv6_network_are_one() -> None:
    limits = AddressLimits(LIMITS, Clock())
    for number in range(3):
        limits.failed(f"2001:db8::{number}")
    assert limits.refusal("2001:db8::ffff:1") is not None
    assert limits.refusal("2001:db8:0:1::1") is None
    assert limits.refusal("fe80::1%lo") is None


def test_it_remembers_a_thousand_addresses_and_the_newest_of_them() -> None:
    limits = AddressLimits(LIMITS, Clock())
    for number in range(1025):
        for _ in range(3):
            limits.failed(f"10.1.{number >> 8}.{number & 255}")
    assert limits.refusal("10.1.0.0") is None
    assert limits.refusal("10.1.0.1") is not None
    assert limits.refusal("10.1.4.0") is not None
