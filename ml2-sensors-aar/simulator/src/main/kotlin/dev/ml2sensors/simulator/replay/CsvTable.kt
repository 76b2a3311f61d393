package dev.ml2sensors.simulator.replay

import java.io.File
import java.io.IOException

/** Reads a `data.csv`: comma-separated fields, the first a time in ns; lines that begin with `#` are comments. */
internal class CsvTable(private val file: File, private val columns: Int) {
    class Row(private val file: File, val line: Int, private val fields: List<String>) {
        val stampNanos: Long = fields[0].toLongOrNull() ?: throw error("a time in integer nanoseconds", fields[0])

        fun text(column: Int): String = fields[column]

        fun number(column: Int): Double =
            fields[column].toDoubleOrNull()?.takeIf(Double::isFinite) ?: throw error("a finite number", fields[column])

        fun error(expected: String, found: String) = RecordingException(file, line, expected, "'$found'")
    }

    /** Returns at least one row; times increase strictly. */
    fun rows(): List<Row> {
        val rows = lines().withIndex().mapNotNull { (index, text) -> row(index + 1, text.trim()) }
        if (rows.isEmpty()) throw RecordingException(file, null, "at least one row", "none")
        rows.zipWithNext { before, row ->
            if (row.stampNanos <= before.stampNanos) {
                throw row.error("a time after ${before.stampNanos}", "${row.stampNanos}")
            }
        }
        return rows
    }

    private fun lines(): List<String> = try {
        file.readLines()
    } catch (failure: IOException) {
        throw RecordingException(file, null, "a readable file", "${failure.message}", failure)
    }

    private fun row(line: Int, text: String): Row? {
        if (text.isEmpty() || text.startsWith('#')) return null
        val fields = text.split(',').map(String::trim)
        if (fields.size != columns) throw RecordingException(file, line, "$columns columns", "${fields.size}")
        return Row(file, line, fields)
    }
}
