package dev.ml2sensors.fuzz

import org.junit.jupiter.params.ParameterizedTest
import org.junit.jupiter.params.provider.EnumSource
import kotlin.random.Random

/** The same inputs in every run; `make fuzz-kotlin` looks for new ones. */
class FuzzTest {
    @ParameterizedTest
    @EnumSource
    internal fun strangersBytesAreRefusedOrRead(target: FuzzTarget) {
        val seeds = target.seeds()
        seeds.forEach(target::read)
        for (number in 0 until RUNS) {
            val input = Mutation(Random(number)).of(seeds[number % seeds.size])
            try {
                target.read(input)
            } catch (failure: Throwable) {
                throw AssertionError("input $number: ${input.toHexString()}", failure)
            }
        }
    }

    private companion object {
        const val RUNS = 20_000
    }
}
