package dev.ml2sensors.android

import android.content.Context
import android.content.pm.PackageManager
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.NoAnswerException
import dev.ml2sensors.source.PlatformCalls
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SensorSource
import dev.ml2sensors.source.SourceException
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.catch
import kotlinx.coroutines.flow.onStart

/** The user has not granted, or has revoked, [permission]. */
internal class PermissionDeniedException internal constructor(
    override val permission: String,
    cause: Throwable? = null,
) :
    SourceException(denial(permission), cause)

/**
 * Returns the Android permissions that [stream] needs and this app lacks. Another process answers that.
 *
 * @throws dev.ml2sensors.source.NoAnswerException after the limit of [calls].
 */
internal fun Context.missingPermissions(stream: StreamSpec, calls: PlatformCalls): List<String> =
    if (stream.permissions.isEmpty()) {
        emptyList()
    } else {
        calls.call("Android is asked for permissions") {
            stream.permissions.filter { checkSelfPermission(it) != PackageManager.PERMISSION_GRANTED }
        }
    }

/**
 * Checks permissions before [source]: a stream without its permission is refused, and one whose permission is revoked
 * fails with [PermissionDeniedException].
 *
 * @param calls is the same for all sources: while Android does not answer, only the first of them waits for it.
 */
internal class PermissionCheckedSource(
    private val context: Context,
    private val source: SensorSource,
    private val calls: PlatformCalls = PlatformCalls(),
) : SensorSource by source {
    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer {
        val missing = missing(stream) ?: return permitted(stream, requested)
        return Answer.Refused(denial(missing), missing)
    }

    private fun permitted(stream: StreamSpec, requested: StreamValues): Answer =
        try {
            source.negotiate(stream, requested)
        } catch (e: SecurityException) {
            Answer.Refused("Android forbids $stream: ${e.message}", stream.permissions.firstOrNull())
        }

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> =
        source.samples(stream, values)
            .catch { throw explained(stream, it) }
            .onStart { missing(stream)?.let { throw PermissionDeniedException(it) } }

    private fun missing(stream: StreamSpec) = context.missingPermissions(stream, calls).firstOrNull()

    private fun explained(stream: StreamSpec, failure: Throwable): Throwable {
        val missing = try {
            missing(stream)
        } catch (_: NoAnswerException) {
            null
        }
        return when {
            missing != null -> PermissionDeniedException(missing, failure)
            failure is SecurityException -> SourceException("Android forbids $stream: ${failure.message}", failure)
            else -> failure
        }
    }
}

private fun denial(permission: String) = "permission $permission is not granted"

/**
 * Returns the result of a [call] of Android, which throws more kinds of exceptions than are documented: all but a
 * SecurityException, which [PermissionCheckedSource] explains, become a SourceException with this [complaint].
 */
internal inline fun <T> ofAndroid(complaint: String, call: () -> T): T = try {
    call()
} catch (e: SourceException) {
    throw e
} catch (e: SecurityException) {
    throw e
} catch (e: Exception) {
    throw SourceException("$complaint: ${e.message ?: e.javaClass.simpleName}", e)
}
