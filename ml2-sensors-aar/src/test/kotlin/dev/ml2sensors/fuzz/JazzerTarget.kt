package dev.ml2sensors.fuzz

import java.io.File

/** The entry points of Jazzer; the arguments are the name of a [FuzzTarget] and the folder with the inputs. */
internal object JazzerTarget {
    private lateinit var target: FuzzTarget

    @JvmStatic
    fun fuzzerInitialize(arguments: Array<String>) {
        val (name, folder) = arguments
        target = FuzzTarget.valueOf(name)
        target.seeds().forEachIndexed { number, seed -> File(folder, "seed-$number").writeBytes(seed) }
    }

    @JvmStatic
    fun fuzzerTestOneInput(data: ByteArray): Unit = target.read(data)
}
