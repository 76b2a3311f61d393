package dev.ml2sensors.simulator.replay

import java.io.File
import java.io.IOException

/** A recording does not follow its format. Names the [file], the [line] if there is one, and what was expected and found. */
public class RecordingException internal constructor(
    public val file: File,
    public val line: Int?,
    public val expected: String,
    public val found: String,
    cause: Throwable? = null,
) : IOException("$file${line?.let { ":$it" }.orEmpty()}: expected $expected, found $found", cause)
