// What must hold unless the program has a mistake, in two tiers.
//
//   SPRINGDRIVE_ASSERT(size_ < kCapacity);                 in every build: a comparison or a few
//   SPRINGDRIVE_ASSERT_AUDIT(std::ranges::is_sorted(all)); in debug and sanitizer builds: what
//                                                          costs; compiled in all, run in those
//
// One that fails says on standard error which it is and where, and aborts the program. A thread
// that has something to bring to safety first runs its work through `run_guarded`: the servo's
// does.
#pragma once

#include <cstddef>
#include <memory>
#include <string_view>

namespace springdrive {

/// Which assertion, and where. The texts are literals: they outlive whoever holds one.
struct AssertionFailure {
    const char *condition = nullptr;
    const char *file = nullptr; ///< by its path from the top of the project
    int line = 0;
};

namespace assertions {

/// The build takes the top of the project off (-fmacro-prefix-map), or ccache has made the way
/// there a relative one. A header has the name of the link by which its room shows it:
/// "…/rooms/contact/engine/contact/contact.h".
[[nodiscard]] consteval const char *path_in_project(const char *file) {
    constexpr std::string_view kUp = "../";
    constexpr std::string_view kLinks = "rooms/";
    std::string_view path(file);
    while (path.starts_with(kUp)) {
        path.remove_prefix(kUp.size());
    }
    const std::size_t links = path.rfind(kLinks);
    if (links == 0 || (links != std::string_view::npos && path[links - 1] == '/')) {
        path.remove_prefix(path.find('/', links + kLinks.size()) + 1);
    }
    return path.data();
}

/// Leaves the guarded work that it is called in, or else ends the program. Not inline, so that an
/// assertion that holds costs a comparison and nothing else.
[[noreturn, gnu::cold, gnu::noinline]] void fail(const char *condition, const char *file,
                                                 int line) noexcept;

using Work = void (*)(const void *context);
using AtOnce = void (*)(const void *context, const AssertionFailure &failure);
[[nodiscard]] bool run_guarded(Work work, const void *of_work, AtOnce at_once,
                               const void *of_at_once) noexcept;

} // namespace assertions

/// Runs `work()`. Where an assertion fails in it, on this thread, `at_once(failure)` is called
/// first, while the call that failed still stands; then the rest of `work` is left, and the answer
/// is false. An assertion that fails in `at_once` ends the program.
///
/// What is left is left by longjmp: no exception has to pass the `noexcept` functions between, and
/// nothing is allocated. No destructor runs on that way, so it is only for work that owns nothing:
/// no memory, no lock. A tick of the servo is such. RT-safe; guards may be nested.
template <typename Work, typename AtOnce>
[[nodiscard]] bool run_guarded(const Work &work, const AtOnce &at_once) noexcept {
    const auto do_work = [](const void *of_work) { (*static_cast<const Work *>(of_work))(); };
    const auto tell = [](const void *of_at_once, const AssertionFailure &failure) {
        (*static_cast<const AtOnce *>(of_at_once))(failure);
    };
    return assertions::run_guarded(do_work, std::addressof(work), tell, std::addressof(at_once));
}

} // namespace springdrive

/// For a `constexpr` function too: there a condition that is false does not compile.
#define SPRINGDRIVE_ASSERT(...)                                                                    \
    (static_cast<bool>(__VA_ARGS__)                                                                \
         ? static_cast<void>(0)                                                                    \
         : ::springdrive::assertions::fail(                                                        \
               #__VA_ARGS__, ::springdrive::assertions::path_in_project(__FILE__), __LINE__))

/// SPRINGDRIVE_AUDIT is 1 where the build is one for debugging, else 0 (CMake's option of that
/// name). The condition is compiled in any case, so that it does not rot.
#define SPRINGDRIVE_ASSERT_AUDIT(...)                                                              \
    (!SPRINGDRIVE_AUDIT || static_cast<bool>(__VA_ARGS__)                                          \
         ? static_cast<void>(0)                                                                    \
         : ::springdrive::assertions::fail(                                                        \
               #__VA_ARGS__, ::springdrive::assertions::path_in_project(__FILE__), __LINE__))
