package dev.ml2sensors.ros

import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.cdr.Cdr
import dev.ml2sensors.message.Point
import dev.ml2sensors.message.Pose
import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.ServiceType
import dev.ml2sensors.message.SetBool
import dev.ml2sensors.message.StringMessage
import dev.ml2sensors.message.Trigger
import dev.ml2sensors.session.AppOpenings
import dev.ml2sensors.session.HostFrame
import dev.ml2sensors.session.HostSession
import dev.ml2sensors.session.SessionFixture
import dev.ml2sensors.test
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Deferred
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.SupervisorJob
import kotlinx.coroutines.async
import kotlinx.coroutines.awaitCancellation
import kotlinx.coroutines.cancel
import kotlinx.coroutines.cancelAndJoin
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.MutableStateFlow
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.flow.onEach
import kotlinx.coroutines.flow.take
import kotlinx.coroutines.flow.toList
import kotlinx.coroutines.launch
import kotlinx.coroutines.runBlocking
import kotlinx.coroutines.test.StandardTestDispatcher
import kotlinx.coroutines.test.TestCoroutineScheduler
import kotlinx.coroutines.withTimeout
import kotlinx.serialization.KSerializer
import kotlinx.serialization.Serializable
import kotlinx.serialization.descriptors.buildClassSerialDescriptor
import kotlinx.serialization.descriptors.element
import kotlinx.serialization.encoding.Decoder
import kotlinx.serialization.encoding.Encoder
import kotlinx.serialization.json.Json
import kotlinx.serialization.json.JsonObject
import kotlinx.serialization.json.int
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import kotlinx.serialization.json.long
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import org.junit.jupiter.params.ParameterizedTest
import org.junit.jupiter.params.provider.CsvSource
import java.io.IOException
import java.nio.ByteBuffer
import java.nio.ByteOrder
import java.util.concurrent.CountDownLatch
import kotlin.random.Random
import kotlin.test.assertContains
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertIs
import kotlin.test.assertTrue
import kotlin.time.Duration
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.Duration.Companion.seconds

class SubscriptionsTest {
    private val fixture = SessionFixture()
    private val subscriptions = Subscriptions()
    private val chatter = chatter()
    private lateinit var running: Deferred<Throwable?>

    @AfterEach
    fun close() = fixture.close()

    @Test
    fun aMessageComesWithItsTimeAndNumber() = runBlocking<Unit> {
        chatter.test {
            val session = session()
            val open = session.await(HostFrame.OPEN).json
            val expected = """{"id": 1, "kind": "subscription", "name": "/chatter", "type": "std_msgs/msg/String",
                "layout": "s", "keep": "latest", "received": 0}"""
            assertEquals(Json.parseToJsonElement(expected), open)
            session.opens(1)
            session.message(1, -1, text("hello") + byteArrayOf(7, 7), publishedNanos = 1_700_000_000_000_000_001)
            assertEquals(Received(StringMessage("hello"), 1_700_000_000_000_000_001, 4_294_967_295), awaitItem())
            session.message(1, 0, text("after the largest number"))
            assertEquals(Received(StringMessage("after the largest number"), null, 0), awaitItem())
        }
    }

    @Test
    fun aTypeWithoutAClassComesAsItsBytes() = runBlocking<Unit> {
        subscriptions.subscribe("/chatter", "std_msgs/msg/String", Keep.All(3), maxHz = 12.5, HASH).test {
            val session = session()
            val open = session.await(HostFrame.OPEN).json
            val expected = """{"id": 1, "kind": "subscription", "name": "/chatter", "type": "std_msgs/msg/String",
                "hash": "$HASH", "keep": "all", "depth": 3, "max_hz": 12.5, "received": 0}"""
            assertEquals(Json.parseToJsonElement(expected), open)
            session.opens(1)
            session.message(1, 0, text("hello"))
            assertContentEquals(text("hello"), awaitItem().message.array())
        }
    }

    @Test
    fun theLaneOfOpeningsIsJoinedOnceAndOnlyWhenItIsNeeded() = runBlocking<Unit> {
        val session = session()
        session.await(HostFrame.STATUS) // Comes a second after the first lanes are joined
        assertEquals(0, session.joined("ros"))
        chatter.test {
            session.opens(1)
            chatter.test { session.opens(2) }
            assertEquals(1, session.joined("ros"))
        }
    }

