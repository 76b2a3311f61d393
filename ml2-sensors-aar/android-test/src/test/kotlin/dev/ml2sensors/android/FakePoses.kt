package dev.ml2sensors.android

import dev.ml2sensors.capture.CaptureException
import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.source.ColorPoses
import java.util.concurrent.CopyOnWriteArrayList
import java.util.concurrent.atomic.AtomicInteger

/** A tracker of the colour camera that knows every pose. */
internal class FakePoses : ColorPoses {
    @Volatile
    var isThere = false

    /** The call, as in [calls], that fails. */
    @Volatile
    var failing: String? = null

    val calls = CopyOnWriteArrayList<String>()
    val threads = CopyOnWriteArrayList<String>()
    private val mutableOpen = AtomicInteger()

    /** The number of trackers that are open. */
    val open: Int get() = mutableOpen.get()

    override fun open(): ColorPoses.Tracker? {
        if (!isThere) return null
        note("open")
        mutableOpen.incrementAndGet()
        return Tracker()
    }

    fun forgetCalls() {
        calls.clear()
        threads.clear()
    }

    private fun note(call: String) {
        calls += call
        threads += Thread.currentThread().name
        NeverReturns.pass("ColorPoses.$call")
        if (call == failing) throw CaptureException.VendorFailure("MLPerceptionGetSnapshot answered UnspecifiedFailure")
    }

    private inner class Tracker : ColorPoses.Tracker {
        override fun captureNanos(mlTimeNanos: Long): Long {
            note("capture")
            return mlTimeNanos + ML_TIME_IN_BOOT_TIME
        }

        override fun poseAt(mlTimeNanos: Long): Transform {
            note("pose")
            return FakePoses.poseAt(mlTimeNanos)
        }

        override fun close() {
            mutableOpen.decrementAndGet()
            note("close")
        }
    }

    companion object {
        const val ML_TIME_IN_BOOT_TIME = 77_000_000_000L

        fun poseAt(mlTimeNanos: Long) = Transform(
            Vector3(mlTimeNanos.toDouble(), 2.0, 3.0),
            Quaternion(0.0, 0.0, 0.0, 1.0),
        )
    }
}
