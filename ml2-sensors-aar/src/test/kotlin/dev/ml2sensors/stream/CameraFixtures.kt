package dev.ml2sensors.stream

import dev.ml2sensors.source.Distortion
import dev.ml2sensors.source.Intrinsics

internal object CameraFixtures {
    fun pinhole(width: Int, height: Int) =
        Intrinsics(width, height, 100.0, 110.0, 32.5, 16.25, Distortion.PlumbBob(0.1, -0.2, 0.001, -0.002, 0.05))
}
