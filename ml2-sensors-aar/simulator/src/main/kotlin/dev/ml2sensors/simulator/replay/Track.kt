package dev.ml2sensors.simulator.replay

import dev.ml2sensors.source.Sample

/**
 * What one stream plays: recorded times, and the sample of the row with the same index. Has one reader at a time.
 *
 * @property next the first row that was not delivered.
 */
internal class Track(val stamps: LongArray, val sample: suspend (row: Int, captureNanos: Long) -> Sample) {
    var next: Int = 0
}
