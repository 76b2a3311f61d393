// Khronos' loader keeps what it made for an instance; that is not ours to free.
extern "C" __attribute__((visibility("default"))) const char *__lsan_default_suppressions() {
    return "leak:libopenxr_loader.so\n";
}
