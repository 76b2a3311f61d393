package dev.ml2sensors.source

/**
 * Java's priority of threads that images must not delay: Android's THREAD_PRIORITY_DISPLAY, a niceness of -4
 * (kNiceValues of ART's libartpalette). Threads with images keep Java's normal one. Below that, Android would move them
 * to the cores of the background.
 */
internal const val URGENT_PRIORITY: Int = 7
