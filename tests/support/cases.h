// How long a proof is: a sample by default, the whole under tests/long.
#pragma once

#include <cstdlib>

namespace springdrive::testing {

/// How many cases to try: `few`, or `all` where tests/long asks for the whole proof.
inline int cases(int few, int all) {
    return std::getenv("SPRINGDRIVE_LONG") != nullptr ? all : few; // NOLINT(concurrency-mt-unsafe)
}

} // namespace springdrive::testing