    @ParameterizedTest
    @CsvSource(
        "rules, NOT_ALLOWED",
        "name, WRONG_NAME",
        "type, UNKNOWN_TYPE",
        "layout, OTHER_LAYOUT",
        "busy, TOO_MANY",
        "later, OTHER",
        ", OTHER",
    )
    fun aRefusalHasItsReasonAndTheWordsOfTheReceiver(code: String?, reason: SubscriptionException.Reason) =
        runBlocking<Unit> {
            chatter.test {
                val session = session()
                session.await(HostFrame.OPEN)
                val coded = code?.let { """, "code": "$it"""" }.orEmpty()
                session.write(HostFrame.OPENED, """{"id": 1, "result": "refused", "reason": "no, \u0007 no"$coded}""")
                val error = assertIs<SubscriptionException>(awaitError())
                assertEquals(reason to "/chatter: no, \\u0007 no", error.reason to error.message)
                assertEquals(emptyMap(), subscriptions.counts())
            }
        }

    @Test
    fun aWithdrawalComesAfterTheMessagesBeforeIt() = runBlocking<Unit> {
        val gate = CompletableDeferred<Unit>()
        chatter(Keep.All()).onEach { gate.await() }.test {
            val session = session()
            session.opens(1)
            for (number in 0..2) session.message(1, number, text("$number"))
            awaitReceived(session, 3)
            session.write(HostFrame.CLOSED, """{"id": 1, "reason": "the rules have changed", "code": "rules"}""")
            session.write(HostFrame.PING)
            session.await(HostFrame.PONG)
            gate.complete(Unit)
            assertEquals(listOf("0", "1", "2"), List(3) { awaitItem().message.data })
            val error = assertIs<SubscriptionException>(awaitError())
            assertEquals(SubscriptionException.Reason.NOT_ALLOWED, error.reason)
            assertEquals(emptyList(), session.frames(HostFrame.CLOSE))
        }
    }

    @Test
    fun aReceiverWithoutOpeningsEndsPresentAndLaterFlows() = runBlocking<Unit> {
        chatter.test {
            fixture.run(app = subscriptions)
            fixture.started()
            val error = assertIs<SubscriptionException>(awaitError())
            assertEquals(SubscriptionException.Reason.NOT_SERVED, error.reason)
            assertContains(error.message.orEmpty(), "`ml2-receiver run` does")
        }
        chatter.test {
            assertEquals(SubscriptionException.Reason.NOT_SERVED, assertIs<SubscriptionException>(awaitError()).reason)
        }
    }

    @Test
    fun aFlowGoesOnInTheNextSessionWhereItsNumbersWere() = runBlocking<Unit> {
        chatter.test {
            val first = session()
            first.opens(1)
            first.message(1, 41, text("latched"))
            assertEquals(41, awaitItem().number)
            lose(first)
            assertEquals(emptyMap(), subscriptions.counts(), "the next STATUS may come before the next OPEN")
            val second = session()
            assertEquals(42, second.await(HostFrame.OPEN).json.getValue("received").jsonPrimitive.long)
            second.opens(1)
            second.message(1, 42, text("latched"))
            assertEquals(Received(StringMessage("latched"), null, 42), awaitItem())
            second.message(1, 42, text("twice"))
            assertEquals("malformed", second.await(HostFrame.ERROR).json.getValue("code").jsonPrimitive.content)
            expectNoEvents()
        }
    }

    @Test
    fun nothingComesTwiceOver200CutsAndTheBooksBalance() = runBlocking<Unit> {
        val random = Random(1)
        var sent = 0
        val numbers = ArrayList<Long>()
        val last = MutableStateFlow(-1L)
        val collecting = launch(Dispatchers.Default) {
            chatter(Keep.All(4)).collect {
                numbers += it.number
                last.value = it.number
            }
        }
        repeat(200) {
            val session = session()
            val expected = session.await(HostFrame.OPEN).json.getValue("received").jsonPrimitive.int
            assertTrue(expected <= sent, "$expected of $sent")
            session.opens(1)
            repeat(random.nextInt(8)) {
                session.message(1, sent, if (sent % 7 == 0) UNDECODABLE else text("$sent"))
                sent++
            }
            lose(session)
        }
        val session = session()
        session.opens(1)
        session.message(1, sent++, UNDECODABLE) // those before may all have been cut off
        session.message(1, sent, text("last"))
        withTimeout(TEST_LIMIT) { last.first { it == sent.toLong() } }
        val counts = subscriptions.counts().getValue("1")
        assertEquals(numbers.distinct().sorted(), numbers)
        assertEquals(emptyList(), numbers.filter { it % 7 == 0L } - sent.toLong())
        assertEquals(numbers.size.toLong(), counts.taken)
        assertEquals(counts.received, counts.run { taken + superseded + queueFull + undecodable })
        assertTrue(counts.undecodable > 0)
        collecting.cancelAndJoin()
    }

    @Test
    fun aSlowCollectorHasTheNewestMessage() = runBlocking<Unit> {
        val session = session()
        val counts = readSlowly(session, Keep.Latest) { assertEquals(listOf("0", "9"), it) }
        val expected = mapOf("received" to 10, "taken" to 2, "superseded" to 8, "queue_full" to 0, "undecodable" to 0)
        assertEquals(expected, counts)
    }

    @Test
    fun aSlowCollectorHasTheNewestMessagesOfADepth() = runBlocking<Unit> {
        val session = session()
        val counts = readSlowly(session, Keep.All(3)) { assertEquals(listOf("0", "7", "8", "9"), it) }
        val expected = mapOf("received" to 10, "taken" to 4, "superseded" to 0, "queue_full" to 6, "undecodable" to 0)
        assertEquals(expected, counts)
    }

    /** Sends ten messages while the collector holds the first; returns the counters of the next STATUS. */
    private suspend fun readSlowly(session: HostSession, keep: Keep, check: (List<String>) -> Unit): Map<String, Int> {
        val (isHeld, gate) = List(2) { CompletableDeferred<Unit>() }
        var counts = emptyMap<String, Int>()
        chatter(keep).onEach { if (isHeld.complete(Unit)) gate.await() }.test {
            session.opens(1)
            session.message(1, 0, text("0"))
            isHeld.await()
            for (number in 1..9) session.message(1, number, text("$number"))
            awaitReceived(session, 10)
            gate.complete(Unit)
            val texts = mutableListOf(awaitItem().message.data)
            while (texts.last() != "9") texts += awaitItem().message.data
            check(texts)
            val seen = session.frames(HostFrame.STATUS).size
            counts = session.await(HostFrame.STATUS, seen + 1).json.getValue("openings").jsonObject.getValue("1")
                .jsonObject.mapValues { it.value.jsonPrimitive.int }
        }
        return counts
    }

    @Test
    fun whatLeavesTheQueueOfALargeTopicIsTakenAlsoAfterItsEnd() = runBlocking<Unit> {
        val session = session()
        val isHeld = CompletableDeferred<Unit>()
        val collecting = launch(Dispatchers.Default) {
            chatter.collect {
                isHeld.complete(Unit)
                awaitCancellation()
            }
        }
        session.opens(1, "bulk_3")
        session.message(1, 0, text("x".repeat(1 shl 20)), lane = "bulk_3")
        session.awaitTaken(1, 0)
        isHeld.await()
        for (number in 1..2) session.message(1, number, text("$number"), lane = "bulk_3")
        session.awaitTaken(1, 1) // The newest alone is kept
        withTimeout(TEST_LIMIT) { collecting.cancelAndJoin() }
        session.awaitTaken(1, 2)
        session.await(HostFrame.CLOSE)
        session.message(1, 3, text("late"), lane = "bulk_3")
        session.awaitTaken(1, 3)
        session.write(HostFrame.CLOSED, """{"id": 1, "reason": "the app closed it"}""")
        session.message(1, 4, text("later"), lane = "bulk_3")
        session.awaitTaken(1, 4)
        assertEquals(5, session.frames(HostFrame.TAKEN).size)
    }

    @Test
    fun aCancelledCollectorClosesItsOpening() = runBlocking<Unit> {
        val session = session()
        val collecting = launch(Dispatchers.Default) { chatter.collect { awaitCancellation() } }
        session.opens(1)
        session.message(1, 0, text("0"))
        withTimeout(TEST_LIMIT) { collecting.cancelAndJoin() }
        assertEquals("""{"id":1}""", session.await(HostFrame.CLOSE).body.decodeToString())
        session.message(1, 1, text("late"))
        session.write(HostFrame.CLOSED, """{"id": 1, "reason": "the app closed it"}""")
        chatter.test {
            session.opens(2)
            session.message(2, 2, text("2"))
            assertEquals("2", awaitItem().message.data)
        }
    }

    @Test
    fun theCollectorOfOneTopicTooManyIsRefusedAlone() = runBlocking<Unit> {
        val session = session()
        val collecting = List(64) { index ->
            async(Dispatchers.Default) { chatter.take(1).toList().single().message.data }
                .also { session.opens(index + 1) }
        }
        chatter.test {
            session.await(HostFrame.OPEN, 64)
            session.write(
                HostFrame.OPENED,
                """{"id": 65, "result": "refused", "reason": "64 names are open", "code": "busy"}""",
            )
            assertEquals(SubscriptionException.Reason.TOO_MANY, assertIs<SubscriptionException>(awaitError()).reason)
        }
        for (id in 1..64) session.message(id, 0, text("$id"))
        withTimeout(TEST_LIMIT) { assertEquals((1..64).map { "$it" }, collecting.map { it.await() }) }
    }

    @Test
    fun anUndecodableMessageIsCountedAndTheNextOneComes() = runBlocking<Unit> {
        chatter(Keep.All()).test {
            val session = session()
            session.opens(1)
            session.message(1, 0, UNDECODABLE)
            session.message(1, 1, text("whole"))
            assertEquals("whole", awaitItem().message.data)
            val counts = subscriptions.counts().getValue("1")
            assertEquals(listOf(2L, 1L, 0L, 1L), counts.run { listOf(received, taken, superseded, undecodable) })
        }
    }

    @Test
    fun openedIsTakenWhileAConfigurationIsCarriedOut() = runBlocking<Unit> {
        fixture.streams.configuring = CompletableDeferred()
        chatter.test {
            val session = session()
            session.write(HostFrame.CONFIGURE, """{"request": 1, "streams": {"color": {}}}""")
            fixture.await("configure [color]")
            session.opens(1)
            session.message(1, 0, text("meanwhile"))
            assertEquals("meanwhile", awaitItem().message.data)
            chatter.test {
                session.await(HostFrame.OPEN, 1)
                session.write(HostFrame.OPENED, """{"id": 2, "result": "refused", "reason": "no"}""")
                assertIs<SubscriptionException>(awaitError())
            }
            assertEquals(emptyList(), session.frames(HostFrame.CONFIGURED))
        }
    }

    @Test
    fun flowsEndWithTheStreamerAndDoNotBeginAfterwards() = runBlocking<Unit> {
        chatter.test {
            subscriptions.end()
            awaitComplete()
        }
        chatter.test { awaitComplete() }
    }

    @Test
    fun aClassThatIsNoRosTypeIsRefusedAtOnce() {
        assertFailsWith<IllegalArgumentException> { subscriptions.subscribe("/a", Unnamed.serializer(), Keep.Latest) }
        for (type in listOf("std_msgs/String", "std_msgs/srv/Empty", "a/msg/${"A".repeat(250)}")) {
            assertFailsWith<IllegalArgumentException>(type) { subscriptions.subscribe("/a", type, Keep.Latest) }
        }
        for (topic in listOf("", "a".repeat(256), "/\u0007")) {
            assertFailsWith<IllegalArgumentException> { subscriptions.subscribe(topic, "a/msg/B", Keep.Latest) }
        }
        for (rate in listOf(0.0, -1.0, Double.NaN, Double.POSITIVE_INFINITY)) {
            assertFailsWith<IllegalArgumentException>("$rate") { chatter(maxHz = rate) }
        }
        for (hash in listOf("", "RIHS01_", HASH.uppercase(), HASH + "0")) {
            assertFailsWith<IllegalArgumentException>(hash) { chatter(hash = hash) }
        }
        for (depth in listOf(0, 101)) assertFailsWith<IllegalArgumentException> { Keep.All(depth) }
    }

    @Test
    fun aLayoutGoesWithItsTypeAsFarAsItFitsIntoAnOpenAndElseItsHashAlone() = runBlocking<Unit> {
        val longTopic = "/" + "\uD83D\uDE00".repeat(254) // Four bytes each
        val many = Fields(3800)
        val reason = assertFailsWith<IllegalArgumentException> {
            subscriptions.subscribe(longTopic, many, Keep.Latest)
        }.message.orEmpty()
        assertTrue("4096 bytes" in reason && "hash" in reason, reason)
        val session = session()
        val flows = listOf(
            subscriptions.subscribe("/many", many, Keep.Latest) to setOf("layout"),
            subscriptions.subscribe(longTopic, many, Keep.Latest, hash = HASH) to setOf("hash"),
            chatter(hash = HASH) to setOf("layout", "hash"),
        )
        flows.forEachIndexed { index, (flow, compared) ->
            flow.test {
                val open = session.await(HostFrame.OPEN, index).json
                assertEquals(compared, open.keys intersect setOf("layout", "hash"))
                session.opens(index + 1)
            }
        }
    }

    @Test
    fun aTransformComesWithBothOfItsTimesAgainAfterAnOutageAndIsInNoBook() = runBlocking<Unit> {
        subscriptions.transform("base_link", "world", maxHz = 30.0).test {
            val session = session()
            val open = session.await(HostFrame.OPEN).json
            val expected =
                """{"id": 1, "kind": "transform", "max_hz": 30.0, "frame": "base_link", "reference": "world"}"""
            assertEquals(Json.parseToJsonElement(expected), open)
            session.opens(1)
            session.pose(1, stampNanos = 0, newestNanos = 0)
            assertEquals(StampedPose(POSE, null, null), awaitItem())
            session.pose(1, stampNanos = 1_700_000_000_000_000_001, newestNanos = 1_700_000_000_000_000_000)
            assertEquals(StampedPose(POSE, 1_700_000_000_000_000_001, 1_700_000_000_000_000_000), awaitItem())
            assertEquals(emptyMap(), subscriptions.counts())
            lose(session)
            val next = session()
            next.opens(1)
            next.pose(1, stampNanos = 2, newestNanos = 1)
            assertEquals(StampedPose(POSE, 2, 1), awaitItem())
            next.write(HostFrame.CLOSED, """{"id": 1, "reason": "the rules have changed", "code": "rules"}""")
            val error = assertIs<SubscriptionException>(awaitError())
            assertEquals("base_link in world: the rules have changed", error.message)
        }
    }

    @Test
    fun framesWithoutANameAndRatesOfNothingAreRefused() {
        for ((frame, reference, maxHz) in listOf(Triple("", "b", 1.0), Triple("a", "", 1.0), Triple("a", "b", 0.0))) {
            assertFailsWith<IllegalArgumentException> { subscriptions.transform(frame, reference, maxHz) }
        }
    }

    private fun HostSession.pose(id: Int, stampNanos: Long, newestNanos: Long) {
        val body = ByteBuffer.allocate(64).order(ByteOrder.LITTLE_ENDIAN)
        val (at, turn) = POSE
        for (number in listOf(at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w)) body.putDouble(number)
        send(HostFrame.POSE, id, 0, body.putLong(newestNanos).array(), stampNanos)
    }

    private fun chatter(
        keep: Keep = Keep.Latest,
        maxHz: Double? = null,
        hash: String? = null,
    ): Flow<Received<StringMessage>> =
        subscriptions.subscribe("/chatter", StringMessage.serializer(), keep, maxHz, hash)

    /** Cuts the connections of a session, and waits until the device has noticed. */
    private fun lose(session: HostSession) {
        session.cut()
        assertIs<IOException>(fixture.outcome(running))
    }

    private fun session(): HostSession {
        running = fixture.run(app = subscriptions)
        return fixture.host.awaitHello().apply { welcome(ros = true) }
    }

    /** Answers the OPEN of [id], which is the one of that number in this session. */
    private fun HostSession.opens(id: Int, lane: String = "ros") {
        assertEquals(id, await(HostFrame.OPEN, id - 1).json.getValue("id").jsonPrimitive.int)
        write(HostFrame.OPENED, """{"id": $id, "result": "opened", "lane": "$lane", "latched": false}""")
    }

    private fun HostSession.joined(lane: String) = frames(HostFrame.JOIN).count { it.lane == lane }

    /** Waits until [count] messages of the opening 1 have arrived. */
    private fun awaitReceived(session: HostSession, count: Int) {
        var status = 0
        do {
            val openings = session.await(HostFrame.STATUS, status++).json["openings"]?.jsonObject
            val received = openings?.get("1")?.jsonObject?.getValue("received")?.jsonPrimitive?.int ?: 0
        } while (received < count)
    }

    private fun text(text: String) = Cdr.encodeToByteArray(StringMessage.serializer(), StringMessage(text))

    @Serializable
    private class Unnamed(val data: String)

    /** A message of so many numbers. */
    private class Fields(count: Int) : KSerializer<Nothing> {
        override val descriptor = buildClassSerialDescriptor("a/msg/Fields") {
            repeat(count) { element<Byte>("field$it") }
        }

        override fun serialize(encoder: Encoder, value: Nothing) = value

        override fun deserialize(decoder: Decoder) = error("nothing comes")
    }

    private companion object {
        val POSE = Pose(Point(1.0, -2.0, 3.0), Quaternion(0.5, -0.5, 0.5, 0.5))
        val HASH = "RIHS01_" + "0af9".repeat(16)

        /** Claims more text than there is. */
        val UNDECODABLE = byteArrayOf(0, 1, 0, 0, 9, 0, 0, 0, 'x'.code.toByte(), 0)
    }
}

/** Sessions of an app that has services, with a scripted receiver. */
abstract class ServiceSessions {
    internal abstract val app: AppOpenings
    internal val fixture = SessionFixture()
    internal val scope = CoroutineScope(SupervisorJob() + Dispatchers.Default)
    internal lateinit var running: Deferred<Throwable?>

