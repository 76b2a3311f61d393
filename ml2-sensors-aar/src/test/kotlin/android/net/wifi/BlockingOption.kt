package android.net.wifi

/** A class of a later Android; Robolectric's stand-in for Wi-Fi does not load without it. */
internal class BlockingOption
