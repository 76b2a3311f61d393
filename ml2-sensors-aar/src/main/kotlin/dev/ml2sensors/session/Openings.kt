package dev.ml2sensors.session

import dev.ml2sensors.wire.Closed
import dev.ml2sensors.wire.ControlJson
import dev.ml2sensors.wire.ErrorCode
import dev.ml2sensors.wire.Failure
import dev.ml2sensors.wire.Frame
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.Open
import dev.ml2sensors.wire.Opened
import dev.ml2sensors.wire.PoseBody
import dev.ml2sensors.wire.ProtocolException
import dev.ml2sensors.wire.RosLanes
import dev.ml2sensors.wire.printable

/**
 * The openings of one session, and which frames of the receiver they allow; PROTOCOL.md, Openings. Thread-safe.
 *
 * @param deliver takes the lane and each frame that an opening is to have; returns false if the app has closed it.
 * @param discarded gets the frames that are not delivered, since their opening has ended.
 */
internal class Openings(
    private val deliver: (String, Frame) -> Boolean,
    private val discarded: (String, Frame) -> Unit = { _, _ -> },
) {
    /** Numbers are the last of their kind, null before any. [lane] is that of OPENED, or of a frame that came before. */
    private class Opening(val kind: String) {
        var lane: String? = null
        var isAnswered = false
        var message: Int? = null
        var requested: Int? = null
        var asked: Int? = null
        val underWay = HashSet<Int>()
        val unanswered = HashSet<Int>()

        /** The length of each message that the app has not taken, by its number. */
        val untaken = LinkedHashMap<Int, Int>()
    }

    private val used = HashSet<Int>()
    private val live = HashMap<Int, Opening>()
    private val taken = HashMap<Int, Int>()

    /** The number of frames discarded because their opening had ended, or nobody waited for the answer any more. */
    @get:Synchronized
    var late: Long = 0
        private set

    /** Takes note of an OPEN before it is sent. */
    @Synchronized
    fun asks(wanted: Open) {
        require(used.add(wanted.id)) { "the opening ${wanted.id} was used in this session" }
        val opening = Opening(wanted.kind)
        opening.message = wanted.received?.takeIf { it > 0 }?.let { (it - 1).toInt() }
        live[wanted.id] = opening
    }

    /** Takes note of a REQUEST before it is sent. */
    @Synchronized
    fun asks(id: Int, number: Int) {
        val client = live.getValue(id)
        client.asked = number
        client.unanswered += number
    }

    /** Takes note that the app has answered a REQUEST. */
    @Synchronized
    fun answered(id: Int, number: Int) {
        live[id]?.underWay?.remove(number)
    }

    /**
     * Takes note that the messages of [id] up to [number] are in no queue any more. Returns false if that was known: an
     * opening that the app closes lets go of older messages after newer ones.
     */
    @Synchronized
    fun taken(id: Int, number: Int): Boolean {
        if (taken[id].let { it != null && !number.isAfter(it) }) return false
        taken[id] = number
        live[id]?.untaken?.keys?.removeIf { !it.isAfter(number) }
        return true
    }

    /** @throws ProtocolException when no OPEN waits for [answer]. */
    @Synchronized
    fun opened(answer: Opened) {
        val opening = live[answer.id]
        if (opening == null || opening.isAnswered) throw unexpected("OPENED of ${answer.id}, which is not asked for")
        val lane = answer.lane.takeIf { answer.isOpen }
        if (opening.lane != null && opening.lane != lane) {
            throw unexpected("OPENED of ${answer.id} on lane $lane, but it has had a frame on lane ${opening.lane}")
        }
        if (lane != null && lane != RosLanes.ROS && opening.kind != Open.SUBSCRIPTION) {
            throw unexpected("OPENED of ${answer.id}, a ${opening.kind}, on lane $lane")
        }
        opening.isAnswered = true
        opening.lane = lane
        if (!answer.isOpen) live -= answer.id
    }

    /** @throws ProtocolException when [end] ends what was never opened. */
    @Synchronized
    fun closed(end: Closed) {
        val opening = find(end.id, "CLOSED") ?: return
        if (!opening.isAnswered) throw unexpected("CLOSED of ${end.id} before its OPENED")
        live -= end.id
    }

    /**
     * Judges and delivers a [frame] of an opening. Returns the FAILURE that answers it if it is a request too many.
     *
     * @throws ProtocolException when PROTOCOL.md does not allow it.
     */
    fun received(lane: String, frame: Frame): Failure? {
        synchronized(this) {
            val id = frame.header.channel
            val opening = find(id, "${frame.kind}")
            if (opening == null) {
                discarded(lane, frame)
                return null
            }
            if (frame.kind !in KINDS[opening.kind].orEmpty() || opening.lane.let { it != null && it != lane }) {
                throw unexpected(
                    "${frame.kind} on lane $lane of opening $id, a ${opening.kind} on lane ${opening.lane}",
                )
            }
            opening.lane = lane
            checkBody(frame)
            when (frame.kind) {
                FrameKind.MESSAGE -> count(opening, frame)
                FrameKind.REQUEST -> if (isTooMuch(opening, frame)) return TOO_MANY
                FrameKind.RESPONSE, FrameKind.FAILURE -> if (!isAwaited(opening, frame)) return null
                else -> Unit
            }
        }
        if (!deliver(lane, frame)) {
            synchronized(this) { late++ }
            discarded(lane, frame)
        }
        return null
    }

    private fun find(id: Int, what: String): Opening? {
        live[id]?.let { return it }
        if (id !in used) throw unexpected("$what of $id, which was never opened")
        late++
        return null
    }

    private fun count(opening: Opening, message: Frame) {
        opening.message = next(opening.message, message)
        if (opening.lane == RosLanes.ROS) return
        val together = live.values.sumOf { it.untaken.values.sum().toLong() } + message.body.size
        if (opening.untaken.size == MOST_UNTAKEN || together > MOST_UNTAKEN_BYTES) {
            throw unexpected("a MESSAGE of ${message.header.channel} before those under way were TAKEN")
        }
        opening.untaken[message.header.sequence] = message.body.size
    }

    private fun isTooMuch(opening: Opening, request: Frame): Boolean {
        opening.requested = next(opening.requested, request)
        if (request.header.captureNanos <= 0) {
            throw malformed("REQUEST is waited for for ${request.header.captureNanos} ns, expected more than 0")
        }
        val together = live.values.sumOf { it.underWay.size }
        if (opening.underWay.size == MOST_REQUESTS || together == MOST_REQUESTS_TOGETHER) return true
        opening.underWay += request.header.sequence
        return false
    }

    private fun isAwaited(opening: Opening, answer: Frame): Boolean {
        val number = answer.header.sequence
        if (opening.asked.let { it == null || number.isAfter(it) }) {
            throw unexpected("${answer.kind} to request ${number.toUInt()}, which was never asked")
        }
        return opening.unanswered.remove(number).also { if (!it) late++ }
    }

    private fun next(last: Int?, frame: Frame): Int {
        val number = frame.header.sequence
        if (last != null && !number.isAfter(last)) {
            throw malformed("${frame.kind} has number ${number.toUInt()} after ${last.toUInt()}")
        }
        return number
    }

    private fun checkBody(frame: Frame) {
        when (frame.kind) {
            FrameKind.POSE -> PoseBody.parse(frame.body)

            FrameKind.FAILURE -> ControlJson.decode<Failure>(frame.body)

            else -> {
                val head = frame.body.take(ENCAPSULATION.size)
                if (head != ENCAPSULATION) throw malformed("${frame.kind} begins with $head, expected $ENCAPSULATION")
            }
        }
    }

    /** Numbers count up modulo 2^32. */
    private fun Int.isAfter(last: Int) = this - last > 0

    private fun unexpected(message: String) = ProtocolException(ErrorCode.UNEXPECTED, printable(message))

    private fun malformed(message: String) = ProtocolException(ErrorCode.MALFORMED, message)

    private companion object {
        const val MOST_UNTAKEN = 2
        const val MOST_UNTAKEN_BYTES = 128L shl 20
        const val MOST_REQUESTS = 16
        const val MOST_REQUESTS_TOGETHER = 64
        val TOO_MANY = Failure(Failure.BUSY, "too many requests are under way")
        val ENCAPSULATION = listOf<Byte>(0, 1, 0, 0)

        /** The kinds of frames that the receiver may send in an opening of each kind. */
        val KINDS = mapOf(
            Open.SUBSCRIPTION to setOf(FrameKind.MESSAGE),
            Open.CLIENT to setOf(FrameKind.RESPONSE, FrameKind.FAILURE),
            Open.SERVICE to setOf(FrameKind.REQUEST),
            Open.TRANSFORM to setOf(FrameKind.POSE),
        )
    }
}
