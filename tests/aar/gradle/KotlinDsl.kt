// What Gradle's Kotlin DSL adds to Gradle's and the plugins' interfaces, for the compiler only: nothing here runs.
// The DSL itself, and the accessors that Gradle generates, come with a Gradle distribution alone.

import com.android.build.api.dsl.ApplicationExtension
import com.android.build.api.dsl.LibraryExtension
import org.gradle.api.Action
import org.gradle.api.Project
import org.gradle.api.artifacts.MinimalExternalModuleDependency
import org.gradle.api.artifacts.ProjectDependency
import org.gradle.api.artifacts.dsl.RepositoryHandler
import org.gradle.api.initialization.Settings
import org.gradle.api.provider.Property
import org.gradle.api.provider.Provider
import org.gradle.plugin.use.PluginDependenciesSpec
import org.gradle.plugin.use.PluginDependencySpec
import org.jetbrains.kotlin.gradle.dsl.KotlinAndroidExtension
import java.net.URI

fun Settings.uri(path: String): URI = TODO(path)

fun plugins(block: PluginDependenciesSpec.() -> Unit): Unit = TODO("$block")

infix fun PluginDependencySpec.apply(isApplied: Boolean): PluginDependencySpec = apply(isApplied)

fun Project.buildscript(block: BuildScript.() -> Unit): Unit = TODO("$block")

interface BuildScript {
    fun repositories(block: RepositoryHandler.() -> Unit)

    fun dependencies(block: Dependencies.() -> Unit)
}

fun Project.dependencies(block: Dependencies.() -> Unit): Unit = TODO("$block")

interface Dependencies {
    fun api(dependency: Provider<MinimalExternalModuleDependency>)

    fun classpath(dependency: Provider<MinimalExternalModuleDependency>)

    fun classpath(dependency: String)

    fun compileOnly(dependency: Provider<MinimalExternalModuleDependency>)

    fun implementation(dependency: ProjectDependency)

    fun implementation(dependency: String)

    fun project(path: String): ProjectDependency
}

fun <T : Any> Property<T>.assign(value: T): Unit = set(value)

fun Project.kotlin(block: Action<KotlinAndroidExtension>): Unit = TODO("$block")

/** `android` of a library. */
interface LibraryScript : Project {
    fun android(block: Action<LibraryExtension>)
}

/** `android` of an app. */
interface ApplicationScript : Project {
    fun android(block: Action<ApplicationExtension>)
}
