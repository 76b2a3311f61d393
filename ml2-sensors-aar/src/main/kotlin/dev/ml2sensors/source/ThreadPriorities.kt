package dev.ml2sensors.source

/**
 * Java's priority of threads that images must not delay: Android's THREAD_PRIORITY_DISPLAY, a niceness of -4
 * (kNiceValues of ART's libartpalette).
 */
internal const val URGENT_PRIORITY: Int = 7

/**
 * Java's priority of threads with images: the normal one, below which Android would move them to the cores of the
 * background. The simulated headset lowers it, since Linux lets nobody but root raise the other.
 */
internal val imagePriority: Int = Integer.getInteger("ml2s.image_priority", Thread.NORM_PRIORITY)
