package dev.ml2sensors.fuzz

import kotlin.random.Random

/** Changes inputs as a fuzzer does that knows JSON, frame headers and URIs. */
internal class Mutation(private val random: Random) {
    fun of(seed: ByteArray): ByteArray = (0..random.nextInt(MOST_STEPS)).fold(seed) { data, _ -> step(data) }

    private fun step(data: ByteArray): ByteArray {
        val from = random.nextInt(data.size + 1)
        val to = random.nextInt(from, data.size + 1)
        val head = data.copyOfRange(0, from)
        val part = data.copyOfRange(from, to)
        val tail = data.copyOfRange(to, data.size)
        return when (random.nextInt(7)) {
            0 -> head + TOKENS.random(random) + data.copyOfRange(from, data.size)
            1 -> head + TOKENS.random(random) + tail
            2 -> head + tail
            3 -> head + part + part.copyOf(minOf(part.size, LONGEST_COPY)) + tail
            4 -> head + random.nextBytes(part.size) + tail
            5 -> head + repeated() + tail
            else -> flipped(data)
        }
    }

    private fun repeated(): ByteArray {
        val token = TOKENS.random(random)
        return ByteArray(token.size * random.nextInt(1, MOST_REPEATS)) { token[it % token.size] }
    }

    private fun flipped(data: ByteArray): ByteArray {
        if (data.isEmpty()) return data
        val at = random.nextInt(data.size)
        return data.copyOf().also { it[at] = (it[at].toInt() xor (1 shl random.nextInt(8))).toByte() }
    }

    private companion object {
        const val MOST_STEPS = 5
        const val MOST_REPEATS = 40
        const val LONGEST_COPY = 256

        val TOKENS =
            """{ } [ ] " : , \ \u0000 \ud800 \u null true -0 1e999 1.5 -1 9223372036854775807 9223372036854775808
            0x1 NaN Infinity "name": "streams": {"a": /* ' & ? @ # %00 ml2s:// é 😀""".split(Regex("\\s+"))
                .map(String::toByteArray) + listOf(
                byteArrayOf(32),
                byteArrayOf(10),
                byteArrayOf(0),
                byteArrayOf(-1, -1, -1, -1),
                byteArrayOf(0xC0.toByte(), 0x80.toByte()),
                byteArrayOf(0x32, 0x4D, 1, 2),
                byteArrayOf(0, 0, 1, 0),
                byteArrayOf(0, 0, 0, -128),
            )
    }
}
