package dev.ml2sensors.stream

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.transport.TestIdentity
import dev.ml2sensors.transport.TransportSecurity
import kotlin.test.Test
import kotlin.test.assertEquals
import kotlin.test.assertIs

class EyeImageFilterTest {
    private val headset = FakeHeadset()
    private val eyeImages = StreamTable.all.filter { it.id.startsWith("eye_temple") || it.id.startsWith("eye_nasal") }

    @Test
    fun imagesOfEyesAreRefusedInPlaintextAndNothingElseIs() {
        val spared = headset.withoutUnprotectedEyeImages(TransportSecurity.Insecure())
        assertEquals(4, eyeImages.size)
        for (stream in eyeImages) {
            val answer = assertIs<Answer.Refused>(spared.negotiate(stream, StreamValues()))
            assertEquals("eye images are biometric: pair, or allow with --insecure-eye-images", answer.reason)
        }
        val values = StreamValues()
        for (stream in StreamTable.all - eyeImages.toSet()) {
            assertEquals(headset.negotiate(stream, values), spared.negotiate(stream, values))
        }
    }

    @Test
    fun theyAreSentWhereTheyAreProtectedOrAllowed() {
        val paired = TransportSecurity.Paired(TestIdentity.device, emptySet())
        for (security in listOf(paired, TransportSecurity.Insecure(allowsEyeImages = true))) {
            assertEquals(headset, headset.withoutUnprotectedEyeImages(security))
        }
    }
}
