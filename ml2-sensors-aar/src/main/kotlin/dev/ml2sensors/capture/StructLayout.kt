package dev.ml2sensors.capture

import java.nio.ByteBuffer
import java.nio.ByteOrder

/** Allocates direct memory for [count] C structures of [sizeBytes] each. */
internal fun structMemory(count: Int, sizeBytes: Int): ByteBuffer =
    ByteBuffer.allocateDirect(count * sizeBytes).order(ByteOrder.nativeOrder())

/** Reads the offsets of a layout one after the other, in the order in which its C function writes them. */
internal class Offsets(private val layout: IntArray) {
    private var next = 0

    fun next(): Int = layout[next++]

    fun end(): Unit = check(next == layout.size) { "the library has ${layout.size} offsets, and $next were read" }
}
