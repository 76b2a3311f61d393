package dev.ml2sensors.simulator.replay

import java.io.File
import java.io.IOException

/** A recording is not as its format says: [file], the [line] in it where there is one, what was expected and found. */
public class RecordingException internal constructor(
    public val file: File,
    public val line: Int?,
    public val expected: String,
    public val found: String,
    cause: Throwable? = null,
) : IOException("$file${line?.let { ":$it" }.orEmpty()}: expected $expected, found $found", cause)