    @AfterEach
    fun close() {
        scope.cancel()
        fixture.close()
    }

    internal fun calling(block: suspend () -> Unit) = runBlocking<Unit> { block() }

    internal fun session(): HostSession {
        running = fixture.run(app = app)
        return fixture.host.awaitHello().apply { welcome(ros = true) }
    }

    /** Cuts the connections of a session, and waits until the device has noticed. */
    internal fun lose(session: HostSession) {
        session.cut()
        assertIs<IOException>(fixture.outcome(running))
    }

    /** Answers the OPEN of [id], which is the one of that number in this session. */
    internal fun HostSession.opens(id: Int) {
        assertEquals(id, await(HostFrame.OPEN, id - 1).json.getValue("id").jsonPrimitive.int)
        write(HostFrame.OPENED, """{"id": $id, "result": "opened", "lane": "ros", "name": "/full/name"}""")
    }

    /** Waits for a STATUS that has these counts of the only client or service. */
    internal fun HostSession.awaitCalls(expected: String) {
        val counts = Json.parseToJsonElement("""{"1": $expected}""")
        var status = 0
        while (await(HostFrame.STATUS, status).json["calls"] != counts) status++
    }
}

class ServiceClientsTest : ServiceSessions() {
    private val clients = ServiceClients()
    override val app: AppOpenings get() = clients
    private val pause = clients.client("/pause", SetBool)

