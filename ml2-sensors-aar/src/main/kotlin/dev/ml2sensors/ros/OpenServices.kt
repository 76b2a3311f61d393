package dev.ml2sensors.ros

import dev.ml2sensors.session.AppOpenings
import dev.ml2sensors.session.OpeningLanes
import dev.ml2sensors.wire.Closed
import dev.ml2sensors.wire.Opened
import dev.ml2sensors.wire.Status
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.coroutineScope
import java.util.TreeMap

/**
 * The clients or the services of an app, over all sessions of its streamer: opens and closes them. Thread-safe; what is
 * protected is called under its lock, but for [send].
 */
internal abstract class OpenServices<T : Any>(private val named: (T) -> NamedService) : AppOpenings {
    private val changes = Channel<Unit>(Channel.CONFLATED)

    /** The ids of the present session. */
    private val ids = HashMap<T, Int>()

    /** The ids that have been OPENED. */
    private val ready = HashSet<Int>()

    /** Returns those that are to be open in this session. */
    protected abstract fun wanted(): List<T>

    protected abstract fun isClosed(service: T): Boolean

    /** Takes note that [service] is open, as [name] in ROS. */
    protected open fun opened(service: T, name: String) = Unit

    /** Takes note that [service] is not open in this session, for the reason [why]. */
    protected abstract fun refused(service: T, why: String)

    protected open fun sessionBegins(session: CoroutineScope, lanes: OpeningLanes): Unit = Unit

    protected abstract fun sessionEnds()

    /** Sends what those that are open have to send. */
    protected open suspend fun send(lanes: OpeningLanes): Unit = Unit

    protected fun change() {
        changes.trySend(Unit)
    }

    protected fun find(id: Int): T? = ids.entries.firstOrNull { it.value == id }?.key

    protected fun readyId(service: T): Int? = ids[service]?.takeIf { it in ready }

    override suspend fun serve(lanes: OpeningLanes?): Unit = coroutineScope {
        if (lanes != null) synchronized(this@OpenServices) { sessionBegins(this, lanes) }
        try {
            while (true) {
                if (lanes == null) refuseAll() else serveOn(lanes)
                changes.receive()
            }
        } finally {
            endSession()
        }
    }

    private suspend fun serveOn(lanes: OpeningLanes) {
        for (id in takeClosed()) lanes.close(id)
        for (service in unopened()) {
            val id = lanes.nextId()
            synchronized(this) { ids[service] = id }
            lanes.open(named(service).open(id))
        }
        send(lanes)
    }

    @Synchronized
    private fun takeClosed(): List<Int> =
        ids.keys.filter { isClosed(it) && readyId(it) != null }.mapNotNull(::remove)

    @Synchronized
    private fun unopened(): List<T> = wanted().filter { it !in ids }

    @Synchronized
    private fun refuseAll() = wanted().forEach { refused(it, "the receiver serves no apps: $WHICH_DOES") }

    @Synchronized
    private fun endSession() {
        ids.clear()
        ready.clear()
        sessionEnds()
    }

    @Synchronized
    override fun opened(answer: Opened) {
        val service = find(answer.id) ?: return
        if (!answer.isOpen) return end(answer.id, answer.reason.orEmpty())
        ready += answer.id
        opened(service, answer.name ?: named(service).name)
        change()
    }

    @Synchronized
    override fun closed(end: Closed): Unit = end(end.id, end.reason)

    private fun end(id: Int, why: String) {
        val service = find(id) ?: return
        remove(service)
        refused(service, why)
    }

    private fun remove(service: T): Int? = ids.remove(service)?.also { ready -= it }

    @Synchronized
    override fun calls(): Map<String, Status.CallCounts> =
        ids.entries.associate { (service, id) -> "$id" to named(service).book.counts() }
}

/** Counts what became of the requests of one client or service, over all sessions. Thread-safe. */
internal class CallBook {
    private var requests = 0L
    private var responses = 0L
    private val failures = TreeMap<String, Long>()

    @Synchronized
    fun begin() {
        requests++
    }

    /** Counts the outcome of a request: the code of its [failure], or null. */
    @Synchronized
    fun end(failure: String?) {
        if (failure == null) responses++ else failures.merge(failure, 1, Long::plus)
    }

    @Synchronized
    fun counts() = Status.CallCounts(requests, responses, TreeMap(failures))
}
