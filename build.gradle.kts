buildscript {
    repositories {
        google()
        mavenCentral()
    }
    dependencies {
        // Before the plugins below: the R8 that comes with the Android plugin does not know the metadata of our Kotlin.
        classpath(libs.r8)
    }
}

plugins {
    alias(libs.plugins.android.application) apply false
    alias(libs.plugins.android.library) apply false
    alias(libs.plugins.kotlin.android) apply false
    alias(libs.plugins.kotlin.serialization) apply false
}