    @Test
    fun aRequestHasItsResponse() = calling {
        val call = call(true, 90.seconds)
        val session = session()
        val expected = """{"id": 1, "kind": "client", "name": "/pause", "type": "std_srvs/srv/SetBool",
            "layout": "b>bs"}"""
        assertEquals(Json.parseToJsonElement(expected), session.await(HostFrame.OPEN).json)
        session.opens(1)
        val request = session.await(HostFrame.REQUEST)
        assertEquals("ros" to 1, request.lane to request.channel)
        assertContentEquals(byteArrayOf(0, 1, 0, 0, 1), request.body)
        assertTrue(request.captureNanos in 1..90.seconds.inWholeNanoseconds, "${request.captureNanos}")
        session.answer(request, "paused")
        assertEquals(SetBool.Response(true, "paused"), call.await())
        val second = call(false)
        session.answer(session.await(HostFrame.REQUEST, 1), "goes on")
        assertEquals("goes on", second.await().message)
        assertEquals(1, session.frames(HostFrame.OPEN).size)
    }

    @Test
    fun statusCountsCallsByTheirOutcomeOverSessions() = calling {
        val first = session()
        val calls = listOf(call(true), call(true)).also { first.opens(1) }
        val requests = List(2) { first.await(HostFrame.REQUEST, it) }
        first.answer(requests[0], "")
        first.answer(requests[1], HostFrame.FAILURE, """{"code": "unheard_of", "message": ""}""".toByteArray())
        calls.forEach { runCatching { it.await() } }
        call(true).apply { first.await(HostFrame.REQUEST, 2) }.cancelAndJoin()
        val lost = call(true)
        first.awaitCalls("""{"requests": 4, "responses": 1, "failures": {"cancelled": 1, "other": 1}}""")
        first.await(HostFrame.REQUEST, 3)
        lose(first)
        runCatching { lost.await() }
        call(true)
        session().apply { opens(1) }.awaitCalls(
            """{"requests": 5, "responses": 1, "failures": {"cancelled": 1, "link_down": 1, "other": 1}}""",
        )
    }

