package dev.ml2sensors.source

import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.emitAll
import kotlinx.coroutines.flow.filterIsInstance
import kotlinx.coroutines.flow.flow

/** Returns the camera of [stream], such as [WorldCamera.LEFT] or `StreamTable.color`. */
public fun Headset.camera(stream: StreamSpec): Camera = Camera(this, stream)

/** One of a headset's cameras. */
public class Camera internal constructor(private val headset: Headset, private val stream: StreamSpec) {
    init {
        require(stream.modes.isNotEmpty()) { "$stream is no camera" }
    }

    /**
     * Returns the images of [Headset.samples] without reports of losses. If the headset adjusts [values], the adjusted
     * ones are used.
     *
     * @param values of one mode of the camera; the default is its first.
     * @throws RefusedException on collection, when the headset refuses.
     */
    public fun frames(values: StreamValues = stream.defaultValues()): Flow<ImageSample> = flow {
        val answer = headset.negotiate(stream, values)
        if (answer is Answer.Refused) throw RefusedException(stream, answer)
        emitAll(headset.samples(stream, checkNotNull(answer.acceptedValues)).filterIsInstance<ImageSample>())
    }
}

/** A headset refused [stream]; [answer] has the reason. */
public class RefusedException internal constructor(public val stream: StreamSpec, public val answer: Answer.Refused) :
    SourceException("$stream: ${answer.reason}")

/** The tracking cameras. */
public object WorldCamera {
    /** The camera on the wearer's left. */
    public val LEFT: StreamSpec get() = StreamTable.worldLeft

    /** The camera on the wearer's right. */
    public val RIGHT: StreamSpec get() = StreamTable.worldRight

    /** The camera above the nose. */
    public val CENTER: StreamSpec get() = StreamTable.worldCenter
}

/** The eye cameras, two for each eye; they need the permission `EYE_CAMERA`. */
public object EyeCamera {
    /** The nasal camera of the left eye. */
    public val NASAL_LEFT: StreamSpec get() = StreamTable.eyeNasalLeft

    /** The nasal camera of the right eye. */
    public val NASAL_RIGHT: StreamSpec get() = StreamTable.eyeNasalRight

    /** The temporal camera of the left eye. */
    public val TEMPLE_LEFT: StreamSpec get() = StreamTable.eyeTempleLeft

    /** The temporal camera of the right eye. */
    public val TEMPLE_RIGHT: StreamSpec get() = StreamTable.eyeTempleRight
}
