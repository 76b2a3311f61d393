package dev.ml2sensors.simulator.replay

import java.io.File
import java.io.IOException
import java.math.BigDecimal

/**
 * Reads a `data.csv`: fields in quotes or not, the first a time in ns. Commas separate them; in a line without any,
 * semicolons, else blanks. Lines that begin with `#` are comments. The first other line may name the columns. Columns behind the first [columns] are ignored.
 */
internal class CsvTable(private val file: File, private val columns: Int) {
    class Row(private val file: File, val line: Int, private val fields: List<String>) {
        val stampNanos: Long = wholeNumber(fields[0]) ?: throw error("a time in integer nanoseconds", fields[0])

        fun text(column: Int): String = fields[column]

        fun number(column: Int): Double =
            fields[column].toDoubleOrNull()?.takeIf(Double::isFinite) ?: throw error("a finite number", fields[column])

        fun error(expected: String, found: String) = RecordingException(file, line, expected, "'$found'")
    }

    /**
     * Returns at least one row; times increase strictly.
     *
     * @param notes receives a sentence if the last line is left out because it ends too early.
     */
    fun rows(notes: MutableList<String>): List<Row> {
        val lines = lines().map(::fields).withIndex().filter { (_, fields) -> fields != null }
            .map { (index, fields) -> index + 1 to fields.orEmpty() }
        val data = if (lines.firstOrNull()?.second?.isHeader() == true) lines.drop(1) else lines
        val whole = if (data.size > 1 && data.last().second.size < columns) {
            notes += "$file:${data.last().first}: the last line ends too early and was left out"
            data.dropLast(1)
        } else {
            data
        }
        val rows = whole.map { (line, fields) -> row(line, fields) }
        if (rows.isEmpty()) throw RecordingException(file, null, "at least one row", "none")
        rows.zipWithNext { before, row ->
            if (row.stampNanos <= before.stampNanos) {
                throw row.error("a time after ${before.stampNanos}", "${row.stampNanos}")
            }
        }
        return rows
    }

    private fun lines(): List<String> = try {
        file.readText().removePrefix(BYTE_ORDER_MARK).lines()
    } catch (failure: IOException) {
        throw RecordingException(file, null, "a readable file", "${failure.message}", failure)
    }

    /** Returns the fields without empty ones at the end, or null for a line that holds no row. */
    private fun fields(line: String): List<String>? {
        val text = line.trim()
        if (text.isEmpty() || text.startsWith('#')) return null
        val separator = SEPARATORS.firstOrNull { it.containsMatchIn(text) } ?: return listOf(text)
        return text.split(separator).map { it.trim().removeSurrounding("\"") }.dropLastWhile(String::isEmpty)
    }

    private fun List<String>.isHeader(): Boolean = none { it.toDoubleOrNull() != null }

    private fun row(line: Int, fields: List<String>): Row {
        if (fields.size < columns) throw RecordingException(file, line, "$columns columns", "${fields.size}")
        return Row(file, line, fields)
    }

    private companion object {
        const val BYTE_ORDER_MARK = "\uFEFF"

        val SEPARATORS = listOf(Regex(","), Regex(";"), Regex("\\s+"))

        /** Takes what some programs write for an integer, such as 1.5e18 or 15.0, if it is one. */
        fun wholeNumber(text: String): Long? = text.toLongOrNull() ?: try {
            text.toBigDecimalOrNull()?.let(BigDecimal::longValueExact)
        } catch (_: ArithmeticException) {
            null
        }
    }
}
