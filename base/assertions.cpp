#include "base/assertions.h"

#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <utility>

namespace springdrive::assertions {

namespace {

/// Out of a guarded work.
struct WayOut {
    AtOnce at_once;
    const void *of_at_once;
    WayOut *around; ///< of the guard that this one is nested in
    std::jmp_buf place;
};

constinit thread_local WayOut *way_out = nullptr; ///< of this thread; null where none is guarded

} // namespace

void fail(const char *condition, const char *file, int line) noexcept {
    // None while somebody is told: a second failure ends the program.
    WayOut *const out = std::exchange(way_out, nullptr);
    if (out == nullptr) {
        std::fprintf(stderr, "springdrive: assertion failed: %s, %s:%d\n", condition, file, line);
        std::abort();
    }
    out->at_once(out->of_at_once, {condition, file, line});
    std::longjmp(out->place, 1);
}

bool run_guarded(Work work, const void *of_work, AtOnce at_once, const void *of_at_once) noexcept {
    WayOut out{at_once, of_at_once, way_out, {}};
    if (setjmp(out.place) != 0) {
        way_out = out.around;
        return false;
    }
    way_out = &out;
    work(of_work);
    way_out = out.around;
    return true;
}

} // namespace springdrive::assertions
