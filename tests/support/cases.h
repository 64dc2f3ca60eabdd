// Number of cases of a test: a sample by default, all under tests/long.
#pragma once

#include <cstdlib>

namespace springdrive::testing {

/// Number of cases to try: `few`, or `all` when run by tests/long.
inline int cases(int few, int all) {
    return std::getenv("SPRINGDRIVE_LONG") != nullptr ? all : few; // NOLINT(concurrency-mt-unsafe)
}

} // namespace springdrive::testing
