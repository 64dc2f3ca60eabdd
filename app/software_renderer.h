// OpenGL that the processor draws, by the names of its renderers.
#pragma once

#include <string_view>

namespace springdrive::app {

[[nodiscard]] inline bool is_software_renderer(std::string_view name) {
    return name.find("llvmpipe") != std::string_view::npos ||
           name.find("softpipe") != std::string_view::npos ||
           name.find("SwiftShader") != std::string_view::npos;
}

} // namespace springdrive::app
