// A vendor's library in which everything succeeds and nothing happens. The build renames functions to remove them.
#include "../../sdk/tables.h"

#pragma GCC diagnostic ignored "-Wunused-parameter"
#define DEFINITION(name, parameters)                                                                                   \
    MLResult name parameters { return MLResult_Ok; }
#define DEFINITIONS(identifier, table, functions, library) functions(DEFINITION)

SDK_AREAS(DEFINITIONS)
