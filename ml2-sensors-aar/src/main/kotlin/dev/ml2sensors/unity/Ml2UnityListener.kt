package dev.ml2sensors.unity

/** What Unity's side implements. */
public interface Ml2UnityListener {
    /** [Ml2Unity.status] is another now. On any thread, one call at a time. */
    public fun changed(statusJson: String)
}
