"""The examples of docs/sites.md: who has no certificate gets nothing, what is denied does not come,
and what leaves a site is limited."""

import re
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from queue import SimpleQueue

import pytest
import zenoh

from configurations import only
from document import ROOT, blocks
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.zenoh.configuration import session_configuration
from ml2_receiver.zenoh.sink import ZenohSink
from ml2_receiver.zenoh.unreachable import why_unreachable
from ros_processes import Child
from tls_device import Certificate
from waiting import LIMIT_S, await_true
from zenoh_peers import free_endpoint

DOMAIN = 1
ROUTER, RECEIVER, SITE_ROUTER = blocks((ROOT / "docs/sites.md").read_text(), "json5")
TABLE = load_table()
IMU = TABLE.streams["gyro_left"].topics[0]
UNITED_IMU = TABLE.streams["imu_left"].topics[0]
POSE = TABLE.streams["head_pose"].topics[0]
IMAGE = TABLE.streams["world_left"].topics[0]


class Sites:
    """The router of the example, and certificates of its authority and of another one."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        ours, other = (Certificate(folder / it, it, is_authority=True) for it in ("ca", "other"))
        Certificate(folder / "router", "router", ours, is_server=True)
        for name, authority in (("site_a", ours), ("site_b", ours), ("stranger", other)):
            Certificate(folder / name, name, authority)
        self.endpoint = free_endpoint("tls")
        text = self._local(ROUTER).replace("tls/0.0.0.0:7447", self.endpoint)
        self.router = zenoh.open(zenoh.Config.from_json5(text))

    def file(self, name: str, authority: str = "ca") -> Path:
        """The example for a receiver, with another certificate and authority."""
        file = self._folder / f"{name}_{authority}.json5"
        text = RECEIVER.replace("site_a", name).replace("/ca.pem", f"/{authority}.pem")
        file.write_text(self._local(text))
        return file

    def site_router(self, endpoint: str) -> zenoh.Session:
        """The router of site A, which lets one message of each limited topic leave."""
        text = self._local(SITE_ROUTER).replace("tcp/0.0.0.0:7447", endpoint)
        text = text.replace("tls/HOST:7447", self.endpoint)
        return zenoh.open(zenoh.Config.from_json5(re.sub(r"freq: \d+", "freq: 0.001", text)))

    def tls(self, name: str, authority: str = "ca") -> dict[str, object]:
        folder = self._folder
        return {
            "root_ca_certificate": str(folder / authority / "chain.pem"),
            "connect_certificate": str(folder / name / "chain.pem"),
            "connect_private_key": str(folder / name / "key.pem"),
            "verify_name_on_connect": None,
        }

    def _local(self, text: str) -> str:
        names = {"pem": "chain.pem", "key": "key.pem"}
        return re.sub(
            r'"/etc/zenoh/(\w+)\.(pem|key)"',
            lambda found: f'"{self._folder / found[1] / names[found[2]]}"',
            text,
        )


@pytest.fixture(scope="module")
def sites(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Sites]:
    sites = Sites(tmp_path_factory.mktemp("sites"))
    with sites.router:
        yield sites


@pytest.fixture
def join(sites: Sites) -> Iterator[Callable[[str], zenoh.Session]]:
    with ExitStack() as stack:
        yield lambda name: stack.enter_context(
            zenoh.open(session_configuration(sites.endpoint, sites.file(name)))
        )


def subscribe(session: zenoh.Session, *keys: str) -> "SimpleQueue[str]":
    """The names of the topics of what comes."""
    found: SimpleQueue[str] = SimpleQueue()
    for key in keys:
        session.declare_subscriber(
            key, lambda sample: found.put(str(sample.key_expr).split("/", 2)[2].rsplit("/", 2)[0])
        )
    return found


def key(topic: Topic) -> str:
    return f"{DOMAIN}/{topic.full_name('magic_leap2')}/**"


def test_another_site_sees_poses_but_no_camera(join: Callable[[str], zenoh.Session]) -> None:
    own, other, curious = join("site_a"), join("site_b"), join("site_b")
    sink = ZenohSink(join("site_a"), TABLE, "/magic_leap2", "", DOMAIN, lambda: None)
    topics = (IMAGE, IMU, POSE)
    publishers = [sink.open(topic) for topic in topics]
    everything = subscribe(own, f"{DOMAIN}/**")
    allowed = [subscribe(other, key(topic)) for topic in (IMU, POSE)]
    denied = [subscribe(curious, key(IMAGE)), subscribe(curious, f"{DOMAIN}/**")]

    def publish_until_seen(found: "SimpleQueue[str]", name: str) -> None:
        def is_seen() -> bool:
            for publish in publishers:
                publish(bytearray(b"payload"))
            return not found.empty() and found.get() == name

        await_true(is_seen)

    for topic, found in zip((IMU, POSE), allowed, strict=True):
        publish_until_seen(found, topic.name)
    publish_until_seen(everything, IMAGE.name)
    # The camera came before what the other site got, so it would be here by now.
    assert [found.qsize() for found in denied] == [0, 0]
    sink.close()


def test_another_site_cannot_publish(join: Callable[[str], zenoh.Session]) -> None:
    own, other = join("site_a"), join("site_b")
    found = subscribe(own, f"{DOMAIN}/**")
    forged, true = (it.declare_publisher(f"{DOMAIN}/magic_leap2/x/y/z") for it in (other, own))
    await_true(lambda: true.matching_status.matching)  # type: ignore[attr-defined]
    for _ in range(20):
        forged.put(b"forged")
    subscriber = SimpleQueue[bytes]()
    own.declare_subscriber(
        f"{DOMAIN}/magic_leap2/x/**", lambda sample: subscriber.put(sample.payload.to_bytes())
    )
    true.put(b"true")
    assert found.get(timeout=LIMIT_S) == "x"
    assert subscriber.get(timeout=LIMIT_S) == b"true"
    assert found.empty()


def test_what_leaves_a_site_is_limited_topic_by_topic(
    sites: Sites, join: Callable[[str], zenoh.Session]
) -> None:
    endpoint = free_endpoint()
    config = session_configuration(endpoint, None)
    topics = (POSE, UNITED_IMU, IMU)
    with sites.site_router(endpoint), zenoh.open(config) as receiver, zenoh.open(config) as local:
        sink = ZenohSink(receiver, TABLE, "/magic_leap2", "", DOMAIN, lambda: None)
        publishers = [sink.open(topic) for topic in topics]
        left = subscribe(join("site_b"), key(POSE), key(UNITED_IMU), key(IMU))
        await_true(lambda: all(sink.demand().values()))
        at_site, rounds = subscribe(local, key(POSE)), 0

        def is_seen_at_site() -> bool:
            nonlocal rounds
            rounds += 1
            for publish in publishers:
                publish(bytearray(b"payload"))
            return at_site.qsize() >= 20

        await_true(is_seen_at_site)
        await_true(lambda: left.qsize() >= rounds + 2)
        found = Counter(left.get() for _ in range(left.qsize()))
        assert found == {IMU.name: rounds, POSE.name: 1, UNITED_IMU.name: 1}
        sink.close()


@pytest.mark.parametrize(
    ("name", "authority", "reason"),
    [
        ("stranger", "ca", "TLS fails: tlsv1 alert unknown ca"),
        ("site_a", "other", "its certificate is refused: "),
    ],
)
def test_a_refused_certificate_is_named(
    sites: Sites, name: str, authority: str, reason: str
) -> None:
    with pytest.raises(zenoh.ZError):
        zenoh.open(session_configuration(sites.endpoint, sites.file(name, authority)))
    assert why_unreachable(sites.endpoint, sites.tls(name, authority)).startswith(reason)


def test_the_command_says_in_one_line_that_its_certificate_is_refused(
    sites: Sites, tmp_path: Path
) -> None:
    config = tmp_path / "config.yaml"
    config.write_text(only("battery: {enabled: true}"))
    options = ("--insecure", "--listen", "127.0.0.1:0", "--config", str(config), "--no-ros")
    zenoh = ("--zenoh", sites.endpoint, "--zenoh-config", str(sites.file("stranger")))
    reason = f"Zenoh: {sites.endpoint} is not reached: TLS fails: tlsv1 alert unknown ca"
    with Child("-m", "ml2_receiver", "run", *options, *zenoh) as receiver:
        receiver.await_error(f"{reason}; trying again")
        assert receiver.end() == 0
    assert sum(it.startswith("Zenoh: ") for it in receiver.errors) == 1


def test_a_missing_certificate_is_named(sites: Sites) -> None:
    tls = sites.tls("nobody")
    expected = "a file of transport/link/tls cannot be used: No such file or directory"
    assert why_unreachable(sites.endpoint, tls) == expected
