package dev.ml2sensors.capture

import dev.ml2sensors.source.Condition
import java.util.Locale

private val HEAD_STATUSES = mapOf(0 to "invalid", 1 to "initializing", 2 to "relocalizing", 100 to "valid")
private val HEAD_ERRORS = listOf("unknown", "not_enough_features", "low_light", "excessive_motion")
private val FITS = listOf("unknown", "not_worn", "good", "bad")
private val CALIBRATIONS = listOf("unknown", "none", "coarse", "fine")

private fun word(words: List<String>, number: Float) =
    if (number < 0) Condition.NOT_SAID else words.getOrElse(number.toInt()) { "unknown" }

/** Says how well the head is tracked. It is good if nothing makes it worse. OpenXR says only that it is tracked or not. */
internal fun headCondition(found: Reading): Condition {
    val status = found.value(Reading.HEAD_STATUS).toInt()
    val errors = wordsOf(HEAD_ERRORS, found.value(Reading.HEAD_ERRORS).toInt())
    val said = if (status < 0) {
        emptyMap()
    } else {
        mapOf(
            "status" to HEAD_STATUSES.getOrElse(status) { "unknown" },
            "confidence" to String.format(Locale.ROOT, "%.2f", found.value(Reading.HEAD_CONFIDENCE)),
            "errors" to errors.joinToString(" "),
        )
    }
    val reasons = listOfNotNull(said["status"].takeUnless { found.isTracked }) + errors
    val state = if (found.isTracked) "the head is tracked" else "the head is not tracked"
    val message = if (reasons.isEmpty()) state else "$state: ${reasons.joinToString()}"
    return Condition(found.isTracked && errors.isEmpty(), message, said)
}

/** Says how far the gaze can be relied on: only if the headset fits well and the eyes are calibrated to the full. */
internal fun gazeCondition(found: Reading): Condition {
    val fit = word(FITS, found.value(Reading.GAZE_FIT))
    val calibration = word(CALIBRATIONS, found.value(Reading.GAZE_CALIBRATION))
    val message = "headset fit is $fit, eye calibration is $calibration"
    val values = mapOf("headset_fit" to fit, "eye_calibration" to calibration)
    return Condition(fit == "good" && calibration == "fine", message, values)
}

/** Returns the words of the bits that are set in [bits]. */
internal fun wordsOf(words: List<String>, bits: Int): List<String> =
    words.filterIndexed { bit, _ -> bits shr bit and 1 != 0 }
