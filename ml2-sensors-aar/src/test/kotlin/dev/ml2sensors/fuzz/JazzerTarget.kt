package dev.ml2sensors.fuzz

/** What Jazzer calls; its one argument is the name of a [FuzzTarget]. */
internal object JazzerTarget {
    private lateinit var target: FuzzTarget

    @JvmStatic
    fun fuzzerInitialize(arguments: Array<String>) {
        target = FuzzTarget.valueOf(arguments.single())
    }

    @JvmStatic
    fun fuzzerTestOneInput(data: ByteArray): Unit = target.read(data)
}
