// Assertions: conditions that are false only if the program has a bug. Two tiers:
//
//   SPRINGDRIVE_ASSERT(size_ < kCapacity);                 in every build: a comparison or a few
//   SPRINGDRIVE_ASSERT_AUDIT(std::ranges::is_sorted(all)); for expensive checks: evaluated in
//                                                          debug and sanitizer builds, compiled in
//                                                          all
//
// A failed assertion prints its condition and location to standard error and aborts the program. A
// thread that must first reach a safe state runs its work through `run_guarded`, as the servo
// thread does.
#pragma once

#include <cstddef>
#include <memory>
#include <string_view>

namespace springdrive {

/// Which assertion failed, and where. The strings are literals, so the pointers never dangle.
struct AssertionFailure {
    const char *condition = nullptr;
    const char *file = nullptr; ///< path relative to the project's root
    int line = 0;
};

namespace assertions {

/// The build strips the project's root from __FILE__ (-fmacro-prefix-map), or ccache has made the
/// path relative. A header's path goes through the symbolic link that exposes its room:
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

/// Leaves the enclosing guarded work, or ends the program if there is none. Not inline, so that an
/// assertion that holds costs only a comparison.
[[noreturn, gnu::cold, gnu::noinline]] void fail(const char *condition, const char *file,
                                                 int line) noexcept;

using Work = void (*)(const void *context);
using AtOnce = void (*)(const void *context, const AssertionFailure &failure);
[[nodiscard]] bool run_guarded(Work work, const void *of_work, AtOnce at_once,
                               const void *of_at_once) noexcept;

} // namespace assertions

/// Runs `work()`. If an assertion fails in it, on this thread, `at_once(failure)` is called while
/// the failing call is still on the stack; then the rest of `work` is skipped and false is
/// returned. An assertion that fails inside `at_once` ends the program.
///
/// Implemented by longjmp: no exception has to cross the `noexcept` functions in between, and
/// nothing is allocated. No destructor runs, so it is only for work that owns nothing, neither
/// memory nor a lock, such as a servo tick. RT-safe; guards may be nested.
template <typename Work, typename AtOnce>
[[nodiscard]] bool run_guarded(const Work &work, const AtOnce &at_once) noexcept {
    const auto do_work = [](const void *of_work) { (*static_cast<const Work *>(of_work))(); };
    const auto report = [](const void *of_at_once, const AssertionFailure &failure) {
        (*static_cast<const AtOnce *>(of_at_once))(failure);
    };
    return assertions::run_guarded(do_work, std::addressof(work), report, std::addressof(at_once));
}

} // namespace springdrive

/// Usable in `constexpr` functions: at compile time a false condition is a compile error.
#define SPRINGDRIVE_ASSERT(...)                                                                    \
    (static_cast<bool>(__VA_ARGS__)                                                                \
         ? static_cast<void>(0)                                                                    \
         : ::springdrive::assertions::fail(                                                        \
               #__VA_ARGS__, ::springdrive::assertions::path_in_project(__FILE__), __LINE__))

/// SPRINGDRIVE_AUDIT is 1 in debug builds, else 0 (the CMake option of that name). The condition is
/// always compiled, so that it stays valid code.
#define SPRINGDRIVE_ASSERT_AUDIT(...)                                                              \
    (!SPRINGDRIVE_AUDIT || static_cast<bool>(__VA_ARGS__)                                          \
         ? static_cast<void>(0)                                                                    \
         : ::springdrive::assertions::fail(                                                        \
               #__VA_ARGS__, ::springdrive::assertions::path_in_project(__FILE__), __LINE__))
