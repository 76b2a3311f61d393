package android.net.wifi

/** Of a later Android; Robolectric's stand-in for Wi-Fi does not load without. */
internal class BlockingOption
