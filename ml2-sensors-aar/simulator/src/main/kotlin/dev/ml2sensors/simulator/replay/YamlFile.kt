package dev.ml2sensors.simulator.replay

import org.snakeyaml.engine.v2.api.LoadSettings
import org.snakeyaml.engine.v2.api.lowlevel.Compose
import org.snakeyaml.engine.v2.exceptions.MarkedYamlEngineException
import org.snakeyaml.engine.v2.exceptions.YamlEngineException
import org.snakeyaml.engine.v2.nodes.MappingNode
import org.snakeyaml.engine.v2.nodes.Node
import org.snakeyaml.engine.v2.nodes.ScalarNode
import org.snakeyaml.engine.v2.nodes.SequenceNode
import java.io.File
import java.io.IOException

/**
 * Reads a file of YAML, of which JSON is a part. Keys of nested mappings are written with dots, items of lists by their
 * index: `value0.resolution.1`.
 */
internal class YamlFile(private val file: File) {
    private val root: Node = compose()

    operator fun contains(key: String): Boolean = find(key) != null

    fun text(key: String): String = (node(key) as? ScalarNode)?.value ?: throw error(key, "one value", "a collection")

    fun number(key: String): Double = node(key).number(key)

    /** Returns the numbers of a list, or of a list of lists of them, in order. */
    fun numbers(key: String): List<Double> = node(key).let { list ->
        if (list !is SequenceNode) throw error(key, "a list of numbers", "something else")
        list.value.flatMap { item -> if (item is SequenceNode) item.value else listOf(item) }.map { it.number(key) }
    }

    fun numbers(key: String, count: Int): List<Double> =
        numbers(key).also { if (it.size != count) throw error(key, "$count numbers", "${it.size}") }

    fun error(key: String, expected: String, found: String) =
        RecordingException(file, line(find(key)), "$key to be $expected", found)

    private fun Node.number(key: String): Double {
        if (this !is ScalarNode) throw error(key, "a finite number", "a collection")
        return value.toDoubleOrNull()?.takeIf(Double::isFinite) ?: throw error(key, "a finite number", "'$value'")
    }

    private fun node(key: String): Node = find(key) ?: throw error(key, "present", "nothing")

    private fun find(key: String): Node? = key.split('.').fold(root as Node?) { node, name ->
        when (node) {
            is MappingNode -> node.value.lastOrNull { (it.keyNode as? ScalarNode)?.value == name }?.valueNode
            is SequenceNode -> name.toIntOrNull()?.let(node.value::getOrNull)
            else -> null
        }
    }

    private fun line(node: Node?): Int? = node?.startMark?.map { it.line + 1 }?.orElse(null)

    private fun compose(): Node = try {
        // OpenCV's first line is not a valid YAML directive
        val text = file.readText().removePrefix("\uFEFF").replaceFirst(Regex("^%YAML:.*"), "")
        Compose(LoadSettings.builder().build()).composeString(text).orElse(null)
    } catch (failure: YamlEngineException) {
        val mark = (failure as? MarkedYamlEngineException)?.problemMark?.orElse(null)
        throw RecordingException(file, mark?.line?.plus(1), "YAML", failure.message.orEmpty(), failure)
    } catch (failure: IOException) {
        throw RecordingException(file, null, "a readable file", "${failure.message}", failure)
    } ?: throw RecordingException(file, null, "a YAML mapping", "an empty file")
}

/** A recording does not follow its format. Names the [file], the [line] if there is one, and what was expected and found. */
public class RecordingException internal constructor(
    public val file: File,
    public val line: Int?,
    public val expected: String,
    public val found: String,
    cause: Throwable? = null,
) : IOException("$file${line?.let { ":$it" }.orEmpty()}: expected $expected, found $found", cause)
