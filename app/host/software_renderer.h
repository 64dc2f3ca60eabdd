// OpenGL that the processor draws, by the names of its renderers.
#pragma once

#include <cstdlib>
#include <string_view>

namespace springdrive::app {

[[nodiscard]] inline bool is_software_renderer(std::string_view name) {
    return name.find("llvmpipe") != std::string_view::npos ||
           name.find("softpipe") != std::string_view::npos ||
           name.find("SwiftShader") != std::string_view::npos;
}

/// Has llvmpipe draw in the thread that calls OpenGL, where the environment does not say otherwise;
/// to be called before a window is opened. Its drawing threads may crash the process, about once in
/// hours on a busy machine: lp_fence_signalled reads a fence's count without its mutex, so that the
/// fence may be freed while the thread that counted still holds that mutex (Mesa 22.3 and later).
inline void draw_without_threads() {
    constexpr int kKeepOther = 0;
    setenv("LP_NUM_THREADS", "0", kKeepOther);
}

} // namespace springdrive::app
