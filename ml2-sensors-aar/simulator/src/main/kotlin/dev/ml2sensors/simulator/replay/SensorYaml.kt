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

/** Reads a `sensor.yaml`. Keys of nested mappings are written with dots. */
internal class SensorYaml(private val file: File) {
    private val root: Node = compose()

    fun text(key: String): String = (node(key) as? ScalarNode)?.value ?: throw error(key, "one value", "a collection")

    fun int(key: String): Int = text(key).let { it.toIntOrNull() ?: throw error(key, "an integer", "'$it'") }

    fun numbers(key: String, count: Int): List<Double> {
        val items = (node(key) as? SequenceNode)?.value ?: throw error(key, "a list of numbers", "something else")
        if (items.size != count) throw error(key, "$count numbers", "${items.size}")
        return items.map { item ->
            (item as? ScalarNode)?.value?.toDoubleOrNull()?.takeIf(Double::isFinite)
                ?: throw error(key, "finite numbers", "'${(item as? ScalarNode)?.value ?: item.nodeType}'")
        }
    }

    fun error(key: String, expected: String, found: String) =
        RecordingException(file, line(find(key)), "$key to be $expected", found)

    private fun node(key: String): Node = find(key) ?: throw error(key, "present", "nothing")

    private fun find(key: String): Node? = key.split('.').fold(root as Node?) { node, name ->
        (node as? MappingNode)?.value?.lastOrNull { (it.keyNode as? ScalarNode)?.value == name }?.valueNode
    }

    private fun line(node: Node?): Int? = node?.startMark?.map { it.line + 1 }?.orElse(null)

    private fun compose(): Node = try {
        // OpenCV's first line is not a valid YAML directive
        val text = file.readText().replaceFirst(Regex("^%YAML:.*"), "")
        Compose(LoadSettings.builder().build()).composeString(text).orElse(null)
    } catch (failure: YamlEngineException) {
        val mark = (failure as? MarkedYamlEngineException)?.problemMark?.orElse(null)
        throw RecordingException(file, mark?.line?.plus(1), "YAML", failure.message.orEmpty(), failure)
    } catch (failure: IOException) {
        throw RecordingException(file, null, "a readable file", "${failure.message}", failure)
    } ?: throw RecordingException(file, null, "a YAML mapping", "an empty file")
}
