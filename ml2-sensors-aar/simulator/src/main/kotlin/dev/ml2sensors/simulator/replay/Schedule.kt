package dev.ml2sensors.simulator.replay

/**
 * When a replay that started at [startNanos] delivers what was recorded, and with which capture times.
 *
 * @param firstRecordedNanos the first instant of the recording, on which all sensors agree.
 * @param rateFactor how many times as fast as recorded; infinite: all is due at once.
 */
internal class Schedule(startNanos: Long, private val firstRecordedNanos: Long, private val rateFactor: Double) {
    private val firstDueNanos = startNanos + LEAD_NANOS
    private val offsetNanos = firstDueNanos - firstRecordedNanos

    /** On the device timebase; whatever the rate, the differences are those of the recording. */
    fun captureNanos(recordedNanos: Long): Long = recordedNanos + offsetNanos

    fun dueNanos(recordedNanos: Long): Long =
        firstDueNanos + ((recordedNanos - firstRecordedNanos) / rateFactor).toLong()

    companion object {
        /** Long enough for every stream to be collected before its first sample is due. */
        const val LEAD_NANOS: Long = 200_000_000
    }
}
