package dev.ml2sensors.android

import android.Manifest
import android.app.Application
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.ScalarSample
import dev.ml2sensors.source.SensorSource
import dev.ml2sensors.source.SourceException
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.test
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.runBlocking
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.RuntimeEnvironment
import org.robolectric.Shadows.shadowOf
import org.robolectric.annotation.Config
import kotlin.test.assertEquals
import kotlin.test.assertIs
import kotlin.test.assertSame

@RunWith(RobolectricTestRunner::class)
@Config(sdk = [29], manifest = Config.NONE)
class PermissionsTest {
    private val app: Application = RuntimeEnvironment.getApplication()
    private val failing = FailingSource()
    private val source = PermissionCheckedSource(app, failing)

    @Test
    fun aStreamIsRefusedWithThePermissionThatIsMissing() {
        val depth = "com.magicleap.permission.DEPTH_CAMERA"
        assertEquals(
            Answer.Refused("permission $depth is not granted", depth),
            source.negotiate(StreamTable.depth, StreamValues()),
        )
        shadowOf(app).grantPermissions(depth)
        assertEquals(Answer.Applied(StreamValues()), source.negotiate(StreamTable.depth, StreamValues()))
    }

    @Test
    fun everyStreamNeedsThePermissionsOfTheTableAndNoOthers() {
        for (stream in StreamTable.all) {
            val missing = (source.negotiate(stream, StreamValues()) as? Answer.Refused)?.permission
            assertEquals(stream.permissions.firstOrNull(), missing, "$stream")
        }
    }

    @Test
    fun withoutThePermissionAFlowFailsBeforeTheSourceIsTouched() = runBlocking {
        source.samples(StreamTable.color, StreamValues()).test {
            assertEquals(Manifest.permission.CAMERA, assertIs<PermissionDeniedException>(awaitError()).permission)
        }
        assertEquals(0, failing.collections)
    }

    @Test
    fun aPermissionThatIsTakenAwayWhileRunningIsTheReasonOfTheFailure() = runBlocking {
        shadowOf(app).grantPermissions(Manifest.permission.CAMERA)
        failing.beforeFailure = { shadowOf(app).denyPermissions(Manifest.permission.CAMERA) }
        source.samples(StreamTable.color, StreamValues()).test {
            awaitItem()
            val failure = assertIs<PermissionDeniedException>(awaitError())
            assertEquals("permission android.permission.CAMERA is not granted", failure.message)
            assertSame(failing.failure, failure.cause)
        }
    }

    @Test
    fun aSecurityExceptionWithAllPermissionsIsTypedAndOtherFailuresStayAsTheyAre() = runBlocking {
        shadowOf(app).grantPermissions(Manifest.permission.CAMERA)
        failing.failure = SecurityException("not allowed by policy")
        source.samples(StreamTable.color, StreamValues()).test {
            awaitItem()
            assertEquals(
                "Android forbids color: not allowed by policy",
                assertIs<SourceException>(awaitError()).message,
            )
        }
        failing.failure = SourceException("broken")
        source.samples(StreamTable.color, StreamValues()).test {
            awaitItem()
            assertSame(failing.failure, awaitError())
        }
    }

    @Test
    fun aSecurityExceptionWhileNegotiatingIsARefusal() {
        shadowOf(app).grantPermissions(Manifest.permission.CAMERA)
        failing.forbids = true
        val expected = Answer.Refused("Android forbids color: by policy", Manifest.permission.CAMERA)
        assertEquals(expected, source.negotiate(StreamTable.color, StreamValues()))
    }

    private class FailingSource : SensorSource {
        var failure: Exception = SourceException("the camera went away")
        var beforeFailure: () -> Unit = {}
        var forbids = false
        var collections = 0
        override val backend = "failing"
        override val streams: Set<StreamSpec> = StreamTable.all.toSet()

        override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer {
            if (forbids) throw SecurityException("by policy")
            return Answer.Applied(requested)
        }

        override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> = flow {
            collections++
            emit(ScalarSample(1, 1.0))
            beforeFailure()
            throw failure
        }

        override fun close() = Unit
    }
}
