// The library for Android Studio, its Kotlin, and its native code by an NDK; and the app. Everything else is built by Maven and make.
pluginManagement {
    repositories {
        google()
        mavenCentral()
        gradlePluginPortal()
    }
}

dependencyResolutionManagement {
    repositoriesMode = RepositoriesMode.FAIL_ON_PROJECT_REPOS
    repositories {
        google()
        mavenCentral()
    }
}

rootProject.name = "ml2-sensors"
include(":ml2-sensors-aar")
include(":ml2-sensors-aar:app")
