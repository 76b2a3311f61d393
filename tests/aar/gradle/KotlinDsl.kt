// The additions of Gradle's Kotlin DSL to Gradle's interfaces, for the compiler only: nothing here runs.
// The DSL itself comes with a Gradle distribution alone.

import org.gradle.api.Project
import org.gradle.api.artifacts.dsl.RepositoryHandler
import org.gradle.api.initialization.Settings
import org.gradle.api.provider.Property
import java.net.URI

fun Settings.uri(path: String): URI = TODO(path)

fun Project.buildscript(block: BuildScript.() -> Unit): Unit = TODO("$block")

interface BuildScript {
    fun repositories(block: RepositoryHandler.() -> Unit)

    fun dependencies(block: Dependencies.() -> Unit)
}

fun Project.dependencies(block: Dependencies.() -> Unit): Unit = TODO("$block")

interface Dependencies {
    fun classpath(dependency: String)

    fun implementation(dependency: String)
}

fun <T : Any> Property<T>.assign(value: T): Unit = set(value)
