package dev.ml2sensors.wire

/** The most characters of a receiver's name and of its software (PROTOCOL.md, WELCOME). */
private const val NAME_LIMIT = 64
private const val SOFTWARE_LIMIT = 128

private const val FIRST_OF_FOUR_DIGITS = 0x10000

/**
 * Returns the text of a peer or a file fit for logs, screens and terminals: with escapes for characters that move a
 * cursor, hide, or do more, and cut after [most] characters, which `...` then says.
 */
internal fun printable(text: String, most: Int = 512): String {
    val kept = StringBuilder()
    text.codePoints().forEach { if (kept.length <= most) kept.append(escaped(it)) }
    return if (kept.length <= most) "$kept" else kept.take(most - 3).toString() + "..."
}

/** Returns what is wrong with what a receiver says of itself, or null. */
internal fun violation(name: String, software: String? = null): String? = when {
    !isShort(name, NAME_LIMIT) -> "name: expected 1 to $NAME_LIMIT printable characters"

    software?.let {
        isShort(it, SOFTWARE_LIMIT)
    } == false -> "software: expected 1 to $SOFTWARE_LIMIT printable characters"

    else -> null
}

/** True for a text of 1 to [most] printable characters. */
internal fun isShort(text: String, most: Int): Boolean =
    text.codePointCount(0, text.length) in 1..most && text.codePoints().allMatch(::isPrintable)

private fun escaped(character: Int): String = when {
    isPrintable(character) -> String(Character.toChars(character))
    character < FIRST_OF_FOUR_DIGITS -> "\\u%04x".format(character)
    else -> "\\U%08x".format(character)
}

private fun isPrintable(character: Int): Boolean = character == ' '.code ||
    when (Character.getType(character).toByte()) {
        Character.CONTROL, Character.FORMAT, Character.SURROGATE, Character.PRIVATE_USE, Character.UNASSIGNED,
        Character.LINE_SEPARATOR, Character.PARAGRAPH_SEPARATOR, Character.SPACE_SEPARATOR,
        -> false

        else -> true
    }