    @ParameterizedTest
    @CsvSource(
        "unavailable, UNAVAILABLE",
        "timeout, TIMEOUT",
        "refused, REFUSED",
        "malformed, MALFORMED",
        "too_large, TOO_LARGE",
        "busy, BUSY",
        "later, OTHER",
    )
    fun aFailureHasItsReasonAndTheWordsOfTheReceiver(code: String, reason: ServiceException.Reason) = calling {
        val call = call(true)
        val session = session().apply { opens(1) }
        val request = session.await(HostFrame.REQUEST)
        session.answer(request, HostFrame.FAILURE, """{"code": "$code", "message": "no, \u0007 no"}""".toByteArray())
        assertFails(call, reason, "/pause: no, \\u0007 no")
    }

    @Test
    fun aRequestThatIsLostWithTheLinkFailsAndOneThatWasNotSentWaits() = calling {
        val sent = call(true)
        val first = session().apply { opens(1) }
        first.await(HostFrame.REQUEST)
        lose(first)
        assertFails(sent, ServiceException.Reason.LINK_DOWN, "/pause: the connection was lost")
        val waiting = call(false)
        val second = session().apply { opens(1) }
        second.answer(second.await(HostFrame.REQUEST), "later")
        assertEquals("later", waiting.await().message)
    }

