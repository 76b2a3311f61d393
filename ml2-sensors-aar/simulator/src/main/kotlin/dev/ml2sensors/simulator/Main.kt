package dev.ml2sensors.simulator

import com.github.ajalt.clikt.core.CliktError
import com.github.ajalt.clikt.core.UsageError
import com.github.ajalt.clikt.core.parse
import kotlin.system.exitProcess

/** Runs `ml2-headset`. The exit code is 0, or 1 if a sensor failed, or 2 for wrong arguments, keys or recordings. */
public fun main(arguments: Array<String>) {
    val command = HeadsetCommand()
    val exitCode = try {
        command.parse(arguments)
        0
    } catch (end: CliktError) {
        command.echoFormattedHelp(end)
        if (end is UsageError) EXIT_USAGE else end.statusCode
    }
    exitProcess(exitCode)
}
