package dev.ml2sensors.unity

/** The listener that Unity's side implements. */
public interface Ml2UnityListener {
    /** Called when [Ml2Unity.status] has changed, on any thread, one call at a time. */
    public fun changed(statusJson: String)
}
