package dev.ml2sensors.cdr

import kotlinx.serialization.ExperimentalSerializationApi
import kotlinx.serialization.SerializationException
import kotlinx.serialization.descriptors.PrimitiveKind
import kotlinx.serialization.descriptors.SerialDescriptor
import kotlinx.serialization.descriptors.StructureKind

/**
 * Returns how CDR walks through a message type, as text. Two types with equal layouts read each other's bytes, whatever
 * the names of their fields are. The receiver derives the same text from ROS's description of the type.
 *
 * | part | stands for |
 * |---|---|
 * | `b`, `1`, `2`, `4`, `8` | bool; an integer of so many bytes, with or without sign |
 * | `f`, `d` | float32, float64 |
 * | `s`, `w` | string, wstring |
 * | `[...]`, `(...*N)` | a sequence; an array of N elements |
 *
 * A nested message adds its fields alone: `tf2_msgs/msg/TFMessage` is `[44ssddddddd]`. A message without fields is the
 * one byte that ROS sends for it.
 *
 * @throws SerializationException if the type has no CDR.
 */
@OptIn(ExperimentalSerializationApi::class)
internal fun SerialDescriptor.layout(): String = StringBuilder().also {
    appendLayout(it, outer = emptySet())
}.toString()

@OptIn(ExperimentalSerializationApi::class)
private fun SerialDescriptor.appendLayout(layout: StringBuilder, outer: Set<String>) {
    if (isNullable || serialName in outer) throw hasNoCdr()
    when (kind) {
        PrimitiveKind.BOOLEAN -> layout.append('b')

        PrimitiveKind.BYTE -> layout.append('1')

        PrimitiveKind.SHORT -> layout.append('2')

        PrimitiveKind.INT -> layout.append('4')

        PrimitiveKind.LONG -> layout.append('8')

        PrimitiveKind.FLOAT -> layout.append('f')

        PrimitiveKind.DOUBLE -> layout.append('d')

        PrimitiveKind.STRING -> layout.append(if (this == WideStringSerializer.descriptor) 'w' else 's')

        StructureKind.LIST -> {
            layout.append('[')
            getElementDescriptor(0).appendLayout(layout, outer)
            layout.append(']')
        }

        StructureKind.CLASS, StructureKind.OBJECT -> {
            if (elementsCount == 0) layout.append('1')
            for (index in 0..<elementsCount) appendElement(index, layout, outer + serialName)
        }

        else -> throw hasNoCdr()
    }
}

@OptIn(ExperimentalSerializationApi::class)
private fun SerialDescriptor.appendElement(index: Int, layout: StringBuilder, outer: Set<String>) {
    val length = fixedLength(index)?.length ?: return getElementDescriptor(index).appendLayout(layout, outer)
    layout.append('(')
    getElementDescriptor(index).getElementDescriptor(0).appendLayout(layout, outer)
    layout.append('*').append(length).append(')')
}

/** The fewest bytes a value can take, padding aside: what bounds the number of elements before they are allocated. */
@OptIn(ExperimentalSerializationApi::class)
internal fun SerialDescriptor.leastSize(): Int = when (kind) {
    PrimitiveKind.SHORT -> Short.SIZE_BYTES
    PrimitiveKind.INT, PrimitiveKind.FLOAT, StructureKind.LIST -> Int.SIZE_BYTES
    PrimitiveKind.LONG, PrimitiveKind.DOUBLE -> Long.SIZE_BYTES
    PrimitiveKind.STRING -> if (this == WideStringSerializer.descriptor) Int.SIZE_BYTES else Int.SIZE_BYTES + 1
    StructureKind.CLASS -> (0 until elementsCount).sumOf(::leastElementSize).coerceAtLeast(Byte.SIZE_BYTES)
    else -> Byte.SIZE_BYTES
}

@OptIn(ExperimentalSerializationApi::class)
private fun SerialDescriptor.leastElementSize(index: Int): Int {
    val length = fixedLength(index)?.length ?: return getElementDescriptor(index).leastSize()
    return Math.multiplyExact(length, getElementDescriptor(index).getElementDescriptor(0).leastSize())
}

// Allocation-friendly loop
@OptIn(ExperimentalSerializationApi::class)
internal fun SerialDescriptor.fixedLength(index: Int): FixedLength? {
    val annotations = getElementAnnotations(index)
    for (i in annotations.indices) (annotations[i] as? FixedLength)?.let { return it }
    return null
}

/** True for a message without fields, for which ROS sends one byte. */
@OptIn(ExperimentalSerializationApi::class)
internal val SerialDescriptor.isEmptyMessage: Boolean
    get() = elementsCount == 0 && (kind == StructureKind.CLASS || kind == StructureKind.OBJECT)

@OptIn(ExperimentalSerializationApi::class)
internal fun SerialDescriptor.checkHasCdr() {
    if (kind != StructureKind.LIST && kind != StructureKind.CLASS && kind != StructureKind.OBJECT) throw hasNoCdr()
}

@OptIn(ExperimentalSerializationApi::class)
private fun SerialDescriptor.hasNoCdr() =
    SerializationException("Expected a message, a sequence, a number or text, but found $serialName of kind $kind")