    @Test
    fun aCallEndsInTimeWithoutAnAnswerAndWithoutAConnection() = calling {
        val reason = assertFailsWith<ServiceException> { pause.call(SetBool.Request(true), 1.milliseconds) }.reason
        assertEquals(ServiceException.Reason.LINK_DOWN, reason)
        val session = session()
        val first = call(true)
        session.opens(1)
        session.answer(session.await(HostFrame.REQUEST), "")
        first.await()
        val time = TestCoroutineScheduler()
        val late = CoroutineScope(StandardTestDispatcher(time)).async {
            runCatching { pause.call(SetBool.Request(true), TEST_LIMIT) }.exceptionOrNull()
        }
        time.runCurrent()
        val request = session.await(HostFrame.REQUEST, 1)
        time.advanceTimeBy(TEST_LIMIT)
        time.runCurrent()
        assertEquals(ServiceException.Reason.TIMEOUT, assertIs<ServiceException>(late.await()).reason)
        session.answer(request, "too late")
        val next = call(true)
        session.answer(session.await(HostFrame.REQUEST, 2), "in time")
        assertEquals("in time", next.await().message)
    }

    @Test
    fun aRefusedServiceIsAskedForAgainByTheNextCall() = calling {
        val first = call(true)
        val session = session()
        session.await(HostFrame.OPEN)
        session.write(HostFrame.OPENED, """{"id": 1, "result": "refused", "reason": "no rule", "code": "rules"}""")
        assertFails(first, ServiceException.Reason.REFUSED, "/pause: no rule")
        val second = call(true)
        session.opens(2)
        session.await(HostFrame.REQUEST)
        session.write(HostFrame.CLOSED, """{"id": 2, "reason": "the rules have changed", "code": "rules"}""")
        assertFails(second, ServiceException.Reason.REFUSED, "/pause: the rules have changed")
    }

    @Test
    fun aReceiverWithoutOpeningsRefuses() = calling {
        running = fixture.run(app = clients)
        fixture.host.awaitHello().welcome()
        val error = assertFailsWith<ServiceException> { pause.call(SetBool.Request(true), TEST_LIMIT) }
        assertEquals(ServiceException.Reason.REFUSED, error.reason)
    }

    @Test
    fun aClosedClientIsClosedInTheSessionAndCallsNothing() = calling {
        val call = call(true)
        val session = session().apply { opens(1) }
        session.await(HostFrame.REQUEST)
        pause.close()
        assertFails(call, ServiceException.Reason.REFUSED, "/pause: the app has closed the client")
        assertEquals("""{"id":1}""", session.await(HostFrame.CLOSE).body.decodeToString())
        assertFails(call(true), ServiceException.Reason.REFUSED, "/pause: the app has closed the client")
    }

    @Test
    fun callsEndWithTheStreamer() = calling {
        val calls = List(3) { call(true) }
        session().apply { opens(1) }.await(HostFrame.REQUEST, 2)
        clients.end()
        for (call in calls + call(true)) {
            assertFails(call, ServiceException.Reason.LINK_DOWN, "/pause: the streamer has ended")
        }
    }

    @Test
    fun aRequestThatIsTooLargeAndAResponseOfAnotherTypeAreToldApart() = calling {
        val echo = ServiceType("a/srv/Echo", StringMessage.serializer(), StringMessage.serializer())
        val client = clients.client("/echo", echo)
        val most = 65_536 - 4 - 4 - 1
        val large = scope.async { client.call(StringMessage("x".repeat(most)), TEST_LIMIT) }
        val session = session().apply { opens(1) }
        val request = session.await(HostFrame.REQUEST)
        session.answer(request, HostFrame.RESPONSE, request.body)
        assertEquals(most, large.await().data.length)
        val error = assertFailsWith<ServiceException> { client.call(StringMessage("x".repeat(most + 1)), TEST_LIMIT) }
        assertEquals(ServiceException.Reason.TOO_LARGE, error.reason)
        val wrong = scope.async { runCatching { client.call(StringMessage(""), TEST_LIMIT) } }
        session.answer(session.await(HostFrame.REQUEST, 1), HostFrame.RESPONSE, byteArrayOf(0, 1, 0, 0, 9, 0, 0, 0))
        val reason = assertIs<ServiceException>(wrong.await().exceptionOrNull()).reason
        assertEquals(ServiceException.Reason.MALFORMED, reason)
    }

