#include "base/assertions.h"

#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <utility>

namespace springdrive::assertions {

namespace {

/// Where to jump to out of guarded work.
struct ReturnPoint {
    AtOnce at_once;
    const void *of_at_once;
    ReturnPoint *enclosing; ///< the guard that this one is nested in
    std::jmp_buf jump;
};

constinit thread_local ReturnPoint *return_point = nullptr; ///< innermost on this thread, or null

} // namespace

void fail(const char *condition, const char *file, int line) noexcept {
    // Cleared while the handler runs: a failure inside the handler ends the program.
    ReturnPoint *const out = std::exchange(return_point, nullptr);
    if (out == nullptr) {
        std::fprintf(stderr, "springdrive: assertion failed: %s, %s:%d\n", condition, file, line);
        std::abort();
    }
    out->at_once(out->of_at_once, {condition, file, line});
    std::longjmp(out->jump, 1);
}

bool run_guarded(Work work, const void *of_work, AtOnce at_once, const void *of_at_once) noexcept {
    ReturnPoint out{at_once, of_at_once, return_point, {}};
    if (setjmp(out.jump) != 0) {
        return_point = out.enclosing;
        return false;
    }
    return_point = &out;
    work(of_work);
    return_point = out.enclosing;
    return true;
}

} // namespace springdrive::assertions
