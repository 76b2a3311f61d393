package dev.ml2sensors.unity

/** The listener that Unity's side implements. */
internal interface Ml2UnityListener {
    /** Called when [Ml2Unity.status] has changed, on any thread, one call at a time. */
    fun changed(statusJson: String)
}
