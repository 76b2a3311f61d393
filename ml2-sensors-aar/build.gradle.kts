import org.jetbrains.kotlin.gradle.dsl.JvmTarget

plugins {
    alias(libs.plugins.android.library)
    alias(libs.plugins.kotlin.android)
    alias(libs.plugins.kotlin.serialization)
}

android {
    namespace = "dev.ml2sensors"
    compileSdk = 34
    defaultConfig {
        minSdk = 29
        consumerProguardFiles("aar/consumer-rules.pro")
        ndk { abiFilters += "x86_64" }
        externalNativeBuild { cmake { targets += "ml2sensors" } }
    }
    buildFeatures { prefab = true }
    externalNativeBuild { cmake { path = file("../native/CMakeLists.txt") } }
    compileOptions {
        sourceCompatibility = JavaVersion.VERSION_11
        targetCompatibility = JavaVersion.VERSION_11
    }
}

kotlin {
    explicitApi()
    compilerOptions {
        jvmTarget = JvmTarget.JVM_11
        allWarningsAsErrors = true
    }
}

dependencies {
    api(libs.coroutines)
    api(libs.serialization)
    // Its headers, by prefab; the loader itself is the app's.
    compileOnly(libs.openxr)
}