    @Test
    fun eachOf10000CallsHasOneOutcomeOver200Cuts() = calling {
        val random = Random(1)
        var answered = 0
        var lost = 0
        repeat(200) { round ->
            val calls = List(50) { call(it % 2 == 0) }
            val ends = Channel<Unit>(Channel.UNLIMITED)
            for (call in calls) call.invokeOnCompletion { ends.trySend(Unit) }
            val session = session().apply { opens(1) }
            val answers = random.nextInt(51)
            for (index in 0..<answers) {
                val request = session.await(HostFrame.REQUEST, index)
                session.answer(request, "${request.body[4]} $round")
            }
            session.await(HostFrame.REQUEST, 49)
            // In the other rounds, what was answered may have been read or not when the link is cut.
            if (round % 2 == 0) withTimeout(TEST_LIMIT) { repeat(answers) { ends.receive() } }
            lose(session)
            for ((index, call) in calls.withIndex()) {
                val outcome = withTimeout(TEST_LIMIT) { runCatching { call.await() } }
                outcome.onSuccess {
                    assertEquals("${if (index % 2 == 0) 1 else 0} $round", it.message)
                    answered++
                }.onFailure {
                    assertEquals(ServiceException.Reason.LINK_DOWN, assertIs<ServiceException>(it).reason)
                    lost++
                }
            }
        }
        assertEquals(10_000, answered + lost)
        assertTrue(answered > 1000 && lost > 1000, "$answered answered, $lost lost")
        val counts = pause.named.book.counts()
        val expected = Triple(10_000L, answered.toLong(), mapOf("link_down" to lost.toLong()))
        assertEquals(expected, Triple(counts.requests, counts.responses, counts.failures))
    }

    @Test
    fun aTypeThatIsNoServiceIsRefusedAtOnce() {
        for (type in listOf("std_srvs/msg/SetBool", "SetBool", "a/srv/${"A".repeat(250)}")) {
            val named = ServiceType(type, StringMessage.serializer(), StringMessage.serializer())
            assertFailsWith<IllegalArgumentException>(type) { clients.client("/a", named) }
        }
        for (name in listOf("", "a".repeat(256), "/\u0007")) {
            assertFailsWith<IllegalArgumentException> { clients.client(name, Trigger) }
        }
        for (limit in listOf(Duration.ZERO, (-1).seconds)) {
            assertFailsWith<IllegalArgumentException> { runBlocking { pause.call(SetBool.Request(true), limit) } }
        }
    }

    private fun call(on: Boolean, timeout: Duration = TEST_LIMIT): Deferred<SetBool.Response> =
        scope.async { pause.call(SetBool.Request(on), timeout) }

    private suspend fun assertFails(call: Deferred<*>, reason: ServiceException.Reason, message: String) {
        val error = assertIs<ServiceException>(runCatching { call.await() }.exceptionOrNull())
        assertEquals(reason to message, error.reason to error.message)
    }

    private fun HostSession.answer(request: HostFrame, message: String) {
        val body = Cdr.encodeToByteArray(SetBool.Response.serializer(), SetBool.Response(true, message))
        answer(request, HostFrame.RESPONSE, body)
    }

    private fun HostSession.answer(request: HostFrame, kind: Int, body: ByteArray) =
        send(kind, request.channel, request.sequence.toInt(), body)
}

class ServiceServersTest : ServiceSessions() {
    private val servers = ServiceServers()
    override val app: AppOpenings get() = servers
    private val asked = Channel<Boolean>(Channel.UNLIMITED)

    @Test
    fun aRequestIsAnsweredByTheApp() = calling {
        val server = echo()
        assertEquals<Any>(ServiceServer.State.Waiting, server.state.value)
        val session = session()
        val expected = """{"id": 1, "kind": "service", "name": "custom/on", "type": "std_srvs/srv/SetBool",
            "layout": "b>bs"}"""
        assertEquals(Json.parseToJsonElement(expected), session.await(HostFrame.OPEN).json)
        session.opens(1)
        server.state.first { it == ServiceServer.State.Offered("/full/name") }
        for ((index, value) in listOf(true, false).withIndex()) {
            session.ask(index + 7, byteArrayOf(0, 1, 0, 0, if (value) 1 else 0))
            val response = session.await(HostFrame.RESPONSE, index)
            assertEquals(Triple("ros", 1, index + 7L), Triple(response.lane, response.channel, response.sequence))
            assertEquals(SetBool.Response(value, "it is $value"), response.response())
        }
    }

    @Test
    fun aRequestThatComesBeforeOpenedIsAnswered() = calling {
        echo()
        val session = session()
        session.await(HostFrame.OPEN)
        session.ask(1)
        session.await(HostFrame.RESPONSE)
        session.opens(1)
    }

    @Test
    fun whatTheAppCannotAnswerFailsWithItsReasonAndTheNextRequestIsAnswered() = calling {
        var answer: suspend (SetBool.Request) -> SetBool.Response = { SetBool.Response(true, "") }
        servers.offer("custom/on", SetBool) { answer(it) }
        val session = session().apply { opens(1) }
        val most = 65_536 - 4 - 1 - 3 - 4 - 1
        val cases = listOf<Triple<String, ByteArray, suspend (SetBool.Request) -> SetBool.Response>>(
            Triple("refused: IllegalStateException: no, \\u0007 no", TRUE) { error("no, \u0007 no") },
            Triple("refused: StackOverflowError: deep", TRUE) { throw StackOverflowError("deep") },
            Triple("too_large: a response of 65537 bytes, expected at most 65536", TRUE) {
                SetBool.Response(true, "x".repeat(most + 1))
            },
            Triple("malformed: ", byteArrayOf(0, 1, 0, 0)) { SetBool.Response(true, "") },
        )
        for ((index, case) in cases.withIndex()) {
            val (expected, request, act) = case
            answer = act
            session.ask(index, request)
            val failure = session.await(HostFrame.FAILURE, index).json.mapValues { it.value.jsonPrimitive.content }
            assertContains("${failure["code"]}: ${failure["message"]}", expected)
        }
        answer = { SetBool.Response(true, "x".repeat(most)) }
        session.ask(cases.size)
        assertEquals(most, session.await(HostFrame.RESPONSE).response().message.length)
        session.awaitCalls(
            """{"requests": 5, "responses": 1, "failures": {"malformed": 1, "refused": 2, "too_large": 1}}""",
        )
    }

