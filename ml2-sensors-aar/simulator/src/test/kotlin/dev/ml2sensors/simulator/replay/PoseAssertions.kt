package dev.ml2sensors.simulator.replay

import dev.ml2sensors.message.Quaternion
import kotlin.test.assertEquals

/** Asserts that both are the same rotation, within about [tolerance] rad. */
internal fun assertClose(expected: Quaternion, actual: Quaternion, tolerance: Double = 1e-9) {
    val dot = expected.x * actual.x + expected.y * actual.y + expected.z * actual.z + expected.w * actual.w
    val sign = if (dot < 0) -1 else 1
    assertEquals(expected.x, sign * actual.x, tolerance, "$expected, $actual")
    assertEquals(expected.y, sign * actual.y, tolerance, "$expected, $actual")
    assertEquals(expected.z, sign * actual.z, tolerance, "$expected, $actual")
    assertEquals(expected.w, sign * actual.w, tolerance, "$expected, $actual")
}
