from ml2_receiver.session.event_limit import EventLimit, OncePerAddress


class Clock:
    now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


def test_days_of_events_are_bounded_and_counted() -> None:
    clock, said = Clock(), list[str]()
    limit = EventLimit(said.append, clock, per_second=2, per_hour=5)
    for _ in range(48 * 3600):
        limit.say("x" * 2000)
        clock.now_s += 1
    hours = 48
    assert len(said) <= hours * (5 + 1)
    assert sum(len(it) for it in said) <= hours * 6 * 1000
    counted = sum(int(it.split()[0]) for it in said if it.endswith("more such events"))
    whole = sum(it.startswith("xx") for it in said)
    last_hour = 3600 - 4
    assert whole + counted == 48 * 3600 - last_hour
    assert said[5] == "too many events: more are only counted until the hour is over"


def test_a_text_is_said_once_for_each_address_and_the_others_are_counted() -> None:
    said = list[str]()
    once = OncePerAddress(said.append)
    for _ in range(3):
        once.say("10.0.0.1", "busy")
        once.say("10.0.0.2", "busy")
    assert said == ["10.0.0.1: busy", "10.0.0.2: busy"]
    once.renew()
    assert said[2:] == ["10.0.0.1: busy, 2 more times", "10.0.0.2: busy, 2 more times"]
    once.say("10.0.0.1", "busy")
    assert said[4:] == ["10.0.0.1: busy"]


def test_a_thousand_addresses_are_remembered_and_no_more() -> None:
    said = list[str]()
    once = OncePerAddress(said.append)
    once.say("first", "busy")
    once.say("first", "busy")
    for number in range(1024):
        once.say(f"{number}", "busy")
    assert said.count("first: busy, 1 more times") == 1