    @Test
    fun answersThatNeverEndAreFailuresInTimeAlsoIfTheyBlock() = calling {
        val isOver = CountDownLatch(1)
        servers.offer("custom/on", SetBool) {
            if (it.data) isOver.await() else awaitCancellation()
            SetBool.Response(true, "")
        }
        val session = session().apply { opens(1) }
        for ((index, request) in listOf(TRUE, FALSE).withIndex()) {
            session.ask(index, request, 50.milliseconds)
            val failure = session.await(HostFrame.FAILURE, index)
            assertEquals("timeout" to index.toLong(), failure.json.code() to failure.sequence)
        }
        isOver.countDown()
    }

    @Test
    fun sixteenRequestsAreAnsweredAtTheSameTimeAndOneMoreIsBusy() = calling {
        val mayAnswer = CountDownLatch(1)
        servers.offer("custom/on", SetBool) {
            asked.trySend(it.data)
            mayAnswer.await()
            SetBool.Response(true, "")
        }
        val session = session().apply { opens(1) }
        repeat(17) { session.ask(it) }
        repeat(16) { withTimeout(TEST_LIMIT) { asked.receive() } }
        val failure = session.await(HostFrame.FAILURE)
        assertEquals("busy" to 16L, failure.json.code() to failure.sequence)
        mayAnswer.countDown()
        session.await(HostFrame.RESPONSE, 15)
        assertEquals((0L..<16).toSet(), session.frames(HostFrame.RESPONSE).map { it.sequence }.toSet())
    }

    @Test
    fun theEndOfASessionCancelsWhatTheAppAnswersAndTheNextOneOffersAgain() = calling {
        val ended = CompletableDeferred<Unit>()
        val server = servers.offer("custom/on", SetBool) {
            try {
                asked.trySend(it.data)
                if (ended.isCompleted) SetBool.Response(true, "again") else awaitCancellation()
            } finally {
                ended.complete(Unit)
            }
        }
        val first = session().apply { opens(1) }
        first.ask(5)
        withTimeout(TEST_LIMIT) { asked.receive() }
        lose(first)
        withTimeout(TEST_LIMIT) { ended.await() }
        server.state.first { it == ServiceServer.State.Waiting }
        val second = session().apply { opens(1) }
        second.ask(6)
        assertEquals("again", second.await(HostFrame.RESPONSE).response().message)
        second.awaitCalls("""{"requests": 2, "responses": 1, "failures": {"link_down": 1}}""")
    }

    @Test
    fun aServiceThatTheReceiverRefusesSaysWhyAndIsAskedForInTheNextSession() = calling {
        val server = echo()
        val first = session()
        first.await(HostFrame.OPEN)
        first.write(HostFrame.OPENED, """{"id": 1, "result": "refused", "reason": "no rule", "code": "rules"}""")
        server.state.first { it == ServiceServer.State.Refused("no rule") }
        val other = servers.offer("custom/other", Trigger) { Trigger.Response(true, "") }
        first.opens(2)
        first.write(HostFrame.CLOSED, """{"id": 2, "reason": "the rules have changed", "code": "rules"}""")
        other.state.first { it == ServiceServer.State.Refused("the rules have changed") }
        assertEquals(2, first.frames(HostFrame.OPEN).size)
        lose(first)
        session().opens(2)
    }

    @Test
    fun aReceiverWithoutOpeningsRefusesServices() = calling {
        val server = echo()
        running = fixture.run(app = servers)
        fixture.host.awaitHello().welcome()
        server.state.first { it is ServiceServer.State.Refused }
    }

    @Test
    fun aClosedServiceIsClosedInTheSession() = calling {
        val server = echo()
        val session = session().apply { opens(1) }
        server.state.first { it is ServiceServer.State.Offered }
        server.close()
        assertEquals("""{"id":1}""", session.await(HostFrame.CLOSE).body.decodeToString())
        assertEquals<Any>(ServiceServer.State.Refused("the app has closed the service"), server.state.value)
        echo()
        session.opens(2)
    }

    @Test
    fun servicesEndWithTheStreamer() = calling {
        val before = echo()
        servers.end()
        for (server in listOf(before, echo())) {
            assertEquals<Any>(ServiceServer.State.Refused("the streamer has ended"), server.state.value)
        }
    }

    private fun echo() = servers.offer("custom/on", SetBool) { SetBool.Response(it.data, "it is ${it.data}") }

    private fun HostSession.ask(number: Int, request: ByteArray = TRUE, limit: Duration = TEST_LIMIT) =
        send(HostFrame.REQUEST, 1, number, request, limit.inWholeNanoseconds)

    private fun HostFrame.response() = Cdr.decodeFromByteArray(SetBool.Response.serializer(), body)

    private fun JsonObject.code() = getValue("code").jsonPrimitive.content

    private companion object {
        val TRUE = byteArrayOf(0, 1, 0, 0, 1)
        val FALSE = byteArrayOf(0, 1, 0, 0, 0)
    }
}
